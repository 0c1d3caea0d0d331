"""Data sets, simulators and SLAM settings: poses and lenses against the equations of their own devkits."""

import json
import math
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from riglens.core.errors import InputError
from riglens.core.formats.mounts import ReadOptions
from riglens.core.geometry import Vec3
from riglens.core.rig.model import BrownConrady, Camera, KannalaBrandt, Lidar, LinearAngles, Sensor
from tests.core.formats.cases import SMALL, VEHICLE, Files, optical, read_files, sensor_matrix, transform
from tests.core.formats.test_reports import has

AT_ORIGIN = ReadOptions(vehicle=VEHICLE, origin_m=(0.0, 0.0, 0.0))


def sensors(files: Files, options: ReadOptions = AT_ORIGIN) -> dict[str, Sensor]:
    """Return the sensors of files by name, with the origin of the file as that of the rig."""
    return {sensor.name: sensor for sensor in read_files(files, options=options).rig.sensors}


def changed(files: Files, change: Any) -> Files:
    """Return a JSON file whose document was changed by a function."""
    ((name, text),) = files.items()
    document = json.loads(text)
    change(document)
    return {name: json.dumps(document)}


def test_once_points_of_the_lidar_come_to_the_camera_as_the_devkit_projects_them() -> None:
    found, calib = sensors(SMALL["once"]), json.loads(SMALL["once"]["000027.json"])["calib"]
    ahead_in_velo = np.array([-0.5, -12.0, 0.25, 1.0])  # x left, y backwards: 12 m ahead, 0.5 m to the right
    in_camera = np.linalg.inv(calib["cam01"]["cam_to_velo"]) @ ahead_in_velo
    ours = np.linalg.inv(optical(sensor_matrix(found["cam01"]))) @ [12.0, -0.5, 0.25, 1.0]
    np.testing.assert_allclose(ours, in_camera, atol=1e-12)
    front = found["cam01"]
    assert isinstance(front, Camera) and front.image == (1920, 1020)
    assert front.distortion == BrownConrady(k1=-0.3, k2=0.1, p1=0.001, p2=0.0005, k3=-0.02)


def test_zod_lidar_has_x_to_the_right_and_the_camera_a_fisheye() -> None:
    found, camera = sensors(SMALL["zod"]), json.loads(SMALL["zod"]["calibration.json"])["FC"]
    ahead = camera["lidar_extrinsics"] @ np.array([0.0, 10.0, 0.0, 1.0])  # y of the LiDAR is forward
    np.testing.assert_allclose(sensor_matrix(found["lidar_velodyne"]) @ [10, 0, 0, 1], ahead, atol=1e-12)
    front = found["FC"]
    assert isinstance(front, Camera) and front.distortion == KannalaBrandt(
        k1=-0.05, k2=0.01, k3=-0.002, k4=0.0005
    )
    np.testing.assert_allclose(optical(sensor_matrix(front)), camera["extrinsics"], atol=1e-12)


@pytest.mark.parametrize(("fisheye", "kind"), [(0, BrownConrady), (1, KannalaBrandt), (3, type(None))])
def test_ddad_lens_follows_the_flag_of_its_model(fisheye: int, kind: type) -> None:
    def bent(document: Any) -> None:
        document["intrinsics"][1] |= {"fisheye": fisheye, "k1": -0.05, "k2": 0.01}

    read = read_files(changed(SMALL["ddad"], bent), options=AT_ORIGIN)
    (camera,) = read.rig.sensors
    assert isinstance(camera, Camera) and isinstance(camera.distortion, kind)
    assert has(read.report, "ignored", "where their LiDARs are is not in the file", "(LIDAR)")
    assert has(read.report, "ignored", "fisheye = 3") == (fisheye == 3)


def test_a_lidar_of_dgp_with_a_place_is_kept() -> None:
    def placed(document: Any) -> None:
        document["extrinsics"][0]["translation"] = {"x": 1.5, "z": 2.0}

    assert sensors(changed(SMALL["ddad"], placed))["LIDAR"].position == (1.5, 0.0, 2.0)


def test_dair_takes_the_frame_that_is_named() -> None:
    def at(frame: str, shift: float) -> Files:
        moved = SMALL["dair-v2x"]["calib/lidar_to_camera/000000.json"].replace("-0.75", f"{shift}")
        return {
            name.replace("000000", frame): moved if "lidar" in name else SMALL["dair-v2x"][name]
            for name in SMALL["dair-v2x"]
        }

    both = {**SMALL["dair-v2x"], **at("000007", -0.5)}
    assert sensors(both)["camera"].position == pytest.approx((0.75, 0.1, -0.3))
    named = ReadOptions(vehicle=VEHICLE, origin_m=(0.0, 0.0, 0.0), token="000007")
    assert sensors(both, named)["camera"].position == pytest.approx((0.5, 0.1, -0.3))
    with pytest.raises(InputError, match="frame '8' is missing"):
        sensors(both, ReadOptions(token="8"))


