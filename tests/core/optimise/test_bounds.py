"""Search and bounds against brute force over all allowed sets of few candidates."""

from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from riglens.core.optimise.bounds import branch_and_bound, fractional_bound
from riglens.core.optimise.search import AtLeast, Limits, front, greedy, search, swap
from riglens.core.optimise.tables import UNIT, CoverTable
from tests.core.optimise.problems import hit_worth, random_columns, random_limits, random_table


def best_of_all(table: CoverTable, limits: Limits) -> int:
    """The largest value of any allowed set."""
    sets = (
        chosen
        for count in range(limits.count + 1)
        for chosen in combinations(range(table.size), count)
        if limits.allow(chosen)
    )
    return max(table.value(chosen) for chosen in sets)


def against_brute_force(seed: int, size: int, count: int) -> None:
    """Check search, both bounds, and that limits are kept, on one random problem."""
    rng = np.random.default_rng(seed)
    table, limits = random_table(rng, size), random_limits(rng, size, count)
    best, found = best_of_all(table, limits), search(table, limits)
    assert limits.allow(found)
    assert table.value(found) <= best
    assert fractional_bound(table, limits, found, cuts=8) >= best
    proven, is_proven = branch_and_bound(table, limits, found)
    assert is_proven
    assert limits.allow(proven)
    assert table.value(proven) == best


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 1 << 32), st.integers(2, 9), st.integers(1, 4))
def test_no_set_beats_the_bound_and_branch_and_bound_finds_the_best(seed: int, size: int, count: int) -> None:
    against_brute_force(seed, size, count)


@pytest.mark.slow
@settings(max_examples=300, deadline=None)
@given(st.integers(0, 1 << 32), st.integers(2, 16), st.integers(1, 4))
def test_no_set_of_up_to_16_candidates_beats_the_bounds(seed: int, size: int, count: int) -> None:
    against_brute_force(seed, size, count)


