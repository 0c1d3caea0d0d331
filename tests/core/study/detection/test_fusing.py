"""Detections of LiDARs and of cameras are joined as what they are: chances."""

from __future__ import annotations

import numpy as np
import pytest

from riglens.core.detect.precision import Detections, Truth
from riglens.core.study.detection.fusing import (
    _RIDGE,
    MEETING_M,
    MEETING_SHARE,
    Reliability,
    _logistic,
    fused,
    reliable,
)


def at(*rows: tuple[int, int, float, float, float]) -> Detections:
    """Frame, class, x, y, score of each."""
    frame, cls, x, y, score = np.array(rows, np.float64).reshape(-1, 5).T
    return Detections(frame.astype(np.int64), cls.astype(np.uint8), np.stack([x, y], axis=1), score)


def test_met_detections_are_wrong_only_if_both_err_and_stand_where_lidars_say() -> None:
    found = fused(at((0, 0, 10.0, 0.0, 0.6)), at((0, 0, 12.0, 0.0, 0.5)))
    assert found.score.tolist() == [pytest.approx(0.8)] and found.centre_m.tolist() == [[10.0, 0.0]]


def test_the_rest_stays_as_it_is() -> None:
    away = MEETING_M + MEETING_SHARE * 15.0 + 0.1
    lidars = at((0, 0, 15.0 - away, 0.0, 0.6), (1, 0, 15.0, 0.0, 0.3))
    cameras = at((0, 0, 15.0, 0.0, 0.5), (0, 1, 10.0, 0.0, 0.2))
    found = fused(lidars, cameras)
    assert sorted(found.score.tolist()) == [0.2, 0.3, 0.5, 0.6]
    assert fused(lidars, at()).score.tolist() == [0.6, 0.3]
    assert sorted(fused(at(), cameras).score.tolist()) == [0.2, 0.5]


def test_a_lidar_detection_meets_the_surest_camera_detection_alone() -> None:
    found = fused(at((0, 0, 10.0, 0.0, 0.5)), at((0, 0, 10.5, 0.0, 0.1), (0, 0, 11.0, 0.0, 0.8)))
    assert sorted(found.score.tolist()) == [pytest.approx(0.1), pytest.approx(0.9)]


def overconfident(frames: int) -> tuple[Truth, Detections]:
    """Detections that are right half as often as they say, one object a frame and class."""
    rng = np.random.default_rng(3)
    frame, cls = np.repeat(np.arange(frames), 3), np.tile(np.arange(3), frames).astype(np.uint8)
    score = rng.uniform(0.2, 0.95, len(frame))
    right = rng.random(len(frame)) < score / 2.0
    centre_m = rng.uniform(-20.0, 20.0, (len(frame), 2))
    truth = Truth(frame, cls, centre_m, np.ones(len(frame), np.int64))
    return truth, Detections(frame, cls, centre_m + np.where(right, 0.5, 5.0)[:, None], score)


def test_scores_become_chances_learned_on_the_other_half() -> None:
    frames = 4000
    judged, half = overconfident(frames), np.arange(frames) < frames // 2
    (found,) = reliable([judged], half)
    asked = judged[1].score
    for low in (0.2, 0.5, 0.8):
        mine = (asked >= low) & (asked < low + 0.15)
        assert found.score[mine].mean() == pytest.approx(asked[mine].mean() / 2.0, abs=0.05)
    by_other = Reliability.of([judged], ~half)
    first = half[found.frame]
    assert (found.score[first] == by_other.chances(judged[1])[first]).all()


def test_the_weights_of_chances_are_the_best_ones() -> None:
    """At the fitted weights, no small change increases the penalised likelihood."""
    rng = np.random.default_rng(4)
    known = np.column_stack([np.ones(300), rng.normal(1.0, 1.0, 300), rng.uniform(0.0, 5.0, 300)])
    right = rng.random(300) < 1.0 / (1.0 + np.exp(-known @ [0.5, 2.0, -0.3]))
    weights = _logistic(known, right)
    slope = known.T @ (right - 1.0 / (1.0 + np.exp(-known @ weights))) - _RIDGE * weights
    np.testing.assert_allclose(slope, 0.0, atol=1e-9)
