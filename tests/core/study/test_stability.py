"""The stability study: its judge, its cases, resampled frames, orders of rigs."""

from dataclasses import replace

import numpy as np
import pytest

from riglens.core.engine.engine import Engine
from riglens.core.metric.scores import MetricSettings
from riglens.core.rig.presets import PAPER_RIGS, preset
from riglens.core.scene.boxes import CLASSES
from riglens.core.scene.pog import build_pog
from riglens.core.study import reference, stability_edits
from riglens.core.study.reference import exact_cover
from riglens.core.study.stability_cases import RayCase, lidar, whole_slopes
from riglens.core.study.stability_edits import random_edits
from riglens.core.study.stability_methods import (
    compared,
    entropy_nat,
    extreme_probabilities,
    identical_sensors,
    judged,
    mirrored,
    mirrored_twin,
    no_sensors,
    one_frame,
    refused_grid,
)
from riglens.core.study.stability_metric import (
    MetricStudy,
    RayLattice,
    ResampledFrames,
    StoredBoxes,
    agreement,
    rank,
    study_metric,
    swapped,
)
from tests.core import oracle
from tests.core.builders import evaluate, field_of, grid_of, random_field, random_sensor
from tests.core.study.small_studies import BOXES, HAND, PLAN, SCENE, judged_cases, ranking, small_metric_study

GRID = grid_of(12, 9, 7, 0.1)


# ---------------------------------------------------------------- the judge


@pytest.mark.parametrize("seed", range(25))
def test_the_judge_agrees_with_an_independent_oracle_on_random_sensors(seed):
    sensor = random_sensor(GRID, np.random.default_rng(seed), 20)
    assert np.array_equal(exact_cover(GRID, [sensor]), oracle.exact_cover(GRID, [sensor]))


@pytest.mark.parametrize(
    "sensor",
    [
        lidar((0.0, 0.3, 0.3), (0.0, 45.0, 90.0), tuple(range(-180, 180, 45))),
        lidar((1e-310, 0.05, 0.0), (0.0, 5e-324), (0.0, 90.0, 180.0), (0.0, 0.0, 1e-310)),
        whole_slopes((-0.3, 0.1, 0.4), side=4),
        lidar((0.05, 0.05, 0.35), azimuths_deg=(0.0, 45.0, 180.0)).replace(range_m=(0.1, 0.3)),
        lidar((-1e6, 0.05, 0.31), (0.0, 1e-6), (0.0, 1e-6, -1e-6)),
    ],
)
def test_the_judge_agrees_with_an_independent_oracle_on_awkward_sensors(sensor):
    assert np.array_equal(exact_cover(GRID, [sensor]), oracle.exact_cover(GRID, [sensor]))


def test_the_judge_turns_to_rational_numbers_only_where_doubles_do_not_decide(monkeypatch):
    redone = []
    monkeypatch.setattr(reference, "_mark_rational", lambda *arguments: redone.append(arguments))
    exact_cover(grid_of(12, 10, 8), [lidar((0.31, 0.17, 3.57), (1.3, -7.7), tuple(range(3, 360, 7)))])
    assert not redone
    exact_cover(grid_of(12, 10, 8), [whole_slopes((0.0, 0.0, 4.0))])
    assert len(redone) == 4


# ---------------------------------------------------------------- methods


@pytest.fixture(scope="module")
def rows():
    return judged_cases()


def test_the_engine_is_right_in_every_case(rows):
    assert len(rows) >= 20
    assert {name for name, row in rows.items() if row.outcomes["fast"].verdict != "ok"} == set()


def test_the_table_says_where_simple_methods_fail(rows):
    corners = rows["rays through corners"].outcomes
    assert corners["plain"].extra > 0 == corners["plain"].missed
    assert corners["plain"].verdict == corners["bresenham"].verdict == "fails"
    assert rows["origin 1,000,000 m away"].outcomes["plain"].verdict == "fails"
    assert rows["tilted sensors"].outcomes["bresenham"].missed > 0
    assert rows["axis-parallel rays"].outcomes["bresenham"].verdict == "ok"


