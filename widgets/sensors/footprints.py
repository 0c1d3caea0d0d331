"""Footprints on the ground: bands of pixels per metre of cameras, of classes reached by radars and ultrasonic sensors.

The selected sensor's are strongest. While something moves, and in the window until a thread has found them, those of a
bent lens or a radar are coarser and ignore the car's body. In motion the fills of the others are haze: those of 60
sensors lie over each other on all the ground, which took most of a frame without a graphics card.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import numpy as np
import pyvista as pv
from numpy.typing import NDArray
from vtkmodules.vtkRenderingCore import vtkRenderer

from riglens.core.footprint.ground import FOOTPRINTS, Footprint, KeptFootprints, has_footprint
from riglens.core.rig.model import Camera, Sensor
from riglens.core.vehicle.solid import Solid
from riglens.widgets.drawing.actors import hidden, rgba_actor, show_mesh
from riglens.widgets.sensors.appearance import ray_colour
from riglens.widgets.theme import Palette, rgb

Points = NDArray[np.float64]
_FILL_M, _EDGE_M = 0.004, 0.008
_OTHERS, _ALONE = 0.26, 0.6
"""Opacity of a footprint among others, as a share of that of the selected sensor's, and of all where none is."""
_PLAIN = 0.22
"""Opacity of radars and ultrasonic sensors that are not selected: one tint for all classes, and no edges."""
_EDGES = (0.34, 0.95)
_WIDTHS_PX = (1.1, 2.0)
_MOST_QUICK = 16
"""Number of coarse footprints that are found for one picture, each in 5 to 7 ms."""
_QUICK = KeptFootprints(step_deg=4.0)


class Tint(NamedTuple):
    """Colour and opacity of a band."""

    colour: str
    opacity: float


def tints(sensor: Sensor, palette: Palette, count: int) -> list[Tint]:
    """Return the tints of a footprint's bands, from the finest."""
    if isinstance(sensor, Camera):
        places = np.linspace(0, len(palette.bands) - 1, count) if count > len(palette.bands) else range(count)
        return [Tint(palette.bands[round(place)], palette.band_opacity[round(place)]) for place in places]
    colour = ray_colour(sensor.kind, palette)
    return [Tint(colour, 0.3 - 0.09 * place) for place in range(count)]


class FootprintsLayer:
    """Fills and edges of all footprints: those of the selected sensor in actors of their own, since they move."""

    def __init__(self, renderer: vtkRenderer, haze: vtkRenderer, waits: bool = False) -> None:
        """Start empty; one that `waits` finds no exact footprints: they are found elsewhere."""
        self._waits, self._lacking = waits, [False, False]
        self._made: list[tuple[object, pv.PolyData | None, pv.PolyData | None]] = [(None, None, None)] * 2
        """Meshes of fills and edges, and what they were made of: most pictures show the same footprints again."""
        self._fills = [hidden(renderer, rgba_actor(pv.PolyData(), "rgba")) for _ in range(2)]
        self._edges = [hidden(renderer, rgba_actor(pv.PolyData(), "rgba")) for _ in range(2)]
        self._hazy = hidden(haze, rgba_actor(pv.PolyData(), "rgba"))
        for actor in (*self._fills, *self._edges, self._hazy):
            actor.force_translucent = True
        self.haze: pv.PolyData | None = None
        """Fills that are drawn as haze."""
        self.set_line_width(1.0)

    def set_line_width(self, width_px: float) -> None:
        """Set the width of the edges, for pictures of higher resolution."""
        for actor, own_px in zip(self._edges, _WIDTHS_PX, strict=True):
            actor.prop.line_width = own_px * width_px

    def show(
        self,
        sensors: Sequence[Sensor],
        is_selected: bool,
        is_any_selected: bool,
        palette: Palette,
        limits: tuple[float, ...],
        solid: Solid | None,
        quick: bool,
    ) -> None:
        """Show the footprints of the selected sensor, or those of all others; cameras with bands of these limits."""
        share = 1.0 if is_selected else _OTHERS if is_any_selected else _ALONE
        edge = _EDGES[is_selected or not is_any_selected]
        found = tuple(self._found(list(filter(has_footprint, sensors)), is_selected, limits, solid, quick))
        look = found, share, edge, palette
        if self._made[is_selected][0] != look:
            self._made[is_selected] = look, *_meshes(found, is_selected, share, edge, palette)
        _, filled, edges = self._made[is_selected]
        if not is_selected:
            self.haze = filled if quick else None
            show_mesh(self._hazy, self.haze)
        show_mesh(self._fills[is_selected], None if quick and not is_selected else filled)
        show_mesh(self._edges[is_selected], edges)

    @property
    def lacks_any(self) -> bool:
        """Return whether a footprint is coarse or left out."""
        return any(self._lacking)

    def _found(
        self,
        sensors: list[Sensor],
        is_selected: bool,
        limits: tuple[float, ...],
        solid: Solid | None,
        quick: bool,
    ) -> Iterator[Footprint]:
        """Yield footprints; coarse ones in place of those that are not known, and no more than a few new ones."""
        self._lacking[is_selected], left = False, _MOST_QUICK
        for sensor in sensors:
            if not (quick or self._waits):
                yield FOOTPRINTS.found(sensor, limits, solid)
            elif known := FOOTPRINTS.known(sensor, limits, solid):
                yield known
            else:
                self._lacking[is_selected] = True
                if not (coarse := _QUICK.known(sensor, limits, None)) and left:
                    left, coarse = left - 1, quick_footprint(sensor, limits)
                if coarse:
                    yield coarse


