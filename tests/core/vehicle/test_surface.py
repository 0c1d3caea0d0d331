"""The geometry that the car body is modelled with."""

import numpy as np
import pytest
from scipy.interpolate import BSpline

from riglens.core.vehicle.surface import spline_matrix, superellipsoid


@pytest.mark.parametrize(
    ("controls", "samples", "degree"), [(23, 113, 3), (4, 9, 3), (21, 36, 3), (7, 61, 2), (5, 5, 1)]
)
def test_the_spline_is_the_clamped_uniform_one_of_scipy_to_the_last_bit(controls, samples, degree):
    inner = np.linspace(0.0, 1.0, controls - degree + 1)
    knots = np.concatenate([np.zeros(degree), inner, np.ones(degree)])
    expected = BSpline(knots, np.eye(controls), degree)(np.linspace(0.0, 1.0, samples))
    assert np.array_equal(spline_matrix(controls, samples, degree), expected)


def test_an_ellipsoid_is_closed_and_holds_its_volume():
    surface = superellipsoid((1.0, 2.0, 0.5), 1.0)
    one, other, third = (surface.points[surface.triangles[:, corner]] for corner in range(3))
    volume = (np.cross(one, other) * third).sum() / 6.0
    assert volume == pytest.approx(4.0 / 3.0 * np.pi * 1.0 * 2.0 * 0.5, rel=0.02)
