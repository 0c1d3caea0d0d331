"""Decide whether a LiDAR can be cast by core and beam cones, and build the cones."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from riglens.core.engine.fans import is_near, is_well_scaled
from riglens.core.kernels.beams.cones import A_TURN, FINDER, HALF_COLUMN, NO_BEAMS, SLACK, Beams, Spinner
from riglens.core.kernels.beams.cores import NEARLY_ONE, Shells
from riglens.core.kernels.cameras.frustum import BALL
from riglens.core.kernels.rays.cast import Cast
from riglens.core.kernels.runtime.codes import LISTED
from riglens.core.rig.model import Lidar

STEEPEST_DEG = 65.0
"""Beams that rise or fall by more in some direction are walked ray by ray: their way through the grid is short."""
SHORTEST_RADIUS = 80.0
"""Voxels: where rays drift apart so soon, walking them is quicker."""
WORTH = 0.38
"""Voxels: where the rays of a beam are farther apart, and no core is, walking them is quicker than its sheet."""
FEWEST_RAYS = 100_000
"""Of more rays, walking takes 1.3 to 4 times as long as sheets for tilted LiDARs of the library, for 23 of 27 models at
least 1.5 times; of fewer, 0.97 to 1.48 times, but for one of 37 models (1.6). Their kernels are 10 s of compiling."""
FEWEST_AZIMUTHS = 400
"""A sector of fewer azimuths is walked sooner: much of its tiles lies outside of it."""
WIDEST_OFFSET = 0.5
"""Radians between the azimuth offsets of a sector's beams, so that what all of them cover is a sector too."""
FEWEST_GAPS = 2
SMALLEST_CORE = 4.0
"""Voxels: smaller cores are not worth looking for."""


class Sheets(NamedTuple):
    """Cones and cores of a LiDAR for `kernels.beams.beam_cones`, as far as the radius in plan, the largest of all
    beams; `rest` are the casts of rays that are walked: those of steep beams, and those that go beyond."""

    spinner: Spinner
    beams: Beams
    shells: Shells
    radius: float
    rest: list[Cast]


def make_sheets(
    lidar: Lidar,
    rays: Cast,
    shortest: float = SHORTEST_RADIUS,
    worth: float = WORTH,
    fewest: int = FEWEST_AZIMUTHS,
) -> Sheets | None:
    """Return the cones of a LiDAR in grid units, each as far as its rays are within `worth` voxels of each other or in
    a core; None if walking its rays is simpler, or faster because they drift apart within the `shortest` radius in
    voxels, or because they are a scan pattern or a sector of fewer azimuths than the `fewest`."""
    if (
        lidar.rays is not None
        or not is_near(rays)
        or not is_well_scaled(rays.rows, rays.planes, rays.rotation, rays.origin)
    ):
        return None
    spinner = _spinner(lidar, rays)
    if spinner.is_sector and spinner.azimuths.size < fewest:
        return None
    beams = _beams(lidar, spinner, _upper(rays))
    spinner = spinner._replace(stopped_before=_stopped_before(spinner, beams))
    heights = rays.box[4:] - rays.origin[2]
    squared = (2.0 * BALL / spinner.step) ** 2 - float(np.abs(heights).max()) ** 2
    radius = float(np.sqrt(max(squared, 0.0)))
    offsets = beams.offset
    if radius < shortest or (spinner.is_sector and np.ptp(offsets) > WIDEST_OFFSET):
        return None
    shells = _shells(beams, spinner.step)
    beams.radius[:] = _radii(shells, worth / spinner.step, radius)
    return Sheets(spinner, beams, shells, float(beams.radius.max()), _rest(spinner, beams, rays))


def _spinner(lidar: Lidar, rays: Cast) -> Spinner:
    azimuths, turns, step, is_sector = _azimuths(np.radians(lidar.azimuths()))
    axis = rays.rotation[:, 2] * _upper(rays)
    return Spinner(
        rays.kind, rays.rows, rays.planes, rays.origin, rays.rotation, rays.reach, rays.box, rays.shape, axis,
        azimuths, turns, step, is_sector, rays.is_stopped,
    )  # fmt: skip