def quick_footprint(sensor: Sensor, limits: tuple[float, ...]) -> Footprint:
    """Return a footprint without the car's body, and coarser where it is bent: that of a pinhole camera is exact."""
    return _QUICK.found(sensor, limits, None)


_Part = tuple[Points, str, float]


def _meshes(
    found: Sequence[Footprint], is_selected: bool, share: float, edge: float, palette: Palette
) -> tuple[pv.PolyData | None, pv.PolyData | None]:
    """Return the fills and the edges of footprints."""
    fills, edges = list[_Part](), list[_Part]()
    for one in found:
        is_plain = not is_selected and not isinstance(one.sensor, Camera)
        for band, tint in zip(one.bands, tints(one.sensor, palette, len(one.bands)), strict=True):
            opacity = _PLAIN if is_plain else tint.opacity
            fills += [(patch, tint.colour, share * opacity) for patch in band.patches]
            if not is_plain:  # the edges of a dozen overlapping sensors say nothing
                edges += [(patch, tint.colour, edge) for patch in band.patches]
    return _mesh(fills, _FILL_M, _faces), _mesh(edges, _EDGE_M, _outline)


def _mesh(
    parts: Sequence[_Part], height_m: float, cells: Callable[[int, int], NDArray[np.int64]]
) -> pv.PolyData | None:
    """Return outlines (n, 2) with their colours as one mesh with an `rgba` array, of faces or of lines."""
    if not parts:
        return None
    counts = [len(outline) for outline, _, _ in parts]
    flat = np.concatenate([outline for outline, _, _ in parts])
    points = np.column_stack([flat, np.full(len(flat), height_m)]).astype(np.float32)
    first = np.concatenate([[0], np.cumsum(counts)[:-1]])
    made = [cells(count, start) for count, start in zip(counts, first, strict=True)]
    numbers = np.concatenate(made)
    mesh = pv.PolyData(points, faces=numbers) if cells is _faces else pv.PolyData(points, lines=numbers)
    colours = np.array([[*(255.0 * np.array(rgb(colour))), 255.0 * alpha] for _, colour, alpha in parts])
    mesh["rgba"] = np.repeat(colours, counts, axis=0).astype(np.uint8)
    return mesh


def _faces(count: int, start: int) -> NDArray[np.int64]:
    """Return the faces of an outline, whose corner k faces corner n - 1 - k across it."""
    row = np.arange(count // 2 - 1)
    quads = np.column_stack([row * 0 + 4, row, row + 1, count - 2 - row, count - 1 - row])
    quads[:, 1:] += start
    middle = count // 2
    last = np.array([3, middle - 1, middle, middle + 1]) + np.array([0, start, start, start])
    return np.asarray(np.concatenate([quads.ravel(), last]) if count % 2 else quads.ravel())


def _outline(count: int, start: int) -> NDArray[np.int64]:
    row = np.concatenate([[count + 1], np.arange(count), [0]])
    row[1:] += start
    return np.asarray(row)
