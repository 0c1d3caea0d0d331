"""The directions that the window draws are those that the compiled kernels cast."""

import numpy as np
import pytest

from riglens.core.kernels.rays.lattice import direction
from riglens.core.kernels.runtime.codes import CAMERA, LIDAR
from riglens.core.sensing.rays import lattice
from riglens.core.sensors.lattice import Lattice
from tests.core.builders import grid_of, random_sensor


@pytest.mark.parametrize("seed", range(12))
def test_directions_of_a_sensor_are_those_of_the_kernels_to_the_last_bit(seed):
    found = lattice(random_sensor(grid_of(12, 10, 7, 0.5), np.random.default_rng(seed)))
    compiled = [direction(found.kind, row, plane) for row in found.rows for plane in found.planes]
    assert np.array_equal(found.directions(), np.array(compiled))


@pytest.mark.parametrize("kind", [LIDAR, CAMERA])
def test_directions_that_overflow_are_those_of_the_kernels_too(kind):
    rows = np.array([[1e200, 0.0], [np.inf, 0.0], [0.0, 1.0]])
    planes = np.array([[-1e300, 0.0], [0.5, -2.0]])
    compiled = [direction(kind, row, plane) for row in rows for plane in planes]
    assert np.array_equal(
        Lattice(kind, rows, planes).directions(np.arange(6)), np.array(compiled), equal_nan=True
    )
