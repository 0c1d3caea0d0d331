"""Poses go into every format as its convention means them, to 1e-9 m and 1e-9 rad.

The files are read here by the standard library and turned into matrices by SciPy, not by the product.
"""

import json
import math
import tomllib
import xml.etree.ElementTree as ElementTree
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from ruamel.yaml import YAML
from scipy.spatial.transform import Rotation

from riglens.core.formats.osi import WHEEL_RADIUS_M
from tests.core.formats.cases import (
    OPTICAL_IN_BODY,
    POSES,
    VEHICLE,
    Matrix,
    Pose,
    assert_same_pose,
    camera,
    lidar,
    optical,
    pose_matrix,
    rig_of,
    rotation,
    transform,
    written,
)
from tests.core.formats.test_poses_read import unreal

REAR_AXLE = transform(Rotation.identity(), (VEHICLE.rear_axle_x, 0.0, 0.0))


def from_rpy_rad(position: Any, rpy_rad: Any) -> Matrix:
    return transform(Rotation.from_euler("xyz", rpy_rad), position)


@settings(max_examples=25)
@given(POSES, POSES)
def test_nuscenes(one: Pose, other: Pose) -> None:
    files = written("nuscenes", rig_of(camera("CAM_FRONT", one), lidar("LIDAR_TOP", other)))
    channels = {row["token"]: row["channel"] for row in json.loads(files["sensor.json"])}
    for row in json.loads(files["calibrated_sensor.json"]):
        w, x, y, z = row["rotation"]
        found = REAR_AXLE @ transform(Rotation.from_quat([x, y, z, w]), row["translation"])
        is_camera = channels[row["sensor_token"]] == "CAM_FRONT"
        assert_same_pose(found, optical(pose_matrix(one)) if is_camera else pose_matrix(other))
        assert w >= 0.0 and math.hypot(w, x, y, z) == pytest.approx(1.0, abs=1e-14)
        assert bool(row["camera_intrinsic"]) == is_camera


@settings(max_examples=25)
@given(POSES, POSES)
def test_autoware(one: Pose, other: Pose) -> None:
    files = written("autoware", rig_of(camera("left", one), lidar("top", other)))
    base, kit = (
        YAML(typ="safe").load(files[f"{name}_calibration.yaml"]) for name in ("sensors", "sensor_kit")
    )

    def matrix(value: dict[str, float]) -> Matrix:
        return from_rpy_rad([value[key] for key in "xyz"], [value[key] for key in ("roll", "pitch", "yaw")])

    rack = REAR_AXLE @ matrix(base["base_link"]["sensor_kit_base_link"])
    sensors = kit["sensor_kit_base_link"]
    assert_same_pose(rack @ matrix(sensors["left/camera_link"]), pose_matrix(one))
    assert_same_pose(rack @ matrix(sensors["top/lidar_link"]), pose_matrix(other))


@settings(max_examples=25)
@given(POSES, POSES)
def test_urdf(one: Pose, other: Pose) -> None:
    (text,) = written("urdf", rig_of(camera("left", one), lidar("top", other))).values()
    frames = {"base_link": REAR_AXLE}
    for joint in ElementTree.fromstring(text).iter("joint"):
        parent, child, origin = (joint.find(tag) for tag in ("parent", "child", "origin"))
        assert parent is not None and child is not None and origin is not None
        xyz, rpy = ([float(word) for word in origin.attrib[key].split()] for key in ("xyz", "rpy"))
        frames[child.attrib["link"]] = frames[parent.attrib["link"]] @ from_rpy_rad(xyz, rpy)
    assert_same_pose(frames["left_link"], pose_matrix(one))
    assert_same_pose(frames["left_optical_frame"], optical(pose_matrix(one)))
    assert_same_pose(frames["top_link"], pose_matrix(other))


@settings(max_examples=25)
@given(POSES, POSES)
def test_carla_objects(one: Pose, other: Pose) -> None:
    (text,) = written("carla", rig_of(camera("left", one), lidar("top", other))).values()
    (vehicle,) = json.loads(text)["objects"]
    for sensor, pose in zip(vehicle["sensors"], (one, other), strict=True):
        spawn = sensor["spawn_point"]
        rpy = (spawn["roll"], spawn["pitch"], spawn["yaw"])
        assert_same_pose(transform(rotation(rpy), [spawn[key] for key in "xyz"]), pose_matrix(pose))


