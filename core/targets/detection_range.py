"""Detection range of a rig: the distance up to which one object in the open has enough points or pixels.

A single object is on flat ground, at every distance, in some directions and turned end on or side on. What the
LiDARs get is counted by `targets.engine`, on their real beam tables; a camera's picture of it is
measured by its lens. Where the object falls between the beams is luck: at 80 m a gap between beams is as wide as a
hand or as a person is tall. So each distance is tried at several places within a step of the lattice.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray

from riglens.core.errors import InputError
from riglens.core.metric.scores import Body
from riglens.core.option_help import OptionHelp
from riglens.core.rig.model import Rig
from riglens.core.scene.boxes import CLASSES
from riglens.core.sensors.camera import CAMERA
from riglens.core.sensors.lidar import LIDAR
from riglens.core.sensors.registry import AnyKind
from riglens.core.targets.settings import EXACT, TargetSettings

Doubles = NDArray[np.float64]
SIZES_M = {"car": (4.6, 1.86, 1.52), "bicycle": (1.81, 0.6, 1.7), "pedestrian": (0.5, 0.6, 1.72)}
"""Length, width, height: means of the bundled town."""
HEADINGS_DEG = {"car": (0.0, 90.0), "bicycle": (0.0, 90.0), "pedestrian": (0.0,)}
"""Between the line of sight and the long axis: 0 end on, 90 side on."""
NEAREST_M, FINE_TO_M, FARTHEST_M = 5.0, 50.0, 1000.0
STEP_M, COARSE_STEP_M = 1.0, 2.0
"""Steps between distances up to FINE_TO_M, and beyond; nearer than the nearest one an object would be in the car."""
MAX_BEARINGS = 72


def _require(field: str, value: float, least: float, most: float) -> None:
    if not least <= value <= most:
        raise InputError(f"must be between {least:g} and {most:g} (got {value:g})", field)


def around(count: int) -> tuple[float, ...]:
    """Return a number of bearings in degrees, evenly around the car, ahead first, then to the left; within (-180,
    180]."""
    _require("directions", count, 1, MAX_BEARINGS)
    turns = (360.0 * k / count for k in range(count))
    return tuple(turn if turn <= 180.0 else turn - 360.0 for turn in turns)


class Case(NamedTuple):
    """Object of a class, turned one way, in one direction from the car."""

    cls: str
    heading_deg: float
    bearing_deg: float


@dataclass(frozen=True)
class RangePlan:
    """Detection thresholds, places to evaluate, and braking model; every number is an assumption that may be changed.

    min_points: nuScenes scores objects with 1 LiDAR point or more; in the Waymo Open Dataset those with fewer than 5
    are LEVEL_2; min_height_px: KITTI has easy from 40, moderate and hard from 25.
    """

    min_points: int = 5
    min_height_px: Annotated[
        float, OptionHelp("PX", "Height in native pixels at which a camera detects an object.")
    ] = 25.0
    bearings_deg: tuple[float, ...] = around(8)
    to_m: Annotated[float, OptionHelp("M", "Maximum distance, in metres.", "range-to")] = 150.0
    speeds_kmh: tuple[float, ...] = (30.0, 50.0, 80.0, 100.0, 130.0)
    reaction_s: Annotated[
        float, OptionHelp("S", "Reaction time until the car brakes, in seconds (our choice).")
    ] = 1.0
    deceleration_mps2: Annotated[float, OptionHelp("MPS2", "Deceleration in m/s2 (our choice).")] = 5.0
    settings: TargetSettings = field(default=replace(EXACT, body="blocks"))

    def __post_init__(self) -> None:
        _require("min_points", self.min_points, 1, 1_000_000)
        _require("min_height_px", self.min_height_px, 0.1, 1e6)
        _require("to_m", self.to_m, NEAREST_M + STEP_M, FARTHEST_M)
        _require("reaction_s", self.reaction_s, 0.0, 60.0)
        _require("deceleration_mps2", self.deceleration_mps2, 0.1, 100.0)
        if not 1 <= len(self.bearings_deg) <= MAX_BEARINGS:
            raise InputError(
                f"must be 1 to {MAX_BEARINGS} angles (got {len(self.bearings_deg)})", "bearings_deg"
            )
        for bearing in self.bearings_deg:
            _require("bearings_deg", bearing, -360.0, 360.0)
        for speed in self.speeds_kmh:
            _require("speeds_kmh", speed, 1.0, 500.0)

    def cases(self) -> tuple[Case, ...]:
        """Return every case of an object in a place: class by class, heading by heading, bearing by bearing."""
        return tuple(
            Case(cls, heading, bearing)
            for cls in CLASSES
            for heading in HEADINGS_DEG[cls]
            for bearing in self.bearings_deg
        )

    def distances_m(self) -> Doubles:
        """Return the distances tried, from the origin of the vehicle frame to the centre of the object."""
        fine = np.arange(NEAREST_M, min(self.to_m, FINE_TO_M) + 1e-9, STEP_M)
        return np.concatenate([fine, np.arange(FINE_TO_M + COARSE_STEP_M, self.to_m + 1e-9, COARSE_STEP_M)])

    def braking_as(self, other: RangePlan) -> RangePlan:
        """Return this plan with the braking model of another one: no counts change."""
        return replace(self, reaction_s=other.reaction_s, deceleration_mps2=other.deceleration_mps2)

    def enough(self, kind: AnyKind) -> float:
        """Return the threshold of LiDARs in points, of cameras in pixels, and of another kind as it says."""
        plan = {LIDAR.name: self.min_points, CAMERA.name: self.min_height_px}
        return plan.get(kind.name, kind.hits.threshold)

    def with_body(self, body: Body) -> RangePlan:
        """Return this plan with rays that end at the car's own body, or do not."""
        return replace(self, settings=replace(self.settings, body=body))

    def stopping_m(self, speed_kmh: float) -> float:
        """Return the stopping distance from the moment at which the object becomes visible: v t + v^2 / 2a."""
        v = speed_kmh / 3.6
        return v * self.reaction_s + v * v / (2.0 * self.deceleration_mps2)

    def stops_from_kmh(self, way_m: float) -> float:
        """Return the speed from which the car stops within this distance; 0 where there is none."""
        at = self.deceleration_mps2 * self.reaction_s
        return 3.6 * (math.sqrt(at * at + 2.0 * self.deceleration_mps2 * max(way_m, 0.0)) - at)