def carla_matrix(pose: list[float]) -> Any:
    """Return the transform of OpenCOOD's x_to_world, in CARLA's left-handed axes."""
    x, y, z, *angles = pose
    r, w, p = np.radians(angles)
    sr, cr, sw, cw, sp, cp = (f(angle) for angle in (r, w, p) for f in (math.sin, math.cos))
    return np.array(
        [
            [cp * cw, cw * sp * sr - sw * cr, -cw * sp * cr - sw * sr, x],
            [sw * cp, sw * sp * sr + cw * cr, -sw * sp * cr + cw * sr, y],
            [sp, -cp * sr, cp * cr, z],
            [0.0, 0.0, 0.0, 1.0],
        ]
    )


def test_opv2v_poses_are_those_of_carla_mirrored() -> None:
    cords, ego = [141.35, -388.64, 1.04, 3.0, 170.0, 7.0], [143.85, -388.75, 0.1, -2.0, 174.0, 1.5]
    text = SMALL["opv2v"]["000069.yaml"].replace("[141.35, -388.75, 1.0, 0.0, 180.0, 0.0]", str(cords))
    text = text.replace("[143.85, -388.75, 0.0, 0.0, 180.0, 0.0]", str(ego))
    mirror = np.diag([1.0, -1.0, 1.0, 1.0])
    expected = mirror @ np.linalg.inv(carla_matrix(ego)) @ carla_matrix(cords) @ mirror
    np.testing.assert_allclose(sensor_matrix(sensors({"a.yaml": text})["camera0"]), expected, atol=1e-9)


def unity_matrix(pitch: float, yaw: float, roll: float) -> Any:
    """Return Unity's rotation of these angles, left-handed: about z (roll), then x (pitch), then y (yaw)."""
    p, w, r = np.radians([pitch, yaw, roll])
    about_z = np.array([[math.cos(r), -math.sin(r), 0], [math.sin(r), math.cos(r), 0], [0, 0, 1]])
    about_x = np.array([[1, 0, 0], [0, math.cos(p), -math.sin(p)], [0, math.sin(p), math.cos(p)]])
    about_y = np.array([[math.cos(w), 0, math.sin(w)], [0, 1, 0], [-math.sin(w), 0, math.cos(w)]])
    return about_y @ about_x @ about_z


def test_lgsvl_poses_are_those_of_unity() -> None:
    camera = sensors(SMALL["lgsvl"])["Right Camera"]
    from_unity = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])  # x right, y up, z forward
    turned = from_unity @ unity_matrix(10.0, 30.0, 5.0) @ from_unity.T
    np.testing.assert_allclose(
        sensor_matrix(camera), transform(Rotation.from_matrix(turned), (0.2, -0.5, 1.7)), atol=1e-12
    )
    assert isinstance(camera, Camera) and camera.hfov_deg is not None
    assert math.tan(math.radians(camera.hfov_deg / 2)) * 9 / 16 == pytest.approx(math.tan(math.radians(25)))


def test_lgsvl_beams_lie_about_the_centre_angle_below_the_horizon() -> None:
    lidar = sensors(SMALL["lgsvl"])["Lidar"]
    assert isinstance(lidar, Lidar) and lidar.range_m == (0.5, 100.0) and lidar.azimuths().size == 360
    assert lidar.elevations_deg == LinearAngles(from_=-30.665, to=10.665, count=32)

    def listed(document: Any) -> None:
        document[1]["params"]["VerticalRayAngles"] = [2.0, -15.639, -25.0]

    listed_one = sensors(changed(SMALL["lgsvl"], listed))["Lidar"]
    assert isinstance(listed_one, Lidar) and listed_one.elevations_deg == (-25.0, -15.639, 2.0)


def test_lgsvl_lidars_of_a_type_are_those_of_velodyne() -> None:
    def of_type(said: str) -> Any:
        return lambda document: document[1]["params"].update(VelodyneLidarType=said)

    known = read_files(changed(SMALL["lgsvl"], of_type("VLP_16")))
    assert has(known.report, "read", "the library model velodyne-vlp-16", "(Lidar)")
    unknown = read_files(changed(SMALL["lgsvl"], of_type("X_9")))
    assert has(unknown.report, "approximated", "unknown to the library (Velodyne X_9)", "(Lidar)")


def test_orb_slam_cameras_stand_as_its_matrices_say() -> None:
    found = sensors(SMALL["orb-slam3"])
    first, second = (optical(sensor_matrix(found[name])) for name in ("camera1", "camera2"))
    between: Any = np.linalg.inv(first) @ second
    assert between[:3, 3] == pytest.approx(
        (0.101063427414194, 0.001946204678584, 0.001015350132563), abs=1e-6
    )
    assert first[:3, 3] == pytest.approx((0.045574835649698, -0.071161801837997, -0.044681254117144))
    camera = found["camera2"]
    assert isinstance(camera, Camera) and isinstance(camera.distortion, KannalaBrandt)
    assert (camera.image, camera.fx, camera.distortion.k3) == (
        (512, 512),
        190.44236969414825,
        -0.00266312569781606,
    )