def test_every_case_has_rays_in_its_grid(rows):
    assert all(int(row.exact.split()[0].replace(",", "")) > 0 for row in rows.values())


def test_missed_and_extra_voxels_are_counted_apart():
    exact, found = np.array([True, True, True, False, False]), np.array([True, False, False, True, False])
    outcome = compared(found, exact)
    assert (outcome.verdict, outcome.missed, outcome.extra, outcome.voxels) == ("fails", 2, 1, 2)
    assert compared(exact, exact).verdict == "ok"


@pytest.mark.parametrize(
    "check",
    [
        refused_grid,
        extreme_probabilities,
        one_frame,
        lambda: no_sensors(1),
        lambda: identical_sensors(1),
        lambda: mirrored_twin(1),
        lambda: random_edits(60),
    ],
)
def test_the_engine_passes_every_check(check):
    assert check().outcomes["fast"].verdict == "ok"


def test_entropies_have_more_digits_than_doubles():
    assert float(entropy_nat(1, 2)) == pytest.approx(np.log(2.0), rel=1e-15)
    assert float(entropy_nat(3, 10)) == pytest.approx(-0.3 * np.log(0.3) - 0.7 * np.log(0.7), rel=1e-14)
    assert entropy_nat(5, 5) == entropy_nat(0, 5) == 0


def test_a_mirrored_sensor_casts_mirrored_rays():
    for sensor in (random_sensor(GRID, np.random.default_rng(seed), 12) for seed in range(8)):
        rays, image = oracle.vehicle_directions(sensor), oracle.vehicle_directions(mirrored(sensor))
        flipped = rays * [1.0, -1.0, 1.0]
        nearest = np.abs(flipped[:, None] - image[None]).max(axis=2).min(axis=1)
        assert nearest.max() < 1e-12


class Forgetful(Engine):
    """An engine that keeps its answer when a rig loses a sensor."""

    last = None

    def evaluate(self, rig, *arguments, **keywords):
        if self.last is None or len(rig.sensors) >= len(self.last.rig.sensors):
            self.last = super().evaluate(rig, *arguments, **keywords)
        return self.last


def test_random_edits_find_an_engine_that_forgets_to_remove(monkeypatch):
    monkeypatch.setattr(stability_edits, "Engine", Forgetful)
    assert random_edits(60).outcomes["fast"].verdict == "fails"


# ---------------------------------------------------------------- frames


def occupied_frames(source, times):
    """Counts of a POG in which every frame counts as often as it was drawn."""
    counts = np.zeros((*SCENE.shape, 3), np.int64)
    for frame, count in enumerate(times):
        rows = source.frame == frame
        if rows.any() and count:
            alone = replace(
                source,
                frame=np.zeros(rows.sum(), np.int64),
                cls=source.cls[rows],
                centre_m=source.centre_m[rows],
                size_m=source.size_m[rows],
                rotation=source.rotation[rows],
            )
            counts += count * dense_counts(build_pog(alone, SCENE))
    return counts


def dense_counts(pog):
    counts = np.zeros((*SCENE.shape, 3), np.int64)
    i, j, k = pog.index.ijk().T
    counts[i, j, k] = pog.counts
    return counts


@pytest.mark.parametrize("split", [(), (1,), (1, 3)])
def test_a_frame_counts_as_often_as_it_was_drawn(split):
    stored = StoredBoxes.read(replace(BOXES, split=split))
    drawn = ResampledFrames(stored, 3)
    assert drawn.times.sum() == BOXES.frames and drawn.times.max() > 1
    pog = build_pog(drawn, SCENE)
    assert pog.data.frames == BOXES.frames
    assert np.array_equal(dense_counts(pog), occupied_frames(BOXES, drawn.times))


def test_the_report_of_a_draw_counts_its_boxes():
    drawn = ResampledFrames(StoredBoxes.read(BOXES), 5)
    boxes = sum(len(batch.cls) for batch in drawn.batches())
    assert sum(drawn.report().boxes.values()) == boxes
    assert drawn.report().boxes["bicycle"] == drawn.times[0]


