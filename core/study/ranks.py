"""Do two figures put rigs in the same order? Rank correlations with intervals and permutation tests."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import permutations
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.stats import rankdata

Doubles = NDArray[np.float64]
Statistic = Literal["spearman", "kendall"]

FEWEST_RIGS = 5
"""With fewer rigs an order means nothing: of four, one in twelve agrees by chance in one direction or the other."""
EXACT_TO = 8
"""Up to this many rigs all permutations are tried (40,320)."""
DRAWN_PERMUTATIONS = 20_000
SPREAD = (0.025, 0.975)


@dataclass(frozen=True)
class RankCorrelation:
    """Correlation of two orders, -1 to 1, its 95 % interval, and the two-sided p of a permutation test.

    exact: whether all permutations were tried; otherwise p is (1 + as far or farther) / (1 + DRAWN_PERMUTATIONS).
    """

    value: float
    low: float
    high: float
    p: float
    exact: bool


def spearman(x: Doubles, y: Doubles) -> Doubles:
    """Return Spearman's coefficient of each row, (...,), of x and y (..., n); equal values share ranks; NaN for a
    constant."""
    return _pearson(rankdata(x, axis=-1), rankdata(y, axis=-1))


def kendall(x: Doubles, y: Doubles) -> Doubles:
    """Return Kendall's tau-b of each row, (...,), of x and y (..., n); NaN where a row is constant."""
    a, b = (np.sign(values[..., :, None] - values[..., None, :]) for values in (x, y))
    with np.errstate(invalid="ignore", divide="ignore"):
        scale = np.sqrt((a * a).sum(axis=(-1, -2)) * (b * b).sum(axis=(-1, -2)))
        return np.asarray((a * b).sum(axis=(-1, -2)) / scale)


def _pearson(x: Doubles, y: Doubles) -> Doubles:
    x, y = (values - values.mean(axis=-1, keepdims=True) for values in (x, y))
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray((x * y).sum(axis=-1) / np.sqrt((x * x).sum(axis=-1) * (y * y).sum(axis=-1)))


STATISTICS: dict[Statistic, Callable[[Doubles, Doubles], Doubles]] = {
    "spearman": spearman,
    "kendall": kendall,
}


def rank_correlation(kind: Statistic, x: Doubles, y: Doubles, replicas: Doubles) -> RankCorrelation | None:
    """Correlate the orders of n rigs by x (n,) and y (n,); replicas (r, n) of y as it may have come out as well.

    The interval draws rigs with replacement, with a replica of y each time. None below FEWEST_RIGS or where one of the
    two is the same for all rigs.
    """
    value = float(STATISTICS[kind](x, y)) if len(x) >= FEWEST_RIGS else float("nan")
    if not np.isfinite(value):
        return None
    low, high = np.nanquantile(drawn(kind, x, y, replicas), SPREAD)
    p, exact = permutation_p(kind, x, y)
    return RankCorrelation(value, float(low), float(high), p, exact)


def drawn(kind: Statistic, x: Doubles, y: Doubles, replicas: Doubles) -> Doubles:
    """Return the correlation on rigs drawn with replacement, (r,), the same draws for every x: differences are
    paired."""
    places = np.random.default_rng(0).integers(0, len(y), replicas.shape)
    return STATISTICS[kind](x[places], np.take_along_axis(replicas, places, axis=1))


def permutation_p(kind: Statistic, x: Doubles, y: Doubles) -> tuple[float, bool]:
    """Return the chance that a random order agrees with x as far as y does, in one direction or the other; and whether
    it is exact."""
    n, exact = len(x), len(x) <= EXACT_TO
    if exact:
        orders = np.array(list(permutations(range(n))))
    else:
        orders = np.random.default_rng(0).permuted(np.tile(np.arange(n), (DRAWN_PERMUTATIONS, 1)), axis=1)
    found = abs(float(STATISTICS[kind](x, y))) - 1e-12
    at_once = 2000
    far = sum(
        int((np.abs(STATISTICS[kind](x, y[orders[start : start + at_once]])) >= found).sum())
        for start in range(0, len(orders), at_once)
    )
    return (far / len(orders), True) if exact else ((1 + far) / (1 + len(orders)), False)