@settings(max_examples=10, deadline=None)
@given(st.integers(0, 1 << 32), st.integers(2, 9), st.integers(1, 3))
def test_bounds_of_a_figure_that_is_not_submodular_hold(seed: int, size: int, count: int) -> None:
    """Its least concave function above is one for the bound."""
    rng = np.random.default_rng(seed)
    table, limits = random_table(rng, size), random_limits(rng, size, count)
    rise = np.sort(rng.integers(0, UNIT >> 6, table.cover.worth.shape), axis=1)
    jumps = table.valued(
        np.where(rng.random(rise.shape) < 0.5, rise, np.maximum.accumulate(rise // 3, axis=1))
    )
    worth = np.maximum.accumulate(jumps.cover.worth, axis=1)
    jumps, above = table.valued(worth), table.valued(worth).above()
    assert (np.diff(above.cover.worth, n=2, axis=1) <= 0).all()
    assert (above.cover.worth >= worth).all()
    best = best_of_all(jumps, limits)
    assert fractional_bound(above, limits, [], cuts=6) >= best
    chosen = branch_and_bound(above, limits, [])[0]
    assert above.value(chosen) >= best


def test_overlaps_on_groups_of_objects_prove_mounts_that_see_different_sides() -> None:
    """Mounts around a car hit what stands on their side of it. Overlaps on all objects together leave more than 6,000
    of the 9,880 sets to be tried."""
    rng, size, things = np.random.default_rng(2), 40, 400
    at, of = rng.random(size), rng.random(things)
    apart = np.abs((at[:, None] - of + 0.5) % 1.0 - 0.5)
    owner = np.repeat(np.arange(things), 12).astype(np.int32)
    hit = rng.random((size, len(owner))) < 0.7 * np.exp(-apart * 6.0)[:, owner]
    cells, cls = (
        [np.flatnonzero(one).astype(np.int32) for one in hit],
        rng.integers(0, 3, things).astype(np.uint8),
    )
    table = CoverTable(cells, owner, np.zeros(things, np.int32), cls, hit_worth(cls), 1)
    limits = Limits(3, np.ones(size), np.inf, np.eye(size, dtype=np.bool_))
    best = max(
        table.value(pair) + int(table.gains(pair, np.arange(size)).max())
        for pair in combinations(range(size), 2)
    )
    found, is_proven = branch_and_bound(table, limits, search(table, limits), most_gains=500)
    assert is_proven
    assert table.value(found) == best


def test_branch_and_bound_says_when_it_gives_up() -> None:
    rng = np.random.default_rng(1)
    table = random_table(rng, 16)
    limits = Limits(4, np.ones(16), np.inf, np.eye(16, dtype=np.bool_))
    found, is_proven = branch_and_bound(table, limits, [0], most_gains=16)
    assert not is_proven
    assert table.value(found) >= table.value([0])


@pytest.mark.parametrize("seed", range(5))
def test_gains_are_differences_of_values_and_shrink_as_sets_grow(seed: int) -> None:
    rng = np.random.default_rng(seed)
    table, ids = random_table(rng, 10), np.arange(10)
    chosen: list[int] = []
    before = table.gains(chosen, ids)
    for one in rng.permutation(10)[:6].tolist():
        chosen.append(one)
        gains = table.gains(chosen, ids)
        assert (gains <= before).all() and (gains >= 0).all()
        assert [table.value([*chosen, c]) - table.value(chosen) for c in range(10) if c not in chosen] == [
            gains[c] for c in range(10) if c not in chosen
        ]
        before = gains
    assert table.value([]) == table.empty().value


def test_gains_do_not_depend_on_the_number_of_workers() -> None:
    one, two = (random_table(np.random.default_rng(7), 40, workers) for workers in (1, 2))
    gains = one.gains([3, 5], np.arange(40))
    assert (gains == two.gains([3, 5], np.arange(40))).all()
    assert (gains[:9] == one.gains([3, 5], np.arange(9))).all(), "few, by one thread"
    limits = Limits(4, np.ones(40), np.inf, np.eye(40, dtype=np.bool_))
    assert search(one, limits) == search(two, limits)
    assert fractional_bound(one, limits, [1]) == fractional_bound(two, limits, [1])


def test_ties_go_to_the_lower_number() -> None:
    cells = [np.arange(3, dtype=np.int32)] * 4
    one = np.zeros(1, np.uint8)
    table = CoverTable(cells, np.zeros(3, np.int32), np.zeros(1, np.int32), one, hit_worth(one), 1)
    assert greedy(table, Limits(2, np.ones(4), np.inf, np.eye(4, dtype=np.bool_))) == [0]


def test_an_exchange_leaves_the_trap_of_greedy_choice() -> None:
    """0 covers 4 cells; 1 and 2 cover 3 + 3, and more together than with 0."""
    cells = [np.array(c, np.int32) for c in ([0, 1, 3, 4], [0, 1, 2], [3, 4, 5])]
    worth = np.arange(7, dtype=np.int64)[None]
    table = CoverTable(cells, np.zeros(6, np.int32), np.zeros(1, np.int32), np.zeros(1, np.uint8), worth, 1)
    limits = Limits(2, np.ones(3), np.inf, np.eye(3, dtype=np.bool_))
    start = greedy(table, limits)
    assert start == [0, 1]
    assert table.value(start) == 5
    assert sorted(swap(table, limits, start)) == [1, 2]


def test_a_search_begins_at_what_is_there_as_well() -> None:
    """0 and 1 cover 9 cells, which greedy choice and exchanges do not leave; 2 and 3 cover all 10."""
    covered = ([0, 1, 2, 5, 6, 7], [3, 4, 8], [0, 1, 2, 3, 4], [5, 6, 7, 8, 9])
    cells, worth = [np.array(c, np.int32) for c in covered], np.arange(11, dtype=np.int64)[None]
    table = CoverTable(cells, np.zeros(10, np.int32), np.zeros(1, np.int32), np.zeros(1, np.uint8), worth, 1)
    limits = Limits(2, np.ones(4), np.inf, np.eye(4, dtype=np.bool_))
    assert search(table, limits) == [0, 1]
    assert search(table, limits, (2, 3)) == [2, 3]


def test_a_second_goal_comes_first_until_its_level() -> None:
    rng = np.random.default_rng(3)
    first, second = random_table(rng, 12), random_columns(rng, 12)
    limits = Limits(2, np.ones(12), np.inf, np.eye(12, dtype=np.bool_))
    most = max(second.value(chosen) for chosen in combinations(range(12), 2))
    strict = AtLeast(first, second, most)
    found = max(combinations(range(12), 2), key=strict.value)
    assert second.value(found) == most
    assert search(AtLeast(first, second, 0), limits) == search(first, limits)


def test_a_budget_does_not_buy_half_a_candidate() -> None:
    rng = np.random.default_rng(5)
    table = random_table(rng, 8)
    costs = np.array([1.0, 1.0, 1.0, 9.0, 9.0, 9.0, 9.0, 9.0])
    limits = Limits(2, costs, 2.0, np.eye(8, dtype=np.bool_))
    cheap = Limits(2, np.ones(3), 2.0, np.eye(3, dtype=np.bool_))
    bound = fractional_bound(table, limits, [0])
    assert bound >= best_of_all(table, limits)
    assert bound <= table.value([0, 1, 2])
    assert limits.open_to([]).tolist() == [True] * 3 + [False] * 5
    assert cheap.open_to([0]).tolist() == [False, True, True]


@pytest.mark.parametrize("seed", range(6))
def test_no_set_beats_a_point_of_the_front_of_single_candidates(seed: int) -> None:
    rng = np.random.default_rng(seed)
    first, second = random_table(rng, 14), random_columns(rng, 14)
    limits = Limits(1, np.ones(14), np.inf, np.eye(14, dtype=np.bool_))
    chosen = search(first, limits)
    found = [chosen, *front(first, second, limits, chosen, 6)]
    points = [(first.value(one), second.value(one)) for one in found]
    assert points == sorted(points, key=lambda point: (-point[0], point[1]))
    for one in range(14):
        a, b = first.value([one]), second.value([one])
        assert not any(a > x and b >= y for x, y in points)
    assert points[-1][1] == max(second.value([one]) for one in range(14))
