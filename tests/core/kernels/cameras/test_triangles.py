"""Sizes of triangles between rays, on four rays in a square."""

import math

import numpy as np
import pytest

from riglens.core.kernels.cameras.triangles import SIZES, measure_triangles

ROWS = np.array([[1.0, y, z] for z in (0.1, -0.1) for y in (0.3, 0.0)])
NUMBERS = np.arange(4).reshape(2, 2)
ALL, NONE = np.ones((1, 1), bool), np.zeros((1, 1), bool)


@pytest.mark.parametrize(("lower", "upper"), [(ALL, ALL), (ALL, NONE), (NONE, ALL)])
def test_right_angled_triangles_lie_in_a_ball_around_their_longest_side(lower, upper) -> None:
    sizes = np.zeros(SIZES)
    assert measure_triangles(ROWS, NUMBERS, lower, upper, math.inf, sizes)
    np.testing.assert_allclose(sizes, [0.5 * np.hypot(0.3, 0.2), 0.0, 0.15, 0.1, 0.3, 0.2], atol=1e-15)


def test_of_an_acute_triangle_the_ball_goes_through_its_corners() -> None:
    rows, sizes = ROWS.copy(), np.zeros(SIZES)
    rows[2, 1:] = 0.2, -0.2
    assert measure_triangles(rows, NUMBERS, ALL.copy(), NONE, math.inf, sizes)
    a, b, c = (rows[i] for i in (0, 3, 2))
    sides = [np.linalg.norm(p - q) for p, q in ((a, b), (b, c), (c, a))]
    assert sizes[0] == pytest.approx(np.prod(sides) / (2.0 * np.linalg.norm(np.cross(b - a, c - a))))


def test_triangles_turned_over_are_told() -> None:
    for lower, upper in ((ALL, NONE), (NONE, ALL)):
        assert not measure_triangles(
            ROWS[[1, 0, 3, 2]], NUMBERS, lower.copy(), upper.copy(), math.inf, np.zeros(SIZES)
        )
    assert measure_triangles(ROWS[[1, 0, 3, 2]], NUMBERS, NONE, NONE, math.inf, np.zeros(SIZES))


def test_triangles_with_longer_sides_are_taken_out() -> None:
    """Of a square with sides of 1 and a triangle on it that reaches far up, the square's half stays."""
    rows = np.array([[10.0, y, z] for y, z in ((0.0, 0.0), (-5.0, 5.0), (0.0, -1.0), (-1.0, -1.0))])
    lower, upper, sizes = ALL.copy(), ALL.copy(), np.zeros(SIZES)
    assert measure_triangles(rows, NUMBERS, lower, upper, 2.0, sizes)
    assert lower.all() and not upper.any()
    assert sizes[0] == pytest.approx(0.5 * math.sqrt(2.0))
