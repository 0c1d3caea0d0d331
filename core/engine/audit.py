"""Count the rays of each sensor that hit the car, miss the region, hit the ground or do useful work.

Every ray counts once, in the first of these that fits, so the shares of a sensor add up to one.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from riglens.core.engine.caster import Caster
from riglens.core.engine.engine import Engine
from riglens.core.kernels.body.ray_outcomes import (
    GROUND,
    NEW,
    NOTHING,
    OPEN,
    OUTSIDE,
    SHARED,
    ends_at_ground,
    follow_rays,
)
from riglens.core.kernels.rays.cast import Cast, ray_direction
from riglens.core.kernels.runtime import jit
from riglens.core.metric.entropy import EntropyField
from riglens.core.metric.scores import Body, MetricSettings, Scores
from riglens.core.rig.model import FORMAT_VERSION, Rig, Sensor
from riglens.core.rig.yaml.file import identity_of
from riglens.core.scene.boxes import CLASSES
from riglens.core.scene.columns import Words
from riglens.core.sensing.body_ends import barrier_ends, barrier_of
from riglens.core.vehicle.housings import car_of
from riglens.core.vehicle.solid import Barrier, solid_of
from riglens.core.vehicle.standing import MountStatus, mount_status

RAY_OUTCOMES = ("hits_car", "never_enters", "ground", "meets_nothing", "seen_by_others", "brings_new")
"""Outcomes of a ray, in display order and by the numbers of `kernels.body.ray_outcomes`."""


@dataclass(frozen=True)
class SensorAudit:
    """Ray outcomes of one sensor.

    `counts` are rays by the names in RAY_OUTCOMES; `lost_nat` is the entropy by class that the sensor on its own loses
    to the car's body, and `lost_share` the same as a share of H(Omega).
    """

    name: str
    kind: str
    counts: Mapping[str, int]
    lost_nat: Mapping[str, float]
    lost_share: Mapping[str, float]
    status: MountStatus

    @property
    def rays(self) -> int:
        """Number of rays cast."""
        return sum(self.counts.values())

    @property
    def shares(self) -> dict[str, float]:
        """The counts as shares of all rays; they add up to one."""
        return {name: count / max(1, self.rays) for name, count in self.counts.items()}


@dataclass(frozen=True)
class RigAudit:
    """Ray outcomes of a rig's enabled sensors; `body` says whether the car's body was considered."""

    rig: Rig
    body: Body
    sensors: tuple[SensorAudit, ...]

    def of(self, name: str) -> SensorAudit | None:
        """Return the audit of one sensor, None when it has none."""
        return next((found for found in self.sensors if found.name == name), None)


def audit(engine: Engine, rig: Rig, body: Body = "blocks") -> RigAudit:
    """Follow every ray of the rig's enabled sensors through the region of an engine.

    A ray that meets the car counts for the car, wherever. Of the others, one that meets voxels which no other sensor
    of the rig sees brings something new; one that meets informative voxels, but only such, sees what others see; one
    that meets none ends at the ground, or leaves the region by its sides or top, or never enters it. InputError where
    the mesh file of the car's body has not been read.
    """
    settings = MetricSettings(body=body)
    solid, car, field = solid_of(rig.vehicle), car_of(rig), engine.field
    engine.evaluate(rig, settings, False)
    enabled = [sensor for sensor in rig.sensors if sensor.enabled]
    marks = [np.array(engine.marks_of(sensor, "exact")) & field.index.words for sensor in enabled]
    once, twice = _seen_once_and_twice(field, marks)
    caster = Caster(field, engine.workers)
    audits = []
    for sensor, own in zip(enabled, marks, strict=True):
        barrier = barrier_of(sensor, car) if body == "blocks" else None
        outcomes = _outcomes(caster, sensor, barrier, twice | (once & ~own))
        counts = {name: int(np.count_nonzero(outcomes == code)) for code, name in enumerate(RAY_OUTCOMES)}
        lost = _lost(engine, rig, sensor)
        audits.append(
            SensorAudit(sensor.name, sensor.kind, counts, *lost, mount_status(sensor.position, solid))
        )
    return RigAudit(rig, body, tuple(audits))


def _seen_once_and_twice(field: EntropyField, marks: list[Words]) -> tuple[Words, Words]:
    """Return the voxels that at least one sensor sees, and those that at least two see."""
    once, twice = np.zeros_like(field.index.words), np.zeros_like(field.index.words)
    for own in marks:
        twice |= once & own
        once |= own
    return once, twice


def _outcomes(caster: Caster, sensor: Sensor, barrier: Barrier | None, others: Words) -> NDArray[np.int8]:
    """Return the outcome of each ray of a sensor, where `others` is what the other sensors see."""
    words, (nx, ny, nz) = caster.field.index.words, caster.field.grid.shape
    rays = caster.rays(sensor, "exact")._replace(box=np.array([0, nx, 0, ny, 0, nz], np.int64))
    if barrier is not None:
        ends = barrier_ends(sensor, barrier, caster.workers) / caster.field.grid.voxel_m
        most = np.minimum(rays.reach[1], rays.ends) if rays.ends.size else rays.reach[1]
        rays = rays._replace(is_stopped=ends < most)
    outcomes = np.empty(len(rays.rows) * len(rays.planes), np.int8)
    jit.use_threads(caster.workers)  # the engine takes fewer for short edits
    follow_rays(rays, words, others, caster.workers, outcomes)
    for number in np.flatnonzero(outcomes == OPEN):
        outcomes[number] = _outcome_in_fractions(caster, rays, int(number), others)
    return outcomes


def _outcome_in_fractions(caster: Caster, rays: Cast, number: int, others: Words) -> int:
    """Return the outcome of a ray that the kernels leave open, computed in fractions."""
    met = list(caster.walk_irregular(rays, np.array([number])))
    seen = [(word, bit) for word, bit in met if caster.field.index.words[word] & bit]
    if seen:
        return NEW if any(bit & ~others[word] for word, bit in seen) else SHARED
    return (
        (GROUND if ends_at_ground(rays, number, ray_direction(rays, number)) else NOTHING) if met else OUTSIDE
    )


def audit_document(found: RigAudit) -> dict[str, Any]:
    """Return the audit as plain data: shares as fractions, entropies in nat."""
    return {
        "riglens": FORMAT_VERSION,
        "body": found.body,
        "rig": identity_of(found.rig),
        "sensors": [_sensor_document(sensor) for sensor in found.sensors],
    }


def _sensor_document(found: SensorAudit) -> dict[str, Any]:
    place = found.status
    return {
        "name": found.name,
        "kind": found.kind,
        "rays": found.rays,
        "shares": found.shares,
        "lost_to_body": {
            name: {"nat": found.lost_nat[name], "share": found.lost_share[name]} for name in CLASSES
        },
        "place": {
            "inside": place.inside,
            "below_ground": place.below_ground,
            "gap_m": place.gap_m if np.isfinite(place.gap_m) else None,
            "drop_m": place.drop_m,
            "problem": place.problem,
        },
    }


def _lost(engine: Engine, rig: Rig, sensor: Sensor) -> tuple[dict[str, float], dict[str, float]]:
    """Return what the body takes from a sensor on its own, in nat by class and as a share of H(Omega)."""
    alone = rig.only((sensor,))
    free, cut = (
        engine.evaluate(alone, replace(MetricSettings(), body=body), False).scores
        for body in ("ignored", "blocks")
    )
    lost = {name: _seen_nat(free, name, sensor) - _seen_nat(cut, name, sensor) for name in CLASSES}
    totals = {name: free.classes[name].h_total for name in CLASSES}
    return lost, {name: lost[name] / totals[name] if totals[name] else 0.0 for name in CLASSES}


def _seen_nat(scores: Scores, cls: str, sensor: Sensor) -> float:
    """Return the entropy that a sensor sees on its own: minus its S-MIG in the reading `covered`."""
    found = scores.classes[cls]
    return -found.kinds[sensor.kind].s_mig
