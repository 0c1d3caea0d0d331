"""From counts to entropies and from sums to scores, with numbers that can be checked on paper."""

from __future__ import annotations

import math

import numpy as np
import pytest

from riglens.core.metric.entropy import QUANTA_PER_NAT, EntropyField, entropy_of_counts, nats
from riglens.core.metric.estimate import estimated
from riglens.core.metric.scores import ClassScores, KindScore, MetricSettings, Reading, Scores
from riglens.core.metric.scoring import score
from riglens.core.scene.boxes import CLASSES
from riglens.core.sensors.registry import kind_names
from tests.core.builders import grid_of, synthetic_pog

QUARTER = 0.25 * math.log(4.0) + 0.75 * math.log(4.0 / 3.0)
HALF = math.log(2.0)


def field() -> EntropyField:
    """Eight voxels and four frames. Cars are in 0, 1, 2, 3, 4 of them and in none elsewhere; a bicycle in one frame of
    the last voxel."""
    counts = np.zeros((2, 2, 2, 3), np.int64)
    counts.reshape(8, 3)[:5, 0] = [0, 1, 2, 3, 4]
    counts.reshape(8, 3)[7, 1] = 1
    return EntropyField.from_pog(synthetic_pog(grid_of(2, 2, 2), counts, 4))


def test_entropy_is_largest_where_a_class_is_half_of_the_time() -> None:
    h = entropy_of_counts(np.array([0, 1, 2, 3, 4]), 4)
    assert h.tolist() == pytest.approx([0.0, QUARTER, HALF, QUARTER, 0.0], rel=1e-15)


def test_entropies_are_whole_numbers_of_quanta() -> None:
    assert QUANTA_PER_NAT == 2**32
    assert nats(3 << 31) == 1.5
    assert field().entropies_q.max() == round(HALF * 2**32) == 2977044472


def test_voxels_that_are_never_or_always_occupied_are_not_informative() -> None:
    assert field().index.ijk().tolist() == [[0, 0, 1], [0, 1, 0], [0, 1, 1], [1, 1, 1]]


def test_totals_are_sums_over_the_voxels_of_a_class() -> None:
    made = field()
    assert made.h_total_nat(0) == pytest.approx(2.0 * QUARTER + HALF, abs=1e-9)
    assert made.h_total_nat(1) == pytest.approx(QUARTER, abs=1e-9)
    assert made.h_total_nat(2) == 0.0


def test_entropies_of_the_voxels_follow_their_order() -> None:
    assert field().entropy_nat(0).tolist() == pytest.approx([QUARTER, HALF, QUARTER, 0.0], abs=1e-9)
    assert field().entropy_nat(1).tolist() == pytest.approx([0.0, 0.0, 0.0, QUARTER], abs=1e-9)


def test_the_most_frequent_counts_have_the_first_code() -> None:
    counts = np.ones((1, 1, 5, 3), np.int64)
    counts[0, 0, 1:4] = 2
    made = EntropyField.from_pog(synthetic_pog(grid_of(1, 1, 5), counts, 4))
    assert made.codes().tolist() == [1, 0, 0, 0, 1]
    assert made.entropies_q[0, 0] == round(HALF * 2**32)


def sums(camera: float, lidar: float, both: float) -> np.ndarray:
    """Sums for cars in quanta, and 1, 2 and 3 voxels."""
    table = np.zeros((len(kind_names()) + 1, 4), np.int64)
    table[[0, 1, -1], 0] = np.array([lidar, camera, both]) * field().totals_q[0]
    table[[0, 1, -1], 3] = [2, 1, 3]
    return table


@pytest.mark.parametrize(("reading", "camera", "lidar"), [("covered", 0.25, 0.5), ("residual", 0.75, 0.5)])
def test_s_mig_is_minus_the_entropy_seen_or_left(reading: Reading, camera: float, lidar: float) -> None:
    found = score(field(), sums(0.25, 0.5, 0.625), MetricSettings(reading=reading))
    total = field().h_total_nat(0)
    car = found.classes["car"]
    assert car.camera.s_mig == pytest.approx(-camera * total, rel=1e-9)
    assert car.lidar.s_mig == pytest.approx(-lidar * total, rel=1e-9)
    assert car.s_ms == pytest.approx(-(0.1 * camera + lidar) * total, rel=1e-9)
    assert (car.camera.seen, car.lidar.seen, car.any_seen) == pytest.approx((0.25, 0.5, 0.625), rel=1e-9)
    assert found.covered_voxels.items() >= {"camera": 1, "lidar": 2, "any": 3}.items()


def test_hits_count_what_is_met_more_than_once() -> None:
    hits = np.zeros((len(kind_names()), 3), object)
    hits[:2, 0] = [5 << 32, 3 << 32]
    car = score(field(), sums(0.25, 0.5, 0.5), MetricSettings("exact", "hits", 0.5), hits).classes["car"]
    assert (car.camera.s_mig, car.lidar.s_mig, car.s_ms) == (-3.0, -5.0, -6.5)
    assert car.lidar.seen == pytest.approx(0.5)


def test_a_class_that_is_nowhere_scores_zero_and_not_minus_zero() -> None:
    pedestrian = score(field(), sums(0.25, 0.5, 0.5), MetricSettings()).classes["pedestrian"]
    assert (pedestrian.lidar.seen, pedestrian.any_seen) == (0.0, 0.0)
    assert math.copysign(1.0, pedestrian.lidar.s_mig) == 1.0


def known(camera: float, lidar: float, both: float, settings: MetricSettings) -> Scores:
    """Scores of a rig that sees these shares of 100 nat of each class."""
    by_kind = dict.fromkeys(kind_names(), KindScore(0.0, 0.0))
    by_cameras, by_lidars = KindScore(-100.0 * camera, camera), KindScore(-100.0 * lidar, lidar)
    s_ms = settings.camera_weight * by_cameras.s_mig + by_lidars.s_mig
    return Scores(
        dict.fromkeys(
            CLASSES, ClassScores(100.0, by_kind | {"camera": by_cameras, "lidar": by_lidars}, both, s_ms)
        ),
        {},
    )


def test_an_estimate_follows_the_cameras_in_full_and_the_lidars_by_half() -> None:
    """On the coarse grid cameras see half as much as before and LiDARs four times as much: the root of that counts."""
    settings = MetricSettings()
    made = estimated(
        known(0.2, 0.4, 0.45, settings),
        known(0.4, 0.1, 0.45, settings),
        known(0.3, 0.05, 0.32, settings),
        settings,
    )
    assert made is not None
    car = made.classes["car"]
    assert (car.camera.seen, car.lidar.seen, car.any_seen) == pytest.approx((0.15, 0.1, 0.32))
    assert car.s_ms == pytest.approx(-0.1 * 15.0 - 10.0)


def test_an_estimate_sees_at_least_what_each_kind_sees_and_never_more_than_all() -> None:
    settings = MetricSettings(reading="residual")
    made = estimated(
        known(0.9, 0.4, 0.2, settings),
        known(0.3, 0.4, 0.4, settings),
        known(0.5, 0.4, 0.6, settings),
        settings,
    )
    assert made is not None
    car = made.classes["car"]
    assert (car.camera.seen, car.any_seen) == (1.0, 1.0)
    assert car.lidar.s_mig == pytest.approx(-60.0)
