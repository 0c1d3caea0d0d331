"""Which of two faces a ray crosses first is decided as in exact arithmetic, however close they are."""

from __future__ import annotations

from fractions import Fraction
from itertools import product

import numpy as np
import pytest

from riglens.core.kernels.rays import predicates
from riglens.core.kernels.rays.predicates import (
    LARGEST,
    SMALLEST,
    Moment,
    compare,
    compare_exactly,
    regular_ray,
)

NEXT = float(np.nextafter(0.1, 1.0))


def truth(one: Moment, other: Moment) -> int:
    """The sign in rational numbers."""
    gap = _exactly(one) - _exactly(other)
    return (gap > 0) - (gap < 0)


def _exactly(moment: Moment) -> Fraction:
    return (Fraction(moment.face) - Fraction(moment.origin)) / Fraction(moment.direction)


def test_one_third_is_two_sixths() -> None:
    assert compare(Moment(1.0, 0.0, 3.0), Moment(2.0, 0.0, 6.0)) == 0


def test_the_earlier_moment_is_the_smaller_one() -> None:
    early, late = Moment(1.0, 0.5, 1.0), Moment(2.0, 0.5, 1.0)
    assert (compare(early, late), compare(late, early)) == (-1, 1)


def test_backwards_along_both_axes_the_order_is_that_of_the_way() -> None:
    early, late = Moment(2.0, 2.5, -1.0), Moment(1.0, 2.5, -1.0)
    assert (compare(early, late), compare(late, early)) == (-1, 1)
    assert (compare_exactly(early, late), compare_exactly(late, early)) == (-1, 1)


def test_backwards_along_one_axis_only() -> None:
    early, late = Moment(2.0, 2.5, -1.0), Moment(4.0, 2.5, 1.0)
    assert (compare_exactly(early, late), compare_exactly(late, early)) == (-1, 1)


def test_a_last_bit_decides_that_doubles_round_away() -> None:
    """From 0.1 and from the double behind it to the face 1e9: in doubles both differences are the same."""
    near, far = Moment(1e9, NEXT, 1.0), Moment(1e9, 0.1, 1.0)
    assert 1e9 - NEXT == 1e9 - 0.1
    assert (compare(near, far), compare(far, near)) == (-1, 1)


def test_doubles_in_the_wrong_order_are_put_right() -> None:
    """Moments of which the later one comes out smaller in doubles."""
    cases = _in_the_wrong_order()
    assert len(cases) >= 20
    for one, other in cases:
        assert compare(one, other) == truth(one, other)


def _in_the_wrong_order() -> list[tuple[Moment, Moment]]:
    rng = np.random.default_rng(1)
    found = []
    for _ in range(4000):
        g, d, other_d = rng.random(), rng.random(), rng.random()
        one = Moment(3.0, g, d)
        at = (3.0 - g) / d
        other = Moment(5.0, 5.0 - at * other_d, other_d)
        t1, t2 = at, (other.face - other.origin) / other.direction
        if t1 != t2 and (1 if t1 > t2 else -1) != truth(one, other):
            found.append((one, other))
    return found


def test_the_sign_is_exact_for_round_and_for_odd_numbers() -> None:
    numbers = [0.1, 0.3, NEXT, 1.0 / 3.0, -0.7, 3.0]
    for f1, g1, d1, g2, d2 in product([1.0, 3.0], numbers, numbers, numbers, numbers):
        one, other = Moment(f1, g1, d1), Moment(2.0, g2, d2)
        assert compare_exactly(one, other) == truth(one, other)


@pytest.mark.parametrize(
    ("terms", "sign"),
    [
        ([1e100, 1.0, -1e100], 1),
        ([1e100, -1.0, -1e100], -1),
        ([1.0, 2.0**-80, -1.0], 1),
        ([0.5, 0.5, -1.0], 0),
        ([1e300, 1.0, -1e300, -1.0], 0),
        ([2.0**53, 1.0, 1.0, -(2.0**53), -2.0], 0),
    ],
)
def test_the_sign_of_a_sum_survives_cancellation(terms: list[float], sign: int) -> None:
    assert predicates._sign_of_sum((*terms, *[0.0] * (8 - len(terms)))) == sign


def test_a_product_and_its_rounding_error_are_the_exact_product() -> None:
    product_, rest = predicates._two_product(0.1, 0.3)
    assert Fraction(float(product_)) + Fraction(float(rest)) == Fraction(0.1) * Fraction(0.3)
    assert rest != 0.0


def test_a_sum_and_its_rounding_error_are_the_exact_sum() -> None:
    total, rest = predicates._two_sum(1e16, 0.1)
    assert Fraction(float(total)) + Fraction(float(rest)) == Fraction(1e16) + Fraction(0.1)
    assert rest != 0.0


@pytest.mark.parametrize("axis", range(6))
@pytest.mark.parametrize(
    ("component", "is_regular"),
    [
        (0.0, True),
        (-0.0, True),
        (SMALLEST, True),
        (-SMALLEST, True),
        (SMALLEST / 2.0, False),
        (5e-324, False),
        (LARGEST, True),
        (-LARGEST * 2.0, False),
    ],
)
def test_rays_of_denormal_or_huge_numbers_are_left_to_rational_arithmetic(
    axis: int, component: float, is_regular: bool
) -> None:
    parts = [1.0] * 6
    parts[axis] = component
    assert regular_ray((parts[0], parts[1], parts[2]), (parts[3], parts[4], parts[5])) == is_regular


def test_the_least_part_of_an_exact_sum_decides_where_all_others_cancel() -> None:
    """1 + low against 1 + p / d: p is low times d but for its rounding, and that alone is the difference."""
    low, d = 0.3 * 2.0**-56, 1.0 + 3.0 * 2.0**-52
    p = low * d
    exact = 1 + Fraction(low) - (Fraction(d) + Fraction(p)) / Fraction(d)
    assert exact != 0
    one, other = Moment(1.0, -low, 1.0), Moment(d, -p, d)
    assert compare_exactly(one, other) == (1 if exact > 0 else -1) == -compare_exactly(other, one)
