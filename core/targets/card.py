"""The card of a rig: up to which distance it gets enough points or pixels onto one road user in the open.

One road user stands alone on flat ground, at every distance, in some directions and turned end on or side on. What the
LiDARs get is counted by the engine of `riglens targets`, on their real beam tables; a camera's picture of it is
measured by its lens. Where the road user falls between the beams is luck: at 80 m a gap between beams is as wide as a
hand or as a person is tall. So each distance is tried at several places within a step of the lattice.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from riglens.core.errors import InputError
from riglens.core.rig.model import Camera, Lidar, Rig
from riglens.core.scene.boxes import CLASSES, DataReport, rotations_from_yaw
from riglens.core.sensing.camera import project_px
from riglens.core.targets.beams import azimuth_step_rad
from riglens.core.targets.engine import TargetEngine
from riglens.core.targets.settings import EXACT, TargetSettings
from riglens.core.targets.traffic import Traffic, traffic_of

Doubles = NDArray[np.float64]
SIZES_M = {"car": (4.6, 1.86, 1.52), "bicycle": (1.81, 0.6, 1.7), "pedestrian": (0.5, 0.6, 1.72)}
"""Length, width, height: means of the bundled town."""
HEADINGS_DEG = {"car": (0.0, 90.0), "bicycle": (0.0, 90.0), "pedestrian": (0.0,)}
"""Between the line of sight and the long axis: 0 end on, 90 side on."""
NEAREST_M, FINE_TO_M, FARTHEST_M = 5.0, 50.0, 1000.0
STEP_M, COARSE_STEP_M = 1.0, 2.0
"""Distances are tried in steps of the first up to FINE_TO_M, beyond in steps of the second; nearer than the nearest one
a road user would stand in the car."""
TURNS, RISES = 2, 12
"""Places within a step of azimuths, and within a gap between beams."""
WIDEST_GAP_DEG = 4.0
MAX_BEARINGS = 72


def _require(name: str, value: float, least: float, most: float) -> None:
    if not least <= value <= most:
        raise InputError(f"{name}: found {value:g}, accepted is a number from {least:g} to {most:g}")


def around(count: int) -> tuple[float, ...]:
    """So many bearings in degrees, evenly around the car, ahead first, then to the left; within (-180, 180]."""
    _require("--directions", count, 1, MAX_BEARINGS)
    turns = (360.0 * k / count for k in range(count))
    return tuple(turn if turn <= 180.0 else turn - 360.0 for turn in turns)


@dataclass(frozen=True)
class CardPlan:
    """What counts as enough, where to look, and how the car brakes; every number is an assumption that may be changed.

    min_points: LiDAR points (nuScenes scores objects with 1 or more; in the Waymo Open Dataset those with fewer than 5
    are LEVEL_2); min_height_px: height in a camera's native pixels (KITTI: easy from 40, moderate and hard from 25).
    reaction_s and deceleration_mps2 are our choice.
    """

    min_points: int = 5
    min_height_px: float = 25.0
    bearings_deg: tuple[float, ...] = around(8)
    to_m: float = 150.0
    speeds_kmh: tuple[float, ...] = (30.0, 50.0, 80.0, 100.0, 130.0)
    reaction_s: float = 1.0
    deceleration_mps2: float = 5.0
    settings: TargetSettings = field(default=EXACT)

    def __post_init__(self) -> None:
        _require("--min-points", self.min_points, 1, 1_000_000)
        _require("--min-height", self.min_height_px, 0.1, 1e6)
        _require("--to", self.to_m, NEAREST_M + STEP_M, FARTHEST_M)
        _require("--reaction", self.reaction_s, 0.0, 60.0)
        _require("--deceleration", self.deceleration_mps2, 0.1, 100.0)
        if not 1 <= len(self.bearings_deg) <= MAX_BEARINGS:
            raise InputError(f"--bearings: found {len(self.bearings_deg)}, accepted are 1 to {MAX_BEARINGS}")
        for bearing in self.bearings_deg:
            _require("--bearings", bearing, -360.0, 360.0)
        for speed in self.speeds_kmh:
            _require("--speeds", speed, 1.0, 500.0)

    def distances_m(self) -> Doubles:
        """Distances that are tried, from the origin of the vehicle frame to the centre of the road user."""
        fine = np.arange(NEAREST_M, min(self.to_m, FINE_TO_M) + 1e-9, STEP_M)
        return np.concatenate([fine, np.arange(FINE_TO_M + COARSE_STEP_M, self.to_m + 1e-9, COARSE_STEP_M)])

    def stopping_m(self, speed_kmh: float) -> float:
        """Way from the moment at which the road user is there to be seen until the car stands: v t + v^2 / 2a."""
        v = speed_kmh / 3.6
        return v * self.reaction_s + v * v / (2.0 * self.deceleration_mps2)

    def stops_from_kmh(self, way_m: float) -> float:
        """The speed from which the car stands after this way; 0 where there is none."""
        at = self.deceleration_mps2 * self.reaction_s
        return 3.6 * (math.sqrt(at * at + 2.0 * self.deceleration_mps2 * max(way_m, 0.0)) - at)


class Reach(NamedTuple):
    """First distance in metres at which there is too little, of the unluckiest, the middle and the luckiest place
    within the lattice; 0: never enough, inf: still enough at the farthest. from_m: from where on there is enough at all
    places that ever have it."""

    least_m: float
    median_m: float
    most_m: float
    from_m: float


@dataclass(frozen=True)
class CardRow:
    """One class, turned one way, in one direction from the car: reach by LiDARs (points) and by cameras (pixels).

    gap_m: from bumper to road user when its centre is 0 m away, below 0; the way to brake in is distance + gap_m.
    """

    cls: str
    heading_deg: float
    bearing_deg: float
    lidar: Reach
    camera: Reach
    gap_m: float


@dataclass(frozen=True)
class Card:
    """The card of a rig; gap_deg: between the beams of its coarsest LiDAR near the horizon, 0 without LiDARs."""

    rig: Rig
    plan: CardPlan
    rows: tuple[CardRow, ...]
    gap_deg: float

    def stops_from_kmh(self, row: CardRow, by: Reach) -> float | None:
        """Speed from which the car stops before a road user straight ahead, seen as late as `by` allows at worst; None
        in another direction, inf where it is seen as far as was tried."""
        if math.cos(math.radians(row.bearing_deg)) < 1.0 - 1e-9:
            return None
        if math.isinf(by.least_m):
            return math.inf
        return self.plan.stops_from_kmh(by.least_m + row.gap_m)


def card_of(
    rig: Rig, plan: CardPlan = CardPlan(), threads: int | None = None, is_serial: bool = False
) -> Card:
    """The card of a rig's enabled sensors. `is_serial`: for a thread that must not call parallel kernels."""
    cases = [
        (cls, heading, bearing)
        for cls in CLASSES
        for heading in HEADINGS_DEG[cls]
        for bearing in plan.bearings_deg
    ]
    gap_deg, step_deg = lattice_steps_deg(rig.lidars())
    points = _points(rig, plan, cases, (gap_deg, step_deg), threads, is_serial)
    rows = []
    for number, (cls, heading, bearing) in enumerate(cases):
        lidar = reach_of(plan.distances_m(), points[number] >= plan.min_points)
        heights = heights_px(rig.cameras(), _poses(plan, cls, heading, bearing), SIZES_M[cls])
        camera = reach_of(plan.distances_m(), heights[None] >= plan.min_height_px)
        half_m = SIZES_M[cls][0 if heading == 0.0 else 1] / 2
        rows.append(CardRow(cls, heading, bearing, lidar, camera, -rig.vehicle.length / 2 - half_m))
    return Card(rig, plan, tuple(rows), gap_deg)


