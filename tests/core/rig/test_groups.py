"""Several sensors as one: rigid motion about a centre, alignment, even spacing; mirror pairs stay pairs."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from riglens.core.errors import InputError
from riglens.core.geometry import Pose
from riglens.core.rig.edits import linked
from riglens.core.rig.groups import aligned, carried, centre_m, spaced
from riglens.core.rig.model import Camera, Rig

metres, angles = st.floats(-5.0, 5.0), st.floats(-180.0, 180.0)
poses = st.builds(
    lambda x, y, z, roll, pitch, yaw: Pose((x, y, z), (roll, pitch, yaw)),
    metres, metres, metres, angles, angles, angles,
)  # fmt: skip


def camera(name: str, *position: float) -> Camera:
    x, y, z = position
    return Camera(name=name, position=(x, y, z), rpy_deg=(0.0, 10.0, 30.0), hfov_deg=70.0)


RIG = Rig(sensors=(camera("a", 1.0, 0.6, 1.5), camera("b", 0.1, -0.7, 1.9), camera("c", -2.0, 0.1, 1.0)))
ALL = ("a", "b", "c")


def places(rig: Rig) -> dict[str, tuple[float, float, float]]:
    return {sensor.name: sensor.position for sensor in rig.sensors}


@given(poses, poses, st.lists(poses, min_size=1, max_size=4))
def test_all_move_as_one_rigid_body(before, after, group):
    named = {str(place): pose for place, pose in enumerate(group)}
    moved = carried(named, before, after)
    for name, pose in named.items():
        held = before.inverse().compose(pose)
        assert np.allclose(
            moved[name].vehicle_SE3_sensor(), after.compose(held).vehicle_SE3_sensor(), atol=1e-6
        )


def test_what_a_motion_does_not_touch_keeps_every_bit():
    odd = Pose((0.1 + 0.2, 1 / 3, 2e-17), (1e-17, 2 / 3, -1 / 7))
    lifted = carried({"odd": odd, "other": Pose()}, Pose(), Pose((0.0, 0.0, 0.5)))["odd"]
    assert lifted == Pose((0.1 + 0.2, 1 / 3, 0.5), odd.rpy_deg)
    turned = carried({"odd": odd}, Pose(), Pose((0.0, 0.0, 0.0), (0.0, 0.0, 90.0)))["odd"]
    assert turned.position_m[2] == odd.position_m[2] and turned.rpy_deg[:2] == odd.rpy_deg[:2]
    assert turned.position_m[:2] == (-0.333333333, 0.3)


def test_a_sensor_in_the_frame_itself_takes_its_pose_bit_for_bit():
    after = Pose((1 / 3, 0.1 + 0.2, 2.0), (0.0, 0.0, 1 / 7))
    assert carried({"a": Pose()}, Pose(), after) == {"a": after}


def test_the_centre_stays_while_all_turn_about_it():
    group = {name: RIG.sensor(name).pose for name in ALL}
    middle = Pose(centre_m(pose.position_m for pose in group.values()))
    turned = carried(group, middle, Pose(middle.position_m, (0.0, 0.0, 37.0)))
    assert np.allclose(centre_m(pose.position_m for pose in turned.values()), middle.position_m, atol=1e-8)


ALIGNED = (
    ("left", 1, 0.6),
    ("right", 1, -0.7),
    ("front", 0, 1.0),
    ("rear", 0, -2.0),
    ("centre", 1, 0.0),
    ("height", 2, 1.9),
)


@pytest.mark.parametrize(("how", "axis", "value"), ALIGNED)
def test_alignment_sets_one_coordinate_and_nothing_else(how, axis, value):
    after = aligned(RIG, ALL, how, "b")
    for old, new in zip(RIG.sensors, after.sensors, strict=True):
        position = list(old.position)
        position[axis] = value
        assert new == old.replace(position=tuple(position))


def test_only_those_named_are_aligned():
    assert places(aligned(RIG, ("a", "c"), "left", "a"))["b"] == RIG.sensor("b").position


def test_even_spacing_goes_along_the_longest_side_and_leaves_the_ends():
    after = places(spaced(RIG, ALL))
    assert after == {"a": (1.0, 0.6, 1.5), "b": (-0.5, -0.7, 1.9), "c": (-2.0, 0.1, 1.0)}


def test_even_spacing_of_two_says_what_it_needs():
    with pytest.raises(InputError, match="three or more"):
        spaced(RIG, ("a", "b"))


PAIR = linked(RIG, "a", "b")


@pytest.mark.parametrize("how", ["left", "right"])
def test_a_pair_that_would_have_to_be_on_one_side_is_told_and_stays(how):
    with pytest.raises(InputError, match=r"mirror image moves the other way.*unlink"):
        aligned(PAIR, ALL, how, "a")


def test_a_pair_is_aligned_where_that_is_possible():
    after = aligned(PAIR, ALL, "height", "c")
    assert {position[2] for position in places(after).values()} == {1.0}
    one = aligned(PAIR, ("a", "c"), "left", "a")
    assert places(one)["c"][1] == 0.6 and places(one)["b"][1] == -0.6
