"""Perception entropy as its authors have it: by hand, for an object of some points and pixels."""

from __future__ import annotations

import math

import numpy as np
import pytest

from riglens.core.study.perception_entropy import fused_precision
from riglens.core.targets.counts import ObjectCounts


def objects(points: list[int], pixels: list[float]) -> ObjectCounts:
    count, none = len(points), np.zeros(len(points), np.int64)
    return ObjectCounts(
        np.arange(count), ("LIDAR",), ("CAM",), np.array(points)[:, None], np.array(pixels)[:, None],
        none, np.zeros(count), none, np.zeros((count, 1)), np.zeros((count, 1)),
    )  # fmt: skip


def test_one_point_is_worth_as_much_as_the_authors_fitted() -> None:
    assert fused_precision(objects([1, 0], [0.0, 0.0])).tolist() == [pytest.approx(0.659), 0.0]


def test_two_sensors_fuse_by_the_inverse_of_their_variances() -> None:
    of_points, of_pixels = 0.152 * math.log(5) + 0.659, 0.055 * math.log(900) + 0.155
    weight = sum((1.0 / of - 1.0) ** -2 for of in (of_points, of_pixels))
    (found,) = fused_precision(objects([5], [900.0]))
    assert found == pytest.approx(1.0 / (1.0 + weight**-0.5))
    assert found > of_points > of_pixels


def test_more_never_hurts_and_nothing_reaches_one() -> None:
    found = fused_precision(objects([1, 2, 10, 10**6], [1e7] * 4))
    assert (np.diff(found) >= 0.0).all() and found[-1] < 1.0
