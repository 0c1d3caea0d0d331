"""Clipped polygons have the corners that lie on the inner side of every plane, and those where sides cross planes."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from numpy.typing import NDArray

from riglens.core.kernels.rays.clip import clip_polygons

Polygon = NDArray[np.float64]
NEAR = 1e-9


def corners_inside(polygon: Polygon, planes: NDArray[np.float64]) -> Polygon:
    """Corners of what is left of a triangle, in no order: all points where two of its lines or planes meet in its plane
    that lie on the inner side of all of them."""
    origin, across, up = polygon[0], polygon[1] - polygon[0], polygon[2] - polygon[0]
    sides = [np.array([0.0, 1.0, 0.0]), np.array([1.0, 0.0, 0.0]), np.array([-1.0, -1.0, 1.0])]
    cuts = [np.array([plane[:3] @ across, plane[:3] @ up, plane[:3] @ origin + plane[3]]) for plane in planes]
    lines, found = [*sides, *cuts], list[NDArray[np.float64]]()
    for one, other in combinations(lines, 2):
        if abs(np.linalg.det([one[:2], other[:2]])) > NEAR:
            place = np.linalg.solve([one[:2], other[:2]], [-one[2], -other[2]])
            if all(line[:2] @ place + line[2] >= -NEAR for line in lines):
                found.append(origin + place[0] * across + place[1] * up)
    return np.array(found).reshape(-1, 3)


@pytest.mark.parametrize("count", [1, 2, 4])
def test_what_is_left_of_triangles_has_the_corners_of_all_inner_crossings(count: int) -> None:
    rng = np.random.default_rng(count)
    triangles, planes = (
        rng.normal(size=(40, 3, 3)),
        rng.normal(size=(count, 4)),
    )
    planes[:, 3] += count / 3.0
    clipped, counts = np.full((40, 3 + count, 3), np.nan), np.full(40, -1)
    clip_polygons(triangles, planes, clipped, counts)
    for triangle, left, corners in zip(triangles, clipped, counts, strict=True):
        expected = corners_inside(triangle, planes)
        assert corners == len(expected) and np.isnan(left[corners:]).all(), "and nothing is written beyond"
        if corners:
            away = np.linalg.norm(left[:corners, None] - expected[None], axis=2)
            assert away.min(axis=1).max() < 1e-6 and away.min(axis=0).max() < 1e-6
            sides = np.roll(left[:corners], -1, axis=0) - left[:corners]
            turns = np.cross(sides, np.roll(sides, -1, axis=0)) @ np.cross(*(triangle[1:] - triangle[0]))
            assert (turns > -1e-9).all(), "in their order"
    assert {0, 3} < set(counts.tolist()), "some vanish, some stay, some gain corners"
