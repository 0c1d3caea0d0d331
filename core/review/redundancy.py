"""Redundancy: coverage by number of sensors, and the loss when one, two or a group of them fail.

Nothing is cast again: of the sets of voxels that the sensors traverse, and of their points and pixels on objects,
the same figures follow as from rigs without the sensors, to the last bit. It is a count of views, not evidence of a
safety integrity level: causes and probabilities of failures are unknown here.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from riglens.core.engine.engine import Engine
from riglens.core.engine.inspect import covered_at_least
from riglens.core.figures.evaluated import Evaluator
from riglens.core.kernels.review import overlap as kernel
from riglens.core.metric.scores import Method
from riglens.core.rig.edits import damaged
from riglens.core.rig.groups import groups_of
from riglens.core.rig.model import Rig, Sensor
from riglens.core.scene.boxes import CLASSES
from riglens.core.scene.columns import Words, words_per_column
from riglens.core.scene.grid import VoxelGrid
from riglens.core.scene.sectors import SECTORS, sector_of
from riglens.core.sensors.base import HALVES
from riglens.core.sensors.registry import kind_names
from riglens.core.targets.counts import Counted, ObjectCounts

NO_EVIDENCE = "a count of views, no evidence of a safety integrity level (ASIL)"
What = Literal["sensor", "pair", "group", "half"]
"""A failure to try; "half" is a sensor with half of its view blocked, which only some requests try."""
Covered = Literal["voxels", "objects"]
Sums = NDArray[np.int64]
Flags = NDArray[np.bool_]
COVERED = ("1", "2", "3", "two kinds")
MOST_PAIRED = 40
"""Largest number of enabled sensors for which pairs are reported: 780 pairs."""


@dataclass(frozen=True)
class Failure:
    """Sensors that fail together, and the loss: (sectors, classes) in the unit of the coverage."""

    what: What
    name: str
    members: tuple[str, ...]
    lost: Sums


@dataclass(frozen=True)
class Coverage:
    """Coverage by 1, 2, 3 sensors or more and by two kinds, the total, and the losses by failures.

    total (sectors, classes) and covered (sectors, 4, classes), the middle axis by COVERED: whole numbers of entropy in
    units of 2^-32 nat, or of objects. Sensors cover an object that each detects alone; the first of COVERED
    counts those that all of them together detect.
    """

    total: Sums
    covered: Sums
    failures: tuple[Failure, ...]

    def worst(self, what: What, cls: int, sector: int | None = None) -> Failure | None:
        """Return the failure of a kind that costs most of a class, everywhere or in one sector; the first of equals."""
        mine = [failure for failure in self.failures if failure.what == what]
        return max(mine, key=lambda failure: lost_of(failure, cls, sector), default=None)


def lost_of(failure: Failure, cls: int, sector: int | None = None) -> int:
    """Return the loss of a class by a failure, everywhere or in one sector."""
    return int(failure.lost[:, cls].sum() if sector is None else failure.lost[sector, cls])


def lost_share(found: Coverage, failure: Failure, cls: int, sector: int | None = None) -> float:
    """Return the loss by a failure as a share of the total of a class, everywhere or in one sector; less is better."""
    total = found.total[:, cls].sum() if sector is None else found.total[sector, cls]
    return share(lost_of(failure, cls, sector), int(total))


def share(part: int, total: int) -> float:
    """Return part / total, 0 for a total of 0."""
    return part / total if total else 0.0


def failing_of(sensors: Sequence[Sensor]) -> list[tuple[What, str, tuple[str, ...]]]:
    """Return what can fail: every sensor, every pair, every group, with its name and the sensors that it takes."""
    names = [sensor.name for sensor in sensors]
    failing: list[tuple[What, str, tuple[str, ...]]] = [("sensor", name, (name,)) for name in names]
    if len(names) <= MOST_PAIRED:
        failing += [("pair", f"{one} + {other}", (one, other)) for one, other in combinations(names, 2)]
    return failing + [("group", name, members) for name, members in groups_of(sensors).items()]


def halves_of(rig: Rig) -> list[tuple[str, Rig]]:
    """Return the rig with each half of each enabled sensor's view blocked, as "roof=left"."""
    names = [f"{sensor.name}={half}" for sensor in rig.sensors if sensor.enabled for half in HALVES]
    return [(name, damaged(rig, [name])) for name in names]


def _failures(sensors: Sequence[Sensor], lost: Callable[[tuple[str, ...]], Sums]) -> tuple[Failure, ...]:
    """Return what can fail with the loss by its members."""
    return tuple(Failure(what, name, members, lost(members)) for what, name, members in failing_of(sensors))


