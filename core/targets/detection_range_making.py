"""Computes detection ranges: LiDAR points by the target engine, heights in pixels by the lens of each camera."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from riglens.core.kernels.body.solid import meet_listed
from riglens.core.rig.model import Camera, Lidar, Rig
from riglens.core.scene.boxes import CLASSES, DataReport, Progress, rotations_from_yaw
from riglens.core.sensing.body_ends import barrier_of
from riglens.core.sensors.camera import CAMERA, project_px
from riglens.core.sensors.lidar import LIDAR
from riglens.core.sensors.registry import AnyKind, further_kinds
from riglens.core.targets.beams import azimuth_step_rad
from riglens.core.targets.detection_range import (
    SIZES_M,
    USUAL_PLAN,
    Case,
    DetectionRange,
    Doubles,
    RangePlan,
    RangeRow,
    Reach,
)
from riglens.core.targets.engine import TargetEngine
from riglens.core.targets.traffic import Traffic, traffic_of
from riglens.core.vehicle.housings import car_of
from riglens.core.vehicle.solid import Solid

TURNS, RISES = 2, 12
"""Places within a step of azimuths, and within a gap between beams."""
WIDEST_GAP_DEG = 4.0
HEIGHTS = 17
"""Heights on an object at which self-occlusion of a camera is tested: every sixteenth of it."""
_SHARES = np.linspace(-0.5, 0.5, HEIGHTS)


def _unheard(_: float) -> None:
    """Ignore the progress."""


def detection_range_of(
    rig: Rig,
    plan: RangePlan = USUAL_PLAN,
    threads: int | None = None,
    progress: Progress = _unheard,
) -> DetectionRange:
    """Return the detection ranges of a rig's enabled sensors.

    `progress` gets the share that is done, from 0 to 1, again every few milliseconds; what it raises ends the work.
    """
    steps_deg, lidars = lattice_steps_deg(rig.enabled_lidars()), rig.with_lidars_alone()
    solid = car_of(rig) if plan.settings.body == "blocks" else None
    counting = _Counting(lidars, plan, steps_deg, threads)
    enabled = [sensor for sensor in rig.sensors if sensor.enabled]
    others = {
        kind: counting._replace(
            sensors=rig.only(tuple(one for one in enabled if one.kind == kind.name)), steps_deg=(0.0, 0.0)
        )
        for kind in further_kinds(one.kind for one in enabled)
    }
    rows, cases = [], plan.cases()
    for number, case in enumerate(cases):
        tell = partial(progress, number / len(cases))
        heights = heights_px(rig.enabled_cameras(), _poses(plan, case), SIZES_M[case.cls], solid)
        found: dict[AnyKind, NDArray[Any]] = {
            LIDAR: counting.points(case, tell),
            CAMERA: heights[None],
            **{kind: one.points(case, tell) for kind, one in others.items()},
        }
        reaches = {
            kind.name: reach_of(plan.distances_m(), count >= plan.enough(kind))
            for kind, count in found.items()
        }
        half_m = SIZES_M[case.cls][0 if case.heading_deg == 0.0 else 1] / 2
        rows.append(RangeRow(*case, reaches, -rig.vehicle.length / 2 - half_m))
    progress(1.0)
    return DetectionRange(rig, plan, tuple(rows), steps_deg[0])


def reach_of(distances_m: Doubles, enough: NDArray[np.bool_]) -> Reach:
    """Return the reach over places (k, distances) within the lattice; enough points again farther out do not count."""
    first, begin = [], []
    for row in enough:
        if not row.any():
            first.append(0.0)
            continue
        start = int(np.argmax(row))
        begin.append(float(distances_m[start]))
        after = np.flatnonzero(~row[start:])
        first.append(float(distances_m[start + after[0]]) if after.size else math.inf)
    ordered = sorted(first)
    return Reach(ordered[0], ordered[(len(ordered) - 1) // 2], ordered[-1], max(begin, default=0.0))


def lattice_steps_deg(lidars: Sequence[Lidar]) -> tuple[float, float]:
    """Return the widest gap between beams near the horizon, at most WIDEST_GAP_DEG, and widest step between
    azimuths."""
    gap_deg, step_deg = 0.0, 0.0
    for lidar in lidars:
        beams = np.unique(lidar.elevations())
        if beams.size > 1:
            place = min(max(int(np.searchsorted(beams, 0.0)), 1), beams.size - 1)
            gap_deg = max(gap_deg, float(beams[place] - beams[place - 1]))
        step_deg = max(step_deg, math.degrees(azimuth_step_rad(lidar)))
    return min(gap_deg, WIDEST_GAP_DEG), step_deg


class _Poses(NamedTuple):
    """Centres (n, 3) in metres and yaw (n,) in radians, in the vehicle frame."""

    centre_m: Doubles
    yaw_rad: Doubles


def _poses(plan: RangePlan, case: Case, turn_deg: float = 0.0, rise_deg: float = 0.0) -> _Poses:
    """Return an object at every distance; turned about the car by a part of a step and lifted by a part of a gap."""
    distance_m, bearing = plan.distances_m(), math.radians(case.bearing_deg + turn_deg)
    up_m = SIZES_M[case.cls][2] / 2 + distance_m * math.tan(math.radians(rise_deg))
    centre = np.column_stack([distance_m * math.cos(bearing), distance_m * math.sin(bearing), up_m])
    return _Poses(centre, np.full(distance_m.size, bearing + math.radians(case.heading_deg)))


class _Counting(NamedTuple):
    """Settings for counting points of LiDARs, or returns of another kind: sensors, plan, lattice, threads."""

    sensors: Rig
    plan: RangePlan
    steps_deg: tuple[float, float]
    threads: int | None

    def points(self, case: Case, tell: Callable[[], None]) -> NDArray[np.int64]:
        """Return points or returns (places within the lattice, distances) on an object; calls `tell` often."""
        tell()
        gap_deg, step_deg = self.steps_deg
        turns, rises = ((np.arange(count) + 0.5) / count for count in (TURNS, RISES))
        places = [
            _poses(self.plan, case, turn * step_deg, (rise - 0.5) * gap_deg)
            for turn in turns
            for rise in rises
        ]
        found = np.zeros(len(places) * self.plan.distances_m().size, np.int64)
        if self.sensors.sensors:
            engine = TargetEngine(_alone(case.cls, places), self.threads)
            scores = engine.evaluate(self.sensors, self.plan.settings, cancel=partial(_stays_wanted, tell))
            found[engine.traffic.row[scores.objects.box]] = (
                scores.objects.all_points + scores.objects.all_returns
            )
        return found.reshape(len(places), -1)


def _stays_wanted(tell: Callable[[], None]) -> bool:
    """Return whether the request is cancelled, by reporting progress: a raised error cancels."""
    tell()
    return False


def _alone(cls: str, places: Sequence[_Poses]) -> Traffic:
    """Return each object in a frame of its own."""
    centre = np.concatenate([place.centre_m for place in places])
    turn = rotations_from_yaw(np.concatenate([place.yaw_rad for place in places]))
    codes, sizes = np.full(len(centre), CLASSES.index(cls), np.uint8), np.tile(SIZES_M[cls], (len(centre), 1))
    data = DataReport("one object at a time", len(codes), dict.fromkeys(CLASSES, 0))
    return traffic_of(data, np.arange(len(codes)), codes, centre, sizes, turn).within(1e6)


def heights_px(
    cameras: Sequence[Camera],
    poses: _Poses,
    size_m: tuple[float, float, float],
    solid: Solid | None = None,
) -> Doubles:
    """Return the native pixels (n,) from the highest to the lowest corner of a box within the image of the camera that
    shows it tallest, less the rows that the own car hides above and below; 0 if no camera shows it, or a part of
    it is outside the valid range of the lens."""
    corners = np.array([[i, j, k] for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)]) * np.array(size_m) / 2
    points = _placed(poses, corners)
    tallest = np.zeros(len(points))
    for camera in cameras:
        pixels, imaged = _imaged(camera, points)
        u, v = pixels[..., 0], pixels[..., 1]
        inside = np.asarray(imaged & (u.max(axis=1) > 0.0) & (u.min(axis=1) < camera.image[0]), np.bool_)
        high, low = v.min(axis=1), v.max(axis=1)
        reach = np.linalg.norm(poses.centre_m - np.asarray(camera.position), axis=1)
        inside &= (reach >= camera.range_m[0]) & (reach <= camera.range_m[1])
        if solid is not None and inside.any():
            some = np.flatnonzero(inside)
            seen = _Poses(poses.centre_m[some], poses.yaw_rad[some])
            high[some], low[some] = _left_by_body(camera, solid, seen, size_m, (high[some], low[some]))
        tall = np.clip(low, 0.0, camera.image[1]) - np.clip(high, 0.0, camera.image[1])
        tallest = np.maximum(tallest, np.where(inside, tall, 0.0))
    return tallest


def _placed(poses: _Poses, offsets_m: Doubles) -> Doubles:
    """Return points (n, k, 3) in the vehicle frame at offsets (k, 3) in the axes of each object."""
    turn = rotations_from_yaw(poses.yaw_rad)
    return np.asarray(poses.centre_m[:, None, :] + np.einsum("nij,kj->nki", turn, offsets_m))


def _imaged(camera: Camera, points_m: Doubles) -> tuple[Doubles, NDArray[np.bool_]]:
    """Return pixels (n, k, 2) of points (n, k, 3), 0 for objects that the lens cannot image completely, and which of
    them it can (n,)."""
    local = (points_m.reshape(-1, 3) - np.asarray(camera.position)) @ camera.pose.rotation()
    pixels = project_px(camera, local).reshape(*points_m.shape[:2], 2)
    whole = np.asarray(np.isfinite(pixels[..., 0]).all(axis=1), np.bool_)
    return np.where(whole[:, None, None], pixels, 0.0), whole


def _left_by_body(
    camera: Camera,
    solid: Solid,
    poses: _Poses,
    size_m: tuple[float, float, float],
    ends_px: tuple[Doubles, Doubles],
) -> tuple[Doubles, Doubles]:
    """Return the highest and lowest row of objects (n,) that the own car leaves visible: rows beyond the highest and
    lowest free heights, those at which it does not stop the rays to all places, are lost; both 0 without any.

    Looked at are HEIGHTS heights at both ends and in the middle of the longer side.
    """
    longer = (size_m[0], 0.0) if size_m[0] >= size_m[1] else (0.0, size_m[1])
    aside = np.array([-0.5, 0.0, 0.5])[:, None] * np.array(longer)
    points = _placed(poses, np.array([[x, y, z * size_m[2]] for z in _SHARES for x, y in aside]))
    free = np.asarray(_is_free(camera, solid, points).reshape(len(points), HEIGHTS, 3).any(axis=2), np.bool_)
    pixels, imaged = _imaged(camera, points)
    rows = pixels[..., 1].reshape(len(points), HEIGHTS, 3)
    up, down = np.where(free, rows.min(axis=2), np.inf), np.where(free, rows.max(axis=2), -np.inf)
    whole = np.asarray(free.all(axis=1) | ~imaged, np.bool_)
    high = np.where(whole | _is_end(up.argmin(axis=1)), ends_px[0], up.min(axis=1))
    low = np.where(whole | _is_end(down.argmax(axis=1)), ends_px[1], down.max(axis=1))
    is_lost = ~np.isfinite(up.min(axis=1))
    return np.where(is_lost, 0.0, high), np.where(is_lost, 0.0, low)


def _is_end(height: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Return whether heights, by number, are the top or the bottom."""
    return np.asarray((height == 0) | (height == HEIGHTS - 1))


def _is_free(camera: Camera, solid: Solid, points_m: Doubles) -> NDArray[np.bool_]:
    """Return whether the solid leaves the way from a camera to points (n, k, 3) free, (n * k,)."""
    rays = points_m.reshape(-1, 3) - np.asarray(camera.position)
    distance = np.linalg.norm(rays, axis=1)
    barrier, place = barrier_of(camera, solid), np.array(camera.position, np.float64)
    directions = rays / distance[:, None]
    met = meet_listed(place, directions, barrier.tree, barrier.stops, distance, barrier.start_m)[0]
    return np.asarray(~np.isfinite(met), np.bool_)
