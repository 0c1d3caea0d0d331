"""Place the sensors of a candidate at a spot: what is to be mounted, and where each of its sensors then is."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from riglens.core.errors import InputError
from riglens.core.geometry import Pose, rpy_deg_from_rotation
from riglens.core.optimise.additions import Additions, Move
from riglens.core.optimise.spots import Spot
from riglens.core.rig.edits import mirrored_pose
from riglens.core.rig.library import default_library
from riglens.core.rig.model import Rig, Sensor, Vehicle
from riglens.core.sensors.registry import kind_of
from riglens.core.vehicle.housings import housing_corners_m

Doubles = NDArray[np.float64]
_FLAT = 0.1
_FULL_TURN_DEG = 300.0
BUMPERS = 0.12
"""Share of a car's length that its bumpers and their corners take at either end: our choice."""
UPRIGHT = 0.6
"""Most that the normal of an upright surface points up or down."""
STAYS = -1
"""Number of the spot where a moved sensor is already."""


@dataclass(frozen=True)
class Candidate:
    """Sensors that are mounted together, a mirror pair or one, and their cost.

    Random draws depend on the names, so a candidate keeps them from the table to the rig. `spot`: number of the spot;
    tilt_deg: how far it leans outwards, a moved one further than now; slot: 0 for added sensors, else the number of
    their move, from 1; on: the spot, None for a sensor that stays.
    """

    sensors: tuple[Sensor, ...]
    cost: float
    spot: int
    tilt_deg: float
    slot: int = 0
    on: Spot | None = field(default=None, compare=False)

    @property
    def is_as_now(self) -> bool:
        """Return whether it is a sensor of the rig that stays as it is."""
        return self.spot == STAYS and self.tilt_deg == 0.0 and self.cost == 0.0

    @property
    def places_m(self) -> Doubles:
        """Places of the sensors, (sensors, 3)."""
        return np.array([sensor.position for sensor in self.sensors])


@dataclass(frozen=True)
class Wish:
    """Sensors of a slot before they have a mount: of a pair the left one first; only their turn counts.

    name: of an added one, which gets that of its spot; near: place and radius in which a moved one may be; central:
    whether it stands on the middle plane; yaw_deg: turns of an added one.
    """

    slot: int
    sensors: tuple[Sensor, ...]
    cost: float
    tilts_deg: tuple[float, ...]
    name: str = ""
    near: tuple[Doubles, float] | None = None
    central: bool = False
    yaw_deg: tuple[float, ...] = (0.0,)

    def at(self, spot: Spot, number: int, tilt_deg: float, yaw_deg: float = 0.0) -> Candidate | None:
        """Return the candidate at a spot; None if both sensors of a pair would coincide."""
        first, others = self.sensors[0], self.sensors[1:]
        name = f"{self.name} {number}.{tilt_deg:g}" + (f".{yaw_deg:g}" if yaw_deg else "")
        if self.name:
            first = first.model_copy(update={"name": f"{name} left" if others else name})
            right = {"name": f"{name} right", "mirror_of": first.name}
            others = tuple(one.model_copy(update=right) for one in others)
        sensor = _placed(spot, first, tilt_deg, self.near is None, yaw_deg)
        if others and sensor.position[1] <= 0.0:
            return None
        images = (one.with_pose(mirrored_pose(sensor.pose)) for one in others)
        return Candidate((sensor, *images), self.cost, number, tilt_deg, self.slot, spot)

    def fits(self, spot: Spot, is_left: bool, vehicle: Vehicle) -> bool:
        """Return whether a spot is where the sensors may go: a pair is mounted by its left sensor, some kinds in
        bumpers alone, behind the windscreen what sees through glass, others anywhere on the skin."""
        if self.central != spot.is_middle or (len(self.sensors) > 1 and not is_left):
            return False
        if self.near is not None:
            place, radius_m = self.near
            if ((spot.point_m - place) ** 2).sum() > radius_m**2:
                return False
        kind = kind_of(self.sensors[0])
        if spot.behind_glass:
            return kind.occlusion.sees_through_glass
        heights_m = kind.placement.in_bumpers_m
        if spot.is_free or heights_m is None:
            return True
        is_end = abs(float(spot.point_m[0])) >= (0.5 - BUMPERS) * vehicle.length
        is_upright = abs(float(spot.normal[2])) <= UPRIGHT
        return is_end and is_upright and heights_m[0] <= float(spot.point_m[2]) <= heights_m[1]


