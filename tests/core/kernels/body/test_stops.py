"""Stops of a picture's rays in words, and ends outside of an empty box: as numpy says, ray by ray."""

import numpy as np
import pytest

from riglens.core.kernels.body.empty_box import finite_ends, stop_rays
from riglens.core.kernels.body.stops import set_stops
from riglens.core.sensing.body_ends import rays_in_metres
from riglens.core.sensing.rays import sensor_rays
from tests.core.builders import camera


@pytest.mark.parametrize("is_turned", [False, True])
def test_bits_and_last_ends_are_those_of_each_ray(is_turned: bool) -> None:
    rng, rows, columns = np.random.default_rng(3), 5, 150
    ends = rng.choice([0.0, 1.5, 7.0, np.inf], rows * columns, p=[0.2, 0.2, 0.1, 0.5])
    row_of, column_of = rng.permutation(rows), rng.permutation(columns)
    steps = np.array([1, rows] if is_turned else [columns, 1])
    bits, last_ends = np.zeros((2, rows * 3), np.uint64), np.zeros(rows * 3)
    set_stops(ends, row_of, column_of, steps, bits, last_ends)
    for row in range(rows):
        for word in range(3):
            slots = range(64 * word, min(64 * (word + 1), columns))
            mine = np.array([ends[row_of[row] * steps[0] + column_of[slot] * steps[1]] for slot in slots])
            found = [int(bits[which, 3 * row + word]) for which in (0, 1)]
            for place in range(64):
                end = mine[place] if place < len(mine) else np.inf
                assert [bit >> place & 1 for bit in found] == [end < np.inf, end == 0.0]
            assert last_ends[3 * row + word] == max(mine[np.isfinite(mine)], default=0.0)


def test_ends_in_the_empty_box_are_told_from_those_outside() -> None:
    sensor = camera((0.3, -0.2, 1.4))
    rng, count = np.random.default_rng(4), sensor.ray_count
    ends = np.where(rng.random(count) < 0.5, rng.uniform(0.0, 4.0, count), np.inf)
    cut, cut_m = finite_ends(ends)
    np.testing.assert_array_equal(cut, np.flatnonzero(ends < np.inf))
    np.testing.assert_array_equal(cut_m, ends[cut])
    box, no_box = np.array([-1.0, -1.0, 0.5, 2.0, 1.0, 1.8]), np.array([1.0, 1.0, 1.0, -1.0, -1.0, -1.0])
    places = np.array(sensor.position) + sensor_rays(sensor, cut).directions * cut_m[:, None]
    is_inside = ((box[:3] <= places) & (places <= box[3:])).all(axis=1)
    assert 0 < is_inside.sum() < cut.size
    for empty_box, outside in ((box, ~is_inside), (no_box, np.ones(cut.size, np.bool_))):
        is_stopped = np.zeros(count, np.bool_)
        found, found_m = stop_rays(rays_in_metres(sensor), cut, cut_m, empty_box, is_stopped)
        np.testing.assert_array_equal(is_stopped, ends < np.inf)
        np.testing.assert_array_equal(found, cut[outside])
        np.testing.assert_array_equal(found_m, cut_m[outside])
