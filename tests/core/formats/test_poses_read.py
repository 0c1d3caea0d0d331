"""Poses come out of every format as its convention means them, to 1e-9 m and 1e-9 rad.

What is expected is computed by SciPy from the published convention, never by the product's own conversions.
"""

import json
import math

import numpy as np
from hypothesis import given, settings
from scipy.spatial.transform import Rotation

from riglens.core.formats.mounts import ReadOptions
from tests.core.formats.cases import (
    POSES,
    VEHICLE,
    Matrix,
    Pose,
    assert_same_pose,
    optical,
    pose_matrix,
    read_files,
    rotation,
    sensor_matrix,
    transform,
)

K = [[1266.4, 0.0, 816.3], [0.0, 1266.4, 491.5], [0.0, 0.0, 1.0]]
ON_VEHICLE = ReadOptions(vehicle=VEHICLE)
AT_ORIGIN = ReadOptions(vehicle=VEHICLE, origin_m=(0.0, 0.0, 0.0))
REAR_AXLE = transform(Rotation.identity(), (-1.4, 0.0, 0.0))
"""Where the rear axle of the test vehicle is; the origin of most formats."""


def rows(matrix: Matrix) -> str:
    """A matrix as YAML."""
    return json.dumps([[float(value) for value in row] for row in matrix])


@settings(max_examples=25)
@given(POSES, POSES)
def test_nuscenes_cameras_are_optical_and_quaternions_start_with_w(one: Pose, other: Pose) -> None:
    def row(token: str, matrix: Matrix, intrinsic: object) -> dict[str, object]:
        x, y, z, w = Rotation.from_matrix(matrix[:3, :3]).as_quat()
        place = {"translation": matrix[:3, 3].tolist(), "rotation": [w, x, y, z]}
        return {"token": token, "sensor_token": token, **place, "camera_intrinsic": intrinsic}

    sensors = [
        {"token": "c", "channel": "CAM", "modality": "camera"},
        {"token": "l", "channel": "LIDAR", "modality": "lidar"},
    ]
    table = [row("c", optical(pose_matrix(one)), K), row("l", pose_matrix(other), [])]
    files = {"sensor.json": json.dumps(sensors), "calibrated_sensor.json": json.dumps(table)}
    camera, lidar = read_files(files, options=ON_VEHICLE).rig.sensors
    assert_same_pose(sensor_matrix(camera), REAR_AXLE @ pose_matrix(one))
    assert_same_pose(sensor_matrix(lidar), REAR_AXLE @ pose_matrix(other))


@settings(max_examples=25)
@given(POSES, POSES, POSES)
def test_autoware_chains_frames_in_radians(kit: Pose, one: Pose, other: Pose) -> None:
    def said(pose: Pose) -> str:
        values = (*pose[0], *(math.radians(angle) for angle in pose[1]))
        return json.dumps(dict(zip(("x", "y", "z", "roll", "pitch", "yaw"), values, strict=True)))

    files = {
        "sensors_calibration.yaml": f"base_link:\n  sensor_kit_base_link: {said(kit)}\n",
        "sensor_kit_calibration.yaml": "sensor_kit_base_link:\n"
        f"  camera0/camera_link: {said(one)}\n  camera1/camera_optical_link: {said(other)}\n",
    }
    camera, lens = read_files(files, options=ON_VEHICLE).rig.sensors
    assert_same_pose(sensor_matrix(camera), REAR_AXLE @ pose_matrix(kit) @ pose_matrix(one))
    assert_same_pose(optical(sensor_matrix(lens)), REAR_AXLE @ pose_matrix(kit) @ pose_matrix(other))


@settings(max_examples=25)
@given(POSES, POSES, POSES)
def test_urdf_chains_joints_and_knows_optical_frames(base: Pose, mount: Pose, sensor: Pose) -> None:
    def joint(parent: str, child: str, pose: Pose) -> str:
        xyz = " ".join(repr(part) for part in pose[0])
        rpy = " ".join(repr(math.radians(angle)) for angle in pose[1])
        ends = f'<parent link="{parent}"/><child link="{child}"/>'
        return f'<joint name="{child}" type="fixed">{ends}<origin xyz="{xyz}" rpy="{rpy}"/></joint>'

    links = "".join(
        f'<link name="{name}"/>' for name in ("map", "base_link", "rack", "lidar", "cam_optical_frame")
    )
    joints = joint("map", "base_link", base) + joint("base_link", "rack", mount)
    joints += joint("rack", "lidar", sensor) + joint("rack", "cam_optical_frame", sensor)
    imported = read_files({"a.urdf": f'<robot name="r">{links}{joints}</robot>'}, options=ON_VEHICLE)
    expected = REAR_AXLE @ pose_matrix(mount) @ pose_matrix(sensor)
    assert_same_pose(sensor_matrix(imported.rig.sensor("lidar")), expected)
    assert_same_pose(optical(sensor_matrix(imported.rig.sensor("cam"))), expected)


