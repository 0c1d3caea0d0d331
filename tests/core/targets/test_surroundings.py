"""What stands around hides road users and is none."""

import numpy as np
import pytest

from riglens.core.errors import InputError
from riglens.core.scene.boxes import rotations_from_yaw
from riglens.core.scene.occluders import Map, MapPose, Occluders
from riglens.core.targets.engine import TargetEngine
from riglens.core.targets.settings import EXACT
from riglens.core.targets.traffic import Standing, Traffic, read_traffic, traffic_of
from tests.core.builders import Boxes
from tests.core.targets.cases import random_rig, random_traffic


def in_order(traffic: Traffic) -> np.ndarray:
    """Boxes in the order of the data."""
    return np.argsort(traffic.row, kind="stable")


def with_standing(traffic: Traffic, rng: np.random.Generator, number: int) -> tuple[Traffic, Traffic]:
    """The same road users among things that stand still, and among as many road users of the same boxes."""
    frame = np.sort(rng.integers(0, traffic.frames, number))
    centre = rng.uniform([-30.0, -20.0, 0.0], [30.0, 20.0, 3.0], (number, 3))
    size = rng.uniform([0.2, 0.2, 1.0], [14.0, 8.0, 9.0], (number, 3))
    turn = rotations_from_yaw(rng.uniform(-3, 3, number))
    order = in_order(traffic)
    held = traffic.frame[traffic.frame_of_box[order]]
    road = (traffic.cls[order], traffic.centre_m[order], traffic.size_m[order], traffic.rotation[order])
    standing = Standing(frame, np.arange(number), centre, size, turn)
    blocked = traffic_of(traffic.data, held, *road, standing)
    merged = np.argsort(np.concatenate([held, frame]), kind="stable")
    parts = zip(road, (np.zeros(number, np.uint8), centre, size, turn), strict=True)
    everything = [np.concatenate(pair)[merged] for pair in parts]
    return blocked, traffic_of(traffic.data, np.concatenate([held, frame])[merged], *everything)


@pytest.mark.parametrize("seed", range(6))
def test_they_hide_as_road_users_do_and_do_not_count(seed: int) -> None:
    rng = np.random.default_rng(seed)
    traffic, rig = random_traffic(rng, 12), random_rig(rng, 6)
    blocked, everything = with_standing(traffic, rng, 150)
    found = TargetEngine(blocked.within(1e3)).evaluate(rig, EXACT).objects
    among = TargetEngine(everything.within(1e3)).evaluate(rig, EXACT).objects
    plain = TargetEngine(traffic.within(1e3)).evaluate(rig, EXACT).objects
    assert found.box.size == plain.box.size == among.box.size - 150
    place = {tuple(centre): k for k, centre in enumerate(everything.centre_m[among.box].tolist())}
    same = [place[tuple(centre)] for centre in blocked.centre_m[found.box].tolist()]
    for name in ("points", "pixels", "points_alone", "pixels_alone", "cells", "height_px"):
        np.testing.assert_array_equal(getattr(found, name), getattr(among, name)[same], err_msg=name)
    assert (found.points <= plain.points).all() and (found.pixels <= plain.pixels).all()
    assert found.points.sum() + found.pixels.sum() < plain.points.sum() + plain.pixels.sum()
    np.testing.assert_array_equal(found.points_alone, plain.points_alone)


def test_none_of_them_changes_nothing() -> None:
    rng = np.random.default_rng(9)
    traffic, rig = random_traffic(rng, 10), random_rig(rng)
    blocked, _ = with_standing(traffic, rng, 0)
    for a, b in zip(
        vars(TargetEngine(traffic).evaluate(rig).objects).items(),
        vars(TargetEngine(blocked).evaluate(rig).objects).items(),
        strict=True,
    ):
        assert a[0] == b[0]
        np.testing.assert_array_equal(a[1], b[1])


def test_frames_without_names_cannot_have_surroundings() -> None:
    boxes = Boxes(
        np.zeros(1, np.int64), np.zeros(1, np.uint8), np.zeros((1, 3)), np.ones((1, 3)), np.eye(3)[None], 1
    )
    wall = Map.of(np.zeros(1, np.int64), np.zeros((1, 3)), np.ones((1, 3)), np.zeros(1))
    occluders = Occluders("poses.csv", ["wall"], {"m": wall}, {("s", 0): MapPose("m", (0.0, 0.0, 0.0), 0.0)})
    with pytest.raises(InputError, match="needs columns seq and frame"):
        read_traffic(boxes, occluders=occluders)
