"""Decide whether a sensor's rays can be walked as fans of vertical planes, and build the fans and their profile."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from riglens.core.kernels.fans.fan import FARTHEST_ORIGIN, STEEPEST, mark_fan
from riglens.core.kernels.fans.leftover_rays import mark_alone
from riglens.core.kernels.fans.planes import Fan
from riglens.core.kernels.fans.profile import Events, Profile, Slopes, find_stays, masks_of
from riglens.core.kernels.fans.spans import find_spans
from riglens.core.kernels.rays.cast import Cast
from riglens.core.kernels.runtime.codes import LIDAR, LISTED
from riglens.core.rig.model import Lidar
from riglens.core.scene.columns import Words
from riglens.core.sensing.rays import lattices_by_offset

TAMEST, WILDEST = 2.0**-110, 2.0**110
"""Table entries in this range, three of them multiplied and subtracted, keep the exact predicates valid."""
FEWEST_BEAMS = 6
"""Of each azimuth offset on average, steep ones by the part of the way that they go: planes with fewer rays than that
take longer than core and sheets."""
MEAN_WAY = 0.55
"""Mean way of level rays, as a share of the way to the farthest corner of the box."""
LEFT_ALONE_MOST = 4096
"""Rays that each worker notes before they are walked one by one."""


def _row_slopes(rays: Cast) -> NDArray[np.float64]:
    """Return the slope dz / ds of each row in a plane of scale 1, (rows,)."""
    first, second = rays.rows.T
    slopes: NDArray[np.float64] = second / first if rays.kind == LIDAR else first
    return slopes


def _plane_headings(rays: Cast) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the heading of each plane in the sensor frame, (planes, 2), and the scale of its slopes, (planes,)."""
    if rays.kind == LIDAR:
        return rays.planes, np.ones(len(rays.planes))
    y = rays.planes[:, 0]
    length = np.sqrt(1.0 + y * y)
    return np.stack([1.0 / length, y / length], axis=1), 1.0 / length


def make_fan(rays: Cast, near_is_empty: bool = False) -> Fan:
    """Make the fan of rays turned about the vertical.

    near_is_empty: whether nothing counts that is so near to the sensor that some ray may not have begun there.
    """
    headings, scales = _plane_headings(rays)
    slopes = _row_slopes(rays)
    order = np.argsort(slopes, kind="stable")
    flat = np.abs(slopes[order]) <= STEEPEST
    row_of = order[flat]
    turned = np.ascontiguousarray(headings @ rays.rotation[:2, :2].T)
    forward = rays.rows[row_of, 0] if rays.kind == LIDAR else np.ones(len(row_of))
    near, far = rays.reach[0] * forward, rays.reach[1] * forward
    return Fan(
        turned, scales, slopes[row_of], near, far, row_of, order[~flat], *_spans(rays, row_of),
        (rays.reach[0] == 0.0 or near_is_empty) and rays.reach[1] > farthest(rays) + 1.0,
    )  # fmt: skip


def _spans(rays: Cast, row_of: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int32]]:
    """Return the runs of free rays of each plane, see `find_spans`; empty where none is stopped."""
    if not rays.is_stopped.size:
        return np.zeros(0, np.int64), np.zeros((0, 2), np.int32)
    rows, planes = len(rays.rows), len(rays.planes)
    starts = np.zeros(planes + 1, np.int64)
    has_stops: NDArray[np.bool_] = np.logical_or.reduce(rays.is_stopped.reshape(rows, planes), axis=1)
    return starts, find_spans(rays.is_stopped, has_stops, row_of, planes, starts)


def make_profile(fan: Fan, rays: Cast) -> Profile | None:
    """Return the levels of a fan's rays by forward distance, as far as the box reaches; None if a range ends so
    close to a face that only the exact walk can tell."""
    low, high, depth = int(rays.box[4]), int(rays.box[5]), (int(rays.shape[2]) + 63) // 64
    most = 2 * (len(fan.slopes) + 2) * (high - low + 1)
    events = Events(np.empty(most), np.empty(most, np.int32))
    slopes = Slopes(fan.slopes, fan.near, fan.far, np.argsort(fan.near, kind="stable"))
    count = find_stays(slopes, rays.origin[2], low, high, farthest(rays) + 1.0, events)
    if count < 0:
        return None
    order = np.argsort(events.at[:count], kind="stable")
    at = np.append(events.at[order], np.inf)
    ordered = events.changes[order]
    begun = int(np.searchsorted(at, 0.0, side="right"))
    return Profile(at, ordered, masks_of(ordered, depth), begun)