@settings(max_examples=25)
@given(POSES)
def test_carla_objects_json_is_in_ros_axes_and_degrees(pose: Pose) -> None:
    spawn = dict(zip(("x", "y", "z", "roll", "pitch", "yaw"), (*pose[0], *pose[1]), strict=True))
    sensor = {"type": "sensor.camera.rgb", "id": "c", "spawn_point": spawn}
    document = {"objects": [{"type": "vehicle.a", "id": "ego", "sensors": [sensor]}]}
    (camera,) = read_files({"objects.json": json.dumps(document)}, options=ON_VEHICLE).rig.sensors
    assert_same_pose(sensor_matrix(camera), pose_matrix(pose))


def unreal(roll_deg: float, pitch_deg: float, yaw_deg: float) -> Matrix:
    """CARLA's own rotation matrix (carla.Transform.get_matrix): left-handed, y to the right, columns F R U."""
    r, p, y = (math.radians(angle) for angle in (roll_deg, pitch_deg, yaw_deg))
    cr, sr, cp, sp, cy, sy = math.cos(r), math.sin(r), math.cos(p), math.sin(p), math.cos(y), math.sin(y)
    return np.array(
        [
            [cp * cy, cy * sp * sr - sy * cr, -cy * sp * cr - sy * sr],
            [cp * sy, sy * sp * sr + cy * cr, -sy * sp * cr + cy * sr],
            [sp, -cp * sr, cp * cr],
        ]
    )


@settings(max_examples=25)
@given(POSES)
def test_carla_toml_is_left_handed(pose: Pose) -> None:
    (x, y, z), (roll, pitch, yaw) = pose
    lidar = "\n".join(
        (
            f"x = [{x!r}]\ny = [{y!r}]\nz = [{z!r}]",
            f"roll = [{math.radians(roll)!r}]\npitch = [{math.radians(pitch)!r}]",
            "channels = 16\nlower_fov = -25\nupper_fov = 5",
        )
    )
    camera = f"T_CAM = [{x!r}, {y!r}, {z!r}]\nR_CAM = [{roll!r}, {pitch!r}, {yaw!r}]\nFOV_CAM = 70"
    rig = read_files({"a.toml": f"[lidar]\n{lidar}\n[camera]\n{camera}\n"}, options=ON_VEHICLE).rig
    mirror = np.diag([1.0, -1.0, 1.0])
    for name, turn in (("lidar_0", unreal(roll, pitch, 0.0)), ("CAM", unreal(roll, pitch, yaw))):
        expected = np.eye(4)
        expected[:3, :3] = mirror @ turn @ mirror
        expected[:3, 3] = (x, -y, z)
        assert_same_pose(sensor_matrix(rig.sensor(name)), expected)


@settings(max_examples=25)
@given(POSES, POSES)
def test_driveworks_applies_corrections_to_the_nominal_pose(nominal: Pose, correction: Pose) -> None:
    sensor = {
        "name": "lidar",
        "protocol": "lidar.virtual",
        "nominalSensor2Rig_FLU": {"roll-pitch-yaw": nominal[1], "t": nominal[0]},
        "correction_sensor_R_FLU": {"roll-pitch-yaw": correction[1]},
        "correction_rig_T": correction[0],
    }
    files = {"rig.json": json.dumps({"rig": {"sensors": [sensor]}})}
    (lidar,) = read_files(files, options=ON_VEHICLE).rig.sensors
    expected = transform(rotation(nominal[1]) * rotation(correction[1]), np.add(nominal[0], correction[0]))
    assert_same_pose(sensor_matrix(lidar), REAR_AXLE @ expected)


@settings(max_examples=25)
@given(POSES)
def test_pandaset_holds_the_transform_from_the_pandar64_to_the_sensor(pose: Pose) -> None:
    """p_camera = R p_lidar + t, with the lidar's x to the left, y backwards and z up."""
    lidar_axes = transform(Rotation.from_euler("z", 90.0, degrees=True), (0.0, 0.0, 0.0))
    camera_T_lidar = np.linalg.inv(optical(pose_matrix(pose))) @ lidar_axes
    x, y, z, w = Rotation.from_matrix(camera_T_lidar[:3, :3]).as_quat()
    turn = json.dumps({"w": w, "x": x, "y": y, "z": z})
    place = json.dumps(dict(zip("xyz", camera_T_lidar[:3, 3].tolist(), strict=True)))
    text = (
        f"cam:\n  extrinsic:\n    transform:\n      rotation: {turn}\n      translation: {place}\n"
        "  intrinsic: {K: [1970.0, 0, 970.0, 0, 1970.0, 483.0, 0, 0, 1]}\n"
    )
    (camera,) = read_files({"calibration.yaml": text}, options=AT_ORIGIN).rig.sensors
    assert_same_pose(sensor_matrix(camera), pose_matrix(pose))