def wishes(rig: Rig, additions: Additions, moves: Sequence[Move]) -> list[Wish]:
    """Return what may be mounted, of the models that the budget buys."""
    if (
        additions.box_m is not None
        and any(1 in additions.sizes_of(model) for model in additions.models if additions.group_of(model))
        and additions.mirrored
    ):
        raise InputError("must be an even number of sensors in a box", "add")
    models = [model for model in additions.models if additions.cost_of(model) <= additions.budget]
    if additions.models and not models:
        cheapest = min(map(additions.cost_of, additions.models))
        raise InputError(
            f"must be at least {cheapest:g}, the cheapest addition (got {additions.budget:g})", "budget"
        )
    found = []
    for model in models:
        plain = default_library().entry(model).sensor(model, Pose())
        yaws = additions.yaw_deg if _looks_one_way(plain) else (0.0,)
        group = additions.group_of(model)
        slot = 1 + len(moves) + list(additions.counts).index(group) if group else 0
        for size in additions.sizes_of(model):
            cost, central = additions.costs.get(model, 1.0) * size, additions.mirrored and size == 1
            if cost <= additions.budget:
                sensors = (plain,) * size
                found.append(
                    Wish(slot, sensors, cost, additions.tilts_deg, model, central=central, yaw_deg=yaws)
                )
    for slot, move in enumerate(moves, 1):
        own = move.sensors_of(rig)
        near = np.array(own[0].position), move.radius_m
        found.append(Wish(slot, own, 0.0, move.tilts_deg, near=near))
        for model in move.models:
            entry = default_library().entry(model)
            kept = ("name", "mirror_of", "fails_with")
            new = [
                entry.sensor(one.name, one.pose).model_copy(
                    update={name: getattr(one, name) for name in kept}
                )
                for one in own
            ]
            cost = additions.costs.get(model, 1.0) * len(own)
            if cost <= additions.budget:
                found.append(Wish(slot, tuple(new), cost, move.tilts_deg, near=near))
    return found


def _placed(spot: Spot, plain: Sensor, tilt_deg: float, is_new: bool, yaw_deg: float = 0.0) -> Sensor:
    """Return a sensor that touches the skin at a spot; a new one looks away from the car but for its yaw, others keep
    their turn."""
    outwards = spot.normal[:2]
    if np.linalg.norm(outwards) < _FLAT:
        ends = np.array([math.copysign(1.0, spot.point_m[0]), 0.0])
        outwards = ends if spot.is_middle else np.array([0.0, math.copysign(1.0, spot.point_m[1])])
    x, y = (outwards / np.linalg.norm(outwards)).tolist()
    heading = math.degrees(math.atan2(y, x)) + yaw_deg if _looks_one_way(plain) else 0.0
    own = Pose((0.0, 0.0, 0.0), (0.0, 0.0, heading) if is_new else plain.rpy_deg)
    roll, pitch, yaw = own.rpy_deg
    if is_new or tilt_deg:
        # z leans towards (x, y): a turn about (-y, x, 0)
        turn = _turn_about(np.array([-y, x, 0.0]), tilt_deg) @ own.rotation()
        roll, pitch, yaw = (round(angle, 2) + 0.0 for angle in rpy_deg_from_rotation(turn))
    position = spot.point_m
    if not spot.is_free:
        turned = plain.with_pose(Pose((0.0, 0.0, 0.0), (roll, pitch, yaw)))
        out = housing_corners_m(turned) @ spot.normal
        position = position - float(out.max() if spot.behind_glass else out.min()) * spot.normal
        position = np.array([round(float(value), 4) + 0.0 for value in position])
    px, py, pz = position.tolist()
    return plain.with_pose(Pose((px, py, pz), (roll, pitch, yaw)))


def _looks_one_way(sensor: Sensor) -> bool:
    return kind_of(sensor).view_deg(sensor)[0] < _FULL_TURN_DEG


def _turn_about(axis: Doubles, angle_deg: float) -> Doubles:
    """Return the rotation (3, 3) about a unit axis (Rodrigues)."""
    x, y, z = axis.tolist()
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    angle = math.radians(angle_deg)
    return np.asarray(np.eye(3) + math.sin(angle) * cross + (1.0 - math.cos(angle)) * cross @ cross)
