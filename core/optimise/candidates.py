"""Generate the candidates of a search: every pose that keeps the rules, and which of them exclude each other."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, partial

import numpy as np
from numpy.typing import NDArray

from riglens.core.blind.outline import Outline
from riglens.core.errors import Cancelled, InputError, IsStale, never_stale
from riglens.core.optimise.additions import Additions, Move
from riglens.core.optimise.placing import STAYS, Candidate, Wish, wishes
from riglens.core.optimise.search import Limits
from riglens.core.optimise.spots import Spot, spots_of
from riglens.core.review.mounts import (
    SIDES,
    MountLimits,
    beyond_m,
    footing_of,
    is_in_zone,
    is_kept_out,
    sizes_m,
    usual_keep_out,
    zones_for,
)
from riglens.core.rig.model import Rig, Sensor
from riglens.core.vehicle.solid import solid_of
from riglens.core.vehicle.standing import Skin, is_inside, skin_of

Doubles = NDArray[np.float64]
_NEAR_M = 0.3


def rules_for(rig: Rig, rules: MountLimits) -> MountLimits:
    """Return the rules with the usual zones where they name none."""
    if rules.keep_out is not None:
        return rules
    return rules.model_copy(update={"keep_out": usual_keep_out(rig.vehicle)})


@dataclass(frozen=True)
class Choices:
    """Candidates of a search, the limits of sets of them, the rig, the rig without the sensors that move, and how many
    sensors each slot needs, (slots,)."""

    candidates: tuple[Candidate, ...]
    limits: Limits
    rig: Rig
    rest: Rig
    least: NDArray[np.int64]

    @property
    def stays(self) -> list[int]:
        """Numbers of the sensors that stay as they are."""
        return [number for number, one in enumerate(self.candidates) if one.is_as_now]

    def rig_with(self, chosen: Sequence[int], name: str = "proposal") -> Rig:
        """Return the rig with some candidates added, and those of its own sensors in their place."""
        found = mounted(self.rig, [self.candidates[one] for one in chosen])
        return found.replace(name=f"{found.name[:150]}, {name}")


def choices_of(
    rig: Rig,
    additions: Additions,
    seed: int = 0,
    is_stale: IsStale = never_stale,
    moves: Sequence[Move] = (),
) -> Choices:
    """Return every pose on the skin that keeps the rules, with each model and tilt, and the limits of allowed sets:
    `additions.count` added ones, one of each move, and of each listed model from its least to its largest number of
    sensors, within the budget.

    A sensor that may move may also stay as it is. Raise InputError where there is nothing to choose from, and Cancelled
    as soon as `is_stale` returns True.
    """
    rules = rules_for(rig, additions.rules)
    gone = {sensor.name for move in moves for sensor in move.sensors_of(rig)}
    rest = rig.model_copy(update={"sensors": tuple(s for s in rig.sensors if s.name not in gone)})
    listed = _candidates(rig, rest, rules, additions, seed, is_stale, moves)
    most = [high for _, high in additions.counts.values()]
    room = np.array([additions.shared, *(1 for _ in moves), *most], np.int64)
    size = np.array([len(one.sensors) if one.slot > len(moves) else 1 for one in listed], np.int64)
    limits = Limits(
        int(room.sum()),
        np.array([one.cost for one in listed]),
        additions.budget,
        conflicts(listed, rest, rules),
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
    return Choices(listed, limits, rig, rest, np.array(least, np.int64))


def _candidates(
    rig: Rig,
    rest: Rig,
    rules: MountLimits,
    additions: Additions,
    seed: int,
    is_stale: IsStale,
    moves: Sequence[Move],
) -> tuple[Candidate, ...]:
    """Return every pose that keeps the rules, next to the rest of a rig, whose sensors stay."""
    asked = wishes(rig, additions, moves)
    outline, solid = Outline.of(rig.vehicle), solid_of(rig.vehicle)
    spots, left = spots_of(
        rig.vehicle, solid, additions.box_m, additions.spots_m, seed, any(wish.central for wish in asked)
    )
    taken = np.array([s.position for s in rest.sensors if s.enabled]).reshape(-1, 3)
    found: list[Candidate] = []
    skin, sizes = skin_of(solid), (rules.length_m, rules.width_m, rules.total_height_m)
    own_out = _outs(rest, outline, rest.sensors) if any(most is not None for most in sizes) else None

    def keep(
        wish: Wish, spot: Spot, number: int, tilts_deg: Sequence[float], near: Callable[[float], Skin]
    ) -> None:
        some = (wish.at(spot, number, tilt, yaw) for tilt in tilts_deg for yaw in wish.yaw_deg)
        keeps = (not rig.vehicle.has_mesh_file, rules, rest, outline, taken, own_out)
        kept = (one for one in some if one is not None and _keeps(one, spot, near, *keeps))
        is_open = spot.is_free or spot.behind_glass
        found.extend(one for one in kept if is_open or not is_inside(one.places_m[0], solid))

    for number, spot in enumerate(spots):
        if is_stale():
            raise Cancelled
        near = cache(partial(_beside, skin, spot))
        for wish in asked:
            if wish.fits(spot, number < left, rig.vehicle):
                keep(wish, spot, number, wish.tilts_deg, near)
    for slot, move in enumerate(moves, 1):
        own = move.sensors_of(rig)
        place = np.array(own[0].position)
        nearest = min(spots, key=lambda spot: float(((spot.point_m - place) ** 2).sum()), default=None)
        normal = np.array([0.0, 0.0, 1.0]) if nearest is None else nearest.normal
        found.append(Candidate(own, 0.0, STAYS, 0.0, slot))
        for wish in asked:
            if wish.slot == slot:
                tilts = [tilt for tilt in wish.tilts_deg if tilt != 0.0 or wish.sensors != own]
                keep(wish, Spot(place, normal, True), STAYS, tilts, lambda _: skin)
    if len(found) <= len(moves):
        where = "on the car's skin" if additions.box_m is None else "in the box"
        raise InputError(f"no mount {where} keeps all limits: relax height, spacing, beyond or keep-out")
    return tuple(found)


def mounted(rig: Rig, picked: Sequence[Candidate]) -> Rig:
    """Return a rig with candidates: sensors of its own in their place, others after them."""
    own, every = {sensor.name for sensor in rig.sensors}, [sensor for one in picked for sensor in one.sensors]
    moved = {sensor.name: sensor for sensor in every if sensor.name in own}
    added = [sensor for sensor in every if sensor.name not in own]
    return rig.replace(sensors=(*(moved.get(sensor.name, sensor) for sensor in rig.sensors), *added))


def _beside(skin: Skin, spot: Spot, side: float) -> Skin:
    """Return the part of the car at a spot, or with -1 at its image."""
    return skin.near(spot.point_m * [1.0, side, 1.0], _NEAR_M)


def _keeps(
    one: Candidate,
    spot: Spot,
    near: Callable[[float], Skin],
    has_materials: bool,
    rules: MountLimits,
    rig: Rig,
    outline: Outline,
    taken: Doubles,
    own_out: Doubles | None,
) -> bool:
    """Return whether a candidate by itself keeps the rules next to the rig's own sensors.

    near: makes the part of the car at the spot, or with -1 at its image; own_out: how far the rig's own sensors stick
    out, where sizes matter.
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
    return all(
        _stands_free(sensor, near(side), spot.behind_glass, has_materials, rules, rig, outline)
        for sensor, side in zip(one.sensors, (1.0, -1.0), strict=False)
    )


def _stands_free(
    sensor: Sensor,
    skin: Skin,
    behind_glass: bool,
    has_materials: bool,
    rules: MountLimits,
    rig: Rig,
    outline: Outline,
) -> bool:
    """Return whether a sensor is near the part of the car around it, and in no zone. Sides of a car differ by rounding,
    so each sensor of a pair is looked at."""
    if not len(skin.low):
        return False
    place = np.array(sensor.position)
    foot = skin.nearest(place)
    if rules.gap_m is not None and float(np.linalg.norm(foot - place)) > rules.gap_m:
        return False
    x, y, z = foot.tolist()
    footing, zones = (
        footing_of(sensor, (x, y, z), skin, has_materials),
        zones_for(sensor, rules.keep_out or (), behind_glass),
    )
    return not (
        is_kept_out(rig, footing.at_m) or any(is_in_zone(zone, footing, rig, outline) for zone in zones)
    )


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
