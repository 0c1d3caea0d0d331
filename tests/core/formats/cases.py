"""Small files in the formats of other programs, and poses said by SciPy in each format's own convention."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from riglens.core.formats.exchange import FORMATS, read_rig
from riglens.core.formats.mounts import ReadOptions
from riglens.core.formats.report import OpenedRig, Report
from riglens.core.rig.model import Camera, Lidar, LinearAngles, Rig, Sensor, Vehicle

Matrix = NDArray[np.float64]
Files = Mapping[str, str]
OPTICAL_IN_BODY = Rotation.from_matrix(np.array([[0, 0, 1], [-1, 0, 0], [0, -1, 0]], dtype=float))
"""REP-103: the optical frame's z is the body's x, its x is minus the body's y, its y is minus the body's z."""

ANGLES = st.floats(-180.0, 180.0) | st.sampled_from([0.0, 90.0, -90.0, 180.0, -180.0, 1e-7, 45.0])
PITCHES = st.floats(-90.0, 90.0) | st.sampled_from([90.0, -90.0, 90.0 - 1e-7, -90.0 + 1e-9, 0.0, 89.9999])
RPY_DEG = st.tuples(ANGLES, PITCHES, ANGLES)
POSITIONS_M = st.tuples(*[st.floats(-20.0, 20.0) | st.sampled_from([0.0, 1e-9, 1 / 3])] * 3)
POSES = st.tuples(POSITIONS_M, RPY_DEG)
Pose = tuple[tuple[float, float, float], tuple[float, float, float]]


def rotation(rpy_deg: tuple[float, float, float]) -> Rotation:
    """Roll, pitch, yaw about fixed axes, as REP-103 says: SciPy's extrinsic xyz."""
    return Rotation.from_euler("xyz", rpy_deg, degrees=True)


def transform(turned: Rotation, position: Any) -> Matrix:
    """A homogeneous matrix."""
    matrix = np.eye(4)
    matrix[:3, :3] = turned.as_matrix()
    matrix[:3, 3] = position
    return matrix


def pose_matrix(pose: Pose) -> Matrix:
    """The matrix of a position in metres and roll, pitch, yaw in degrees."""
    return transform(rotation(pose[1]), pose[0])


def sensor_matrix(sensor: Sensor) -> Matrix:
    """Where a sensor of a rig stands in the vehicle frame, by SciPy and not by the product."""
    return transform(rotation(sensor.rpy_deg), sensor.position)


def optical(body: Matrix) -> Matrix:
    """The optical frame of a camera whose body stands there."""
    return body @ transform(OPTICAL_IN_BODY, (0.0, 0.0, 0.0))


def assert_same_pose(found: Matrix, expected: Matrix) -> None:
    """Equal to 1e-9 m and 1e-9 rad."""
    assert np.abs(found[:3, 3] - expected[:3, 3]).max() < 1e-9
    turn = found[:3, :3].T @ expected[:3, :3]
    assert np.linalg.norm(turn - turn.T) / np.sqrt(8.0) < 1e-9 and np.trace(turn) > 2.0


def write_files(folder: Path, files: Files) -> Path:
    """Write files into a folder, which is made."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text, encoding="utf-8")
    return folder


def read_files(files: Files, name: str | None = None, options: ReadOptions | None = None) -> OpenedRig:
    """Read files that are written for it: the file alone where it is one, else the folder."""
    with tempfile.TemporaryDirectory() as made:
        folder = write_files(Path(made) / "rig", files)
        path = folder / next(iter(files)) if len(files) == 1 else folder
        return read_rig(path, name, options)


def written(name: str, rig: Rig) -> Files:
    """The text of every file that a format writes."""
    return FORMATS[name].write(rig).files


def report_on(name: str, rig: Rig) -> Report:
    """Return the report of writing a rig."""
    return FORMATS[name].write(rig).report


# ---------------------------------------------------------------- small files
ROW = ("token", "sensor_token", "translation", "rotation", "camera_intrinsic")
K = [[1266.4, 0.0, 816.3], [0.0, 1266.4, 491.5], [0.0, 0.0, 1.0]]
CALIBRATED: tuple[tuple[object, ...], ...] = (
    ("a1", "s1", [1.7, 0.0, 1.5], [0.5, -0.5, 0.5, -0.5], K),
    ("a2", "s2", [0.94, 0.0, 1.84], [0.7071067811865476, 0, 0, -0.7071067811865476], []),
    ("a3", "s3", [3.4, 0.0, 0.5], [1, 0, 0, 0], []),
    ("b1", "s1", [1.6, 0.0, 1.4], [0.5, -0.5, 0.5, -0.5], K),
    ("b2", "s2", [0.9, 0.0, 1.8], [0.7071067811865476, 0, 0, -0.7071067811865476], []),
)
NUSCENES: Files = {
    "sensor.json": json.dumps(
        [
            {"token": "s1", "channel": "CAM_FRONT", "modality": "camera"},
            {"token": "s2", "channel": "LIDAR_TOP", "modality": "lidar"},
            {"token": "s3", "channel": "RADAR_FRONT", "modality": "radar"},
        ]
    ),
    "calibrated_sensor.json": json.dumps([dict(zip(ROW, values, strict=True)) for values in CALIBRATED]),
}
AUTOWARE_KIT: Files = {
    "sensors_calibration.yaml": """\
base_link:
  sensor_kit_base_link: {x: 0.9, y: 0.0, z: 2.0, roll: -0.001, pitch: 0.015, yaw: -0.0364}