def reach_of(distances_m: Doubles, enough: NDArray[np.bool_]) -> Reach:
    """The reach over places (k, distances) within the lattice; what is enough again farther out does not count."""
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
    """Widest gap between beams near the horizon, at most WIDEST_GAP_DEG, and widest step between azimuths."""
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


def _poses(
    plan: CardPlan,
    cls: str,
    heading_deg: float,
    bearing_deg: float,
    turn_deg: float = 0.0,
    rise_deg: float = 0.0,
) -> _Poses:
    """A road user at every distance; turned about the car by a part of a step and lifted by a part of a gap."""
    distance_m, bearing = plan.distances_m(), math.radians(bearing_deg + turn_deg)
    up_m = SIZES_M[cls][2] / 2 + distance_m * math.tan(math.radians(rise_deg))
    centre = np.column_stack([distance_m * math.cos(bearing), distance_m * math.sin(bearing), up_m])
    return _Poses(centre, np.full(distance_m.size, bearing + math.radians(heading_deg)))


def _points(
    rig: Rig,
    plan: CardPlan,
    cases: Sequence[tuple[str, float, float]],
    steps_deg: tuple[float, float],
    threads: int | None,
    is_serial: bool,
) -> NDArray[np.int64]:
    """LiDAR points (cases, places within the lattice, distances)."""
    gap_deg, step_deg = steps_deg
    turns, rises = ((np.arange(count) + 0.5) / count for count in (TURNS, RISES))
    places = [(turn * step_deg, (rise - 0.5) * gap_deg) for turn in turns.tolist() for rise in rises.tolist()]
    shape = (len(cases), len(places), plan.distances_m().size)
    lidars = rig.model_copy(update={"sensors": tuple(rig.lidars())})
    if not lidars.sensors:
        return np.zeros(shape, np.int64)
    every = [
        (cls, _poses(plan, cls, heading, bearing, *place))
        for cls, heading, bearing in cases
        for place in places
    ]
    engine = TargetEngine(_alone(every), threads, is_serial)
    objects = engine.evaluate(lidars, plan.settings).objects
    points = np.zeros(math.prod(shape), np.int64)
    points[engine.traffic.row[objects.box]] = objects.all_points
    return points.reshape(shape)


