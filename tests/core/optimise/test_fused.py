"""Chances that LiDARs and other sensors make together: worth what the engine says, with bounds that hold."""

from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from riglens.core.optimise.additions import Additions
from riglens.core.optimise.bounds import bounded
from riglens.core.optimise.fused import FusedTable, Hits
from riglens.core.optimise.guard import ObjectSampler
from riglens.core.optimise.makers import FusedMaker, maker_of
from riglens.core.optimise.objectives import objective_named, objectives
from riglens.core.optimise.problem import Problem
from riglens.core.optimise.search import greedy, search
from riglens.core.optimise.tables import UNIT
from riglens.core.optimise.weights import Weights
from riglens.core.rig.model import Rig
from tests.core.optimise.problems import random_limits
from tests.core.targets.cases import random_traffic, rig_of_every_kind

CHANCES = [key for key, goal in objectives().items() if goal.tables == "chances"]
ROUNDING = 1e-8 * UNIT


def test_leading_figures_of_objects_have_tables() -> None:
    assert {"predicted", "share_5", "seen_by_cameras", "missed", "found", "radar"} <= set(CHANCES)
    assert objective_named("both").tables == "none"


@pytest.mark.parametrize("name", CHANCES)
@pytest.mark.parametrize("seed", range(3))
def test_a_table_is_worth_what_the_engine_says(name: str, seed: int) -> None:
    rng = np.random.default_rng(seed)
    rig = rig_of_every_kind(rng, 6).replace(self_occlusion=bool(seed % 2))
    weights = Weights({"pedestrian": 2.0}, {(0.0, 20.0): 3.0})
    model = {"seen_by_cameras": "nuscenes-front", "radar": "generic-corner-radar"}.get(name, "generic-16")
    model = "generic-ultrasonic" if name == "ultrasonic" else model
    problem = Problem(
        rig, random_traffic(rng, 30), Additions((model,)), name, frames=6, weights=weights, held_out=8
    )
    maker, goal = maker_of(problem, (), ObjectSampler(problem.traffic, 1), 1), problem.goal
    assert isinstance(maker, FusedMaker)
    sensors = goal.sensors_of(rig)
    base, rest = sensors[:1], sensors[1:]
    table = maker.table(maker.cells_of(base), [maker.cells_of([one]) for one in rest])
    sampler = ObjectSampler(problem.traffic, 1, goal, weights)
    chosen: list[int] = []
    for one in (None, *rng.permutation(len(rest)).tolist()):
        before, gains = table.value(chosen), table.gains(chosen, np.arange(len(rest)))
        if one is not None:
            chosen.append(one)
            assert table.value(chosen) == before + gains[one]
        alone = Rig(
            vehicle=rig.vehicle,
            self_occlusion=rig.self_occlusion,
            sensors=(*base, *(rest[n] for n in chosen)),
        )
        value = sampler(alone, problem.settings, (0, 6)).value
        assert maker.shown(table.value(chosen)) == pytest.approx(value, abs=1e-9)
    joined = maker.joined([maker.cells_of([one]) for one in sensors])
    assert maker.table(joined, []).value([]) == table.value(chosen)
    free = maker.table(maker.joined([]), [maker.cells_of([one]) for one in rest])
    assert (maker.gains_next_to(free, maker.cells_of(base)) == table.gains([], np.arange(len(rest)))).all()


def random_fused(rng: np.random.Generator, size: int, is_concave: bool) -> FusedTable:
    """Candidates of LiDARs, cameras or both that hit some of few objects; points or cells."""
    objects, most = int(rng.integers(1, 25)), int(rng.integers(2, 12))
    steps = rng.random((3, most)) * (rng.random((3, most)) < 0.7)
    steps = np.sort(steps, axis=1)[:, ::-1] if is_concave else steps
    curve = np.concatenate([np.zeros((3, 1)), np.cumsum(steps, axis=1)], axis=1)
    curve /= np.maximum(curve[:, -1:], 1.0)
    owner = np.repeat(np.arange(objects), 9).astype(np.int32)
    has_cells, kinds = rng.random() < 0.5, rng.choice(["both", "lidars", "cameras"])

    def hits(share: float) -> Hits:
        is_lidar = kinds == "lidars" or (kinds == "both" and rng.random() < 0.5)
        met, nothing = rng.random(objects) < share, np.zeros(objects, np.int32)
        if not is_lidar:
            return Hits(nothing[:0], nothing, np.round(rng.random(objects), 1) * met)
        if has_cells:
            return Hits(
                np.flatnonzero(rng.random(len(owner)) < share).astype(np.int32), nothing, 0.0 * nothing
            )
        return Hits(nothing[:0], (rng.integers(0, 9, objects) * met).astype(np.int32), 0.0 * nothing)

    base = hits(0.2 * float(rng.random()))
    row = rng.integers(0, 3, objects).astype(np.uint8)
    weight = UNIT * rng.dirichlet(np.ones(objects))
    candidates = [hits(0.8 * float(rng.random())) for _ in range(size)]
    return FusedTable(base, candidates, lambda cells: owner[cells], curve, row, weight, 1)


def against_brute_force(seed: int, size: int, count: int) -> None:
    """Check that no set beats what is proven or exceeds the bound, and what stands above."""
    rng = np.random.default_rng(seed)
    table = random_fused(rng, size, bool(rng.random() < 0.5))
    limits, above = random_limits(rng, size, count), table.above()
    assert above is not None
    sets = [
        list(chosen)
        for number in range(limits.count + 1)
        for chosen in combinations(range(size), number)
        if limits.allow(chosen)
    ]
    for chosen in sets[:: max(1, len(sets) // 40)]:
        assert above.value(chosen) >= table.value(chosen)
    best, start = max(map(table.value, sets)), search(table, limits)
    assert table.value(greedy(table, limits)) <= table.value(start) <= best
    found, bound = bounded(table, table, limits, start, [(above, limits)])
    assert bound is not None and limits.allow(found)
    assert table.is_submodular == (bound.kind == "proven")
    assert bound.value >= best - ROUNDING
    assert table.value(found) <= best
    if bound.kind == "proven":
        assert table.value(found) >= best - ROUNDING


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 1 << 32), st.integers(2, 9), st.integers(1, 4))
def test_no_set_beats_the_bound_of_chances(seed: int, size: int, count: int) -> None:
    against_brute_force(seed, size, count)


@pytest.mark.slow
@settings(max_examples=150, deadline=None)
@given(st.integers(0, 1 << 32), st.integers(2, 14), st.integers(1, 4))
def test_no_set_of_up_to_14_candidates_beats_the_bound_of_chances(seed: int, size: int, count: int) -> None:
    against_brute_force(seed, size, count)


@pytest.mark.parametrize("seed", range(8))
def test_gains_of_concave_chances_shrink_as_sets_grow(seed: int) -> None:
    rng = np.random.default_rng(seed)
    table, ids = random_fused(rng, 10, True), np.arange(10)
    assert table.is_submodular
    chosen: list[int] = []
    before = table.gains(chosen, ids)
    for one in rng.permutation(10)[:6].tolist():
        chosen.append(one)
        gains = table.gains(chosen, ids)
        assert (gains >= 0).all() and (gains <= before + ROUNDING).all()
        before = gains