def mark_planes(
    fan: Fan, rays: Cast, profile: Profile, first: int, end: int, slabs: NDArray[np.int64], marks: Words
) -> None:
    """Mark the voxels that rays of the planes first..end-1 traverse, in marks uint64 (words,).

    slabs int64 (workers, 2): the rows of the grid for each worker.
    """
    listed = np.empty((len(slabs), LEFT_ALONE_MOST, 6), np.int32)
    counts = np.empty(len(slabs), np.int64)
    for limited in (None, True) if fan.span_starts.size else (None,):
        done = np.full(len(slabs), first, np.int64)
        while (done < end).any():
            counts[:] = 0
            mark_fan(fan, rays, profile, limited, end, slabs, done, listed, counts, marks)
            if counts.any():
                mark_alone(rays, listed, counts, marks)


def share_rows(work: NDArray[np.float64], x_from: int, x_to: int, workers: int) -> NDArray[np.int64]:
    """Cut the rows x_from..x_to-1 of the grid into a part for each worker, (workers, 2), so that all have as much to
    do; work (rows,) of each row of the grid."""
    done = np.cumsum(work[x_from:x_to])
    cuts = x_from + np.searchsorted(done, done[-1] * np.arange(1, workers) / workers)
    return np.stack([np.append(x_from, cuts), np.append(cuts, x_to)], axis=1)


def farthest(rays: Cast) -> float:
    """Return the distance in voxels from the origin of the rays to the farthest corner of their box."""
    return float(np.linalg.norm(np.abs(rays.box.reshape(3, 2).T - rays.origin).max(axis=0)))


def is_upright(rotation: NDArray[np.float64]) -> bool:
    """Return whether a sensor only yaws: its vertical planes stay vertical."""
    return bool(rotation[2, 2] == 1.0 and rotation[2, 0] == 0.0 and rotation[2, 1] == 0.0)


def is_plain(rays: Cast) -> bool:
    """Return whether the short cuts hold: rays in rows and planes, from the origin to the end of the box for cameras,
    an origin not too far away for their tolerance, and no number so small or large that a ray could need rational
    arithmetic."""
    if rays.kind == LISTED:
        return False
    endless = rays.reach[0] == 0.0 and rays.reach[1] > farthest(rays) + 1.0
    return bool(
        is_near(rays)
        and (endless or rays.kind == LIDAR)
        and is_well_scaled(rays.rows, rays.planes, rays.rotation, rays.origin)
    )


def has_few(offsets: Sequence[float]) -> bool:
    """Return whether enough beams share an azimuth offset to make planes of each worthwhile."""
    return len(set(offsets)) * FEWEST_BEAMS <= len(offsets)


def _level_beams(lidar: Lidar, rays: Cast) -> float:
    """Return the number of beams of an upright LiDAR, steep ones weighted by the part of their way inside the box."""
    slopes = np.tan(np.radians(lidar.elevations()))
    below, above = rays.origin[2] - rays.box[4], rays.box[5] - rays.origin[2]
    room = np.maximum(np.where(slopes > 0.0, above, below), 0.0)
    way = MEAN_WAY * max(farthest(rays), 1.0)
    return float(np.minimum(room / np.maximum(np.abs(slopes) * way, 1e-9), 1.0).sum())


def by_offset(lidar: Lidar, rays: Cast) -> list[Cast]:
    """Return the rays of an upright LiDAR whose beams have few azimuth offsets, those of each offset as a separate fan;
    none for others."""
    offsets = lidar.azimuth_offsets_deg
    if (
        offsets is None
        or not has_few(offsets)
        or _level_beams(lidar, rays) < FEWEST_BEAMS * len(set(offsets))
    ):
        return []
    parts = []
    for beams, lattice in lattices_by_offset(lidar):
        stopped = rays.is_stopped
        if stopped.size:
            stopped = stopped.reshape(len(offsets), -1)[beams].ravel()
        part = rays._replace(kind=lattice.kind, rows=lattice.rows, planes=lattice.planes, is_stopped=stopped)
        if not is_plain(part):
            return []
        parts.append(part)
    return parts


def is_near(rays: Cast) -> bool:
    """Return whether places are small enough for tolerances in voxels."""
    return bool(max(np.abs(rays.origin).max(), rays.box.max()) <= FARTHEST_ORIGIN)


def may_stride(rays: Cast) -> bool:
    """Return whether rays may be walked in strides."""
    return is_near(rays) and not rays.bresenham


def planes_of(rays: Cast) -> int:
    """Return the number of rays per row of the lattice; all of them where rays are listed and rows are unknown."""
    if len(rays.planes) > 1:
        return len(rays.planes)
    is_whole = rays.in_row > 0 and len(rays.rows) % rays.in_row == 0
    return rays.in_row if is_whole else len(rays.rows)


def is_well_scaled(*tables: NDArray[np.float64]) -> bool:
    """Return whether no number of some tables is so small or large that a ray could need rational arithmetic."""
    for table in tables:
        small = (table < TAMEST) & (table > -TAMEST)
        widest = max(table.max(initial=0.0), -table.min(initial=0.0))
        if widest > WILDEST or (small.any() and table[small].any()):
            return False
    return True
