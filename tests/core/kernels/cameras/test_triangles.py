"""Sizes of triangles between rays, on four rays in a square."""

import numpy as np
import pytest

from riglens.core.kernels.cameras.triangles import SIZES, measure_triangles

ROWS = np.array([[1.0, y, z] for z in (0.1, -0.1) for y in (0.3, 0.0)])
NUMBERS = np.arange(4).reshape(2, 2)
ALL, NONE = np.ones((1, 1), bool), np.zeros((1, 1), bool)


@pytest.mark.parametrize(("lower", "upper"), [(ALL, ALL), (ALL, NONE), (NONE, ALL)])
def test_right_angled_triangles_lie_in_a_ball_around_their_longest_side(lower, upper) -> None:
    sizes = np.zeros(SIZES)
    assert measure_triangles(ROWS, NUMBERS, lower, upper, sizes)
    np.testing.assert_allclose(sizes, [0.5 * np.hypot(0.3, 0.2), 0.0, 0.15, 0.1, 0.3, 0.2], atol=1e-15)


def test_of_an_acute_triangle_the_ball_goes_through_its_corners() -> None:
    rows, sizes = ROWS.copy(), np.zeros(SIZES)
    rows[2, 1:] = 0.2, -0.2
    assert measure_triangles(rows, NUMBERS, ALL, NONE, sizes)
    a, b, c = (rows[i] for i in (0, 3, 2))
    sides = [np.linalg.norm(p - q) for p, q in ((a, b), (b, c), (c, a))]
    assert sizes[0] == pytest.approx(np.prod(sides) / (2.0 * np.linalg.norm(np.cross(b - a, c - a))))


def test_triangles_turned_over_are_told() -> None:
    for lower, upper in ((ALL, NONE), (NONE, ALL)):
        assert not measure_triangles(ROWS[[1, 0, 3, 2]], NUMBERS, lower, upper, np.zeros(SIZES))
    assert measure_triangles(ROWS[[1, 0, 3, 2]], NUMBERS, NONE, NONE, np.zeros(SIZES))
