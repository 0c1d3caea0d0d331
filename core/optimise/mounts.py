"""Generate candidate mounts: sensor poses at spots on the car's skin, and conflicts between them."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, partial

import numpy as np
from numpy.typing import NDArray

from riglens.core.blind.outline import Outline
from riglens.core.errors import Cancelled, InputError, IsStale, never_stale
from riglens.core.geometry import Pose, rpy_deg_from_rotation
from riglens.core.optimise.search import Limits
from riglens.core.optimise.spots import Spot, box_spots, skin_spots
from riglens.core.review.mounts import (
    SIDES,
    MountLimits,
    beyond_m,
    footing_of,
    is_in_zone,
    is_kept_out,
    sizes_m,
    usual_keep_out,
)
from riglens.core.rig.edits import mirrored_pose, partner_of
from riglens.core.rig.library import default_library
from riglens.core.rig.model import Rig, Sensor
from riglens.core.sensors.registry import kind_of
from riglens.core.vehicle.housings import housing_corners_m
from riglens.core.vehicle.solid import solid_of
from riglens.core.vehicle.standing import Skin, is_inside, skin_of

Doubles = NDArray[np.float64]
LEVELS_DEG = (0.0, 8.0, 15.0)
"""Outward tilts of added sensors."""
TURNS_DEG = (-8.0, 0.0, 8.0, 15.0)
"""Further outward lean of moved sensors."""
USUAL_RULES = MountLimits(height_m=(0.4, 100.0), spacing_m=0.25)
"""Our choice: dirt and kerbs below, housings side by side."""
_FLAT = 0.1
_NEAR_M = 0.3
_FULL_TURN_DEG = 300.0


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
class Move:
    """A sensor that may go elsewhere on the skin, with its mirror partner, or be exchanged for models of the library.

    radius_m: how far from where it is; 0: it stays in its place.
    """

    sensor: str
    radius_m: float = math.inf
    models: tuple[str, ...] = ()
    tilts_deg: tuple[float, ...] = TURNS_DEG

    def __post_init__(self) -> None:
        if not self.radius_m >= 0.0:
            raise InputError(f"{self.sensor} must move by at least 0 m (got {self.radius_m:g})", "move")

    def sensors_of(self, rig: Rig) -> tuple[Sensor, ...]:
        """Return the sensor, or its mirror pair with the left one first."""
        names = (self.sensor, partner_of(rig, self.sensor))
        return tuple(sorted((s for s in rig.sensors if s.name in names), key=lambda one: -one.position[1]))


def moves_of(
    radius_m: Mapping[str, float],
    models: Mapping[str, Sequence[str]],
    tilts_deg: tuple[float, ...] = TURNS_DEG,
) -> tuple[Move, ...]:
    """Return the moves of sensors by how far they may go, and by what they may be exchanged for."""
    found = [Move(name, far, tuple(models.get(name, ())), tilts_deg) for name, far in radius_m.items()]
    return (*found, *(Move(n, 0.0, tuple(m), (0.0,)) for n, m in models.items() if n not in radius_m))


@dataclass(frozen=True)
class Additions:
    """Sensors that may be added: models of the library, in mirror pairs or single, `count` of them, within a budget.

    counts: from how many to how many sensors of a model, which do not count in `count`; of mirror pairs an odd one
    stands on the middle plane. yaw_deg: turns of sensors that look one way, from straight out. costs: of one sensor by
    model, 1 where nothing is said. rules: limits of each mount; without zones of their own the usual ones keep sensors
    out. spots_m: distance between neighbouring spots. box_m: from and to along
    each axis, where sensors stand in the air on brackets, instead of the skin.
    """

    models: tuple[str, ...]
    count: int = 1
    mirrored: bool = True
    costs: Mapping[str, float] = field(default_factory=dict)
    budget: float = math.inf
    rules: MountLimits = USUAL_RULES
    spots_m: float = 0.2
    tilts_deg: tuple[float, ...] = LEVELS_DEG
    box_m: tuple[tuple[float, float], ...] | None = None
    counts: Mapping[str, tuple[int, int]] = field(default_factory=dict)
    yaw_deg: tuple[float, ...] = (0.0,)

    def __post_init__(self) -> None:
        if self.box_m is not None and not all(-50.0 <= low <= high <= 50.0 for low, high in self.box_m):
            raise InputError("must rise from X0 to X1, Y0 to Y1 and Z0 to Z1, within 50 m", "box_m")
        if not 1 <= self.count <= 20:
            raise InputError(f"must be between 1 and 20 (got {self.count})", "count")
        if not self.budget > 0.0:
            raise InputError(f"must be above 0 (got {self.budget:g})", "budget")
        if not 0.05 <= self.spots_m <= 2.0:
            raise InputError(f"must be between 0.05 and 2 m (got {self.spots_m:g})", "spots_m")
        for model, (least, most) in self.counts.items():
            if not 0 <= least <= most <= 20 or not most:
                raise InputError(
                    f"{model} must be from 0 to 20 sensors, from the lower number (got {least}-{most})", "add"
                )
        if not self.yaw_deg or not all(-180.0 <= yaw <= 180.0 for yaw in self.yaw_deg):
            raise InputError("must be between -180 and 180 degrees", "yaw_deg")
        for model, cost in self.costs.items():
            if not 0.0 < cost < math.inf:
                raise InputError(f"{model} must be above 0 (got {cost:g})", "cost")

    def sizes_of(self, model: str) -> tuple[int, ...]:
        """Return how many sensors a candidate of a model may have: 2 of a mirror pair, 1 of a single sensor."""
        least, most = self.counts.get(model, (0, 2))
        if not self.mirrored:
            return (1,)
        return (*((2,) if most > 1 else ()), *((1,) if least % 2 or most % 2 else ()))

    def cost_of(self, model: str) -> float:
        """Return the cost of the cheapest candidate of a model: a pair costs twice as much as a sensor."""
        return self.costs.get(model, 1.0) * min(self.sizes_of(model))

    @property
    def shared(self) -> int:
        """Return how many candidates may be added, at most, of the models without counts of their own."""
        return self.count if any(model not in self.counts for model in self.models) else 0


NO_ADDITIONS = Additions(())


def counts_of(words: Sequence[str]) -> tuple[tuple[str, ...], dict[str, tuple[int, int]]]:
    """Return models, and from how many to how many of them, from words such as hesai-xt32, hesai-xt32:2 or
    hesai-xt32:0-4."""
    models, counts = list[str](), dict[str, tuple[int, int]]()
    for word in words:
        model, colon, said = word.partition(":")
        if model in models:
            raise InputError(f"must name each model once (got '{word}')", "add")
        models.append(model)
        if colon:
            try:
                low, _, high = said.partition("-")
                counts[model] = int(low), int(high or low)
            except ValueError:
                raise InputError(f"must be MODEL, MODEL:N or MODEL:FROM-TO (got '{word}')", "add") from None
    return tuple(models), counts


def rules_for(rig: Rig, rules: MountLimits) -> MountLimits:
    """Return the rules with the usual zones where they name none."""
    if rules.keep_out is not None:
        return rules
    return rules.model_copy(update={"keep_out": usual_keep_out(rig.vehicle)})


@dataclass(frozen=True)
class _Wish:
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


def locked(rig: Rig, moves: Sequence[Move]) -> Rig:
    """Return the rig without the sensors that move."""
    gone = {sensor.name for move in moves for sensor in move.sensors_of(rig)}
    return rig.model_copy(update={"sensors": tuple(s for s in rig.sensors if s.name not in gone)})


def candidates(
    rig: Rig,
    additions: Additions,
    seed: int = 0,
    is_stale: IsStale = never_stale,
    moves: Sequence[Move] = (),
) -> tuple[Candidate, ...]:
    """Return every pose on the skin that keeps the rules, with each model and tilt, within the budget.

    A sensor that may move may also stay as it is. Raise InputError where there is nothing to choose from, and Cancelled
    as soon as `is_stale` returns True.
    """
    rules, outline = rules_for(rig, additions.rules), Outline.of(rig.vehicle)
    wishes = _wishes(rig, additions, moves)
    solid = solid_of(rig.vehicle)
    if additions.box_m is not None:
        spots = box_spots(additions.box_m, additions.spots_m, solid)
        left = len(spots)
    else:
        spots = skin_spots(rig.vehicle, additions.spots_m, seed)
        left = len(spots)
        flip = np.array([1.0, -1.0, 1.0])
        spots += [Spot(spot.point_m * flip, spot.normal * flip) for spot in spots if spot.point_m[1] > 0.05]
        if any(wish.central for wish in wishes):
            spots += _in_the_middle(spots[:left], additions.spots_m, skin_of(solid))
    rest = locked(rig, moves)
    taken = np.array([s.position for s in rest.sensors if s.enabled]).reshape(-1, 3)
    found: list[Candidate] = []
    skin, sizes = skin_of(solid), (rules.length_m, rules.width_m, rules.total_height_m)
    own_out = _outs(rest, outline, rest.sensors) if any(most is not None for most in sizes) else None

    def keep(
        wish: _Wish, spot: Spot, number: int, tilts_deg: Sequence[float], near: Callable[[], Skin]
    ) -> None:
        some = (wish.at(spot, number, tilt, yaw) for tilt in tilts_deg for yaw in wish.yaw_deg)
        keeps = (not rig.vehicle.has_mesh_file, rules, rest, outline, taken, own_out)
        kept = (one for one in some if one is not None and _keeps(one, spot, near, *keeps))
        found.extend(one for one in kept if spot.is_free or not is_inside(one.places_m[0], solid))

    for number, spot in enumerate(spots):
        if is_stale():
            raise Cancelled
        near = cache(partial(skin.near, spot.point_m, _NEAR_M))
        for wish in wishes:
            if _is_near(wish, spot, number < left):
                keep(wish, spot, number, wish.tilts_deg, near)
    for slot, move in enumerate(moves, 1):
        own = move.sensors_of(rig)
        place = np.array(own[0].position)
        nearest = min(spots, key=lambda spot: float(((spot.point_m - place) ** 2).sum()), default=None)
        normal = np.array([0.0, 0.0, 1.0]) if nearest is None else nearest.normal
        found.append(Candidate(own, 0.0, STAYS, 0.0, slot))
        for wish in wishes:
            if wish.slot == slot:
                tilts = [tilt for tilt in wish.tilts_deg if tilt != 0.0 or wish.sensors != own]
                keep(wish, Spot(place, normal, True), STAYS, tilts, lambda: skin)
    if len(found) <= len(moves):
        where = "on the car's skin" if additions.box_m is None else "in the box"
        raise InputError(f"no mount {where} keeps all limits: relax height, spacing, beyond or keep-out")
    return tuple(found)


@dataclass(frozen=True)
class Choices:
    """Candidates of a search, the limits of sets of them, the rig without the sensors that move, and how many sensors
    each slot needs, (slots,)."""

    candidates: tuple[Candidate, ...]
    limits: Limits
    rest: Rig
    least: NDArray[np.int64]

    @property
    def stays(self) -> list[int]:
        """Numbers of the sensors that stay as they are."""
        return [number for number, one in enumerate(self.candidates) if one.is_as_now]


def choices_of(
    rig: Rig,
    additions: Additions,
    seed: int = 0,
    is_stale: IsStale = never_stale,
    moves: Sequence[Move] = (),
) -> Choices:
    """Return the candidates and the limits of allowed sets: `additions.count` added ones, one of each move, and of each
    listed model from its least to its largest number of sensors."""
    listed, rest = candidates(rig, additions, seed, is_stale, moves), locked(rig, moves)
    most = [high for _, high in additions.counts.values()]
    room = np.array([additions.shared, *(1 for _ in moves), *most], np.int64)
    size = np.array([len(one.sensors) if one.slot > len(moves) else 1 for one in listed], np.int64)
    limits = Limits(
        int(room.sum()),
        np.array([one.cost for one in listed]),
        additions.budget,
        conflicts(listed, rest, rules_for(rig, additions.rules)),
        np.array([one.slot for one in listed], np.int64),
        room,
        size,
    )
    least = [0, *(1 for _ in moves), *(low for low, _ in additions.counts.values())]
    for (model, (low, _)), slot in zip(
        additions.counts.items(), range(1 + len(moves), len(room)), strict=True
    ):
        there = int(size[limits.slot == slot].sum())
        if there < low:
            raise InputError(f"{model} has mounts for {there} sensors only (got {low})", "add")
    return Choices(listed, limits, rest, np.array(least, np.int64))


def mounted(rig: Rig, picked: Sequence[Candidate]) -> Rig:
    """Return a rig with candidates: sensors of its own in their place, others after them."""
    own, every = {sensor.name for sensor in rig.sensors}, [sensor for one in picked for sensor in one.sensors]
    moved = {sensor.name: sensor for sensor in every if sensor.name in own}
    added = [sensor for sensor in every if sensor.name not in own]
    return rig.replace(sensors=(*(moved.get(sensor.name, sensor) for sensor in rig.sensors), *added))


def _wishes(rig: Rig, additions: Additions, moves: Sequence[Move]) -> list[_Wish]:
    """Return what may be mounted, of the models that the budget buys."""
    if (
        additions.box_m is not None
        and any(1 in additions.sizes_of(m) for m in additions.counts)
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
        slot = 1 + len(moves) + list(additions.counts).index(model) if model in additions.counts else 0
        for size in additions.sizes_of(model):
            cost, central = additions.costs.get(model, 1.0) * size, additions.mirrored and size == 1
            if cost <= additions.budget:
                sensors = (plain,) * size
                found.append(
                    _Wish(slot, sensors, cost, additions.tilts_deg, model, central=central, yaw_deg=yaws)
                )
    for slot, move in enumerate(moves, 1):
        own = move.sensors_of(rig)
        near = np.array(own[0].position), move.radius_m
        found.append(_Wish(slot, own, 0.0, move.tilts_deg, near=near))
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
                found.append(_Wish(slot, tuple(new), cost, move.tilts_deg, near=near))
    return found


def _is_near(wish: _Wish, spot: Spot, is_left: bool) -> bool:
    """Return whether a spot is where sensors may go; a pair is mounted by its left sensor."""
    if wish.central != spot.is_middle:
        return False
    if len(wish.sensors) > 1 and not is_left:
        return False
    if wish.near is None:
        return True
    place, radius_m = wish.near
    return bool(((spot.point_m - place) ** 2).sum() <= radius_m**2)


def _placed(spot: Spot, plain: Sensor, tilt_deg: float, is_new: bool, yaw_deg: float = 0.0) -> Sensor:
    """Return a sensor that touches the skin at a spot; a new one looks away from the car but for its yaw, others keep
    their turn."""
    outwards = spot.normal[:2]
    if np.linalg.norm(outwards) < _FLAT:
        outwards = np.array([0.0, math.copysign(1.0, spot.point_m[1])])
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
        position = position - float((housing_corners_m(turned) @ spot.normal).min()) * spot.normal
        position = np.array([round(float(value), 4) + 0.0 for value in position])
    px, py, pz = position.tolist()
    return plain.with_pose(Pose((px, py, pz), (roll, pitch, yaw)))


def _in_the_middle(spots: Sequence[Spot], spacing_m: float, skin: Skin) -> list[Spot]:
    """Return the spots next to the middle plane moved onto it."""
    found = list[Spot]()
    for spot in spots:
        if 0.0 < spot.point_m[1] <= spacing_m / 2.0:
            x, _, z = skin.nearest(spot.point_m * [1.0, 0.0, 1.0]).tolist()
            normal = spot.normal * [1.0, 0.0, 1.0]
            found.append(Spot(np.array([x, 0.0, z]), normal / np.linalg.norm(normal), is_middle=True))
    return found


def _looks_one_way(sensor: Sensor) -> bool:
    return kind_of(sensor).view_deg(sensor)[0] < _FULL_TURN_DEG


def _turn_about(axis: Doubles, angle_deg: float) -> Doubles:
    """Return the rotation (3, 3) about a unit axis (Rodrigues)."""
    x, y, z = axis.tolist()
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    angle = math.radians(angle_deg)
    return np.asarray(np.eye(3) + math.sin(angle) * cross + (1.0 - math.cos(angle)) * cross @ cross)


def _keeps(
    one: Candidate,
    spot: Spot,
    near: Callable[[], Skin],
    has_materials: bool,
    rules: MountLimits,
    rig: Rig,
    outline: Outline,
    taken: Doubles,
    own_out: Doubles | None,
) -> bool:
    """Return whether a candidate by itself keeps the rules next to the rig's own sensors; a car is symmetric.

    near: makes the part of the car at the spot; own_out: how far the rig's own sensors stick out, where sizes matter.
    """
    places = one.places_m
    low, high = rules.height_m or (-math.inf, math.inf)
    if (places[:, 2] < low).any() or (places[:, 2] > high).any():
        return False
    if rules.spacing_m is not None:
        others = np.concatenate([taken, places])
        away = np.linalg.norm(places[:, None] - others[None], axis=2)
        away[np.arange(len(places)), len(taken) + np.arange(len(places))] = np.inf
        if away.min() < rules.spacing_m:
            return False
    most = [getattr(rules.beyond_m, name) for name in SIDES]
    for sensor in one.sensors if any(limit is not None for limit in most) else ():
        out = beyond_m(sensor, rig, outline)
        if any(limit is not None and far > limit for far, limit in zip(out, most, strict=True)):
            return False
    if own_out is not None:
        both = np.maximum(own_out, _outs(rig, outline, one.sensors))
        if _grows(both, rules, rig, outline):
            return False
    if spot.is_free:
        return True
    skin, place = near(), np.array(one.sensors[0].position)
    if not len(skin.low):
        return False
    foot = skin.nearest(place)
    if rules.gap_m is not None and float(np.linalg.norm(foot - place)) > rules.gap_m:
        return False
    x, y, z = foot.tolist()
    footing = footing_of(one.sensors[0], (x, y, z), skin, has_materials)
    for at_m in ((x, y, z), (x, -y, z))[: len(one.sensors)]:
        image, zones = replace(footing, at_m=at_m), rules.keep_out or ()
        if is_kept_out(rig, at_m) or any(is_in_zone(zone, image, rig, outline) for zone in zones):
            return False
    return True


def _outs(rig: Rig, outline: Outline, sensors: Sequence[Sensor]) -> Doubles:
    """Return how far the farthest housing sticks out by SIDES, (5,), at least 0."""
    enabled = [sensor for sensor in sensors if sensor.enabled]
    return np.asarray(np.max([np.zeros(5), *(beyond_m(sensor, rig, outline) for sensor in enabled)], axis=0))


def _grows(out: Doubles, rules: MountLimits, rig: Rig, outline: Outline) -> NDArray[np.bool_]:
    """Return whether housings that stick out so far (..., 5) make the car larger than the rules allow, (...)."""
    over = [size > most for _, size, most in sizes_m(out, rig, outline, rules) if most is not None]
    return np.asarray(np.any([np.zeros(out.shape[:-1], np.bool_), *over], axis=0))


def conflicts(listed: Sequence[Candidate], rig: Rig, rules: MountLimits) -> NDArray[np.bool_]:
    """Return which candidates exclude each other (n, n): too near to each other, or too large together. Sensors that
    may move do not exclude each other where they are already."""
    count, outline = len(listed), Outline.of(rig.vehicle)
    found = np.eye(count, dtype=np.bool_)
    if rules.spacing_m is not None:
        places = np.array([place for one in listed for place in one.places_m])
        owner = np.repeat(np.arange(count), [len(one.sensors) for one in listed])
        for place, one in zip(places, owner, strict=True):
            near = owner[((places - place) ** 2).sum(axis=1) < rules.spacing_m**2]
            found[one, near] = found[near, one] = True
    if any(most is not None for most in (rules.length_m, rules.width_m, rules.total_height_m)):
        outs = np.maximum(
            _outs(rig, outline, rig.sensors), [_outs(rig, outline, one.sensors) for one in listed]
        )
        found |= _grows(np.maximum(outs[:, None], outs[None]), rules, rig, outline)
    stays = np.array([one.is_as_now for one in listed], np.bool_)
    return np.asarray(found & ~(stays[:, None] & stays[None]) | np.eye(count, dtype=np.bool_))