def test_lvi_sam_groups_its_parameters_by_its_own_name() -> None:
    text = SMALL["lio-sam"]["params.yaml"].replace("lio_sam:", "lvi_sam:").replace("  sensor: velodyne\n", "")
    (lidar,) = sensors({"params_lidar.yaml": f'PROJECT_NAME: "lvi_sam"\n{text}'}).values()
    assert isinstance(lidar, Lidar) and lidar.name == "velodyne"


def test_the_sensors_of_r3live_stand_around_its_imu() -> None:
    """The camera as in its configuration, with the offset given there in a comment; the LiDAR as the program has it."""
    found = sensors(SMALL["r3live"])
    camera, lidar = found["camera"], found["lidar"]
    between = np.array(camera.position) - np.array(lidar.position)
    assert between == pytest.approx((0.050166 - 0.04165, 0.0474116 - 0.02326, -0.0312415 + 0.0284))
    assert camera.rpy_deg == pytest.approx((0.0, 0.9, 0.0), abs=0.2) and lidar.rpy_deg == (0.0, 0.0, 0.0)
    assert isinstance(lidar, Lidar) and lidar.model == "livox-avia"
    assert isinstance(camera, Camera) and (camera.image, camera.fx) == ((1280, 1024), 863.4241)


RECTIFIED = """\
%YAML:1.0
Camera.type: "Rectified"
Camera1.fx: 718.856
Camera1.fy: 718.856
Camera1.cx: 607.1928
Camera1.cy: 185.2157
Camera.width: 1241
Camera.height: 376
"""


@pytest.mark.parametrize(
    ("more", "apart"),
    [
        ("Stereo.b: 0.53716\n", 0.53716),
        ("Camera1.bf: 386.1448\n", 386.1448 / 718.856),
        ("", None),
        ("Camera1.bf: 40.0\nRGBD.DepthMapFactor: 5000.0\n", None),  # a depth camera
    ],
)
def test_orb_slam_pairs_have_their_base_line(more: str, apart: float | None) -> None:
    found = sensors({"KITTI00-02.yaml": RECTIFIED + more})
    assert found["camera1"].position == (0.0, 0.0, 0.0) and found["camera1"].rpy_deg == (0.0, 0.0, 0.0)
    assert ("camera2" in found) == (apart is not None)
    if apart is not None:
        assert found["camera2"].position == pytest.approx((0.0, -apart, 0.0), abs=1e-11)


@pytest.mark.parametrize("kind", ["velodyne", "strange"])
@pytest.mark.parametrize("form", ["ros1", "ros2"])
def test_lio_sam_names_what_it_takes_the_lidar_for(kind: str, form: str) -> None:
    text = SMALL["lio-sam"]["params.yaml"].replace("sensor: velodyne", f"sensor: {kind}")
    if form == "ros2":
        text = "/**:\n  ros__parameters:\n" + "".join(f"  {line}\n" for line in text.splitlines()[1:])
    read = read_files({"params.yaml": text})
    (lidar,) = read.rig.sensors
    assert isinstance(lidar, Lidar) and lidar.model == (
        "velodyne-vlp-16" if kind == "velodyne" else "generic-16"
    )
    assert has(read.report, "approximated", kind) and has(read.report, "ignored", "IMU")


def test_vlcal_pose_takes_points_of_the_camera_to_the_lidar() -> None:
    x, y, z, *xyzw = json.loads(SMALL["vlcal"]["calib.json"])["results"]["T_lidar_camera"]
    position: Vec3 = (x, y, z)
    expected = transform(Rotation.from_quat(xyzw), position)
    np.testing.assert_allclose(optical(sensor_matrix(sensors(SMALL["vlcal"])["camera"])), expected, atol=1e-9)


@pytest.mark.parametrize(
    ("model", "numbers", "lens"),
    [
        ("fisheye", [0.1, 0.0, 0.0, 0.0], KannalaBrandt),
        ("omnidir", [0.0, 0.0, 0.0, 0.0], KannalaBrandt),
        ("atan", [0.9], type(None)),
    ],
)
def test_vlcal_lenses(model: str, numbers: list[float], lens: type) -> None:
    def other(document: Any) -> None:
        document["camera"] |= {"camera_model": model, "distortion_coeffs": numbers}
        document["camera"]["intrinsics"] += [1.2] if model == "omnidir" else []

    camera = sensors(changed(SMALL["vlcal"], other))["camera"]
    assert isinstance(camera, Camera) and isinstance(camera.distortion, lens)


def test_vlcal_panoramas_are_refused_and_first_guesses_told() -> None:
    def panorama(document: Any) -> None:
        document["camera"] |= {"camera_model": "equirectangular", "intrinsics": [1920, 960]}

    with pytest.raises(InputError, match="camera_model: must be plumb_bob"):
        read_files(changed(SMALL["vlcal"], panorama))

    def guessed(document: Any) -> None:
        document["results"] = {"init_T_lidar_camera_auto": document["results"]["T_lidar_camera"]}

    assert has(read_files(changed(SMALL["vlcal"], guessed)).report, "approximated", "first guess", "(camera)")