def _stopped_before(spinner: Spinner, beams: Beams) -> NDArray[np.int32]:
    """Return the number of stopped rays among the first azimuths of each beam, see `Spinner`."""
    if not spinner.is_stopped.size:
        return NO_BEAMS
    table: NDArray[np.bool_] = spinner.is_stopped.reshape(len(beams.number), spinner.azimuths.size)
    before = np.zeros((len(beams.number), spinner.azimuths.size + 1), np.int32)
    some = np.flatnonzero(np.logical_or.reduce(table, axis=1)[beams.number])
    before[some, 1:] = np.cumsum(table[beams.number[some]][:, spinner.turns], axis=1)
    return before


def _upper(rays: Cast) -> float:
    """Return 1 where the upper end of the sensor's axis points up, -1 where it is upside down."""
    return -1.0 if rays.rotation[2, 2] < 0.0 else 1.0


def _azimuths(
    azimuth: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.int64], float, bool]:
    """Return azimuths in ascending order from behind their widest gap, their numbers, the widest other gap, and
    whether they leave out a sector: whether the widest gap is much wider than that."""
    order = np.argsort(azimuth % A_TURN, kind="stable")
    sorted_ = (azimuth % A_TURN)[order]
    gaps = np.append(np.diff(sorted_), sorted_[0] + A_TURN - sorted_[-1])
    first = (int(np.argmax(gaps)) + 1) % len(gaps)
    ordered = np.concatenate([sorted_[first:], sorted_[:first] + A_TURN])
    others = np.sort(gaps)[:-1]
    inner = float(others[-1]) if others.size else 0.0
    is_sector = bool(gaps.max() > 1.5 * inner)
    step = inner if is_sector else float(gaps.max())
    return ordered, np.roll(order, -first), max(step, 1e-9), is_sector


def _beams(lidar: Lidar, spinner: Spinner, upper: float) -> Beams:
    """Return the cones in ascending order; see `kernels.beams.cones`."""
    axis, elevation = spinner.axis, upper * np.radians(lidar.elevations())
    order = np.argsort(elevation, kind="stable")
    elevation = elevation[order]
    sine, cosine = np.sin(elevation), np.cos(elevation)
    lean = float(np.arctan2(np.hypot(axis[0], axis[1]), axis[2]))
    steepest = np.abs(elevation) + lean
    flat = steepest <= np.radians(STEEPEST_DEG)
    opening = np.where(flat, axis[2] ** 2 - sine**2, 1.0)
    offsets = np.radians(np.array(lidar.azimuth_offsets_deg or np.zeros(lidar.beam_count)))[order]
    first, last = spinner.azimuths[0] + offsets, spinner.azimuths[-1] + offsets
    return Beams(
        elevation,
        sine,
        cosine,
        np.where(flat, -axis[2] / opening, 0.0),
        np.where(flat, sine / opening, 0.0),
        np.where(flat, opening, 0.0),
        np.where(flat, np.tan(np.minimum(steepest, 1.5)), 0.0),
        np.where(flat, np.abs(sine) * cosine**2 / opening**1.5, np.inf),
        order,
        offsets,
        np.stack([np.cos(first), np.sin(first), np.cos(last), np.sin(last)], axis=1),
        np.full(elevation.size, np.inf),
        np.searchsorted(sine, np.arange(FINDER) * (2.0 / FINDER) - 1.0),
    )


