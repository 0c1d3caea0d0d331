"""Mirror pairs: poses on the other side of the car, edits that reach both, links that survive files and renames."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from riglens.core.errors import InputError
from riglens.core.geometry import Pose
from riglens.core.rig.edits import (
    duplicated,
    in_step,
    linked,
    mirrored_name,
    mirrored_pose,
    nearest_to_image,
    partner_of,
    unlinked,
    with_mirror_image,
    without,
)
from riglens.core.rig.model import Camera, Lidar, LinearAngles, Rig
from riglens.core.rig.yaml.file import dumps, loads, new_rig_file, rig_sha256

metres = st.floats(-5.0, 5.0)
angles = st.floats(-180.0, 180.0)
poses = st.builds(
    lambda x, y, z, roll, pitch, yaw: Pose((x, y, z), (roll, pitch, yaw)),
    metres, metres, metres, angles, angles, angles,
)  # fmt: skip
MIRROR = np.diag([1.0, -1.0, 1.0])
LEFT = Lidar(
    name="left",
    position=(-0.4, 0.8, 2.2),
    rpy_deg=(5.0, 10.0, 30.0),
    elevations_deg=LinearAngles(**{"from": -25.0, "to": 25.0, "count": 16}),
)
RIGHT = LEFT.replace(name="right", position=(1.0, 0.0, 1.0))
CAMERA = Camera(name="front", position=(1.0, 0.0, 1.4), hfov_deg=70.0)
PAIR = linked(Rig(sensors=(LEFT, RIGHT, CAMERA)), "left", "right")


@given(poses)
def test_a_mirrored_pose_is_the_reflection_at_the_middle_plane(pose):
    image = mirrored_pose(pose)
    assert np.allclose(image.position_m, MIRROR @ pose.position_m)
    assert np.allclose(image.rotation(), MIRROR @ pose.rotation() @ MIRROR, atol=1e-12)


@given(poses)
def test_mirroring_twice_gives_the_pose_back(pose):
    assert mirrored_pose(mirrored_pose(pose)) == pose


def test_linking_puts_the_second_sensor_where_the_image_of_the_first_is():
    right = PAIR.sensor("right")
    assert right.pose == mirrored_pose(LEFT.pose)
    assert right.mirror_of == "left" and PAIR.sensor("left").mirror_of is None
    assert (partner_of(PAIR, "left"), partner_of(PAIR, "right"), partner_of(PAIR, "front")) == (
        "right", "left", None,
    )  # fmt: skip


@pytest.mark.parametrize("name", ["left", "right"])
@given(pose=poses)
def test_a_move_of_either_sensor_moves_the_other_to_its_image(name, pose):
    moved = PAIR.with_sensor(name, PAIR.sensor(name).with_pose(pose))
    after = in_step(PAIR, moved)
    assert after.sensor(name).pose == pose
    assert after.sensor(partner_of(PAIR, name)).pose == mirrored_pose(pose)
    assert after.sensor("front") == CAMERA


@pytest.mark.parametrize("name", ["left", "right"])
def test_other_fields_change_on_both_sides_but_names_stay(name):
    edited = PAIR.sensor(name).replace(elevations_deg=(0.0, 1.0), enabled=False)
    after = in_step(PAIR, PAIR.with_sensor(name, edited))
    other = after.sensor(partner_of(PAIR, name))
    assert other.elevations_deg == (0.0, 1.0) and not other.enabled
    assert other.name == partner_of(PAIR, name)


def test_an_edit_of_another_sensor_leaves_a_pair_alone():
    crooked = PAIR.with_sensor("right", PAIR.sensor("right").with_pose(Pose((0.0, 0.0, 9.0))))
    after = crooked.with_sensor("front", CAMERA.replace(hfov_deg=90.0))
    assert in_step(crooked, after) == after


@pytest.mark.parametrize("name", ["left", "right"])
def test_a_renamed_sensor_stays_in_its_pair(name):
    renamed = PAIR.with_sensor(name, PAIR.sensor(name).replace(name="new"))
    after = in_step(PAIR, renamed)
    other = partner_of(PAIR, name)
    assert partner_of(after, "new") == other
    assert after.sensor("new").pose == PAIR.sensor(name).pose
    assert after.sensor(other).pose == PAIR.sensor(other).pose


@pytest.mark.parametrize("name", ["left", "right"])
def test_deleting_one_leaves_the_other_alone_where_it_is(name):
    other = partner_of(PAIR, name)
    after = without(PAIR, (name,))
    assert [sensor.name for sensor in after.sensors] == [other, "front"]
    assert after.sensor(other).mirror_of is None and after.sensor(other).pose == PAIR.sensor(other).pose
    bare = PAIR.model_copy(update={"sensors": tuple(s for s in PAIR.sensors if s.name != name)})
    assert in_step(PAIR, bare).sensor(other).mirror_of is None


@pytest.mark.parametrize("name", ["left", "right"])
def test_unlinked_sensors_move_alone(name):
    alone = unlinked(PAIR, name)
    assert all(sensor.mirror_of is None for sensor in alone.sensors)
    moved = alone.with_sensor(name, alone.sensor(name).with_pose(Pose()))
    assert in_step(alone, moved) == moved


def test_a_pair_survives_a_file_and_an_unlinked_one_loses_the_key():
    file = new_rig_file(PAIR)
    assert loads(file.text).rig == PAIR
    assert file.text.count("mirror_of: left") == 1
    assert "mirror_of" not in file.updated(unlinked(PAIR, "left")).text
    again = new_rig_file(unlinked(PAIR, "left")).updated(PAIR)
    assert loads(again.text).rig == PAIR
    assert rig_sha256(PAIR) != rig_sha256(unlinked(PAIR, "left"))


@pytest.mark.parametrize(
    ("other", "reason"),
    [
        ("nobody", r"must be the name of another sensor .got 'nobody'."),
        ("right", r"must be the name of another sensor .got 'right'."),
        ("front", r"must be a lidar, not a camera .got 'front'."),
    ],
)
def test_a_wrong_partner_is_refused_with_its_line(other, reason):
    text = dumps(PAIR).replace("mirror_of: left", f"mirror_of: {other}")
    line = 1 + text[: text.index("mirror_of")].count("\n")
    with pytest.raises(InputError, match=rf'^rig.yaml:{line}: lidar "right": mirror_of: {reason}$'):
        loads(text)


def test_a_sensor_belongs_to_one_pair_only():
    third = LEFT.replace(name="third", mirror_of="left")
    text = dumps(PAIR)
    with pytest.raises(ValueError, match="another mirror pair"):
        Rig(sensors=(*PAIR.sensors, third))
    with pytest.raises(ValueError, match="another mirror pair"):
        linked(Rig(sensors=(*PAIR.sensors, LEFT.replace(name="third"))), "right", "third")
    assert loads(text).rig == PAIR


NAMES = (
    ("CAM_FL", "CAM_FR"),
    ("CAM_RR", "CAM_RL"),
    ("cam_bl", "cam_br"),
    ("LIDAR_L", "LIDAR_R"),
    ("L2", "R2"),
    ("camFL", "camFR"),
    ("side_r_1", "side_l_1"),
    ("FRONT_LEFT", "FRONT_RIGHT"),
    ("frontRight", "frontLeft"),
    ("left", "right"),
)


@pytest.mark.parametrize(("name", "image"), NAMES)
@pytest.mark.parametrize("y_m", [-0.5, 0.0, 0.5])
def test_the_name_of_an_image_is_that_of_the_other_side(name, image, y_m):
    assert mirrored_name(name, y_m) == image and mirrored_name(image, -y_m) == name


@pytest.mark.parametrize(
    "name", ["roof", "radar", "LIDAR_1", "Solar", "corner", "CAR", "E1R", "VLP", "lr_x", "LRR"]
)
def test_a_name_without_a_side_gets_the_side_of_its_image(name):
    is_upper = name.isupper()
    assert mirrored_name(name, 0.5) == name + ("_RIGHT" if is_upper else "_right")
    assert mirrored_name(name, -0.5) == name + ("_LEFT" if is_upper else "_left")
    assert mirrored_name(name, 0.0) == name


def test_a_copied_pair_is_a_linked_pair_in_place_and_a_copied_half_is_alone():
    rig, names = duplicated(PAIR, ("left", "right", "front"), 0.2)
    assert names == ("left_2", "right_2", "front_2")
    assert partner_of(rig, "left_2") == "right_2" and partner_of(rig, "left") == "right"
    assert [rig.sensor(f"{name}_2").pose for name in ("left", "right")] == [
        rig.sensor(name).pose for name in ("left", "right")
    ]
    assert rig.sensor("front_2").position == (1.0, 0.2, 1.4)
    half, (name,) = duplicated(PAIR, ("right",), 0.2)
    assert partner_of(half, name) is None
    assert half.sensor(name).position[1] == pytest.approx(PAIR.sensor("right").position[1] + 0.2)


def test_a_sensor_on_the_middle_plane_has_no_image() -> None:
    with pytest.raises(ValueError, match="front is on the middle plane"):
        with_mirror_image(Rig(sensors=(CAMERA,)), "front", "back")


def test_only_sensors_of_its_kind_are_offered_as_the_image_of_one() -> None:
    beside = CAMERA.replace(name="camera", position=(-0.4, -0.8, 2.2))
    far = LEFT.replace(name="far", position=(3.0, 3.0, 1.0))
    assert nearest_to_image(Rig(sensors=(LEFT, beside, far)), "left") == "far"
    assert nearest_to_image(Rig(sensors=(LEFT, beside)), "left") is None
