"""Compare exactly the moments at which a ray crosses grid faces.

A moment is the rational number (f - g) / d: face f (an integer), origin g and direction d of the ray on that
axis, in grid units; a plain number t is the moment (t - 0) / 1. Moments are first compared in double
precision with an error bound; when that cannot decide, error-free transforms (Dekker 1971, Shewchuk 1997)
give the sign of the exact difference. The transforms neither over- nor underflow while every nonzero |g| and
|d| lies in [2^-400, 2^300]; `regular_ray` tells. Other rays are walked in rational arithmetic.
"""

from __future__ import annotations

from typing import NamedTuple

from riglens.core.kernels.runtime.jit import lean, lean_inlined

SMALLEST = 2.0**-400
LARGEST = 2.0**300
UNIT_ROUNDOFF = 2.0**-53
MOMENT_BOUND = 8.0 * UNIT_ROUNDOFF
"""Two computed moments that differ by more than this, relative to the larger, are in their true order:
each is a rounded difference times a rounded reciprocal, so off by at most 3 roundoffs."""
_SPLITTER = 134217729.0
"""2^27 + 1: splits a double into two halves whose products are exact (Dekker)."""

Vector = tuple[float, float, float]
_Parts = tuple[float, float, float, float, float, float, float, float]


class Moment(NamedTuple):
    """Moment at which a ray crosses a face of one axis: (face - origin) / direction, all in grid units."""

    face: float
    origin: float
    direction: float


@lean_inlined
def _two_sum(a: float, b: float) -> tuple[float, float]:
    total = a + b
    part = total - a
    return total, (a - (total - part)) + (b - part)


@lean_inlined
def _two_product(a: float, b: float) -> tuple[float, float]:
    product = a * b
    scaled = _SPLITTER * a
    a_high = scaled - (scaled - a)
    a_low = a - a_high
    scaled = _SPLITTER * b
    b_high = scaled - (scaled - b)
    b_low = b - b_high
    return product, ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low


@lean
def _grown(parts: _Parts, term: float) -> _Parts:
    """Return a non-overlapping expansion, from small to large parts, with a term added; its first part must be zero."""
    carry, _ = _two_sum(term, parts[0])
    carry, a = _two_sum(carry, parts[1])
    carry, b = _two_sum(carry, parts[2])
    carry, c = _two_sum(carry, parts[3])
    carry, d = _two_sum(carry, parts[4])
    carry, e = _two_sum(carry, parts[5])
    carry, f = _two_sum(carry, parts[6])
    carry, g = _two_sum(carry, parts[7])
    return a, b, c, d, e, f, g, carry


@lean
def _sign_of_sum(terms: _Parts) -> int:
    """Return the sign of the exact sum of doubles: grown into a non-overlapping expansion, whose last nonzero part
    decides."""
    parts = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    for i in range(8):
        parts = _grown(parts, terms[i])
    for i in range(8):
        if parts[7 - i] != 0.0:
            return 1 if parts[7 - i] > 0.0 else -1
    return 0


@lean_inlined
def _compare_products(a: float, b: float, c: float, d: float) -> tuple[int, bool]:
    """Return the sign of a b - c d from the exact products, and whether this quick method could decide."""
    high, low = _two_product(a, b)
    other_high, other_low = _two_product(c, d)
    gap, rest = high - other_high, low - other_low
    if gap == 0.0:
        return (1 if low > other_low else -1 if low < other_low else 0), True
    return (1 if gap > 0.0 else -1), abs(rest) < 0.5 * abs(gap)


@lean
def compare_exactly(one: Moment, other: Moment) -> int:
    """Return the sign (-1, 0, 1) of the difference of two moments in exact arithmetic; no direction is zero."""
    d1, d2 = one.direction, other.direction
    a, a_low = _two_sum(one.face, -one.origin)
    b, b_low = _two_sum(other.face, -other.origin)
    if a_low == 0.0 and b_low == 0.0:
        sign, decided = _compare_products(a, d2, b, d1)
        if decided:
            return sign if (d1 > 0.0) == (d2 > 0.0) else -sign
    p, p_low = _two_product(a_low, d2)
    q, q_low = _two_product(-b_low, d1)
    r, r_low = _two_product(a, d2)
    s, s_low = _two_product(-b, d1)
    sign = _sign_of_sum((p_low, p, q_low, q, r_low, r, s_low, s))
    return sign if (d1 > 0.0) == (d2 > 0.0) else -sign


@lean_inlined
def compare(one: Moment, other: Moment) -> int:
    """Return the sign (-1, 0, 1) of the difference of two moments: in doubles where their error bound decides, else
    exactly."""
    t1 = (one.face - one.origin) / one.direction
    t2 = (other.face - other.origin) / other.direction
    if abs(t1 - t2) > MOMENT_BOUND * max(abs(t1), abs(t2)):
        return 1 if t1 > t2 else -1
    return compare_exactly(one, other)


@lean_inlined
def _is_regular(value: float) -> bool:
    return value == 0.0 or SMALLEST <= abs(value) <= LARGEST


@lean_inlined
def regular_ray(g: Vector, d: Vector) -> bool:
    """Return whether the exact predicates hold for a ray of origin g and direction d (no denormal or huge
    component)."""
    origin = _is_regular(g[0]) and _is_regular(g[1]) and _is_regular(g[2])
    return origin and _is_regular(d[0]) and _is_regular(d[1]) and _is_regular(d[2])