def _alone(every: Sequence[tuple[str, _Poses]]) -> Traffic:
    """Each road user in a frame of its own."""
    centre = np.concatenate([poses.centre_m for _, poses in every])
    sizes = np.concatenate([np.tile(SIZES_M[cls], (len(poses.yaw_rad), 1)) for cls, poses in every])
    codes = np.concatenate(
        [np.full(len(poses.yaw_rad), CLASSES.index(cls), np.uint8) for cls, poses in every]
    )
    turn = rotations_from_yaw(np.concatenate([poses.yaw_rad for _, poses in every]))
    data = DataReport("one road user at a time", len(codes), dict.fromkeys(CLASSES, 0))
    return traffic_of(data, np.arange(len(codes)), codes, centre, sizes, turn).within(1e6)


def heights_px(cameras: Sequence[Camera], poses: _Poses, size_m: tuple[float, float, float]) -> Doubles:
    """Native pixels (n,) from the highest to the lowest corner of a box within the image of the camera that shows it
    tallest; 0 where no camera shows it, and where a part of it lies beyond what the lens can say."""
    corners = np.array([[i, j, k] for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)]) * np.array(size_m) / 2
    turn = rotations_from_yaw(poses.yaw_rad)
    points = poses.centre_m[:, None, :] + np.einsum("nij,cj->nci", turn, corners)
    tallest = np.zeros(len(points))
    for camera in cameras:
        seen = (points.reshape(-1, 3) - np.asarray(camera.position)) @ camera.pose.rotation()
        pixels = project_px(camera, seen).reshape(len(points), 8, 2)
        width, height = camera.image
        imaged = np.asarray(np.isfinite(pixels[..., 0]).all(axis=1), np.bool_)
        u, v = (np.asarray(np.where(imaged[:, None], pixels[..., axis], 0.0)) for axis in (0, 1))
        inside = np.asarray(imaged & (u.max(axis=1) > 0.0) & (u.min(axis=1) < width), np.bool_)
        tall = np.clip(v.max(axis=1), 0.0, height) - np.clip(v.min(axis=1), 0.0, height)
        reach = np.linalg.norm(poses.centre_m - np.asarray(camera.position), axis=1)
        near, far = camera.range_m
        tallest = np.maximum(tallest, np.where(inside & (reach >= near) & (reach <= far), tall, 0.0))
    return tallest
