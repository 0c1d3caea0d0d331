"""Draw markers: the edges of the picked voxel's cube, visible through everything and never too small; a test object
next to the car."""

from __future__ import annotations

import numpy as np
import pyvista as pv
from vtkmodules.vtkRenderingCore import vtkRenderer

from riglens.widgets.drawing.actors import Material, hidden, plain_actor, surface_actor
from riglens.widgets.drawing.camera import OrbitCamera, Size
from riglens.widgets.theme import Palette, rgb
from riglens.widgets.viewport.scene_state import Marker, Post

_LEAST_PX = 12.0
_WIDTHS_PX = (4.0, 2.0)
_EDGE_COLOUR = "#101418"
SEEN_COLOUR, UNSEEN_COLOUR = "#2fb37c", "#f43f5e"
_POST_OPACITY = 0.72


class MarkerLayer:
    """Cube of lines on the overlay, with a dark edge so that it contrasts with every colour."""

    def __init__(self, overlay: vtkRenderer) -> None:
        cube = pv.Cube().extract_all_edges()
        self._actors = tuple(hidden(overlay, plain_actor(cube, lighting=False)) for _ in _WIDTHS_PX)
        self._marker: Marker | None = None

    def set_marker(self, marker: Marker | None, palette: Palette) -> None:
        """Point out another cube, or none."""
        self._marker = marker
        for actor, colour in zip(self._actors, (_EDGE_COLOUR, palette.selected), strict=True):
            actor.visibility = marker is not None
            actor.prop.color = rgb(colour)

    def arrange(self, camera: OrbitCamera, size: Size, pixel_ratio: float) -> None:
        """Draw the cube at its size, larger where it would be too small to see."""
        if self._marker is None:
            return
        least_m = _LEAST_PX * pixel_ratio * camera.metres_per_pixel(np.array(self._marker.centre_m), size)
        for actor, width_px in zip(self._actors, _WIDTHS_PX, strict=True):
            actor.scale = max(self._marker.edge_m, least_m)
            actor.position = self._marker.centre_m
            actor.prop.line_width = width_px * pixel_ratio


class PostLayer:
    """An upright cylinder on the ground, green where the rig sees it."""

    def __init__(self, main: vtkRenderer) -> None:
        mesh = pv.Cylinder(
            center=(0.0, 0.0, 0.5), direction=(0.0, 0.0, 1.0), radius=1.0, height=1.0, resolution=48
        )
        actor = surface_actor(mesh, Material(UNSEEN_COLOUR, ambient=0.5, diffuse=0.5))
        self._actor = hidden(main, actor)
        self._actor.prop.opacity = _POST_OPACITY

    def show(self, post: Post | None) -> None:
        """Point out another object, or none."""
        self._actor.visibility = post is not None
        if post is not None:
            self._actor.position = (post.x_m, post.y_m, 0.0)
            self._actor.scale = (post.radius_m, post.radius_m, post.height_m)
            self._actor.prop.color = rgb(SEEN_COLOUR if post.is_seen else UNSEEN_COLOUR)
