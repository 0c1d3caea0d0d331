"""Precision with intervals: by hand where all sequences are alike, and against drawing the frames themselves."""

from __future__ import annotations

import numpy as np
import pytest

from riglens.core.detect.precision import MATCH_M, Matched
from riglens.core.study.detection.statistics import COLUMNS, MEAN, Precisions, precisions


def matched(
    right_share: float, seed: int, groups: int = 8, objects: int = 20, classes: int = 3
) -> list[Matched]:
    """Detections whose sequences all look alike on average: each object is found with the same probability."""
    rng = np.random.default_rng(seed)
    size = groups * objects
    found = []
    for _ in range(classes):
        right = np.tile(rng.random(size) < right_share, (len(MATCH_M), 1))
        group = rng.permutation(np.repeat(np.arange(groups), objects))
        found.append(Matched(group, right, np.full(groups, objects)))
    return found


def study(shares: dict[str, float], seeds: int = 3) -> Precisions:
    cases = {(rig, seed): matched(share, 7 * seed) for rig, share in shares.items() for seed in range(seeds)}
    return precisions(tuple(shares), cases, seeds, replicas=100)


def test_values_are_means_over_seeds_of_the_devkits_precision() -> None:
    found = study({"a": 0.8, "b": 0.5})
    wanted = [[100 * one.precision()[0] for one in matched(0.8, 7 * seed)] for seed in range(3)]
    assert found.value[0, :3] == pytest.approx(np.mean(wanted, axis=0))
    assert found.value[0, 3] == pytest.approx(np.mean(wanted))
    assert found.by_seed[0, :, :3] == pytest.approx(np.array(wanted))


def test_replicas_are_what_drawing_sequences_and_seeds_one_by_one_gives() -> None:
    cases = {("a", seed): matched(0.6, seed, groups=4, classes=1) for seed in range(2)}
    cases = {key: [*one, *one, *one] for key, one in cases.items()}
    found = precisions(("a",), cases, 2, replicas=40, seed=5)
    rng = np.random.default_rng(5)
    weights = rng.multinomial(4, np.full(4, 0.25), 40)
    seeds = rng.multinomial(2, np.full(2, 0.5), 40)
    for replica in range(40):
        one = [
            float(cases["a", s][0].precision(weights[replica][:, None].astype(float))[0]) for s in range(2)
        ]
        drawn = np.repeat(one, seeds[replica])
        assert found.replicas[replica, 0, 0] == pytest.approx(100 * drawn.mean())


def test_what_is_clearly_better_is_called_better_and_the_other_worse() -> None:
    found = study({"good": 0.9, "bad": 0.4})
    for column in COLUMNS:
        assert found.verdict(0, 1, column) == "better"
        assert found.verdict(1, 0, column) == "worse"
        assert found.verdict(0, 0, column) == "not resolved"
        there, back = found.difference(0, 1, column), found.difference(1, 0, column)
        assert there.value == pytest.approx(-back.value) and there.low == pytest.approx(-back.high)


def sure(differences: dict[str, float]) -> Precisions:
    """Two rigs that differ by so much in every replica."""
    value = np.zeros((2, len(COLUMNS)))
    value[0] = [differences[column] for column in COLUMNS]
    return Precisions(("a", "b"), 1, 2, value, value[:, None], np.tile(value, (10, 1, 1)))


@pytest.mark.parametrize(
    ("column", "points", "said"),
    [("car", 1.4, "not resolved"), ("car", 1.5, "better"), ("bicycle", 3.9, "not resolved"),
     ("bicycle", 4.0, "better"), (MEAN, -1.5, "worse")],
)  # fmt: skip
def test_small_differences_are_not_called_better_however_sure(column: str, points: float, said: str) -> None:
    assert sure(dict.fromkeys(COLUMNS, points)).verdict(0, 1, column) == said


def test_an_interval_with_zero_is_not_resolved_however_large_the_difference() -> None:
    value = np.array([[10.0] * 4, [0.0] * 4])
    replicas = np.stack([np.stack([np.full(4, v), np.zeros(4)]) for v in np.linspace(-1, 21, 100)])
    assert (
        Precisions(("a", "b"), 1, 9, value, value[:, None], replicas).verdict(0, 1, "car") == "not resolved"
    )


def test_a_class_without_objects_is_left_out_of_the_mean() -> None:
    nothing = Matched(np.zeros(0, np.int64), np.zeros((len(MATCH_M), 0), np.bool_), np.zeros(4, np.int64))
    cases = {("a", 0): [*matched(0.7, 1, groups=4, classes=2), nothing]}
    found = precisions(("a",), cases, 1, replicas=50)
    assert np.isnan(found.value[0, 2]) and np.isnan(found.estimate(0, "pedestrian").low)
    assert found.value[0, 3] == pytest.approx(found.value[0, :2].mean())
    assert found.seed_spread(MEAN) is None


def test_the_interval_of_a_share_is_near_its_closed_form() -> None:
    """Precision 1 everywhere and a share found: the area is the share, whose spread over alike groups is known."""
    rng = np.random.default_rng(2)
    groups, objects = 40, 50
    share = rng.integers(20, 40, groups)
    group = np.repeat(np.arange(groups), share)
    right = np.ones((len(MATCH_M), len(group)), np.bool_)
    one = [Matched(group, right, np.full(groups, objects))] * 3
    found = precisions(("a",), {("a", 0): one}, 1, replicas=1000).estimate(0, "car")
    se = (
        100 * (share / objects).std() / np.sqrt(groups) * 100 / 90
    )  # 100 recalls, of which the first 10 do not count
    assert (found.high - found.low) / 2 == pytest.approx(1.96 * se, rel=0.12)


def test_seeds_spread() -> None:
    by_seed = np.zeros((2, 3, 4))
    by_seed[0, :, 0] = [1.0, 2.0, 3.0]
    found = Precisions(("a", "b"), 3, 1, by_seed.mean(axis=1), by_seed, np.zeros((1, 2, 4)))
    assert found.seed_spread("car") == pytest.approx(np.sqrt(0.5))