""",
    "sensor_kit_calibration.yaml": """\
sensor_kit_base_link:
  camera0/camera_link: {x: 0.1, y: 0.56, z: -0.27, roll: -0.025, pitch: 0.315, yaw: 1.035}
  velodyne_top_base_link: {x: 0.0, y: 0.0, z: 0.0, roll: 0.0, pitch: 0.0, yaw: 1.575}
  gnss_link: {x: -0.1, y: 0.0, z: -0.2, roll: 0.0, pitch: 0.0, yaw: 0.0}
""",
}
URDF: Files = {
    "rig.urdf": """\
<?xml version="1.0"?>
<robot name="shuttle">
  <link name="base_link"><visual><geometry><mesh filename="package://x/../../../etc/passwd"/></geometry></visual></link>
  <link name="mount"/>
  <joint name="m" type="fixed">
    <parent link="base_link"/><child link="mount"/><origin xyz="1 0 2" rpy="0 0 1.57"/>
  </joint>
  <link name="camera_link"/>
  <joint name="c" type="fixed"><parent link="mount"/><child link="camera_link"/><origin xyz="0.1 0 0"/></joint>
  <link name="camera_optical_frame"/>
  <joint name="o" type="fixed">
    <parent link="camera_link"/><child link="camera_optical_frame"/>
    <origin rpy="-1.5707963267948966 0 -1.5707963267948966"/>
  </joint>
  <link name="puck"/>
  <joint name="l" type="continuous"><parent link="mount"/><child link="puck"/><origin xyz="0 0 0.2"/></joint>
  <gazebo reference="puck">
    <sensor type="ray" name="velodyne">
      <pose>0 0 0.0377 0 0 0</pose>
      <ray>
        <scan>
          <horizontal><samples>4</samples><min_angle>-3.141592653589793</min_angle>
            <max_angle>1.5707963267948966</max_angle></horizontal>
          <vertical><samples>16</samples><min_angle>-0.2617993877991494</min_angle>
            <max_angle>0.2617993877991494</max_angle></vertical>
        </scan>
        <range><min>0.3</min><max>131</max></range>
      </ray>
    </sensor>
  </gazebo>
</robot>
"""
}
CARLA: Files = {
    "objects.json": json.dumps(
        {
            "objects": [
                {"type": "sensor.pseudo.map", "id": "map"},
                {
                    "type": "vehicle.tesla.model3",
                    "id": "ego",
                    "sensors": [
                        {
                            "type": "sensor.camera.rgb",
                            "id": "view",
                            "spawn_point": {
                                "x": -4.5,
                                "y": 0.5,
                                "z": 2.8,
                                "roll": 0,
                                "pitch": 20.0,
                                "yaw": 0,
                            },
                            "image_size_x": "800",
                            "image_size_y": 600,
                            "fov": 90.0,
                        },
                        {
                            "type": "sensor.lidar.ray_cast",
                            "id": "lidar",
                            "spawn_point": {"x": 0.0, "y": 0.0, "z": 2.4},
                            "range": 50,
                            "channels": 32,
                            "points_per_second": 320000,
                            "upper_fov": 2.0,
                            "lower_fov": -26.8,
                            "rotation_frequency": 20,
                        },
                        {"type": "sensor.other.imu", "id": "imu"},
                    ],
                },
            ]
        }
    )
}
CARLA_TOML: Files = {
    "lidar_pyramid.toml": """\
[lidar]
num = 4
channels = 16
lower_fov = -25.0
upper_fov = 5.0
x = [-0.2, 0.4, -0.2, -0.2]
y = [-0.6, 0, 0, 0.6]
z = [2.2, 2.4, 2.6, 2.2]
roll = [-0.28, 0.0, 0.0, 0.28]
pitch = [0.0, -0.09, 0.0, 0.0]

[camera]
T_CAM_FRONT_LEFT = [0.0, -0.5, 1.8]
R_CAM_FRONT_LEFT = [0.0, 0.0, -55.0]
FOV_CAM_FRONT_LEFT = 70.0
"""
}
DRIVEWORKS: Files = {
    "rig.json": json.dumps(
        {
            "rig": {
                "sensors": [
                    {
                        "name": "camera:front",
                        "protocol": "camera.gmsl",
                        "parameter": "interface=csi-a",
                        "nominalSensor2Rig_FLU": {"roll-pitch-yaw": [0.1, 0.4, 0.2], "t": [1.7, 0.0, 1.4]},
                        "correction_sensor_R_FLU": {"roll-pitch-yaw": [0.8, 2.2, 0.6]},
                        "correction_rig_T": [0.0, 0.0, 0.3],
                        "properties": {
                            "Model": "ftheta",
                            "bw-poly": "0.0 0.000545421498827636 -1.6e-10 -4.6e-12 2.8e-16",
                            "cx": "960",
                            "cy": "604",
                            "height": "1208",
                            "width": "1920",
                        },
                    },
                    {
                        "name": "lidar:top",
                        "protocol": "lidar.virtual",
                        "parameter": "device=VELO_VLP16,file=x",
                        "nominalSensor2Rig_FLU": {"roll-pitch-yaw": [0.0, 0.0, 90.0], "t": [1.0, 0.0, 2.0]},
                        "properties": None,
                    },
                    {"name": "can", "protocol": "can.socket", "parameter": ""},
                ],
                "vehicle": {
                    "valid": True,
                    "value": {"length": 4.872, "width": 1.852, "height": 1.473, "bumperRear": 1.109},
                },
            },
            "version": 2,
        }
    )
}
PANDASET: Files = {
    "calibration.yaml": """\
