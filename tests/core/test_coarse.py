"""The coarser copy of a scene holds the same voxels at a step, and scores estimated on it meet the exact ones."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from riglens.core.metric.entropy import EntropyField
from riglens.core.metric.estimate import estimated
from riglens.core.metric.scores import MetricSettings, Scores
from riglens.core.scene.columns import unpack
from riglens.core.scene.pog import Pog, coarse_pog
from tests.core.builders import (
    camera,
    evaluate,
    grid_of,
    random_field,
    rig_of,
    spinning,
    synthetic_pog,
)

COVERED = MetricSettings()


def random_pog(shape: tuple[int, int, int], seed: int) -> Pog:
    rng = np.random.default_rng(seed)
    counts = rng.integers(1, 9, (*shape, 3)) * (rng.random((*shape, 3)) < 0.4)
    return synthetic_pog(grid_of(*shape, 0.5), counts, 9)


def dense_counts(pog: Pog) -> np.ndarray:
    dense = np.zeros((*pog.grid.shape, 3), np.int64)
    i, j, k = pog.index.ijk().T
    dense[i, j, k] = pog.counts
    return dense


@pytest.mark.parametrize(
    ("shape", "step"), [((6, 4, 70), 2), ((9, 3, 15), 3), ((6, 12, 6), 2), ((2, 2, 130), 2)]
)
def test_every_second_or_third_voxel_stands_for_its_block(shape, step) -> None:
    pog = random_pog(shape, 1)
    coarse = coarse_pog(pog)
    assert coarse is not None
    middle = step // 2
    assert coarse.grid.voxel_m == 0.5 * step
    assert coarse.grid.roi_m == pog.grid.roi_m
    assert np.array_equal(dense_counts(coarse), dense_counts(pog)[middle::step, middle::step, middle::step])
    assert np.array_equal(unpack(coarse.grid, coarse.index.words), dense_counts(coarse).any(axis=-1))


@pytest.mark.parametrize("shape", [(5, 4, 4), (4, 9, 6), (7, 7, 7)])
def test_a_grid_that_cannot_be_halved_or_cut_in_three_has_no_coarser_copy(shape) -> None:
    assert coarse_pog(random_pog(shape, 2)) is None


def test_an_empty_scene_stays_empty() -> None:
    grid = grid_of(4, 4, 4)
    coarse = coarse_pog(synthetic_pog(grid, np.zeros((4, 4, 4, 3), np.int64), 5))
    assert coarse is not None
    assert coarse.index.count == 0


FIELD = random_field(grid_of(20, 20, 8), np.random.default_rng(3))
SHIFT = st.floats(-2.0, 2.0)


def scores_at(x: float, field: EntropyField = FIELD, settings: MetricSettings = COVERED) -> Scores:
    rig = rig_of(spinning((x, 0.3, 4.0)), camera((-9.0, 0.2, 3.0)))
    return evaluate(field, rig, settings).scores


@settings(max_examples=20)
@given(SHIFT, SHIFT)
@pytest.mark.parametrize("reading", ["covered", "residual"])
def test_cameras_follow_the_coarse_answer_and_lidars_half_of_it(reading, known: float, now: float) -> None:
    settings = MetricSettings(reading=reading, camera_weight=0.3)
    exact, before = scores_at(now, settings=settings), scores_at(known, settings=settings)
    guess = estimated(scores_at(now), scores_at(known), scores_at(known), settings)
    assert guess is not None
    for name, found in exact.classes.items():
        shown, then = guess.classes[name], before.classes[name]
        assert shown.h_total == found.h_total
        assert shown.camera.seen == pytest.approx(found.camera.seen, rel=1e-12)
        assert shown.camera.s_mig == pytest.approx(found.camera.s_mig, rel=1e-9)
        assert shown.lidar.seen**2 == pytest.approx(found.lidar.seen * then.lidar.seen, rel=1e-9)
        assert shown.s_ms == pytest.approx(0.3 * shown.camera.s_mig + shown.lidar.s_mig, rel=1e-12)
        assert shown.any_seen == pytest.approx(max(found.any_seen, shown.lidar.seen), rel=1e-12)


def test_a_rig_that_is_known_is_estimated_as_it_is() -> None:
    known = scores_at(0.7)
    guess = estimated(known, known, known, COVERED)
    assert guess is not None
    for name, found in known.classes.items():
        shown = guess.classes[name]
        assert (shown.camera.seen, shown.lidar.seen) == (found.camera.seen, found.lidar.seen)
        assert (shown.any_seen, shown.s_ms) == (found.any_seen, pytest.approx(found.s_ms, rel=1e-12))


def test_shares_stay_shares_and_any_sensor_sees_at_least_what_each_kind_sees() -> None:
    little, much = scores_at(9.5), scores_at(0.0)
    guess = estimated(much, little, much, COVERED)
    assert guess is not None
    for found in guess.classes.values():
        assert max(found.camera.seen, found.lidar.seen) <= found.any_seen <= 1.0


def test_there_is_no_estimate_without_anything_to_compare_with() -> None:
    blind = evaluate(FIELD, rig_of(camera((-9.0, 0.2, 3.0)))).scores
    assert estimated(scores_at(0.0), blind, blind, COVERED) is None


def test_a_rig_that_stays_blind_is_estimated_as_blind() -> None:
    blind = evaluate(FIELD, rig_of()).scores
    guess = estimated(blind, blind, blind, COVERED)
    assert guess is not None
    assert all(found.s_ms == 0.0 and found.any_seen == 0.0 for found in guess.classes.values())


def test_hits_are_not_estimated() -> None:
    one = scores_at(0.0)
    assert estimated(one, one, one, MetricSettings(reading="hits")) is None
