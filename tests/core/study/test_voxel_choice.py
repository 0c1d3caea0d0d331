"""The voxel edge that is picked is the coarsest at which the scores of the rigs stay what they are."""

import psutil
import pytest
from hypothesis import given
from hypothesis import strategies as st

from riglens.core.errors import InputError
from riglens.core.metric.scores import ClassScores, KindScore, Scores
from riglens.core.scene.boxes import CLASSES
from riglens.core.study.voxel_choice import LADDER_M, EdgeScores, Swap, choose, ladder_grids

FINE, MIDDLE, COARSE = 0.05, 0.1, 0.2
SHARES = st.floats(0.0, 1.0)


def scores(camera: float = 0.5, lidar: float = 0.2, seen: float = 0.6, s_ms: float = -1.0) -> Scores:
    one = ClassScores(
        100.0, {"camera": KindScore(-camera, camera), "lidar": KindScore(-lidar, lidar)}, seen, s_ms
    )
    return Scores(dict.fromkeys(CLASSES, one), {})


def tried(voxel_m: float, *rigs: Scores) -> EdgeScores:
    return EdgeScores(voxel_m, tuple((f"rig {i}", one) for i, one in enumerate(rigs)))


@st.composite
def attempts(draw: st.DrawFn) -> list[EdgeScores]:
    """Some edges with the scores of as many rigs each, seen near enough to agree now and then."""
    edges = draw(st.lists(st.sampled_from(LADDER_M), min_size=1, unique=True))
    rigs = draw(st.integers(0, 3))
    near = st.floats(0.5, 0.53)
    one = st.builds(scores, near, near, near, st.sampled_from([-3.0, -2.0, -1.0]))
    return [tried(edge, *draw(st.lists(one, min_size=rigs, max_size=rigs))) for edge in edges]


def allowed(one: EdgeScores, finest: EdgeScores, tolerance: float) -> bool:
    """The rule said another way: every share near, and the same pairs below each other."""
    for cls in CLASSES:
        here = [rig.classes[cls] for _, rig in one.scores]
        there = [rig.classes[cls] for _, rig in finest.scores]
        for a, b in zip(here, there, strict=True):
            shares = ((a.camera.seen, b.camera.seen), (a.lidar.seen, b.lidar.seen), (a.any_seen, b.any_seen))
            if any(abs(x - y) > tolerance for x, y in shares):
                return False
        below = [[a.s_ms < b.s_ms for b in rigs for a in rigs] for rigs in (here, there)]
        if below[0] != below[1]:
            return False
    return True


@given(attempts(), st.floats(0.0, 0.05))
def test_the_picked_edge_and_all_finer_ones_agree_and_the_next_coarser_does_not(
    found: list[EdgeScores], tolerance: float
) -> None:
    by_edge = sorted(found, key=lambda one: one.voxel_m)
    place = [one.voxel_m for one in by_edge].index(choose(found, tolerance).voxel_m)
    assert all(allowed(one, by_edge[0], tolerance) for one in by_edge[: place + 1])
    assert place + 1 == len(by_edge) or not allowed(by_edge[place + 1], by_edge[0], tolerance)


@given(attempts(), st.floats(0.0, 0.05), st.floats(0.0, 0.05))
def test_more_tolerance_never_picks_a_finer_edge(found: list[EdgeScores], one: float, other: float) -> None:
    low, high = sorted((one, other))
    assert choose(found, low).voxel_m <= choose(found, high).voxel_m


@given(attempts(), st.floats(0.0, 0.05), st.randoms(use_true_random=False))
def test_the_choice_does_not_depend_on_the_order_of_trying(found, tolerance, random) -> None:
    shuffled = list(found)
    random.shuffle(shuffled)
    assert choose(shuffled, tolerance) == choose(found, tolerance)


@given(SHARES, SHARES, SHARES)
def test_equal_scores_pick_the_coarsest_even_without_tolerance(camera, lidar, seen) -> None:
    same = scores(camera, lidar, seen)
    assert choose([tried(edge, same) for edge in LADDER_M], 0.0).voxel_m == max(LADDER_M)


@pytest.mark.parametrize("changed", [scores(camera=0.52), scores(lidar=0.22), scores(seen=0.62)])
def test_cameras_lidars_and_all_together_count_each_for_itself(changed: Scores) -> None:
    found = [tried(FINE, scores()), tried(COARSE, changed)]
    assert choose(found, 0.01).voxel_m == FINE
    assert choose(found, 0.021).voxel_m == COARSE


def test_an_edge_that_agrees_by_chance_beyond_one_that_does_not_is_not_picked() -> None:
    found = [tried(FINE, scores()), tried(MIDDLE, scores(lidar=0.5)), tried(COARSE, scores())]
    assert choose(found, 0.01).voxel_m == FINE


def test_two_rigs_that_change_places_forbid_an_edge_whatever_the_tolerance() -> None:
    found = [
        tried(FINE, scores(s_ms=-2.0), scores(s_ms=-1.0)),
        tried(COARSE, scores(s_ms=-1.0), scores(s_ms=-2.0)),
    ]
    choice = choose(found, 1.0)
    assert choice.voxel_m == FINE
    assert choice.edges[1].swap == Swap("rig 0", "rig 1", "car")


def test_nats_that_grow_with_the_number_of_voxels_are_no_difference() -> None:
    found = [
        tried(FINE, scores(s_ms=-8000.0), scores(s_ms=-4000.0)),
        tried(COARSE, scores(s_ms=-1000.0), scores(s_ms=-500.0)),
    ]
    assert choose(found, 0.0).voxel_m == COARSE


def test_edges_that_do_not_divide_the_region_are_left_out() -> None:
    grids, left_out = ladder_grids((20.2, 20.0, 4.0))
    assert [grid.voxel_m for grid in grids] == [0.05, 0.1, 0.2]
    assert [edge for edge, _ in left_out] == [0.4]


def test_edges_that_do_not_fit_in_memory_are_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    class Memory:
        available = 100e6

    monkeypatch.setattr(psutil, "virtual_memory", Memory)
    grids, left_out = ladder_grids((60.0, 40.0, 4.0))
    assert [grid.voxel_m for grid in grids] == [0.2, 0.4]
    assert all("GB" in reason for _, reason in left_out)


def test_a_region_that_no_edge_divides_is_refused_with_what_to_do() -> None:
    with pytest.raises(InputError, match=r"none of the edges .* give one in metres"):
        ladder_grids((20.03, 20.0, 4.0))
