"""Draw one frame: every object in one mesh, plain or coloured by the points on it, and the points themselves."""

from __future__ import annotations

import numpy as np
import pyvista as pv
from numpy.typing import NDArray
from vtkmodules.vtkRenderingCore import vtkRenderer

from riglens.core.scene.boxes import CLASSES
from riglens.widgets.drawing.actors import exchange, rgba_actor
from riglens.widgets.theme import Palette, mix, rgb
from riglens.widgets.traffic.frame import STANDING_COLOUR, ShownFrame, colour_of
from riglens.widgets.traffic.shapes import shape_of

_POINT_PX = 2.0
_LIGHT = np.array([0.35, 0.25, 0.9])
_SHADE = 0.55
"""Share of the colour on faces away from the light."""
_PALE = 0.6
"""Fading of occluders behind the objects."""


class TrafficLayer:
    """Layer that adds and removes the actors of a frame; they take no part in picking."""

    def __init__(self, renderer: vtkRenderer) -> None:
        self._renderer = renderer
        self._actors: list[pv.Actor] = []
        self._pixel_ratio = 1.0

    def set_pixel_ratio(self, pixel_ratio: float) -> None:
        """Draw larger points on dense screens and in large pictures."""
        self._pixel_ratio = pixel_ratio
        for actor in self._actors:
            actor.prop.point_size = _POINT_PX * pixel_ratio

    def set_frame(self, frame: ShownFrame | None, palette: Palette) -> None:
        """Show another frame, or none."""
        actors = [] if frame is None else [*_solids(frame, palette), *_returns(frame, palette)]
        exchange(self._renderer, self._actors, actors)
        self._actors = actors
        self.set_pixel_ratio(self._pixel_ratio)


def box_colours(frame: ShownFrame, palette: Palette) -> list[str]:
    """Return the colour of each box: by its points, paler for occluders; all the same in a plain frame."""
    if frame.is_plain:
        return [palette.traffic] * len(frame.cls)
    colours = []
    for number, cls in enumerate(frame.cls.tolist()):
        if cls >= len(CLASSES):
            colours.append(mix(STANDING_COLOUR, palette.ground, _PALE))
        elif number == frame.pointed_out:
            colours.append(palette.selected)
        else:
            colours.append(colour_of(int(frame.points[number]), frame.enough))
    return colours


def _solids(frame: ShownFrame, palette: Palette) -> list[pv.Actor]:
    """Return all boxes as one mesh of flat triangles, shaded by hand: their colours have to be read."""
    if not len(frame.cls):
        return []
    corners, colours = [], []
    for number, colour in enumerate(box_colours(frame, palette)):
        shape, triangles = shape_of(int(frame.cls[number]))
        places = (shape * frame.size_m[number]) @ frame.rotation[number].T + frame.centre_m[number]
        faces = places[triangles]
        corners.append(faces.reshape(-1, 3))
        colours.append(np.repeat(_shaded(faces, colour), 3, axis=0))
    points = np.concatenate(corners).astype(np.float32)
    faces_of = np.insert(np.arange(len(points)).reshape(-1, 3), 0, 3, axis=1).ravel()
    mesh = pv.PolyData(points, faces=faces_of)
    mesh["rgb"] = np.concatenate(colours)
    return [rgba_actor(mesh, "rgb")]


def _shaded(faces: NDArray[np.float64], colour: str) -> NDArray[np.uint8]:
    """Return colours (t, 3) of triangles (t, 3, 3) in a light from above, ahead and left; both sides alike."""
    normal = np.cross(faces[:, 1] - faces[:, 0], faces[:, 2] - faces[:, 0])
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    facing = np.abs(normal @ _LIGHT)[:, None] / (np.where(length > 0.0, length, 1.0) * np.linalg.norm(_LIGHT))
    shade = _SHADE + (1.0 - _SHADE) * facing
    return np.asarray(255.0 * np.array(rgb(colour)) * shade, np.uint8)


def _returns(frame: ShownFrame, palette: Palette) -> list[pv.Actor]:
    """Return the points: those on objects are emphasised, those on the ground are faint."""
    if not len(frame.places_m):
        return []
    mesh = pv.PolyData(frame.places_m)
    strong, faint = (np.array(rgb(colour)) * 255 for colour in (palette.text, palette.ring))
    mesh["rgb"] = np.where(frame.on_box[:, None], strong, faint).astype(np.uint8)
    return [rgba_actor(mesh, "rgb")]
