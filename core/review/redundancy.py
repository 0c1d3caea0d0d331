"""Redundancy: coverage by number of sensors, and the loss when one, two or a group of them fail.

Nothing is cast again: of the sets of voxels that the sensors traverse, and of their points and pixels on objects,
the same figures follow as from rigs without the sensors, to the last bit. It is a count of views, not evidence of a
safety integrity level: causes and probabilities of failures are unknown here.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from riglens.core.engine.engine import Engine
from riglens.core.kernels.review import overlap as kernel
from riglens.core.kernels.runtime import jit
from riglens.core.metric.entropy import EntropyField
from riglens.core.metric.scores import Method, MetricSettings
from riglens.core.rig.edits import damaged
from riglens.core.rig.groups import groups_of
from riglens.core.rig.model import Rig, Sensor
from riglens.core.scene.boxes import CLASSES
from riglens.core.scene.columns import words_per_column
from riglens.core.scene.grid import VoxelGrid
from riglens.core.scene.sectors import SECTORS, sector_of
from riglens.core.sensors.base import HALVES
from riglens.core.sensors.registry import kind_names
from riglens.core.targets.engine import TargetEngine
from riglens.core.targets.scores import ObjectCounts
from riglens.core.targets.settings import TargetSettings
from riglens.core.targets.traffic import Traffic

NO_EVIDENCE = "a count of views, no evidence of a safety integrity level (ASIL)"
What = Literal["sensor", "pair", "group", "half"]
"""A failure to try; "half" is a sensor with half of its view blocked, which only some requests try."""
Sums = NDArray[np.int64]
Flags = NDArray[np.bool_]
COVERED = ("1", "2", "3", "two kinds")
EVERYBODY = 0
"""Rows of crowds: all sensors, those of either kind, and groups from there on."""
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


def with_halves(found: Coverage, rig: Rig, coverage: Callable[[Rig], Coverage]) -> Coverage:
    """Return a rig's coverage with the losses by half-blocked sensors; `coverage` computes that of any rig."""
    seen = found.covered[:, 0]
    failures = [
        Failure("half", name, (name.rpartition("=")[0],), seen - coverage(other).covered[:, 0])
        for name, other in halves_of(rig)
    ]
    return replace(found, failures=(*found.failures, *failures))


# ---------------------------------------------------------------- voxels


def sectors_of_columns(grid: VoxelGrid) -> NDArray[np.uint8]:
    """Return the sector of the centre of each column, (columns,)."""
    x, y = np.meshgrid(grid.centres_m(0), grid.centres_m(1), indexing="ij")
    return sector_of(x, y).ravel()


class _Shares(NamedTuple):
    """Coverage by the sensors that provide it, (s, ..., 4): one alone (s, n, 4); exactly two (s, n, n, 4) with the
    first before the second; three or more of one crowd and no others, many (s, g, 4)."""

    alone: Sums
    both: Sums
    many: Sums

    @classmethod
    def of(cls, sums: Sums, n: int) -> _Shares:
        """Name the parts of sums (s, rows, 4) of n sensors."""
        sectors, _, columns = sums.shape
        both = sums[:, n : n + n * n].reshape(sectors, n, n, columns)
        return cls(sums[:, :n], both, sums[:, n + n * n :])

    def within(self, crowds: Flags) -> Sums:
        """Return the coverage by exactly two sensors, both of the crowd (g, n), and no others: (s, g, 4)."""
        return np.stack([self.both[:, who][:, :, who].sum(axis=(1, 2)) for who in crowds], axis=1)

    def covered(self, of_kind: Flags) -> Sums:
        """Return the coverage by 1, 2, 3 sensors or two kinds, (s, 4, classes); of_kind (kinds, sensors)."""
        thrice, of_one_kind = self.many[:, EVERYBODY], self.many[:, _by_kind()].sum(axis=1)
        mixed = (of_kind[:, :, None] != of_kind[:, None, :]).any(axis=0)
        kinds = thrice - of_one_kind + self.both[:, mixed].sum(axis=1)
        twice = thrice + self.both.sum(axis=(1, 2))
        levels = [twice + self.alone.sum(axis=1), twice, thrice, kinds]
        return np.stack(levels, axis=1)[..., : len(CLASSES)]