def test_draws_depend_on_their_seed_alone():
    stored = StoredBoxes.read(BOXES)
    draws = [ResampledFrames(stored, seed).times.tolist() for seed in (1, 1, 2, 3)]
    assert draws[0] == draws[1]
    assert len({tuple(draw) for draw in draws}) > 1
    assert ResampledFrames(stored, 1).content_hash != ResampledFrames(stored, 2).content_hash


# ---------------------------------------------------------------- orders


def test_orders_put_the_lowest_first():
    found = ranking(**HAND)
    assert found.order("lidars", "car") == ("C", "P", "L", "T")
    assert found.order("cameras", "car") == ("N", "W")
    assert found.order("rigs", "car")[:3] == ("N+C", "W+C", "N+P")
    assert found.s_ms["W+T"]["car"] == pytest.approx(-10.4)
    assert ranking().order("lidars", "car") == ()


def test_swapped_names_the_pairs_that_change_places():
    other = ranking(**{**HAND, "P": -45.0})
    assert swapped(other, ranking(**HAND), "lidars", "car") == [("C", "P")]
    assert swapped(other, other, "rigs", "car") == []


def test_rank_correlation_is_one_with_itself_and_minus_one_reversed():
    found = ranking(**HAND)
    back = ranking(**{name: -value for name, value in HAND.items()})
    assert agreement(found, found, "car") == pytest.approx(agreement(found, found, "bicycle"))
    assert agreement(found, found, "car").tau == pytest.approx(1.0)
    assert agreement(back, found, "car").rho == pytest.approx(-1.0)
    assert agreement(found, ranking(), "car").tau is None


def test_scores_from_groups_are_those_of_the_rigs():
    field = random_field(SCENE, np.random.default_rng(2), share=0.1)
    found = rank(field, camera_weight=0.3, threads=1)
    for name in PAPER_RIGS:
        scores = evaluate(field, preset(name), MetricSettings(camera_weight=0.3), threads=1).scores
        assert found.s_ms[name] == {cls: scores.classes[cls].s_ms for cls in CLASSES}


def test_a_ray_lattice_changes_rays_and_nothing_else():
    rig = preset("W+T")
    changed = RayLattice((16, 9), 90).applied(rig)
    assert {camera.cast for camera in changed.enabled_cameras()} == {(16, 9)}
    assert {len(lidar.azimuths()) for lidar in changed.enabled_lidars()} == {90}
    assert [sensor.pose for sensor in changed.sensors] == [sensor.pose for sensor in rig.sensors]
    assert RayLattice().applied(rig) == rig


# ---------------------------------------------------------------- the metric


@pytest.fixture(scope="module")
def metric() -> MetricStudy:
    return small_metric_study()


def test_every_setting_is_ranked_and_a_grid_that_cannot_be_had_is_left_out(metric):
    assert [variation.value for variation in metric.along("δ")] == [1.0]
    assert set(metric.h_total) == {0.5, 1.0}
    assert len(metric.along("rays")) == 2 and len(metric.along("reading")) == 2
    assert [drawn.value for drawn in metric.along("frames")] == [1, 2, 3]
    assert len({repr(drawn.ranking.s_mig) for drawn in metric.along("frames")}) > 1


def test_the_reading_residual_turns_the_order_round(metric):
    residual = next(v for v in metric.along("reading") if v.value == "residual")
    assert agreement(residual.ranking, metric.reference, "car").tau == pytest.approx(-1.0)


def test_progress_ends_at_one():
    said = []
    field = field_of(grid_of(6, 6, 4))
    study_metric(field, lambda *_: None, None, replace(PLAN, threads=1), said.append)
    assert said == sorted(said) and said[-1] == 1.0


def test_a_case_of_ones_own_can_be_judged():
    case = RayCase("own", "why", grid_of(4, 4, 2), (lidar((-1.9, 0.5, 0.5)),))
    row = judged(case, 1)
    assert (row.exact, row.rays) == ("4 voxels", 1)