front_camera:
  extrinsic:
    transform:
      rotation: {w: 0.0, x: 0.0, y: 0.7071067811865476, z: -0.7071067811865476}
      translation: {x: 0.0, y: -0.3, z: -0.9}
  intrinsic:
    D: [-0.5894, 0.66, 0.0011, -0.001, -1.0088]
    K: [1970.0, 0, 970.0, 0, 1970.0, 483.0, 0, 0, 1]
main_pandar64:
  extrinsic:
    transform:
      rotation: {w: 1.0, x: 0.0, y: 0.0, z: 0.0}
      translation: {x: 0.0, y: 0.0, z: 0.0}
"""
}
KALIBR: Files = {
    "camchain.yaml": """\
cam0:
  T_cam_imu:
  - [0.0, -1.0, 0.0, 0.1]
  - [0.0, 0.0, -1.0, 0.2]
  - [1.0, 0.0, 0.0, 0.3]
  - [0.0, 0.0, 0.0, 1.0]
  camera_model: pinhole
  distortion_coeffs: [-0.28, 0.07, 0.0002, 0.00002]
  distortion_model: radtan
  intrinsics: [458.6, 457.3, 367.2, 248.4]
  resolution: [752, 480]
  rostopic: /cam0/image_raw
cam1:
  T_cn_cnm1:
  - [1.0, 0.0, 0.0, -0.11]
  - [0.0, 1.0, 0.0, 0.0]
  - [0.0, 0.0, 1.0, 0.0]
  - [0.0, 0.0, 0.0, 1.0]
  camera_model: pinhole
  distortion_coeffs: [0.01, -0.02, 0.003, 0.0]
  distortion_model: equidistant
  intrinsics: [460.0, 460.0, 370.0, 240.0]
  resolution: [752, 480]
"""
}
KITTI: Files = {
    "000000.txt": """\
P0: 700 0 600 0 0 700 180 0 0 0 1 0
P1: 700 0 600 -378 0 700 180 0 0 0 1 0
P2: 700 0 600 45.5 0 700 180 -0.35 0 0 1 0.005
P3: 700 0 600 -334 0 700 180 2.33 0 0 1 0.003
R0_rect: 1 0 0 0 1 0 0 0 1
Tr_velo_to_cam: 0 -1 0 0 0 0 -1 -0.08 1 0 0 -0.27
Tr_imu_to_velo: 1 0 0 -0.81 0 1 0 0.32 0 0 1 -0.8
"""
}
KITTI_RAW: Files = {
    "calib_cam_to_cam.txt": """\
calib_time: 09-Jan-2012 13:57:47
corner_dist: 9.950000e-02
S_00: 1392 512
K_00: 984.2 0 690 0 980.8 233.2 0 0 1
D_00: -0.37 0.2 0.001 0.002 -0.07
R_00: 1 0 0 0 1 0 0 0 1
T_00: 0 0 0
S_01: 1392 512
K_01: 989.5 0 702 0 987.8 245.6 0 0 1
D_01: 0 0 0 0 0
R_01: 1 0 0 0 1 0 0 0 1
T_01: -0.537 0.0048 -0.0125
""",
    "calib_velo_to_cam.txt": """\
calib_time: 15-Mar-2012 11:37:16
R: 0 -1 0 0 0 -1 1 0 0
T: -0.004 -0.076 -0.27
delta_f: 0 0
""",
}
OPENCV: Files = {
    "front.yaml": """\
image_width: 1280
image_height: 720
camera_name: front_camera
camera_matrix:
  rows: 3
  cols: 3
  data: [1000.5, 0, 640.25, 0, 1001.5, 360.75, 0, 0, 1]
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data: [-0.3, 0.1, 0.001, -0.002, 0.01]
"""
}
CARLA_AGENT: Files = {
    "agent.py": """\
class FirstAgent(AutonomousAgent):
    def sensors(self):
        sensors = [
            {'type': 'sensor.camera.rgb', 'x': 1.3, 'y': -0.5, 'z': 2.3, 'roll': 0.0, 'pitch': 5.0, 'yaw': -60.0,
             'width': 960, 'height': 480, 'fov': 120, 'id': 'rgb_left'},
            {'type': 'sensor.lidar.ray_cast', 'x': 0.0, 'y': 0.0, 'z': 2.5, 'roll': 0.0, 'pitch': 0.0,
             'yaw': -90.0, 'id': 'lidar'},
            {'type': 'sensor.other.imu', 'x': 0.0, 'y': 0.0, 'z': 0.0, 'roll': 0.0, 'pitch': 0.0, 'yaw': 0.0,
             'id': 'imu'},
        ]
        return sensors