def _shells(beams: Beams, step: float) -> Shells:
    """Return cores between beams that are no farther apart than some of the gaps between them."""
    gaps = np.diff(beams.elevation)
    is_flat = np.isfinite(beams.bend)
    gaps = np.where(is_flat[1:] & is_flat[:-1], gaps, np.inf)
    finite = gaps[np.isfinite(gaps)]
    cores: dict[tuple[int, int], float] = {}
    for gap in np.quantile(finite, (0.5, 0.9, 1.0), method="higher") * 1.001 + 1e-9 if finite.size else ():
        reach = _core_radius(float(gap), step)
        for run in _runs(gaps <= gap) if reach >= SMALLEST_CORE else ():
            if run[1] - run[0] >= max(FEWEST_GAPS, len(gaps) // 8):
                cores.setdefault(run, reach)
    low, high = np.array(list(cores), np.int64).reshape(-1, 2).T
    radius = np.array(list(cores.values()))
    inside = np.minimum(
        beams.elevation - beams.elevation[low][:, None], beams.elevation[high][:, None] - beams.elevation
    )
    with np.errstate(divide="ignore"):
        since = np.where(inside > 0.0, NEARLY_ONE / np.sin(np.clip(inside, 0.0, 1.5)), np.inf)
    return Shells(
        np.ascontiguousarray(low), np.ascontiguousarray(high), radius**2, since, radius - NEARLY_ONE
    )


def _radii(shells: Shells, worth: float, most: float) -> NDArray[np.float64]:
    """Return the radius to which the cone of each beam is followed: while it pays off, to the end of an enclosing core,
    or for its last fifth."""
    until = shells.until[:, None]
    ends = np.where(shells.since <= np.maximum(worth, 0.8 * until), until, worth)
    radii: NDArray[np.float64] = np.minimum(ends.max(axis=0, initial=worth), most)
    return radii


def _core_radius(gap: float, step: float) -> float:
    """Return the distance from the sensor, in voxels, up to which every place between two beams is within BALL of a
    ray."""
    chord = 0.5 * float(np.hypot(0.5 * gap, 0.5 * step))
    angle = 2.0 * np.arcsin(min(chord, 1.0))
    return float(BALL / np.sin(angle)) if angle < 1.0 else 0.0


def _runs(close: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Return first and last beam of each run of gaps that are close enough."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], close, [False]]).astype(np.int8)))
    return [(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True)]


def _rest(spinner: Spinner, beams: Beams, rays: Cast) -> list[Cast]:
    """Return the rays to be walked: all of steep beams, and of the others those beyond the tiles within their
    radius."""
    begin = beams.radius - 2.0 * HALF_COLUMN - SLACK
    rest = []
    steep = ~np.isfinite(beams.bend)
    if steep.any():
        rest.append(_only(rays, np.sort(beams.number[steep]), spinner.azimuths.size))
    low, high = rays.box[4:] - rays.origin[2]
    lean = float(np.arctan2(np.hypot(spinner.axis[0], spinner.axis[1]), spinner.axis[2]))
    lowest, highest = np.sin(beams.elevation - lean) * begin, np.sin(beams.elevation + lean) * begin
    goes_on = ~steep & (lowest <= max(high, 0.0) + 1.0) & (highest >= min(low, 0.0) - 1.0)
    corners = np.abs(rays.box[:4].reshape(2, 2) - rays.origin[:2, None]).max(axis=1)
    goes_on &= begin <= min(float(np.hypot(*corners)), float(rays.reach[1]))
    for start in np.unique(begin[goes_on]):
        beyond = np.array([max(start, rays.reach[0]), rays.reach[1]])
        numbers = np.sort(beams.number[goes_on & (begin == start)])
        rest.append(_only(rays, numbers, spinner.azimuths.size)._replace(reach=beyond))
    return rest


def _only(rays: Cast, beams: NDArray[np.int64], turns: int) -> Cast:
    """Return the rays of some beams."""
    if rays.is_stopped.size:
        rays = rays._replace(is_stopped=rays.is_stopped.reshape(-1, turns)[beams].ravel())
    if rays.kind != LISTED:
        return rays._replace(rows=np.ascontiguousarray(rays.rows[beams]))
    return rays._replace(rows=np.ascontiguousarray(rays.rows.reshape(-1, turns, 3)[beams].reshape(-1, 3)))
