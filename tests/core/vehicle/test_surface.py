"""The geometry that the car body is modelled with."""

import numpy as np
import pytest

from riglens.core.vehicle.surface import superellipsoid


def test_an_ellipsoid_is_closed_and_holds_its_volume():
    surface = superellipsoid((1.0, 2.0, 0.5), 1.0)
    one, other, third = (surface.points[surface.triangles[:, corner]] for corner in range(3))
    volume = (np.cross(one, other) * third).sum() / 6.0
    assert volume == pytest.approx(4.0 / 3.0 * np.pi * 1.0 * 2.0 * 0.5, rel=0.02)