def coverage_of(evaluate: Evaluator, rig: Rig, of: Covered, halves: bool = False) -> Coverage:
    """Evaluate a rig and return what it covers of voxels or of objects; with `halves`, the losses by half-blocked
    sensors too."""
    found = _coverage(evaluate, rig, of)
    if not halves:
        return found
    seen = found.covered[:, 0]
    failures = [
        Failure(
            "half",
            name,
            (name.rpartition("=")[0],),
            seen - _coverage(evaluate, other, of, False).covered[:, 0],
        )
        for name, other in halves_of(rig)
    ]
    return replace(found, failures=(*found.failures, *failures))


def _coverage(evaluate: Evaluator, rig: Rig, of: Covered, with_failures: bool = True) -> Coverage:
    objects = evaluate(rig, (of,)).objects
    if objects is not None:
        return target_coverage(objects, with_failures)
    return voxel_coverage(evaluate.voxels, rig, evaluate.settings.metric.method, with_failures)


# ---------------------------------------------------------------- voxels


def sectors_of_columns(grid: VoxelGrid) -> NDArray[np.uint8]:
    """Return the sector of the centre of each column, (columns,)."""
    x, y = np.meshgrid(grid.centres_m(0), grid.centres_m(1), indexing="ij")
    return sector_of(x, y).ravel()


def voxel_coverage(
    engine: Engine, rig: Rig, method: Method = "exact", with_failures: bool = True
) -> Coverage:
    """Return how much entropy of each class the rig covers that an engine evaluated last. Call it from the thread of
    the parallel kernels."""
    field, sensors = engine.field, [sensor for sensor in rig.sensors if sensor.enabled]
    keep, sectors, depth = field.index.words, sectors_of_columns(field.grid), words_per_column(field.grid)
    stack, slots = engine.stack_of(sensors, method)
    own = {sensor.name: stack[slot] for sensor, slot in zip(sensors, slots, strict=True)}

    def entropy(voxels: Words) -> Sums:
        sums = np.zeros((len(SECTORS), kernel.COLUMNS), np.int64)
        kernel.sum_by_sector(voxels, sectors, depth, field.entropies, sums)
        return sums[:, : len(CLASSES)]

    def seen_by(names: Iterable[str]) -> Words:
        return _once_and_twice((own[name] for name in names), keep)[0]

    kinds = (seen_by(s.name for s in sensors if s.kind == kind) for kind in kind_names())
    levels = covered_at_least(engine, rig, method)
    by_one, by_two = levels[0] & ~levels[1], levels[1] & ~levels[2]
    alone = {name: entropy(voxels & by_one) for name, voxels in own.items()} if with_failures else {}

    def lost(members: tuple[str, ...]) -> Sums:
        if len(members) > 2:
            return entropy(seen_by(members) & ~seen_by(own.keys() - members))
        # of up to two sensors it is what exactly one of them sees, and what exactly these two do
        shared = [entropy(own[one] & own[other] & by_two) for one, other in combinations(members, 2)]
        return np.asarray(np.sum([*(alone[name] for name in members), *shared], axis=0))

    return Coverage(
        entropy(keep),
        np.stack([entropy(voxels) for voxels in (*levels, _once_and_twice(kinds, keep)[1])], axis=1),
        _failures(sensors, lost) if with_failures else (),
    )


def _once_and_twice(sets: Iterable[Words], keep: Words) -> tuple[Words, Words]:
    """Return the voxels of `keep` that one or more of some sets hold, and those that two or more do."""
    once, twice = np.zeros_like(keep), np.zeros_like(keep)
    for one in sets:
        twice |= once & one
        once |= one & keep
    return once, twice


# ---------------------------------------------------------------- objects


def target_coverage(counted: Counted, with_failures: bool = True) -> Coverage:
    """Count the objects that the rig detects, by `min_points` points of its LiDARs, half of it in a picture, or the
    threshold of another kind."""
    rig, objects, groups = counted.rig, counted.objects, counted.groups
    min_points = counted.settings.min_points
    where = sector_of(*groups.centre_m.T).astype(np.int64) * len(CLASSES) + groups.cls

    def tally(flags: Flags) -> Sums:
        found = np.bincount(where[flags], minlength=len(SECTORS) * len(CLASSES))
        return found.reshape(len(SECTORS), len(CLASSES)).astype(np.int64)

    sensors = [sensor for sensor in rig.sensors if sensor.enabled]
    alone = objects.sensors_detecting(min_points)
    detected = _detected(objects, (), min_points)
    kinds = np.sum(list(objects.detected(min_points).values()), axis=0) >= 2
    covered = np.stack([tally(detected), tally(alone >= 2), tally(alone >= 3), tally(kinds)], axis=1)

    def lost(members: tuple[str, ...]) -> Sums:
        return tally(detected & ~_detected(objects, members, min_points))

    failures = _failures(sensors, lost) if with_failures else ()
    return Coverage(tally(np.ones(len(objects.box), np.bool_)), covered, failures)


def _detected(objects: ObjectCounts, failed: tuple[str, ...], min_points: int) -> Flags:
    """Return which objects are detected without some sensors, (k,)."""
    return np.asarray(np.any(list(objects.detected(min_points, failed).values()), axis=0))
