"""Define the result of a study: average precision, its surrogates, and the rigs that differ."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from riglens.core.study.detection.pieces import Pieces, Study
from riglens.core.study.detection.published import equal_rays, families
from riglens.core.study.detection.second import budgets
from riglens.core.study.detection.statistics import COLUMNS, Precisions, precisions
from riglens.core.study.detection.surrogates import SURROGATES, Surrogates
from riglens.core.study.ranks import STATISTICS, RankCorrelation, Statistic, rank_correlation

Doubles = NDArray[np.float64]


@dataclass(frozen=True)
class Finding:
    """Agreement of the order of rigs by a surrogate with that by average precision of a column."""

    among: str
    surrogate: str
    column: str
    kind: Statistic
    rigs: int
    found: RankCorrelation | None


@dataclass(frozen=True)
class Order:
    """Pairs of rigs that average precision of a column resolves, within a span of differences, and how many of them a
    surrogate puts in the same order: higher is better, equal values count as wrong."""

    surrogate: str
    column: str
    apart: str
    pairs: int
    right: int


EASY_POINTS = 10.0
"""Pairs of rigs farther apart in average precision are easy to order."""


@dataclass(frozen=True)
class Result:
    """every: precision over all objects; hit: over those with a LiDAR point, as the devkit counts, so that each rig has
    its own test."""

    study: Study
    every: Precisions
    hit: Precisions
    surrogates: Surrogates

    def groups(self) -> dict[str, list[int]]:
        """Return the groups of rigs that are analysed together: all, equal ray counts, families, and budgets."""
        rays = [one.rays for one in self.study.compared]
        every = {"all rigs": list(range(len(rays)))}
        names = [one.name for one in self.study.compared]
        same = {"equal ray count": equal_rays(rays), **families(names), **budgets(names)}
        return every | {name: places for name, places in same.items() if 0 < len(places) < len(rays)}

    @cached_property
    def ranks(self) -> list[Finding]:
        """All rank correlations, group by group and class by class."""
        return [
            Finding(among, name, column, kind, len(places), self._correlation(kind, name, column, places))
            for among, places in self.groups().items()
            for column in COLUMNS
            for name in SURROGATES
            for kind in STATISTICS
        ]

    @cached_property
    def missed(self) -> dict[str, float]:
        """Return the mean over rigs of how far predicted AP is from what was measured, by column, percentage points."""
        found = {}
        for number, column in enumerate(COLUMNS):
            apart = 100.0 * self.surrogates.of("predicted", column) - self.every.value[:, number]
            found[column] = float(np.abs(apart).mean())
        return found

    @cached_property
    def orders(self) -> list[Order]:
        """Return how many of the resolved pairs each surrogate puts in the order of average precision."""
        found = []
        for column in COLUMNS:
            ap = self.every.value[:, COLUMNS.index(column)]
            pairs = [
                (one, other)
                for one, other in combinations(range(len(ap)), 2)
                if self.every.verdict(one, other, column) != "not resolved"
            ]
            places = np.array(pairs, np.int64).reshape(-1, 2).T
            lead = ap[places[0]] - ap[places[1]]
            for name in SURROGATES:
                values = self.surrogates.of(name, column)
                right = (values[places[0]] - values[places[1]]) * lead > 0.0
                for apart, chosen in (
                    ("all", np.ones(len(lead), np.bool_)),
                    (f"below {EASY_POINTS:g} points", np.abs(lead) < EASY_POINTS),
                    (f"from {EASY_POINTS:g} points", np.abs(lead) >= EASY_POINTS),
                ):
                    found.append(Order(name, column, apart, int(chosen.sum()), int(right[chosen].sum())))
        return found

    def _correlation(
        self, kind: Statistic, name: str, column: str, places: list[int]
    ) -> RankCorrelation | None:
        value, replicas = self._precision(column, places)
        if not (np.isfinite(value).all() and np.isfinite(replicas).all()):
            return None
        return rank_correlation(kind, self.surrogates.of(name, column)[places], value, replicas)

    def _precision(self, column: str, places: list[int]) -> tuple[Doubles, Doubles]:
        at = COLUMNS.index(column)
        return self.every.value[places, at], self.every.replicas[:, places, at]


def finished_seeds(pieces: Pieces) -> int:
    """Return the number of complete seeds, from the first on: every rig judged."""
    nets = pieces.study.nets
    for seed in range(pieces.study.protocol.seeds):
        mine = [net for net in nets if net.seed == seed]
        if not all(pieces.has_found(net, one) for net in mine for one in net.judges):
            return seed
    return pieces.study.protocol.seeds


def assemble(pieces: Pieces, seeds: int) -> tuple[Precisions, Precisions]:
    """Average precision over all objects and over those hit, from the first seeds, which must be complete."""
    rigs = [one.name for one in pieces.study.compared]
    nets = [net for net in pieces.study.nets if net.seed < seeds]
    found = []
    for hit_only in (False, True):
        matched = {
            (one.name, net.seed): pieces.matched(net, one, hit_only) for net in nets for one in net.judges
        }
        found.append(precisions(rigs, matched, seeds))
    return found[0], found[1]
