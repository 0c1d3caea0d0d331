"""Ray fans: a sample of the rays that the metric casts, clipped to the ROI, fading towards the sensor.

The selected sensor shows a dense fan, the others a sparse one, so that a picture stays below a few thousand
lines.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import pyvista as pv
from numpy.typing import NDArray
from vtkmodules.vtkRenderingCore import vtkRenderer

from riglens.core.rig.model import Sensor
from riglens.core.scene.grid import VoxelGrid
from riglens.core.sensing.rays import clip_to_roi, sensor_rays
from riglens.core.sensors.registry import kind_of
from riglens.core.vehicle.solid import Solid
from riglens.widgets.drawing.actors import hidden, line_mesh, rgba_actor, show_mesh
from riglens.widgets.drawing.camera import OrbitCamera, Size
from riglens.widgets.sensors.appearance import appearance_of, ray_colour, selected_ray_colour
from riglens.widgets.sensors.ray_look import Strokes
from riglens.widgets.theme import Palette, rgb

_NEAR_SHARE = 0.12
_EDGES, _RINGS, _RINGS_ON_LIGHT = 5.0, 2.6, 4.0
"""Opacity of edges of a view and rings of beams, relative to rays; thin dark rings on a light ground look fainter."""
_WIDTHS_PX, _SEAM_PX = (1.0, 1.6), 2.0
"""Widths of the edges of all other sensors, and of the selected one; and the extra width of a seam."""
_NEAR_PIXEL_M = 0.016
"""Size of a pixel above which rays crowd."""
_THINNEST = 0.45
"""Share of their opacity that rays have when they are seen level."""
PYRAMID_M, _PYRAMID_ALPHA = 2.6, 0.9
_Index = NDArray[np.int64]
Points = NDArray[np.float64]
Bools = NDArray[np.bool_]


def fan_rows(sensor: Sensor, most: int) -> _Index:
    """Return row numbers of at most about `most` rays, evenly spread over beams and azimuths or over the image."""
    columns, rows = sensor.resolution
    if appearance_of(sensor.kind).is_fan:
        blocks = kind_of(sensor).blocks(sensor)
        middle = ((np.arange(blocks) + 0.5) * rows / blocks).astype(np.int64)
        across = (
            np.linspace(0, columns - 1, min(columns, max(25, most // (12 * blocks)))).round().astype(np.int64)
        )
        return np.asarray((middle[:, None] * columns + across).ravel())
    if appearance_of(sensor.kind).beams(sensor) is not None:
        return _spread(rows, columns, max(3, min(most // 36, int(most**0.5 / 2))), most, False)
    tall = max(2, round((most / 5 * rows / columns) ** 0.5))
    return _spread(rows, columns, tall, max(4, most // 5), True)


def _spread(slow: int, fast: int, slow_wanted: int, most: int, closed: bool) -> _Index:
    """Return rows of a (slow, fast) lattice: `slow_wanted` lines with both ends, most / slow_wanted places each."""
    first = np.unique(np.linspace(0, slow - 1, min(slow, slow_wanted)).round().astype(np.int64))
    count = max(1, min(fast, most // len(first)))
    second = np.linspace(0, fast - 1 if closed else fast, count, endpoint=closed).round().astype(np.int64)
    second = np.unique(np.minimum(second, fast - 1))
    return np.asarray((first[:, None] * fast + second[None, :]).ravel())


def frame_rows(sensor: Sensor) -> _Index:
    """Return row numbers of the rays in the corners of the image, once round."""
    columns, rows = sensor.resolution
    return np.array([0, columns - 1, rows * columns - 1, (rows - 1) * columns])


class Fan(NamedTuple):
    """Lines with an `rgba` array: some rays, and bolder ones over them: rings of beams or edges of a view."""

    rays: pv.PolyData
    edges: pv.PolyData


def fan_of(
    sensor: Sensor,
    grid: VoxelGrid,
    strokes: Strokes,
    colour: str,
    framed: bool = False,
    solid: Solid | None = None,
    rings: float = _RINGS,
) -> Fan:
    """Return the rays of a sensor inside the ROI, up to the solid where one stops them.

    Rays are faint at the sensor, where they crowd, and strongest where they leave the ROI; there LiDAR beams
    are joined to rings, and a camera's corner rays are drawn stronger to show the frustum. `framed` adds a frame
    that the corner rays pass through. `rings`: opacity of rings and arcs relative to rays.
    """
    starts, ends, row, is_whole = _segments(sensor, grid, fan_rows(sensor, strokes.lines), solid)
    alpha = strokes.opacity
    fan = _tinted(starts, ends, colour, _NEAR_SHARE * alpha, alpha)
    look = appearance_of(sensor.kind)
    beams = look.beams(sensor)
    if look.has_corners:
        return Fan(fan, _frustum(sensor, grid, colour, min(1.0, _EDGES * alpha), framed, solid))
    if look.is_fan:
        return Fan(
            fan,
            _range_arcs(starts, ends, row // sensor.resolution[0], is_whole, colour, min(1.0, rings * alpha)),
        )
    if beams is not None:
        beam = row // sensor.resolution[0]
        return Fan(fan, _beam_rings(beam, beams.goes_round, ends, colour, min(1.0, rings * alpha)))
    return Fan(fan, pv.PolyData())


def _beam_rings(beam: _Index, goes_round: bool, ends: Points, colour: str, alpha: float) -> pv.PolyData:
    """Return lines that join the ends of neighbouring rays of a beam where both leave through floor or ceiling."""
    here = np.arange(len(beam))
    after = np.roll(here, -1)
    if goes_round:
        first = np.searchsorted(beam, beam, side="left")
        last = np.searchsorted(beam, beam, side="right") - 1
        after = np.where(here == last, first, after)
    same_beam = beam == beam[after]
    level = np.abs(ends[:, 2] - ends[after, 2]) < 1e-6
    joined = same_beam & level & (after != here)
    return _tinted(ends[joined], ends[after][joined], colour, alpha, alpha)


def _range_arcs(
    starts: Points, ends: Points, line: _Index, is_whole: Bools, colour: str, alpha: float
) -> pv.PolyData:
    """Return the first and the last ray of each row, and arcs that join the ends of neighbours that end with the
    range."""
    joined = np.flatnonzero((line[1:] == line[:-1]) & is_whole[1:] & is_whole[:-1])
    sides = np.flatnonzero(np.diff(line, prepend=-1, append=-1)[:-1] | np.diff(line, append=-1))
    arcs = _tinted(ends[joined], ends[joined + 1], colour, alpha, alpha)
    return _joined([arcs, _tinted(starts[sides], ends[sides], colour, 0.3 * alpha, alpha)])


def _segments(
    sensor: Sensor, grid: VoxelGrid, rows: _Index, solid: Solid | None
) -> tuple[Points, Points, _Index, Bools]:
    """Return where the picked rays enter and leave the ROI or end, (k, 3) each, the row numbers of those k that do, and
    whether each ends with the range."""
    rays = sensor_rays(sensor, rows)
    t0, t1 = clip_to_roi(grid, rays)
    if solid is not None:
        from riglens.core.sensing.body_ends import barrier_of_some, listed_ends  # the compiler

        t1 = np.minimum(t1, listed_ends(sensor, rays.directions, barrier_of_some(sensor, solid)))
    inside = t1 > t0
    directions, origin = rays.directions[inside], np.array(rays.origin_m)
    near, far, is_whole = t0[inside, None], t1[inside, None], (t1 >= rays.far_m)[inside]
    return origin + near * directions, origin + far * directions, rows[inside], is_whole


def _frustum(
    sensor: Sensor, grid: VoxelGrid, colour: str, alpha: float, framed: bool, solid: Solid | None
) -> pv.PolyData:
    """Return the four edges of the field of view and, if requested, a frame one metre ahead through the corners.

    A fisheye that has no ray in a corner, or one that looks sideways, has no such frame.
    """
    starts, ends, *_ = _segments(sensor, grid, frame_rows(sensor), solid)
    edges = _tinted(starts, ends, colour, alpha, 0.7 * alpha)
    if not framed or not len(starts):
        return edges
    rays = sensor_rays(sensor, frame_rows(sensor))
    depth = rays.directions @ sensor.pose.rotation()[:, 0]
    if not (depth > 0.1).all():
        return edges
    ahead = rays.directions / depth[:, None]
    corners = np.array(rays.origin_m) + ahead
    return _joined([edges, _tinted(corners, np.roll(corners, -1, axis=0), colour, alpha, alpha)])


def pyramid_of(sensor: Sensor, colour: str, alpha: float) -> Fan:
    """Return the field of view of a camera as a pyramid of PYRAMID_M: its edge, and lines to the corners.

    Of a lens without rays in the corners, lines to the middles of the sides of what it images.
    """
    columns, rows = sensor.resolution
    across, down = np.arange(columns), columns * np.arange(rows)  # a table of all rays takes a frame's time
    sides = (across, down[1:] + columns - 1, down[-1] + across[-2::-1], down[-2:0:-1])
    border = np.concatenate([side[:: max(1, len(side) // 24)] for side in sides])
    rays = sensor_rays(sensor, border)
    ends = PYRAMID_M * rays.directions
    depth = rays.directions @ sensor.pose.rotation()[:, 0]
    if kind_of(sensor).lattice(sensor) is not None:
        ends = ends / depth[:, None]
    known = np.isfinite(ends[:, 0])
    corner = np.isin(border, frame_rows(sensor)) if known.all() else np.arange(len(border)) % 24 == 12
    ends = ends[known] + rays.origin_m
    spokes = ends[corner[known]]
    lines = [(ends, np.roll(ends, -1, axis=0)), (np.tile(rays.origin_m, (len(spokes), 1)), spokes)]
    return Fan(pv.PolyData(), _joined([_tinted(*pair, colour, alpha, alpha) for pair in lines]))


def _tinted(starts: Points, ends: Points, colour: str, alpha: float, alpha_end: float) -> pv.PolyData:
    """Return segments with an `rgba` array: one colour, opacity from `alpha` at the start to `alpha_end`."""
    mesh = line_mesh(starts, ends)
    rgba = np.empty((2 * len(starts), 4), dtype=np.uint8)
    rgba[:, :3] = np.array(rgb(colour)) * 255
    rgba[0::2, 3], rgba[1::2, 3] = round(alpha * 255), round(alpha_end * 255)
    if len(starts):
        mesh["rgba"] = rgba
    return mesh


def _joined(meshes: list[pv.PolyData]) -> pv.PolyData:
    """Return all segments in one mesh (no filter: this runs on every mouse move)."""
    full = [mesh for mesh in meshes if mesh.n_points]
    if not full:
        return pv.PolyData()
    points = np.concatenate([mesh.points for mesh in full])
    joined = line_mesh(points[0::2], points[1::2])
    joined["rgba"] = np.concatenate([mesh["rgba"] for mesh in full])
    return joined


def _rings_on(palette: Palette) -> float:
    """Return the opacity of rings on the ground of a theme, relative to rays."""
    return _RINGS if palette.is_dark else _RINGS_ON_LIGHT


class RaysLayer:
    """Fans of a scene: those of all others below that of the selected sensor.

    Edges have a wider seam below them, which keeps them legible on a heatmap of any colour; on the ground, whose
    colour it has, it is not seen.
    """

    def __init__(self, renderer: vtkRenderer) -> None:
        self._fans = tuple(_FanLines(renderer, width_px) for width_px in _WIDTHS_PX)

    def set_line_width(self, width_px: float) -> None:
        """Set the width of the lines, for pictures of higher resolution."""
        for fan in self._fans:
            fan.set_width(width_px)

    def arrange(self, camera: OrbitCamera, size: Size, pixel_ratio: float) -> None:
        """Draw fainter rays where they crowd: from far away, and where a camera sees all of them side on."""
        pixel_m = pixel_ratio * camera.metres_per_pixel(np.array(camera.focal_m), size)
        level = 1.0 - (1.0 - _THINNEST) * camera.from_the_side
        for fan in self._fans:
            fan.set_opacity(level * min(1.0, (_NEAR_PIXEL_M / pixel_m) ** 0.5), level)

    def show(
        self,
        sensors: Sequence[Sensor],
        is_selected: bool,
        grid: VoxelGrid,
        palette: Palette,
        strokes: Strokes,
        solid: Solid | None = None,
        lattice: bool = True,
    ) -> None:
        """Draw the fan of the selected sensor, or those of all others; rays end at the solid.

        Without `lattice` sensors with corners show a pyramid.
        """
        colour = selected_ray_colour if is_selected else ray_colour

        def fan(sensor: Sensor) -> Fan:
            own = colour(sensor.kind, palette)
            if appearance_of(sensor.kind).has_corners and not lattice:
                return pyramid_of(sensor, palette.selected if is_selected else own, _PYRAMID_ALPHA)
            return fan_of(sensor, grid, strokes, own, is_selected, solid, _rings_on(palette))

        fans = [fan(sensor) for sensor in sensors]
        rays, edges = (_joined([fan[part] for fan in fans]) for part in (0, 1))
        self._fans[is_selected].show(Fan(rays, edges), palette.seam)


class _FanLines:
    """Three actors: rays, and over them the seams of edges and the edges."""

    def __init__(self, renderer: vtkRenderer, width_px: float) -> None:
        self._width_px = width_px
        self.rays, self.seams, self.edges = (
            hidden(renderer, rgba_actor(pv.PolyData(), name)) for name in ("rgba", "seam", "rgba")
        )
        for actor in (self.rays, self.seams, self.edges):
            actor.force_translucent = True
        self.set_width(1.0)

    def set_width(self, width_px: float) -> None:
        """Set the width of a ray; seams and edges are wider by as much."""
        widths = (1.0, self._width_px + _SEAM_PX, self._width_px)
        for actor, share in zip((self.rays, self.seams, self.edges), widths, strict=True):
            actor.prop.line_width = share * width_px

    def set_opacity(self, rays: float, edges: float) -> None:
        """Draw them fainter, 0 to 1."""
        for actor, share in ((self.rays, rays), (self.seams, edges), (self.edges, edges)):
            actor.prop.opacity = share

    def show(self, fan: Fan, seam: str) -> None:
        """Draw a fan; empty parts are left out."""
        if fan.edges.n_points:
            below = np.array(fan.edges["rgba"])
            below[:, :3] = np.array(rgb(seam)) * 255
            fan.edges["seam"] = below
        for actor, mesh in ((self.rays, fan.rays), (self.seams, fan.edges), (self.edges, fan.edges)):
            show_mesh(actor, mesh)
