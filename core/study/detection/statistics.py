"""Compare the detection of rigs and its uncertainty: average precision in pairs, over sequences and seeds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from riglens.core.detect.precision import Matched
from riglens.core.scene.boxes import CLASSES
from riglens.core.study.ranks import SPREAD

Doubles = NDArray[np.float64]
Verdict = Literal["better", "worse", "not resolved"]

MEAN = "mean"
COLUMNS = (*CLASSES, MEAN)
"""Columns of average precision: each class, and their mean (mAP)."""
LEAST_DIFFERENCE = {"car": 1.5, "bicycle": 4.0, "pedestrian": 1.5, MEAN: 1.5}
"""Smaller differences, in percentage points, are not called better: our choice, above what seeds alone make of them."""
REPLICAS = 1000


@dataclass(frozen=True)
class Estimate:
    """A figure with its 95 % interval."""

    value: float
    low: float
    high: float


@dataclass(frozen=True)
class Precisions:
    """Average precision of rigs in percent, mean over seeds: value (rigs, COLUMNS); by_seed (rigs, seeds, COLUMNS);
    replicas (r, rigs, COLUMNS): the value on sequences and seeds drawn with replacement, the same draws for all rigs.

    NaN for a class without objects, which the mean leaves out.
    """

    rigs: tuple[str, ...]
    seeds: int
    sequences: int
    value: Doubles
    by_seed: Doubles
    replicas: Doubles

    def estimate(self, rig: int, column: str) -> Estimate:
        """Average precision of a rig and its interval."""
        place = COLUMNS.index(column)
        return _estimate(float(self.value[rig, place]), self.replicas[:, rig, place])

    def difference(self, one: int, other: int, column: str) -> Estimate:
        """Return the advantage of one rig over the other, percentage points."""
        place = COLUMNS.index(column)
        of = self.replicas[:, one, place] - self.replicas[:, other, place]
        return _estimate(float(self.value[one, place] - self.value[other, place]), of)

    def verdict(self, one: int, other: int, column: str) -> Verdict:
        """Return whether the one detects better than the other: the interval leaves 0 out, and the difference is worth
        it."""
        found = self.difference(one, other, column)
        resolved = found.low > 0.0 or found.high < 0.0
        if not resolved or abs(found.value) < LEAST_DIFFERENCE[column]:
            return "not resolved"
        return "better" if found.value > 0.0 else "worse"

    def seed_spread(self, column: str) -> float | None:
        """Return the standard deviation between seeds, root mean square over rigs, percentage points; None for one
        seed."""
        if self.seeds < 2:
            return None
        variance = np.var(self.by_seed[:, :, COLUMNS.index(column)], axis=1, ddof=1)
        return float(np.sqrt(variance.mean()))


def precisions(
    rigs: Sequence[str],
    matched: Mapping[tuple[str, int], Sequence[Matched]],
    seeds: int,
    replicas: int = REPLICAS,
    seed: int = 0,
) -> Precisions:
    """Return the average precision of the rigs from matches, by (rig, seed) and class, on the same frames for all."""
    sequences = len(matched[rigs[0], 0][0].objects)
    rng = np.random.default_rng(seed)
    weights = rng.multinomial(sequences, np.full(sequences, 1.0 / sequences), replicas).T.astype(np.float64)
    shares = rng.multinomial(seeds, np.full(seeds, 1.0 / seeds), replicas).astype(np.float64) / seeds
    weights = np.concatenate([np.ones((sequences, 1)), weights], axis=1)  # what was found stands first
    by_seed = np.empty((len(rigs), seeds, len(COLUMNS)))
    drawn = np.empty((replicas, len(rigs), len(COLUMNS)))
    for place, rig in enumerate(rigs):
        found = np.array(
            [[100.0 * one.precision(weights) for one in matched[rig, number]] for number in range(seeds)]
        )
        found = np.concatenate([found, _mean(found)[:, None]], axis=1)  # (seeds, columns, 1 + replicas)
        by_seed[place] = found[:, :, 0]
        drawn[:, place] = np.einsum("rs,scr->rc", shares, found[:, :, 1:])
    return Precisions(tuple(rigs), seeds, sequences, by_seed.mean(axis=1), by_seed, drawn)


def _mean(found: Doubles) -> Doubles:
    """Return the mean over the classes (seeds, classes, r) that have objects at all."""
    there = ~np.isnan(found[:, :, 0]).any(axis=0)
    return np.asarray(found[:, there].mean(axis=1)) if there.any() else np.full_like(found[:, 0], np.nan)


def _estimate(value: float, replicas: Doubles) -> Estimate:
    known = replicas[~np.isnan(replicas)]
    if not known.size:
        return Estimate(value, float("nan"), float("nan"))
    low, high = np.quantile(known, SPREAD)
    return Estimate(value, float(low), float(high))
