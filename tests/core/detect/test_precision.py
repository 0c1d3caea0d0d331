"""Average precision against a literal reading of its definition, against the devkit where it is installed, and by
hand."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from riglens.core.detect.precision import MATCH_M, Detections, Matched, Truth

FRAMES = 12


def a_case(seed: int, frames: int = FRAMES, per_frame: int = 6) -> tuple[Truth, Detections]:
    """Random objects, detections near some of them and elsewhere, scores with ties."""
    rng = np.random.default_rng(seed)
    n = frames * per_frame
    frame = np.sort(rng.integers(0, frames, n))
    centre = rng.uniform(-20, 20, (n, 2))
    points = rng.integers(0, 4, n)
    truth = Truth(frame, rng.integers(0, 3, n).astype(np.uint8), centre, points)
    near = rng.choice(n, rng.integers(1, 2 * n))
    spread = rng.choice([0.2, 1.0, 3.0], len(near))[:, None]
    found_at = centre[near] + rng.normal(0, spread, (len(near), 2))
    score = np.round(rng.uniform(0, 1, len(near)), rng.integers(1, 4))
    cls = np.where(rng.random(len(near)) < 0.9, truth.cls[near], rng.integers(0, 3, len(near)))
    order = np.argsort(frame[near], kind="stable")
    return truth, Detections(frame[near][order], cls[order].astype(np.uint8), found_at[order], score[order])


def literal(truth: Truth, found: Detections, cls: int, within_m: float) -> float:
    """The definition step by step, one detection after the other, no arrays where a loop says it."""
    objects = [i for i in range(len(truth.frame)) if truth.cls[i] == cls]
    mine = [i for i in range(len(found.frame)) if found.cls[i] == cls]
    mine.sort(key=lambda i: (found.score[i], i), reverse=True)
    taken: set[int] = set()
    recall, precision, right, matched = [], [], 0, False
    for rank, i in enumerate(mine, start=1):
        free = [j for j in objects if truth.frame[j] == found.frame[i] and j not in taken]
        distance = {j: float(np.linalg.norm(found.centre_m[i] - truth.centre_m[j])) for j in free}
        nearest = min(free, key=lambda j: distance[j], default=None)
        if nearest is not None and distance[nearest] < within_m:
            taken.add(nearest)
            right, matched = right + 1, True
        recall.append(right / len(objects))
        precision.append(right / rank)
    if not matched:
        return 0.0
    at = np.interp(np.linspace(0, 1, 101), recall, precision, right=0)
    return sum(max(0.0, value - 0.1) for value in at[11:]) / 90 / 0.9


def precisions(truth: Truth, found: Detections) -> np.ndarray:
    """Of each class over all frames."""
    one = np.zeros(FRAMES, np.int64)
    return np.concatenate([Matched.of(truth, found, number, one).precision() for number in range(3)])


@pytest.mark.parametrize("seed", range(40))
def test_it_is_the_literal_definition(seed: int) -> None:
    truth, found = a_case(seed, per_frame=6 if seed % 2 else 2)
    for cls, ours in enumerate(precisions(truth, found)):
        wanted = np.mean([literal(truth, found, cls, within_m) for within_m in MATCH_M])
        assert ours == pytest.approx(wanted, abs=1e-12)


@pytest.mark.parametrize("seed", range(40))
def test_it_is_that_of_the_devkit(seed: int) -> None:
    algo = pytest.importorskip("nuscenes.eval.detection.algo", reason="pip install nuscenes-devkit")
    from nuscenes.eval.common.utils import center_distance

    truth, found = a_case(seed)
    names = ("car", "bicycle", "pedestrian")
    objects = devkit_boxes(truth.frame, truth.cls, truth.centre_m, np.full(len(truth.frame), -1.0), names)
    guesses = devkit_boxes(found.frame, found.cls, found.centre_m, found.score, names)
    ours = precisions(truth, found)
    for name, value in zip(names, ours, strict=True):
        data = [algo.accumulate(objects, guesses, name, center_distance, th) for th in MATCH_M]
        assert value == pytest.approx(np.mean([algo.calc_ap(one, 0.1, 0.1) for one in data]), abs=1e-12)


def devkit_boxes(frame: Any, cls: Any, centre: Any, score: Any, names: tuple[str, ...]) -> Any:
    from nuscenes.eval.common.data_classes import EvalBoxes
    from nuscenes.eval.detection.data_classes import DetectionBox

    boxes = EvalBoxes()
    for number in range(FRAMES):  # every sample is there, also one without boxes
        boxes.add_boxes(str(number), [])
    for at, kind, (x, y), value in zip(frame, cls, centre, score, strict=True):
        box = DetectionBox(
            sample_token=str(at), translation=(x, y, 0.0), size=(1, 1, 1), rotation=(1, 0, 0, 0),
            velocity=(0, 0), detection_name=names[kind], detection_score=float(value),
        )  # fmt: skip
        boxes.add_boxes(str(at), [box])
    return boxes


def by_hand(right: list[bool], objects: int) -> float:
    """Average precision at one distance of detections in the order of their scores."""
    flags = np.tile(np.array(right, np.bool_), (len(MATCH_M), 1))
    matched = Matched(np.zeros(len(right), np.int64), flags, np.array([objects]))
    return float(matched.precision()[0])


def test_all_found_and_nothing_else_is_one() -> None:
    assert by_hand([True] * 5, 5) == pytest.approx(1.0, abs=1e-15)


def test_half_found_is_precision_one_up_to_half_of_the_recalls() -> None:
    assert by_hand([True] * 5, 10) == pytest.approx(40 / 90)  # recalls 0.11 to 0.50 of 0.11 to 1.00


def test_nothing_found_is_zero_and_nothing_to_find_is_not_a_number() -> None:
    assert by_hand([], 3) == by_hand([False, False], 3) == 0.0
    assert np.isnan(by_hand([False], 0))


def test_an_object_is_found_once() -> None:
    truth = Truth(np.zeros(1, np.int64), np.zeros(1, np.uint8), np.zeros((1, 2)), np.zeros(1, np.int64))
    twice = Detections(
        np.zeros(2, np.int64), np.zeros(2, np.uint8), np.array([[0.1, 0.0], [0.0, 0.0]]), np.array([0.9, 0.8])
    )
    matched = Matched.of(truth, twice, 0, np.zeros(1, np.int64))
    assert matched.right.tolist() == [[True, False]] * 4


@pytest.mark.parametrize("seed", range(10))
def test_weights_count_sequences_as_often_as_they_say(seed: int) -> None:
    truth, found = a_case(seed, per_frame=12)
    group_of_frame = np.arange(FRAMES) // 3
    kept = np.array([1.0, 0.0, 1.0, 1.0])
    here = Matched.of(truth, found, 0, group_of_frame)
    mask, seen = kept[group_of_frame[truth.frame]] > 0, kept[group_of_frame[found.frame]] > 0
    part = Detections(*(column[seen] for column in found))
    wanted = precisions(truth.where(mask), part)[:1]
    assert here.precision(kept[:, None]) == pytest.approx(wanted, abs=1e-12)
    replicas = np.random.default_rng(seed).integers(1, 4, (4, 450)).astype(np.float64)
    assert here.precision(replicas[:, 400:]) == pytest.approx(here.precision(replicas)[400:], abs=0)
    assert here.precision(3.0 * replicas[:, :5]) == pytest.approx(here.precision(replicas[:, :5]), abs=1e-12)


def test_a_score_that_is_no_number_is_refused() -> None:
    truth, found = a_case(0)
    with pytest.raises(ValueError, match="finite"):
        precisions(truth, found._replace(score=np.full(len(found.score), np.nan)))
