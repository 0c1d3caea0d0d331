"""Rank correlations by closed forms, by scipy, and by trying every permutation."""

from __future__ import annotations

from itertools import permutations

import numpy as np
import pytest
from scipy.stats import kendalltau, spearmanr

from riglens.core.study.ranks import (
    DRAWN_PERMUTATIONS,
    drawn,
    kendall,
    permutation_p,
    rank_correlation,
    spearman,
)


def columns(seed: int, n: int, ties: bool) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    x, y = rng.normal(size=(2, n))
    return (np.round(x), np.round(y)) if ties else (x, y)


@pytest.mark.parametrize("ties", [False, True])
@pytest.mark.parametrize("seed", range(8))
def test_coefficients_are_those_of_scipy(seed: int, ties: bool) -> None:
    x, y = columns(seed, 12, ties)
    assert float(spearman(x, y)) == pytest.approx(spearmanr(x, y).statistic, abs=1e-12)
    assert float(kendall(x, y)) == pytest.approx(kendalltau(x, y).statistic, abs=1e-12)


def test_closed_forms_on_five() -> None:
    x, y = np.arange(5.0), np.array([0.0, 1.0, 2.0, 4.0, 3.0])
    assert float(spearman(x, y)) == pytest.approx(1 - 6 * 2 / (5 * 24))
    assert float(kendall(x, y)) == pytest.approx((9 - 1) / 10)


@pytest.mark.parametrize("kind", ["spearman", "kendall"])
def test_p_is_the_share_of_all_permutations(kind: str) -> None:
    x, y = columns(3, 6, ties=False)
    of = {"spearman": lambda b: spearmanr(x, b).statistic, "kendall": lambda b: kendalltau(x, b).statistic}[
        kind
    ]
    as_far = [abs(of(np.array(order))) >= abs(of(y)) - 1e-12 for order in permutations(y)]
    assert permutation_p(kind, x, y) == (sum(as_far) / 720, True)  # type: ignore[arg-type]


def test_perfect_order_of_five_is_two_of_all_orders() -> None:
    x = np.arange(5.0)
    assert permutation_p("spearman", x, x * 3) == (2 / 120, True)


def test_drawn_permutations_are_near_the_exact_ones() -> None:
    x, y = columns(5, 9, ties=False)
    p, exact = permutation_p("spearman", x, y)
    assert not exact
    true = spearmanr(x, y, alternative="two-sided").statistic
    orders = np.array(list(permutations(range(9))))
    wanted = np.mean(np.abs(spearman(x, y[orders])) >= abs(true) - 1e-12)
    assert p == pytest.approx(wanted, abs=4 * np.sqrt(wanted / DRAWN_PERMUTATIONS))


def test_nothing_is_said_about_four_rigs_or_a_constant() -> None:
    four, five = np.arange(4.0), np.arange(5.0)
    assert rank_correlation("spearman", four, four, np.tile(four, (10, 1))) is None
    assert rank_correlation("spearman", five, np.ones(5), np.ones((10, 5))) is None


def test_the_interval_holds_the_value_and_widens_with_what_may_have_been() -> None:
    rng = np.random.default_rng(0)
    x = np.arange(20.0)
    y = x + rng.normal(0, 3, 20)
    still = rank_correlation("spearman", x, y, np.tile(y, (800, 1)))
    moved = rank_correlation("spearman", x, y, y + rng.normal(0, 8, (800, 20)))
    assert still is not None and moved is not None
    assert still.low < still.value < still.high <= 1.0
    assert moved.low < still.low
    assert not still.exact and still.p == pytest.approx(1 / (1 + DRAWN_PERMUTATIONS))


def test_draws_are_the_same_for_every_figure() -> None:
    y = np.arange(10.0)
    replicas = np.tile(y, (50, 1))
    assert (drawn("kendall", y, y, replicas) == drawn("kendall", 2 * y, y, replicas)).all()
    assert np.nanmin(drawn("kendall", y, y, replicas)) == pytest.approx(1.0)