USUAL_PLAN = RangePlan()


class Reach(NamedTuple):
    """First distance in metres at which there is too little, of the unluckiest, the middle and the luckiest place
    within the lattice; 0: never enough, inf: still enough at the farthest. from_m: from where on there is enough at all
    places that ever have it."""

    least_m: float
    median_m: float
    most_m: float
    from_m: float


@dataclass(frozen=True)
class RangeRow:
    """One class, turned one way, in one direction from the car: reach by kind of sensor, for LiDARs by points, for
    cameras by pixels.

    gap_m: from bumper to object when its centre is 0 m away, below 0; the way to brake in is distance + gap_m.
    """

    cls: str
    heading_deg: float
    bearing_deg: float
    reaches: Mapping[str, Reach]
    gap_m: float

    @property
    def lidar(self) -> Reach:
        """Reach of all LiDARs."""
        return self.reaches[LIDAR.name]

    @property
    def camera(self) -> Reach:
        """Reach of all cameras."""
        return self.reaches[CAMERA.name]


@dataclass(frozen=True)
class DetectionRange:
    """Detection range of a rig; gap_deg: between the beams of its coarsest LiDAR near the horizon, 0 without LiDARs."""

    rig: Rig
    plan: RangePlan
    rows: tuple[RangeRow, ...]
    gap_deg: float

    def stops_from_kmh(self, row: RangeRow, by: Reach) -> float | None:
        """Return the speed from which the car stops before an object straight ahead, detected at the worst distance of
        `by`; None in another direction, inf where it is detected at all distances tried."""
        if math.cos(math.radians(row.bearing_deg)) < 1.0 - 1e-9:
            return None
        if math.isinf(by.least_m):
            return math.inf
        return self.plan.stops_from_kmh(by.least_m + row.gap_m)
