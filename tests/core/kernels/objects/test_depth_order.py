"""The queue of a frame: whatever comes later is never met first, but within a group."""

from itertools import pairwise

import numpy as np
import pytest

from riglens.core.kernels.objects.depth_order import DepthOrder, line_up, new_depth_order
from riglens.core.rig.model import Camera, Lidar, LinearAngles, Sensor
from riglens.core.targets.beams import beams_of
from riglens.core.targets.contribution import TargetCaster
from riglens.core.targets.traffic import Traffic
from tests.core.targets.brute_force import _directions, _entries
from tests.core.targets.cases import random_traffic, traffic
from tests.core.targets.parts import parts_of

AROUND = Lidar(
    name="L",
    position=(0.3, -0.2, 1.5),
    elevations_deg=LinearAngles(from_=-40.0, to=20.0, count=40),
    azimuths_deg=LinearAngles(from_=-180.0, to=180.0, count=240),
)

AHEAD = Camera(name="C", position=(0.3, -0.2, 1.5), rpy_deg=(4.0, -6.0, 70.0), hfov_deg=40.0, cast=(80, 60))
"""Most boxes are apart from its picture, many of those around its edge."""


def groups_of(
    held: Traffic, frame: int, used: DepthOrder | None = None, sensor: Sensor = AROUND
) -> list[list[int]]:
    boxes = TargetCaster(held)._boxes_of("box")
    depth_order = used or new_depth_order(most_of(held))
    count = line_up(boxes, beams_of(sensor), frame, depth_order)
    begins = np.unique(depth_order.first[:count]).tolist()
    assert depth_order.first[begins].tolist() == begins
    return [depth_order.box[b:e].tolist() for b, e in pairwise([*begins, count])]


def most_of(held: Traffic) -> int:
    return max(1, int(np.diff(held.starts).max()))


@pytest.mark.parametrize(("seed", "sensor"), [(0, AROUND), (1, AROUND), (2, AHEAD), (3, AHEAD)])
def test_no_ray_enters_a_later_group_first(seed, sensor):
    held = random_traffic(np.random.default_rng(seed), 12, 30).within(1e6)
    directions, singles, used = _directions(sensor, 0.0), 0, new_depth_order(most_of(held))
    for frame in range(held.frames):
        first, end = held.starts[frame : frame + 2].tolist()
        parts = parts_of("box", held.cls[first:end], held.size_m[first:end])
        entry, _, _ = _entries(held, slice(first, end), parts, sensor, directions)
        groups, nearest = groups_of(held, frame, used, sensor), np.zeros(len(directions))
        for group in groups:
            mine = entry[:, [box - first for box in group]].min(axis=1)
            assert (mine >= nearest).all(), (frame, group)
            nearest = np.maximum(nearest, np.where(np.isfinite(mine), mine, 0.0))
            assert group == sorted(group)
        singles += sum(len(group) == 1 for group in groups)
        met = {first + box for box in np.flatnonzero(np.isfinite(entry).any(axis=0)).tolist()}
        assert met <= {box for group in groups for box in group}
    assert singles > (50 if sensor is AROUND else 10)


def test_a_long_wall_that_begins_nearer_comes_after_what_stands_before_it():
    """The wall's nearest point is nearer than the car's, but its face keeps the car on the sensor's side."""
    wall = (0, 0, (0.0, 6.0, 1.5), (80.0, 0.4, 3.0), 0.0)
    car = (0, 0, (20.0, 4.5, 0.8), (4.4, 1.8, 1.6), 0.0)
    assert groups_of(traffic([wall, car]), 0) == [[1], [0]]


def test_what_overlaps_is_one_group_in_the_order_of_the_data_and_the_others_are_alone():
    near, far = (0, 0, (5.0, 0.0, 1.0), (1.0, 1.0, 2.0), 0.0), (0, 0, (30.0, 0.0, 1.0), (4.0, 2.0, 2.0), 0.0)
    one, other = ((0, 0, (x, 0.5, 1.0), (4.0, 2.0, 2.0), 0.3) for x in (15.0, 14.0))
    assert groups_of(traffic([far, one, other, near]), 0) == [[3], [1, 2], [0]]


def test_what_cannot_hide_anything_that_counts_is_left_out():
    held = traffic([(0, 0, (x, 0.0, 1.0), (4.0, 2.0, 2.0), 0.0) for x in (10.0, 40.0, 70.0)]).within(50.0)
    assert groups_of(held, 0) == [[0], [1]]
