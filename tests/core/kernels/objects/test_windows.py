"""Windows of boxes hold every point of the box that the sensor can see, and are no wider than they have to be."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from numpy.typing import NDArray

from riglens.core.geometry import rotation_from_rpy_deg
from riglens.core.kernels.objects.windows import (
    MARGIN,
    NOWHERE,
    TURN,
    corners_of,
    place_at,
    slopes_between,
    window_of_image,
    window_of_turn,
)

RNG = np.random.default_rng(7)
LEAST = 0.3
ROUNDED = 1e-7
SHARES = np.array([[int(c & 1), int(c >> 1 & 1), int(c >> 2 & 1)] for c in range(8)], np.float64) * 2.0 - 1.0


def box(
    middle: NDArray[np.float64], angles_deg: NDArray[np.float64], half: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Corners of a box, the bits of whose numbers are its sides."""
    turn = rotation_from_rpy_deg((float(angles_deg[0]), float(angles_deg[1]), float(angles_deg[2]))).T
    to = np.empty((8, 3))
    corners_of(middle, turn, tuple(half), to)
    return to


def boxes(count: int, away_m: float) -> list[NDArray[np.float64]]:
    return [
        box(RNG.uniform(-away_m, away_m, 3), RNG.uniform(-180.0, 180.0, 3), RNG.uniform(0.1, 2.5, 3))
        for _ in range(count)
    ]


def inside(corners: NDArray[np.float64], count: int = 400) -> NDArray[np.float64]:
    """Random points of a box and all on its edges that matter: its corners."""
    a, b, c = (corners[1 << axis] - corners[0] for axis in range(3))
    shares = RNG.uniform(0.0, 1.0, (count, 3))
    return np.concatenate([corners, corners[0] + shares @ np.stack([a, b, c])])


def cut(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """Points that span what of a box is at least so far ahead: corners, and where lines between any two are cut."""
    found = [corner for corner in corners if corner[0] >= LEAST]
    for one, other in combinations(corners, 2):
        if (one[0] < LEAST) != (other[0] < LEAST):
            share = (LEAST - one[0]) / (other[0] - one[0])
            found.append(one + share * (other - one))
    return np.array(found).reshape(-1, 3)


def test_corners_are_the_ends_of_all_three_sides_in_the_axes_of_the_sensor() -> None:
    middle, half, angles_deg = np.array([3.0, -2.0, 1.0]), np.array([2.0, 1.0, 0.5]), (10.0, 20.0, 30.0)
    found = box(middle, np.array(angles_deg), half)
    assert found == pytest.approx(middle + (SHARES * half) @ rotation_from_rpy_deg(angles_deg).T)


def test_a_window_of_the_image_is_the_smallest_rectangle_around_what_is_ahead() -> None:
    """Wherever the plane of the sensor cuts a box: against lines between all pairs of corners, not its edges alone."""
    counts = {"cut": 0, "whole": 0, "behind": 0}
    for corners in boxes(400, 3.0):
        window, ahead = window_of_image(corners, LEAST), cut(corners)
        behind = int((corners[:, 0] < LEAST).sum())
        counts["behind" if behind == 8 else "cut" if behind else "whole"] += 1
        if behind == 8:
            assert window == NOWHERE and window.width < 0.0
            continue
        y, z = ahead[:, 1] / ahead[:, 0], ahead[:, 2] / ahead[:, 0]
        wide = (y.min(), y.max(), z.min(), z.max())
        found = (window.left, window.left + window.width, window.low, window.high)
        assert found == pytest.approx(wide, rel=ROUNDED, abs=ROUNDED)
        assert found[0] < wide[0] and wide[1] < found[1] and found[2] < wide[2] and wide[3] < found[3], (
            "never less"
        )
    assert min(counts.values()) > 30


@pytest.mark.parametrize("is_upright", [False, True])
def test_a_window_of_a_turn_holds_the_box_and_ends_at_its_corners(is_upright: bool) -> None:
    counts = {"around": 0, "beside": 0, "seam": 0}
    for _ in range(400):
        angles_deg = RNG.uniform(-180.0, 180.0, 3) * ([0.0, 0.0, 1.0] if is_upright else 1.0)
        corners = box(RNG.uniform(-3.0, 3.0, 3), angles_deg, RNG.uniform(0.1, 2.0, 3))
        window, points = window_of_turn(corners, is_upright), inside(corners)
        radius = np.hypot(points[:, 0], points[:, 1])
        assert (radius >= window.near).all() and window.far == pytest.approx(radius.max())
        slopes = points[:, 2] / radius
        assert (slopes > window.low).all() and (slopes < window.high).all()
        assert 0.0 <= window.left < TURN
        azimuths = (np.arctan2(points[:, 1], points[:, 0]) - window.left) % TURN
        assert (azimuths <= window.width).all()
        if window.width == TURN:
            counts["around"] += 1
            assert window.near == 0.0
            continue
        counts["seam"] += window.left + window.width > TURN
        counts["beside"] += window.width > np.pi / 2.0
        assert azimuths[:8].min() == pytest.approx(MARGIN, abs=ROUNDED), "from corner"
        assert azimuths[:8].max() == pytest.approx(window.width - MARGIN, abs=ROUNDED), "to corner"
        if window.near == 0.0:
            continue
        bottom, top = corners[:, 2].min(), corners[:, 2].max()
        assert (window.low, window.high) == slopes_between(bottom, top, window.near, window.far)
    assert min(counts.values()) > 10


@pytest.mark.parametrize(
    ("bottom", "top", "low", "high"),
    [(-1.0, 3.0, -0.5, 1.5), (1.0, 3.0, 0.25, 1.5), (-3.0, -1.0, -1.5, -0.25), (0.0, 0.0, 0.0, 0.0)],
)
def test_slopes_are_steepest_where_they_are_near(bottom: float, top: float, low: float, high: float) -> None:
    found = slopes_between(bottom, top, 2.0, 4.0)
    assert found == pytest.approx((low, high), abs=1e-8)
    assert found[0] <= low - MARGIN and found[1] >= high + MARGIN


def test_the_place_of_a_value_is_that_of_a_search_whether_steps_are_even_or_not() -> None:
    uneven = np.sort(RNG.normal(size=30)), np.geomspace(1.0, 99.0, 7)
    for row in (np.array([]), np.array([2.0]), np.linspace(-1.0, 1.0, 9), *uneven):
        values = [
            *row,
            *(row + 1e-12),
            *(row - 1e-12),
            *RNG.uniform(-3.0, 100.0, 60),
            *RNG.uniform(-1.5, 1.5, 60),
        ]
        for value in (*values, np.inf, -np.inf):
            assert place_at(row, value) == np.searchsorted(row, value)
