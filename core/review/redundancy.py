"""Redundancy: what how many sensors see, and what is lost when one, two or a group of them fail.

Nothing is cast again: of the sets of voxels that the sensors traverse, and of the points and pixels that each gets onto
road users, the same figures follow as from rigs without the sensors, to the last bit. It is a count of views, and no
evidence of any safety integrity level: nothing is known here of why sensors fail, or how likely.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from riglens.core.engine.engine import Engine
from riglens.core.kernels import jit
from riglens.core.kernels import review as kernel
from riglens.core.metric.entropy import EntropyField
from riglens.core.metric.scores import Method
from riglens.core.metric.scoring import KINDS
from riglens.core.review.outline import SECTORS, sector_of
from riglens.core.rig.groups import groups_of
from riglens.core.rig.model import Rig, Sensor
from riglens.core.scene.boxes import CLASSES
from riglens.core.scene.columns import Words, words_per_column
from riglens.core.scene.grid import VoxelGrid
from riglens.core.targets.scores import ObjectCounts
from riglens.core.targets.settings import HEIGHT_PX
from riglens.core.targets.traffic import Traffic

NO_EVIDENCE = "a count of views, no evidence of a safety integrity level (ASIL)"
What = Literal["sensor", "pair", "group"]
Sums = NDArray[np.int64]
Flags = NDArray[np.bool_]
COVERED = ("1", "2", "3", "two kinds")
MOST_MOVED = 2
"""The sets of so many sensors that moved are kept, for they move again: of one, or of a mirrored pair."""
MOST_PAIRED = 40
"""Pairs are told of rigs with at most so many enabled sensors: 780 pairs."""


@dataclass(frozen=True)
class Failure:
    """Sensors that fail together, and what is lost then: (sectors, classes) in the unit of the coverage."""

    what: What
    name: str
    members: tuple[str, ...]
    lost: Sums


@dataclass(frozen=True)
class Coverage:
    """What there is, what of it 1, 2 or 3 sensors or more, or two kinds, cover, and what failures cost.

    total (sectors, classes) and covered (sectors, 4, classes), the middle axis by COVERED: whole numbers of entropy in
    units of 2^-32 nat, or of road users. Sensors cover a road user that each detects alone; the first of COVERED
    counts those that all of them together detect.
    """

    total: Sums
    covered: Sums
    failures: tuple[Failure, ...]

    def worst(self, what: What, cls: int, sector: int | None = None) -> Failure | None:
        """The failure of a kind that costs most of a class, everywhere or in one sector; the first of equals."""
        mine = [failure for failure in self.failures if failure.what == what]
        return max(mine, key=lambda failure: lost_of(failure, cls, sector), default=None)


def lost_of(failure: Failure, cls: int, sector: int | None = None) -> int:
    """What a failure costs of a class, everywhere or in one sector."""
    return int(failure.lost[:, cls].sum() if sector is None else failure.lost[sector, cls])


# ---------------------------------------------------------------- voxels


def sectors_of_columns(grid: VoxelGrid) -> NDArray[np.uint8]:
    """The sector of the centre of each column, (columns,)."""
    x, y = np.meshgrid(grid.centres_m(0), grid.centres_m(1), indexing="ij")
    return sector_of(x, y).ravel()


class _Tally(NamedTuple):
    """What `tally_losses` writes, all workers added up: levels (s, 2, 4), singles (s, n, 4), pairs (s, n, n, 4), groups
    (s, g, 4)."""

    levels: Sums
    singles: Sums
    pairs: Sums
    groups: Sums

    @classmethod
    def room(cls, workers: int, sensors: int, groups: int) -> _Tally:
        """Zeros for each of some workers."""
        shapes = ((2,), (sensors,), (sensors, sensors), (groups,))
        return cls(*(np.zeros((workers, len(SECTORS), *shape, kernel.COLUMNS), np.int64) for shape in shapes))

    def total(self) -> _Tally:
        """The sums over the workers."""
        return _Tally(*(part.sum(axis=0) for part in self))

    def plus(self, change: _Tally) -> _Tally:
        """The sums with a change."""
        return _Tally(*(one + other for one, other in zip(self, change, strict=True)))


class _Counted(NamedTuple):
    """A tally, what it depends on, and the sets (m, words) of those sensors that had moved in it, by their places."""

    tally: _Tally
    origins: tuple[Hashable, ...]
    kinds: NDArray[np.int64]
    members: Flags
    moved: tuple[int, ...]
    before: Words

    def moved_to(
        self, origins: tuple[Hashable, ...], kinds: NDArray[np.int64], members: Flags
    ) -> tuple[int, ...] | None:
        """Places of sensors that see something else now; None where not the same sensors are to be counted."""
        if not (np.array_equal(kinds, self.kinds) and np.array_equal(members, self.members)):
            return None
        return tuple(i for i, (now, old) in enumerate(zip(origins, self.origins, strict=True)) if now != old)


class VoxelRedundancy:
    """Coverage of the entropy of one field. Where those sensors move again that moved last, as in a drag, only what
    they see anew or no more is counted. Call it from the thread of the parallel kernels."""

    def __init__(self, field: EntropyField, threads: int | None = None) -> None:
        self._workers, self._depth = jit.use_threads(threads), words_per_column(field.grid)
        self._sectors = sectors_of_columns(field.grid)
        self._total = np.zeros((len(SECTORS), kernel.COLUMNS), np.int64)
        kernel.total_by_sector(self._sectors, self._depth, field.entropies, self._total)
        self._counted: _Counted | None = None

    def coverage(self, engine: Engine, rig: Rig, method: Method = "exact") -> Coverage:
        """What the rig that an engine on this field evaluated last covers of the entropy of each class."""
        sensors = [sensor for sensor in rig.sensors if sensor.enabled]
        groups = groups_of(sensors)
        self._counted = self._count(engine, sensors, _members(sensors, list(groups.values())), method)
        levels, *failing = (part[..., : len(CLASSES)] for part in self._counted.tally)
        lost, both, together = (np.moveaxis(part, 0, -2) for part in failing)
        names = [sensor.name for sensor in sensors]
        failures = [Failure("sensor", name, (name,), own) for name, own in zip(names, lost, strict=True)]
        if len(names) <= MOST_PAIRED:
            for i, j in combinations(range(len(names)), 2):
                failures.append(_pair(names[i], names[j], lost[i] + lost[j] + both[i, j]))
        for (name, members), own in zip(groups.items(), together, strict=True):
            failures.append(Failure("group", name, members, own))
        thrice, kinds = levels[:, kernel.AT_LEAST_3], levels[:, kernel.TWO_KINDS]
        twice = thrice + both.sum(axis=(0, 1))
        covered = np.stack([twice + lost.sum(axis=0), twice, thrice, kinds], axis=1)
        return Coverage(self._total[:, : len(CLASSES)], covered, tuple(failures))

    def _count(self, engine: Engine, sensors: list[Sensor], members: Flags, method: Method) -> _Counted:
        """The tally of now: the last one, or that with a change, or one from scratch."""
        known, self._counted = self._counted, None
        origins = engine.origins_of(sensors, method)
        kinds = np.array([KINDS.index(sensor.kind) for sensor in sensors], np.int64)
        stack, slots = engine.stack_of(sensors, method)
        moved = None if known is None else known.moved_to(origins, kinds, members)
        tally = _Tally.room(self._workers, len(sensors), len(members))
        entropies = engine.field.entropies
        jit.use_threads(self._workers)
        if known is not None and moved is not None and set(moved) <= set(known.moved):
            kernel.change_losses(
                np.array(known.moved, np.int64), known.before, stack, slots, kinds, members, self._sectors,
                self._depth, entropies, *tally,
            )  # fmt: skip
            return known._replace(tally=known.tally.plus(tally.total()), origins=origins)
        kernel.tally_losses(stack, slots, kinds, members, self._sectors, self._depth, entropies, *tally)
        again = moved if moved is not None and len(moved) <= MOST_MOVED else ()
        before = stack[slots[list(again)]] & entropies.keep
        return _Counted(tally.total(), origins, kinds, members, again, before)


def voxel_coverage(
    engine: Engine, rig: Rig, method: Method = "exact", threads: int | None = None
) -> Coverage:
    """What the rig that an engine evaluated last covers of the entropy of its field."""
    return VoxelRedundancy(engine.field, threads).coverage(engine, rig, method)


def _pair(one: str, other: str, lost: Sums) -> Failure:
    return Failure("pair", f"{one} + {other}", (one, other), lost)


def _members(sensors: Sequence[Sensor], groups: Sequence[tuple[str, ...]]) -> Flags:
    """Who belongs to which group, (groups, sensors)."""
    rows = [[sensor.name in group for sensor in sensors] for group in groups]
    return np.array(rows, np.bool_).reshape(len(groups), len(sensors))


# ---------------------------------------------------------------- road users


def target_coverage(traffic: Traffic, rig: Rig, objects: ObjectCounts, min_points: int) -> Coverage:
    """How many road users the rig detects, by `min_points` points of its LiDARs or 25 px of height in a camera."""
    place = traffic.centre_m[objects.box]
    where = sector_of(place[:, 0], place[:, 1]).astype(np.int64) * len(CLASSES) + traffic.cls[objects.box]

    def tally(flags: Flags) -> Sums:
        found = np.bincount(where[flags], minlength=len(SECTORS) * len(CLASSES))
        return found.reshape(len(SECTORS), len(CLASSES)).astype(np.int64)

    sensors = [sensor for sensor in rig.sensors if sensor.enabled]
    alone = np.concatenate([objects.points >= min_points, objects.heights_px >= HEIGHT_PX], axis=1).sum(
        axis=1
    )
    detected = _detected(objects, (), min_points)
    kinds = (objects.all_points >= min_points) & (objects.height_px >= HEIGHT_PX)
    covered = np.stack([tally(detected), tally(alone >= 2), tally(alone >= 3), tally(kinds)], axis=1)
    names = [sensor.name for sensor in sensors]
    failing: list[tuple[What, str, tuple[str, ...]]] = [("sensor", name, (name,)) for name in names]
    if len(names) <= MOST_PAIRED:
        failing += [("pair", f"{one} + {other}", (one, other)) for one, other in combinations(names, 2)]
    failing += [("group", name, members) for name, members in groups_of(sensors).items()]
    failures = tuple(
        Failure(what, name, members, tally(detected & ~_detected(objects, members, min_points)))
        for what, name, members in failing
    )
    return Coverage(tally(np.ones(len(objects.box), np.bool_)), covered, failures)


def _detected(objects: ObjectCounts, failed: tuple[str, ...], min_points: int) -> Flags:
    """Which road users are detected without some sensors, (k,)."""
    lidars = np.array([name not in failed for name in objects.lidars], np.bool_)
    cameras = np.array([name not in failed for name in objects.cameras], np.bool_)
    points = objects.points[:, lidars].sum(axis=1)
    tallest = objects.heights_px[:, cameras].max(axis=1, initial=0.0)
    return np.asarray((points >= min_points) | (tallest >= HEIGHT_PX))