@settings(max_examples=25)
@given(POSES, POSES)
def test_kalibr_chains_inverse_transforms(imu: Pose, second: Pose) -> None:
    cam0_T_imu = np.linalg.inv(optical(pose_matrix(imu)))
    cam1_T_cam0 = pose_matrix(second)
    lens = "  intrinsics: [458.6, 457.3, 367.2, 248.4]\n  resolution: [752, 480]\n"
    text = f"cam0:\n  T_cam_imu: {rows(cam0_T_imu)}\n{lens}cam1:\n  T_cn_cnm1: {rows(cam1_T_cam0)}\n{lens}"
    one, other = (
        optical(sensor_matrix(camera))
        for camera in read_files({"camchain.yaml": text}, options=AT_ORIGIN).rig.sensors
    )
    imu_T_cam0 = np.linalg.inv(cam0_T_imu)
    turn = np.round(one @ cam0_T_imu)  # an axis of the IMU to each of the vehicle
    assert_same_pose(one, turn @ imu_T_cam0)
    assert_same_pose(other, turn @ imu_T_cam0 @ np.linalg.inv(cam1_T_cam0))
    upward = -one[:3, 1] - other[:3, 1]
    tipped = 0.5 * np.linalg.norm(upward)  # by 60 degrees
    assert upward[2] >= tipped - 1e-9
    assert np.array_equal(turn, np.eye(4)) or (turn.T[:3, :3] @ upward)[2] < tipped + 1e-9


@settings(max_examples=25)
@given(POSES, POSES)
def test_kitti_cameras_follow_from_their_projection_matrices(velo: Pose, rectify: Pose) -> None:
    """A point x of the Velodyne projects to P R0_rect Tr x; the camera's centre is where P x = 0."""
    tr = np.linalg.inv(optical(pose_matrix(velo)))
    rect = transform(rotation(rectify[1]), (0.0, 0.0, 0.0))
    k = np.array([[700.0, 0.0, 600.0], [0.0, 710.0, 180.0], [0.0, 0.0, 1.0]])
    shift = np.array([0.06, -0.0005, 0.0027])
    projection = k @ np.hstack([np.eye(3), shift[:, None]])

    def words(matrix: Matrix) -> str:
        return " ".join(repr(float(value)) for value in matrix.ravel())

    text = f"P2: {words(projection)}\nR0_rect: {words(rect[:3, :3])}\nTr_velo_to_cam: {words(tr[:3])}\n"
    camera, lidar = read_files({"000001.txt": text}, options=AT_ORIGIN).rig.sensors
    assert_same_pose(sensor_matrix(lidar), np.eye(4))
    expected = np.linalg.inv(transform(Rotation.identity(), shift) @ rect @ tr)
    assert_same_pose(optical(sensor_matrix(camera)), expected)


@settings(max_examples=20)
@given(POSES, POSES)
def test_kitti_raw_cameras_follow_from_camera_0(velo: Pose, second: Pose) -> None:
    tr, step = np.linalg.inv(optical(pose_matrix(velo))), pose_matrix(second)

    def words(values: Matrix) -> str:
        return " ".join(repr(float(value)) for value in values.ravel())

    lens = "S_0{0}: 1392 512\nK_0{0}: 984 0 690 0 980 233 0 0 1\n"
    cameras = lens.format(0) + "R_00: 1 0 0 0 1 0 0 0 1\nT_00: 0 0 0\n" + lens.format(1)
    cameras += f"R_01: {words(step[:3, :3])}\nT_01: {words(step[:3, 3])}\n"
    files = {
        "calib_cam_to_cam.txt": cameras,
        "calib_velo_to_cam.txt": f"R: {words(tr[:3, :3])}\nT: {words(tr[:3, 3])}\n",
    }
    one, other, _ = read_files(files, options=AT_ORIGIN).rig.sensors
    assert_same_pose(sensor_matrix(one), pose_matrix(velo))
    assert_same_pose(optical(sensor_matrix(other)), np.linalg.inv(step @ tr))