"""
}
FORWARD = "[0, 0, 1, 0.3, -1, 0, 0, 0.1, 0, -1, 0, 0.2, 0, 0, 0, 1]"
"""A camera's optical axes in axes x forward, y left, z up."""
EUROC: Files = {
    f"{side}CameraParams.yaml": f"""\
%YAML:1.0
camera_id: {side.lower()}_cam
T_BS:
  cols: 4
  rows: 4
  data: {FORWARD.replace("0.1", shift)}
resolution: [752, 480]
camera_model: pinhole
intrinsics: [458.6, 457.3, 367.2, 248.4]
distortion_model: radial-tangential
distortion_coefficients: [-0.28, 0.07, 0.0002, 0.00002]
"""
    for side, shift in (("Left", "0.05"), ("Right", "-0.05"))
}
MAPLAB: Files = {
    "sensors.yaml": f"""\
sensors:
  - {{id: a0, sensor_type: IMU, topic: /imu0}}
  - id: b0
    sensor_type: NCAMERA
    cameras:
      - camera:
          topic: /cam0/image_raw
          image_height: 480
          image_width: 752
          type: pinhole
          intrinsics: {{cols: 1, rows: 4, data: [467.7, 467.5, 376.5, 231.3]}}
          distortion: {{type: equidistant, parameters: {{cols: 1, rows: 4, data: [0.01, 0.02, -0.03, 0.01]}}}}
        T_B_C: {{rows: 4, cols: 4, data: {FORWARD}}}
  - {{id: c0, sensor_type: LIDAR, topic: /os0_128}}
extrinsics:
  - {{sensor_id: a0, base_sensor_id: a0, T_B_S: {{data: [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]}}}}
  - {{sensor_id: b0, base_sensor_id: a0, T_B_S: {{data: [[1, 0, 0, 0.5], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]}}}}
  - {{sensor_id: c0, base_sensor_id: a0, T_B_S: {{data: [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0.7], [0, 0, 0, 1]]}}}}
"""
}
FAST_LIVO: Files = {
    "avia.yaml": """\
extrin_calib:
  extrinsic_T: [0.04, 0.02, -0.03]
  extrinsic_R: [1, 0, 0, 0, 1, 0, 0, 0, 1]
  Rcl: [0, -1, 0, 0, 0, -1, 1, 0, 0]
  Pcl: [0.02, 0.1, -0.03]
preprocess: {lidar_type: 5, scan_line: 32}
"""
}
APOLLO: Files = {
    "front_6mm_extrinsics.yaml": """\
header: {seq: 0, frame_id: lidar64, stamp: {secs: 0, nsecs: 0}}
child_frame_id: front_6mm
transform:
  rotation: {x: -0.5, y: 0.5, z: -0.5, w: 0.5}
  translation: {x: 0.6, y: 0.1, z: -0.2}
""",
    "front_6mm_intrinsics.yaml": """\
header: {frame_id: front_6mm}
height: 1080
width: 1920
distortion_model: plumb_bob
D: [-0.55, 0.3, -0.005, -0.0008, -0.1]
K: [1951.7, 0.0, 936.2, 0.0, 1949.4, 532.0, 0.0, 0.0, 1.0]
""",
    "lidar64_novatel_extrinsics.yaml": """\
header: {frame_id: novatel}
child_frame_id: lidar64
transform:
  rotation: {x: 0, y: 0, z: 0.7071067811865476, w: 0.7071067811865476}
  translation: {x: -0.1, y: 1.2, z: 1.8}
""",
}
BOREAS: Files = {
    "T_applanix_lidar.txt": "0 -1 0 0\n1 0 0 0.2\n0 0 1 0.45\n0 0 0 1\n",
    "T_camera_lidar.txt": "0 -1 0 -0.04\n0 0 -1 -0.8\n1 0 0 -0.2\n0 0 0 1\n",
    "P_camera.txt": "1475.6 0.0 1226.0 0.0\n0.0 1475.4 1031.6 0.0\n0 0 1 0\n0 0 0 1\n",
}
KITTI_360: Files = {
    "calib_cam_to_pose.txt": """\
image_00: 0 0 1 1.5 1 0 0 -0.3 0 1 0 -1.1
image_02: 1 0 0 0.7 0 0 -1 -0.15 0 1 0 -1.07
""",
    "calib_cam_to_velo.txt": "0 0 1 0.75 -1 0 0 0.05 0 -1 0 -0.3",
    "perspective.txt": """\
S_00: 1392 512
K_00: 788.6 0 687.2 0 786.4 317.8 0 0 1
D_00: -0.34 0.19 0.001 -0.0004 -0.07
""",
    "image_02.yaml": """\
%YAML:1.0
---
model_type: MEI
camera_name: image_02
image_width: 1400
image_height: 1400
mirror_parameters:
   xi: 2.2
distortion_parameters: {k1: 0.017, k2: 1.65, p1: 0.0004, p2: 0.0004}
projection_parameters: {gamma1: 1336.3, gamma2: 1335.8, u0: 716.9, v0: 705.8}
""",
}
AIRSIM: Files = {
    "settings.json": json.dumps(
        {
            "SettingsVersion": 1.2,
            "SimMode": "Car",
            "Vehicles": {
                "Car1": {
                    "VehicleType": "PhysXCar",
                    "Cameras": {
                        "view": {
                            "CaptureSettings": [
                                {"ImageType": 3, "Width": 10, "Height": 10},
                                {"ImageType": 0, "Width": 640, "Height": 480, "FOV_Degrees": 100},
                            ],
                            **{"X": 1.0, "Y": 0.5, "Z": -1.5, "Roll": 0.0, "Pitch": 10.0, "Yaw": 30.0},
                        }
                    },
                    "Sensors": {
                        "top": {
                            **{"SensorType": 6, "Enabled": True, "NumberOfChannels": 16, "Z": -2},
                            **{"PointsPerSecond": 160_000, "RotationsPerSecond": 10, "Range": 80},
                            **{"VerticalFOVUpper": 15, "VerticalFOVLower": -25},
                            **{"HorizontalFOVStart": -20, "HorizontalFOVEnd": 90},
                        },
                        "imu": {"SensorType": 2, "Enabled": True},
                    },
                },
                "Car2": {"VehicleType": "PhysXCar"},
            },
        }
    )
}
MMDET3D: Files = {
    "infos.json": json.dumps(
        {
            "data_list": [
                {
                    "images": {
                        "CAM_FRONT": {
                            "cam2img": K,
                            "cam2ego": [[0, 0, 1, 1.7], [-1, 0, 0, 0], [0, -1, 0, 1.5], [0, 0, 0, 1]],
                            **{"width": 1600, "height": 900},
                        },
                        "CAM_BACK": {
                            "cam2img": K,
                            "lidar2cam": [[-1, 0, 0, 0], [0, 0, -1, -0.3], [0, -1, 0, -0.5], [0, 0, 0, 1]],
                        },
                    },
                    "lidar_points": {
                        "lidar2ego": [[0, 1, 0, 0.9], [-1, 0, 0, 0], [0, 0, 1, 1.8], [0, 0, 0, 1]]
                    },
                }
            ]
        }
    )
}
BASALT: Files = {
    "calibration.json": json.dumps(
        {
            "value0": {
                "T_imu_cam": [
                    {"px": 0.05, "py": 0.1, "pz": 0.02, "qx": -0.5, "qy": 0.5, "qz": -0.5, "qw": 0.5},
                    {"px": 0.05, "py": -0.1, "pz": 0.02, "qx": -0.5, "qy": 0.5, "qz": -0.5, "qw": 0.5},
                ],
                "intrinsics": [
                    {
                        "camera_type": "kb4",
                        "intrinsics": {
                            **{"fx": 379.5, "fy": 379.25, "cx": 505.5, "cy": 509.75},
                            **{"k1": 0.01, "k2": -0.005, "k3": 0.004, "k4": -0.001},
                        },
                    },
                    {
                        "camera_type": "ds",
                        "intrinsics": {
                            "fx": 158.0,
                            "fy": 158.0,
                            "cx": 508.0,
                            "cy": 506.0,
                            "xi": -0.17,
                            "alpha": 0.6,
                        },
                    },
                ],
                "resolution": [[1024, 1024], [1024, 1024]],
                "calib_accel_bias": [0.0] * 9,
                "imu_update_rate": 200.0,
            }
        }
    )
}
A2D2: Files = {
    "cams_lidars.json": json.dumps(
        {
            "vehicle": {
                "view": {"origin": [0, 0, 0], "x-axis": [1, 0, 0], "y-axis": [0, 1, 0]},
                "ego-dimensions": {"x-range": [-1.125, 3.9375], "y-range": [-1, 1], "z-range": [-0.25, 1.5]},
            },
            "cameras": {
                "front_center": {
                    "view": {"origin": [1.75, 0, 1.0], "x-axis": [1, 0, 0], "y-axis": [0, 1, 0]},
                    "Lens": "Telecam",
                    "CamMatrix": [[1687.0, 0, 965.4], [0, 1783.5, 684.4], [0, 0, 1]],
                    "CamMatrixOriginal": [[1750.0, 0, 955.0], [0, 1750.0, 604.0], [0, 0, 1]],
                    "Distortion": [[-0.25, 0.125, 0.001, -0.002, 0.01]],
                    "Resolution": [1920, 1208],
                    "tstamp_delay": 0,
                },
                "side_left": {
                    "view": {"origin": [0.5, 0.75, 1.0], "x-axis": [0, 1, 0], "y-axis": [-1, 0.1, 0]},
                    "Lens": "Fisheye",
                    "CamMatrix": [[881.0, 0, 951.0], [0, 881.0, 580.0], [0, 0, 1]],
                    "CamMatrixOriginal": [[1050.0, 0, 951.0], [0, 1050.0, 600.0], [0, 0, 1]],
                    "Distortion": [[-0.04, 0.02, -0.03, 0.01]],
                    "Resolution": [1920, 1208],
                },
            },
            "lidars": {
                "front_left": {
                    "view": {"origin": [1.75, 0.5, 1.0], "x-axis": [0.8, 0.6, 0], "y-axis": [-0.6, 0.8, 0]}
                }
            },
        }
    )
}
SDF: Files = {
    "car.sdf": """\
<?xml version="1.0"?>
<sdf version="1.9">
  <model name="car">
    <link name="chassis"><pose>0.5 0 0.25 0 0 0</pose></link>
    <link name="roof">
      <pose relative_to="chassis">-0.25 0 1.25 0 0 1.5707963267948966</pose>
      <sensor name="top" type="gpu_lidar">
        <pose>0.5 0 0.125 0 0 0</pose>
        <lidar>
          <scan>
            <horizontal><samples>4</samples><min_angle>-1.5</min_angle><max_angle>1.5</max_angle></horizontal>
            <vertical><samples>8</samples><min_angle>-0.25</min_angle><max_angle>0.25</max_angle></vertical>
          </scan>
          <range><min>0.5</min><max>90</max></range>
        </lidar>
      </sensor>
      <sensor name="gps" type="navsat"/>
    </link>
    <link name="front">
      <pose degrees="true">1.75 0 1 0 5 0</pose>
      <sensor name="view" type="camera">
        <camera><horizontal_fov>1.2</horizontal_fov><image><width>800</width><height>600</height></image></camera>
      </sensor>
    </link>
  </model>
</sdf>
"""
}
OSI: Files = {
    "osi.json": json.dumps(
        [
            {
                "version": {"versionMajor": 3, "versionMinor": 5, "versionPatch": 0},
                "sensorId": {"value": "7"},
                "mountingPosition": {
                    "position": {"x": 3.1, "z": 0.2},
                    "orientation": {"yaw": 0.5, "pitch": -0.1},
                },
                "fieldOfViewHorizontal": 1.0,
                "range": 150.0,
                "radarSensorViewConfiguration": [{"fieldOfViewVertical": 0.2}],
            },
            {
                "sensorId": {"value": "8"},
                "lidarSensorViewConfiguration": [
                    {
                        "mountingPosition": {"position": {"x": 1.2, "y": 0.1, "z": 1.5}},
                        **{"fieldOfViewHorizontal": 6.283185307179586, "fieldOfViewVertical": 0.5},
                        **{"numberOfRaysHorizontal": 1800, "numberOfRaysVertical": 32},
                    }
                ],
            },
            {
                "cameraSensorViewConfiguration": [
                    {
                        "sensorId": {"value": "9"},
                        "mountingPosition": {"position": {"x": 1.8, "z": 1.1}},
                        "fieldOfViewHorizontal": 1.2,
                        **{"numberOfPixelsHorizontal": 1920, "numberOfPixelsVertical": 1080},
                    },
                    {"fieldOfViewHorizontal": 3.3},
                ],
                "ultrasonicSensorViewConfiguration": [{"range": 4.0}],
                "genericSensorViewConfiguration": [{}],
            },
        ]
    )
}
ONCE: Files = {
    "000027.json": json.dumps(
        {
            "meta_info": {"weather": "sunny", "image_size": [1920, 1020]},
            "calib": {
                "cam01": {  # looks along -y of the LiDAR, which is forward
                    "cam_to_velo": [[-1, 0, 0, 0.1], [0, 0, -1, -0.5], [0, -1, 0, -0.25], [0, 0, 0, 1]],
                    "cam_intrinsic": [[960.0, 0, 957.0], [0, 961.0, 510.0], [0, 0, 1]],
                    "distortion": [-0.3, 0.1, 0.001, 0.0005, -0.02],
                },
                "cam09": {
                    "cam_to_velo": [[1, 0, 0, 0.0], [0, 0, 1, 1.0], [0, -1, 0, -0.25], [0, 0, 0, 1]],
                    "cam_intrinsic": [[960.0, 0, 957.0], [0, 961.0, 510.0], [0, 0, 1]],
                    "distortion": [0, 0, 0, 0, 0],
                },
            },
            "frames": [{"sequence_id": "000027", "frame_id": "1", "pose": [0, 0, 0, 1, 0, 0, 0]}],
        }
    )
}
ZOD: Files = {
    "calibration.json": json.dumps(
        {
            "FC": {
                "extrinsics": [[0, 0, 1, 2.0], [-1, 0, 0, 0.05], [0, -1, 0, 1.25], [0, 0, 0, 1]],
                "lidar_extrinsics": [[0, 1, 0, 1.5], [-1, 0, 0, 0.0], [0, 0, 1, 2.0], [0, 0, 0, 1]],
                "image_dimensions": [3848, 2168],
                "intrinsics": [[2000.0, 0, 1924.0, 0], [0, 2000.5, 1084.0, 0], [0, 0, 1, 0]],
                "distortion": [-0.05, 0.01, -0.002, 0.0005],
                "undistortion": [0.05, 0.01, 0.002, 0.0],
                "field_of_view": [120.0, 67.0],
            }
        }
    )
}
DDAD: Files = {
    "f1a2.json": json.dumps(
        {
            "names": ["LIDAR", "CAMERA_01"],
            "intrinsics": [{}, {"fx": 2181.5, "fy": 2181.6, "cx": 928.0, "cy": 615.9}],
            "extrinsics": [
                {"rotation": {"qw": 1.0}, "translation": {}},
                {
                    "rotation": {"qx": -0.5, "qy": 0.5, "qz": -0.5, "qw": 0.5},
                    "translation": {"x": 2.0, "z": 1.5},
                },
            ],
        }
    )
}
DAIR: Files = {
    "calib/lidar_to_camera/000000.json": json.dumps(
        {
            "rotation": [[0, -1, 0], [0, 0, -1], [1, 0, 0]],
            "translation": [[0.1], [-0.3], [-0.75]],
        }
    ),
    "calib/camera_intrinsic/000000.json": json.dumps(
        {
            "height": 1080,
            "width": 1920,
            "cam_D": [-0.4, 0.2, 0.0, 0.0, 0.0],
            "cam_K": [2100.0, 0.0, 950.0, 0.0, 2101.0, 550.0, 0.0, 0.0, 1.0],
        }
    ),
}
OPV2V: Files = {
    "000069.yaml": """\
camera0:
  cords: [141.35, -388.75, 1.0, 0.0, 180.0, 0.0]
  extrinsic: [[1, 0, 0, -3], [0, 1, 0, 0], [0, 0, 1, 0.9], [0, 0, 0, 1]]
  intrinsic: [[335.639852470912, 0.0, 400.0], [0.0, 335.639852470912, 300.0], [0.0, 0.0, 1.0]]
camera1:
  cords: [143.35, -389.25, 1.0, 0.0, 280.0, 0.0]
  intrinsic: [[335.639852470912, 0.0, 400.0], [0.0, 335.639852470912, 300.0], [0.0, 0.0, 1.0]]
lidar_pose: [144.0, -388.75, 2.0, 0.0, 180.0, 0.0]
true_ego_pos: [143.85, -388.75, 0.0, 0.0, 180.0, 0.0]
ego_speed: 18.1
"""
}
LGSVL: Files = {
    "sensors.json": json.dumps(
        [
            {"type": "GPS Device", "name": "GPS", "params": {"Topic": "/gps"}, "transform": {"z": -1.348649}},
            {
                "type": "Lidar",
                "name": "Lidar",
                "params": {
                    "LaserCount": 32,
                    "MinDistance": 0.5,
                    "MaxDistance": 100,
                    "FieldOfView": 41.33,
                    "CenterAngle": 10,
                    "MeasurementsPerRotation": 360,
                },
                "transform": {"x": 0, "y": 2.312, "z": -0.3679201, "pitch": 0, "yaw": 0, "roll": 0},
            },
            {
                "type": "Color Camera",
                "name": "Right Camera",
                "params": {"Width": 1920, "Height": 1080, "FieldOfView": 50},
                "transform": {"x": 0.5, "y": 1.7, "z": 0.2, "pitch": 10, "yaw": 30, "roll": 5},
            },
        ]
    )
}
ORB_SLAM: Files = {
    "TUM-VI.yaml": """\
%YAML:1.0
File.version: "1.0"
Camera.type: "KannalaBrandt8"
Camera1.fx: 190.97847715128717
Camera1.fy: 190.9733070521226
Camera1.cx: 254.93170605935475
Camera1.cy: 256.8974428996504
Camera1.k1: 0.0034823894022493434
Camera1.k2: 0.0007150348452162257
Camera1.k3: -0.0020532361418706202
Camera1.k4: 0.00020293673591811182
Camera2.fx: 190.44236969414825
Camera2.fy: 190.4344384721956
Camera2.cx: 252.59949716835982
Camera2.cy: 254.91723064636983
Camera2.k1: 0.0034003170790442797
Camera2.k2: 0.001766278153469831
Camera2.k3: -0.00266312569781606
Camera2.k4: 0.0003299517423931039
Stereo.T_c1_c2: !!opencv-matrix
  rows: 4
  cols: 4
  dt: f
  data: [ 0.999999445773493,   0.000791687752817,   0.000694034010224,   0.101063427414194,
            -0.000823363992158,   0.998899461915674,   0.046895490788700,   0.001946204678584,
            -0.000656143613644,  -0.046896036240590,   0.998899560146304,   0.001015350132563,
          0.0,0.0,0.0,1.0]
Camera.width: 512
Camera.height: 512
IMU.T_b_c1: !!opencv-matrix
   rows: 4
   cols: 4
   dt: f
   data: [-0.9995250378696743, 0.0075019185074052044, -0.02989013031643309, 0.045574835649698026,
          0.029615343885863205, -0.03439736061393144, -0.998969345370175, -0.071161801837997044,
         -0.008522328211654736, -0.9993800792498829, 0.03415885127385616, -0.044681254117144367,
          0.0, 0.0, 0.0, 1.0]
ORBextractor.nFeatures: 1000
Viewer.PointSize:2
"""
}
LIO_SAM: Files = {
    "params.yaml": """\
lio_sam:
  lidarFrame: "velodyne"
  sensor: velodyne
  N_SCAN: 16
  Horizon_SCAN: 1800
  extrinsicTrans: [0.0, 0.0, 0.0]
  extrinsicRot: [-1, 0, 0, 0, 1, 0, 0, 0, -1]
"""
}
R3LIVE: Files = {
    "r3live_config.yaml": """\
Lidar_front_end:
   lidar_type: 1   # 1 for Livox-avia, 3 for Ouster-OS1-64
   N_SCANS: 6
   using_raw_point: 1
   point_step: 1
r3live_common:
   if_dump_log: 0
r3live_vio:
   image_width: 1280
   image_height: 1024
   camera_intrinsic:
      [863.4241, 0.0, 640.6808,
      0.0,  863.4171, 518.3392,
      0.0, 0.0, 1.0 ]
   camera_dist_coeffs: [-0.1080, 0.1050, -1.2872e-04, 5.7923e-05, -0.0222]  #k1, k2, p1, p2, k3
   camera_ext_R:
         [-0.00113207, -0.0158688, 0.999873,
            -0.9999999,  -0.000486594, -0.00113994,
            0.000504622,  -0.999874,  -0.0158682]
   camera_ext_t: [0.050166, 0.0474116, -0.0312415]
r3live_lio:
   lio_update_point_step: 4
"""
}
VLCAL: Files = {
    "calib.json": json.dumps(
        {
            "camera": {
                "camera_model": "plumb_bob",
                "distortion_coeffs": [-0.04088, 0.08232, 0.00015244, -0.0002905, -0.03995],
                "intrinsics": [810.3829, 810.2790, 822.8441, 622.4745],
            },
            "meta": {"bag_names": ["a"]},
            "results": {
                "T_lidar_camera": [
                    0.029965406350829532,
                    0.0018510163746144406,
                    0.10836834957603067,
                    -0.5020970411416648,
                    0.49250979122625377,
                    -0.5009468032383634,
                    0.5043659060130069,
                ]
            },
        }
    )
}
SMALL: dict[str, Files] = {
    "nuscenes": NUSCENES,
    "autoware": AUTOWARE_KIT,
    "urdf": URDF,
    "carla": CARLA,
    "carla-toml": CARLA_TOML,
    "driveworks": DRIVEWORKS,
    "pandaset": PANDASET,
    "kalibr": KALIBR,
    "euroc": EUROC,
    "euroc-raw": MAPLAB,
    "fast-livo": FAST_LIVO,
    "apollo": APOLLO,
    "opencv": OPENCV,
    "carla-agent": CARLA_AGENT,
    "kitti": KITTI,
    "kitti-raw": KITTI_RAW,
    "kitti-360": KITTI_360,
    "boreas": BOREAS,
    "airsim": AIRSIM,
    "mmdet3d": MMDET3D,
    "basalt": BASALT,
    "a2d2": A2D2,
    "sdf": SDF,
    "once": ONCE,
    "zod": ZOD,
    "ddad": DDAD,
    "dair-v2x": DAIR,
    "opv2v": OPV2V,
    "lgsvl": LGSVL,
    "orb-slam3": ORB_SLAM,
    "lio-sam": LIO_SAM,
    "r3live": R3LIVE,
    "vlcal": VLCAL,
    "osi": OSI,
}
"""A valid rig in every format that is read; the last one is another form of the one before."""
JSON, YAML = '"{key}": {value}, ', "{key}: {value}, "
PLACES: dict[str, tuple[str, str, str]] = {
    "nuscenes": ("calibrated_sensor.json", '"token": "a1"', JSON),
    "autoware": ("sensor_kit_calibration.yaml", "x: 0.1,", YAML),
    "urdf": ("rig.urdf", "<scan>", "<{key}>{value}</{key}>"),
    "carla": ("objects.json", '"type": "sensor.lidar', JSON),
    "carla-toml": ("lidar_pyramid.toml", "channels", "{key} = {value}\n"),
    "driveworks": ("rig.json", '"bw-poly"', JSON),
    "pandaset": ("calibration.yaml", "    K:", "    {key}: {value}\n"),
    "kalibr": ("camchain.yaml", "  camera_model", "  {key}: {value}\n"),
    "euroc": ("LeftCameraParams.yaml", "camera_id", "{key}: {value}\n"),
    "euroc-raw": ("sensors.yaml", "          topic: /cam0", "          {key}: {value}\n"),
    "fast-livo": ("avia.yaml", "  extrinsic_T", "  {key}: {value}\n"),
    "apollo": ("front_6mm_intrinsics.yaml", "height", "{key}: {value}\n"),
    "opencv": ("front.yaml", "image_width", "{key}: {value}\n"),
    "carla-agent": ("agent.py", "'x': 1.3", "'{key}': {value}, "),
    "kitti": ("000000.txt", "P0", "{key}: {value}\n"),
    "kitti-raw": ("calib_cam_to_cam.txt", "S_00", "{key}: {value}\n"),
    "kitti-360": ("image_02.yaml", "image_width", "{key}: {value}\n"),
    "airsim": ("settings.json", '"X"', JSON),
    "mmdet3d": ("infos.json", '"cam2img"', JSON),
    "basalt": ("calibration.json", '"fx": 379.5', JSON),
    "a2d2": ("cams_lidars.json", '"Lens": "Telecam"', JSON),
    "sdf": ("car.sdf", "<scan>", "<{key}>{value}</{key}>"),
    "once": ("000027.json", '"cam_intrinsic"', JSON),
    "zod": ("calibration.json", '"distortion"', JSON),
    "ddad": ("f1a2.json", '"fx"', JSON),
    "dair-v2x": ("calib/camera_intrinsic/000000.json", '"cam_D"', JSON),
    "opv2v": ("000069.yaml", "  intrinsic", "  {key}: {value}\n"),
    "lgsvl": ("sensors.json", '"FieldOfView": 50', JSON),
    "orb-slam3": ("TUM-VI.yaml", "Camera1.fy", "{key}: {value}\n"),
    "lio-sam": ("params.yaml", "  N_SCAN", "  {key}: {value}\n"),
    "r3live": ("r3live_config.yaml", "   image_width", "   {key}: {value}\n"),
    "vlcal": ("calib.json", '"intrinsics"', JSON),
    "osi": ("osi.json", '"range"', JSON),
}
"""File, text before which a further field is put, and how the format writes a field."""
WITHOUT_NAMES = {"boreas"}
"""Formats whose files hold numbers alone: further files are named."""
WITH_COLUMNS = {"argoverse"}
"""Formats of tables, see test_argoverse."""

VEHICLE = Vehicle(length=4.9, width=1.9, height=1.6, rear_axle_x=-1.4)


def lidar(name: str, pose: Pose, **fields: Any) -> Lidar:
    """A LiDAR of 8 beams there."""
    beams = {"elevations_deg": LinearAngles(from_=-15.0, to=10.0, count=8)}
    return Lidar(name=name, position=pose[0], rpy_deg=pose[1], **(beams | fields))


def camera(name: str, pose: Pose, **fields: Any) -> Camera:
    """A camera there, 800 x 600 pixels."""
    lens = {} if "fx" in fields else {"hfov_deg": 80.0}
    return Camera(name=name, position=pose[0], rpy_deg=pose[1], image=(800, 600), **(lens | fields))


def rig_of(*sensors: Sensor) -> Rig:
    """A rig on a vehicle whose rear axle is not at the default place."""
    return Rig(name="test rig", vehicle=VEHICLE, sensors=sensors)
