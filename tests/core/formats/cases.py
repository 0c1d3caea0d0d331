"""Small files in the formats of other programs, and poses said by SciPy in each format's own convention."""

from __future__ import annotations

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
SMALL: dict[str, Files] = {
    place.name: {
        file.relative_to(place).as_posix(): file.read_text(encoding="utf-8")
        for file in sorted(place.rglob("*.*"))
    }
    for place in sorted((Path(__file__).parent / "small").iterdir())
} | {"carla-agent": CARLA_AGENT}
"""A valid rig in every format that is read, by the name of the format; -raw is another form of it."""
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