class VoxelRedundancy:
    """Coverage of the entropy of one field. Call it from the thread of the parallel kernels."""

    def __init__(self, field: EntropyField, threads: int | None = None) -> None:
        self._workers, self._depth = jit.use_threads(threads), words_per_column(field.grid)
        self._sectors = sectors_of_columns(field.grid)
        self._total = np.zeros((len(SECTORS), kernel.COLUMNS), np.int64)
        kernel.total_by_sector(self._sectors, self._depth, field.entropies, self._total)

    def coverage(self, engine: Engine, rig: Rig, method: Method = "exact") -> Coverage:
        """Return how much entropy of each class the rig covers that an engine on this field evaluated last."""
        sensors = [sensor for sensor in rig.sensors if sensor.enabled]
        groups = groups_of(sensors)
        crowds = _crowds(sensors, list(groups.values()))
        shares, names = self._shares(engine, sensors, crowds, method), [sensor.name for sensor in sensors]
        lost = shares.alone[..., : len(CLASSES)]
        failures = [Failure("sensor", name, (name,), lost[:, i]) for i, name in enumerate(names)]
        if len(names) <= MOST_PAIRED:
            for i, j in combinations(range(len(names)), 2):
                both = shares.both[:, i, j, : len(CLASSES)]
                pair = (names[i], names[j])
                failures.append(Failure("pair", " + ".join(pair), pair, lost[:, i] + lost[:, j] + both))
        together = shares.within(crowds) + shares.many
        for g, (name, members) in enumerate(groups.items(), start=_by_kind().stop):
            alone = lost[:, crowds[g]].sum(axis=1)
            failures.append(Failure("group", name, members, alone + together[:, g, : len(CLASSES)]))
        covered = shares.covered(crowds[_by_kind()])
        return Coverage(self._total[:, : len(CLASSES)], covered, tuple(failures))

    def _shares(self, engine: Engine, sensors: list[Sensor], crowds: Flags, method: Method) -> _Shares:
        views = kernel.Views(*engine.stack_of(sensors, method), crowds, self._sectors, self._depth)
        rows = kernel.rows_of_sums(len(sensors), len(crowds))
        sums = np.zeros((self._workers, len(SECTORS), rows, kernel.COLUMNS), np.int64)
        jit.use_threads(self._workers)
        kernel.tally_views(views, engine.field.entropies, sums)
        return _Shares.of(sums.sum(axis=0), len(sensors))


def voxel_coverage(
    engine: Engine, rig: Rig, method: Method = "exact", threads: int | None = None
) -> Coverage:
    """Return how much entropy of an engine's field the rig evaluated last covers."""
    return VoxelRedundancy(engine.field, threads).coverage(engine, rig, method)


def voxel_counter(
    engine: Engine, settings: MetricSettings, threads: int | None = None
) -> Callable[[Rig], Coverage]:
    """Return a function that evaluates a rig with an engine and counts the entropy that it covers."""
    counting = VoxelRedundancy(engine.field, threads)

    def coverage(rig: Rig) -> Coverage:
        engine.evaluate(rig, settings, False)
        return counting.coverage(engine, rig, settings.method)

    return coverage


def _by_kind() -> slice:
    """Return the places of the kinds among the crowds."""
    return slice(1, 1 + len(kind_names()))


def _crowds(sensors: Sequence[Sensor], groups: Sequence[tuple[str, ...]]) -> Flags:
    """Return the members of the crowds, (1 + kinds + groups, sensors): of all, of each kind, of each group."""
    rows = [[True] * len(sensors)]
    rows += [[sensor.kind == kind for sensor in sensors] for kind in kind_names()]
    rows += [[sensor.name in group for sensor in sensors] for group in groups]
    return np.array(rows, np.bool_).reshape(len(rows), len(sensors))


# ---------------------------------------------------------------- objects


def target_coverage(traffic: Traffic, rig: Rig, objects: ObjectCounts, min_points: int) -> Coverage:
    """Count the objects that the rig detects, by `min_points` points of its LiDARs, 25 px of height in a camera, or the
    threshold of another kind."""
    place = traffic.centre_m[objects.box]
    where = sector_of(place[:, 0], place[:, 1]).astype(np.int64) * len(CLASSES) + traffic.cls[objects.box]

    def tally(flags: Flags) -> Sums:
        found = np.bincount(where[flags], minlength=len(SECTORS) * len(CLASSES))
        return found.reshape(len(SECTORS), len(CLASSES)).astype(np.int64)

    sensors = [sensor for sensor in rig.sensors if sensor.enabled]
    alone = objects.sensors_detecting(min_points)
    detected = _detected(objects, (), min_points)
    kinds = np.sum(list(objects.detected(min_points).values()), axis=0) >= 2
    covered = np.stack([tally(detected), tally(alone >= 2), tally(alone >= 3), tally(kinds)], axis=1)
    failures = tuple(
        Failure(what, name, members, tally(detected & ~_detected(objects, members, min_points)))
        for what, name, members in failing_of(sensors)
    )
    return Coverage(tally(np.ones(len(objects.box), np.bool_)), covered, failures)


def target_counter(
    engine: TargetEngine, traffic: Traffic, settings: TargetSettings
) -> Callable[[Rig], Coverage]:
    """Return a counter of the objects that rigs detect, with an engine on the same traffic."""

    def coverage(rig: Rig) -> Coverage:
        return target_coverage(traffic, rig, engine.evaluate(rig, settings).objects, settings.min_points)

    return coverage


def _detected(objects: ObjectCounts, failed: tuple[str, ...], min_points: int) -> Flags:
    """Return which objects are detected without some sensors, (k,)."""
    return np.asarray(np.any(list(objects.detected(min_points, failed).values()), axis=0))