@settings(max_examples=25)
@given(POSES, POSES)
def test_carla_toml(one: Pose, other: Pose) -> None:
    upright = (other[0], (*other[1][:2], 0.0))
    (text,) = written("carla-toml", rig_of(camera("CAM", one), lidar("top", upright))).values()
    document = tomllib.loads(text)
    cameras, lidars = document["camera"], document["lidar"]
    mirror = np.diag([1.0, -1.0, 1.0])
    place = [lidars[key][0][0] for key in "xyz"]
    roll, pitch = (lidars[key][0][0] for key in ("roll", "pitch"))
    for position, rpy, pose in (
        (cameras["T_CAM"], cameras["R_CAM"], one),
        (place, (roll, pitch, 0.0), upright),
    ):
        found = np.eye(4)
        found[:3, :3] = mirror @ unreal(*rpy) @ mirror
        found[:3, 3] = mirror @ position
        expected = pose_matrix(pose)
        if pose is upright:  # at pitch +-90 degrees roll and yaw are one; the file has no yaw
            expected = expected if abs(pitch) < 89.99 else found
        assert_same_pose(found, expected)


@settings(max_examples=25)
@given(POSES, POSES)
def test_driveworks(one: Pose, other: Pose) -> None:
    (text,) = written("driveworks", rig_of(camera("left", one), lidar("top", other))).values()
    rig = json.loads(text)["rig"]
    for sensor, pose in zip(rig["sensors"], (one, other), strict=True):
        nominal = sensor["nominalSensor2Rig_FLU"]
        found = REAR_AXLE @ transform(rotation(nominal["roll-pitch-yaw"]), nominal["t"])
        assert_same_pose(found, pose_matrix(pose))
    size = rig["vehicle"]["value"]
    assert size["bumperRear"] == pytest.approx(size["length"] / 2 + VEHICLE.rear_axle_x)


@settings(max_examples=25)
@given(POSES, POSES)
def test_osi(one: Pose, other: Pose) -> None:
    """The origin is the rear axle itself; orientation turns by yaw, then pitch, then roll (OSI, Orientation3d)."""
    (text,) = written("osi", rig_of(camera("left", one), lidar("top", other))).values()
    axle = transform(Rotation.identity(), (VEHICLE.rear_axle_x, 0.0, WHEEL_RADIUS_M))
    document = json.loads(text)
    assert document["sensor_names"] == {"1": "left", "2": "top"}
    for message, pose in zip(document["sensor_view_configuration"], (one, other), strict=True):
        mounting = message["mounting_position"]
        turn = Rotation.from_euler("ZYX", [mounting["orientation"][key] for key in ("yaw", "pitch", "roll")])
        found = axle @ transform(turn, [mounting["position"][key] for key in "xyz"])
        assert_same_pose(found, pose_matrix(pose))


def test_osi_says_what_a_sensor_sees_in_the_fields_of_its_protobuf() -> None:
    pose = ((0.0, 0.0, 2.0), (0.0, 0.0, 0.0))
    rig = rig_of(camera("left", pose, range_m=(0.0, 80.0)), lidar("top", pose))
    (text,) = written("osi", rig).values()
    one, other = json.loads(text)["sensor_view_configuration"]
    assert one["sensor_id"] == {"value": 1} and one["range"] == 80.0 and "range" not in other
    (view,) = one["camera_sensor_view_configuration"]
    assert view["field_of_view_horizontal"] == pytest.approx(math.radians(80.0))
    assert (view["number_of_pixels_horizontal"], view["number_of_pixels_vertical"]) == (800, 600)
    (view,) = other["lidar_sensor_view_configuration"]
    assert view["field_of_view_horizontal"] == pytest.approx(2.0 * math.pi)
    assert view["field_of_view_vertical"] == pytest.approx(math.radians(30.0))
    assert (view["number_of_rays_horizontal"], view["number_of_rays_vertical"]) == (360, 8)


def test_the_optical_axes_of_these_tests_are_those_of_rep_103() -> None:
    right, down, forward = OPTICAL_IN_BODY.as_matrix().T
    assert right.tolist() == [0, -1, 0] and down.tolist() == [0, 0, -1] and forward.tolist() == [1, 0, 0]
