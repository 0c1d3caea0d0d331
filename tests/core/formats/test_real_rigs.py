"""Real rigs of public data sets and programs come in whole, and their cameras look where their names say."""

import gzip
import json
import math
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from riglens.core.errors import InputError
from riglens.core.formats.exchange import FORMATS, read_rig
from riglens.core.formats.mounts import ReadOptions
from riglens.core.formats.report import OpenedRig
from riglens.core.rig.model import Lidar, Rig, Sensor
from tests.core.formats.cases import (
    Matrix,
    assert_same_pose,
    optical,
    read_files,
    sensor_matrix,
    transform,
)

BEARINGS_DEG = {
    "FRONT": 0, "FRONT_LEFT": 55, "FRONT_RIGHT": -55, "BACK": 180, "BACK_LEFT": 110, "BACK_RIGHT": -110,
    "LEFT": 90, "RIGHT": -90,
}  # fmt: skip
"""Where a camera of such a name looks from above, positive to the left."""


def real(folder: Path, *parts: str) -> Path:
    """A real file; skips the test when it is not on this machine."""
    path = folder.joinpath(*parts)
    if not path.exists():
        pytest.skip(f"{parts[-1]} is not on this machine")
    return path


def assert_looks_there(camera: Sensor, bearing_deg: float, within_deg: float = 12.0) -> None:
    """Whether the camera's axis, level within 12 degrees, points there."""
    x, y, z = sensor_matrix(camera)[:3, 0]
    off_deg = (math.degrees(math.atan2(y, x)) - bearing_deg + 180.0) % 360.0 - 180.0
    assert abs(off_deg) < within_deg and abs(math.degrees(math.asin(z))) < 12.0, camera.name
    assert sensor_matrix(camera)[2, 2] > 0.9, f"{camera.name} is not upright"


def everything_comes_back(rig: Rig) -> None:
    """The rig goes through every format that is read and written, and its poses come back."""
    for name, format_ in FORMATS.items():
        if format_.reads is None or format_.writes is None or name == "carla-toml":
            continue
        back = read_files(format_.write(rig).files, name, ReadOptions(vehicle=rig.vehicle)).rig
        known = {"camera", "lidar"} | {sensor.kind for sensor in back.sensors}  # URDF has no radars
        there = [sensor for sensor in rig.sensors if sensor.kind in known]
        assert len(back.sensors) == len(there)
        for sensor in there:
            assert_same_pose(sensor_matrix(back.sensor(sensor.name)), sensor_matrix(sensor))


@pytest.fixture(scope="module")
def nuscenes(shared_data: Path) -> Path:
    return real(shared_data, "nuscenes", "calibrated_sensor.json.gz").parent


def test_nuscenes_cameras_look_where_their_names_say(nuscenes: Path) -> None:
    imported = read_rig(nuscenes)
    assert "rig 1 of 850" in imported.report.lines()[0]
    cameras = imported.rig.enabled_cameras()
    assert len(cameras) == 6 and [lidar.name for lidar in imported.rig.enabled_lidars()] == ["LIDAR_TOP"]
    for camera in cameras:
        assert_looks_there(camera, BEARINGS_DEG[camera.name.removeprefix("CAM_")])
        assert 1.3 < camera.position[2] < 1.7 and abs(camera.position[0]) < 1.5
    everything_comes_back(imported.rig)


def test_every_rig_of_the_nuscenes_tables_is_whole(nuscenes: Path) -> None:
    """Rigs of all 850 scenes, by the token of any row; a few of them here."""
    table = json.loads(gzip.decompress((nuscenes / "calibrated_sensor.json.gz").read_bytes()))
    for index in (0, 13, 5_000, len(table) - 1):
        imported = read_rig(nuscenes, options=ReadOptions(token=table[index]["token"]))
        assert f"rig {index // 12 + 1} of 850" in imported.report.lines()[0]
        assert len(imported.rig.sensors) == 12
        for camera in imported.rig.enabled_cameras():
            assert_looks_there(camera, BEARINGS_DEG[camera.name.removeprefix("CAM_")])


def test_nuscenes_poses_are_those_of_the_table(nuscenes: Path) -> None:
    table = json.loads(gzip.decompress((nuscenes / "calibrated_sensor.json.gz").read_bytes()))
    names = {
        row["token"]: row["channel"]
        for row in json.loads((nuscenes / "sensor.json").read_text(encoding="utf-8"))
    }
    rig = read_rig(nuscenes, options=ReadOptions(rear_axle_x=-1.35)).rig
    rear_axle = transform(Rotation.identity(), (-1.35, 0.0, 0.0))
    for row in table[:12]:
        w, x, y, z = row["rotation"]
        expected = rear_axle @ transform(Rotation.from_quat([x, y, z, w]), row["translation"])
        if names[row["sensor_token"]].startswith("CAM"):
            assert_same_pose(optical(sensor_matrix(rig.sensor(names[row["sensor_token"]]))), expected)
        elif names[row["sensor_token"]].startswith("LIDAR"):
            assert_same_pose(sensor_matrix(rig.sensor("LIDAR_TOP")), expected)


@pytest.mark.slow
@pytest.mark.parametrize("form", ["pandaset"])
def test_pandaset_cameras_look_where_their_names_say(shared_data: Path, form: str) -> None:
    imported = read_rig(real(shared_data, "rigs", form, "static_extrinsic_calibration.yaml"))
    for camera in imported.rig.enabled_cameras():
        assert_looks_there(camera, BEARINGS_DEG[camera.name.removesuffix("_camera").upper()])
        assert camera.distortion is not None and 1.5 < camera.position[2] < 2.1
    assert imported.rig.sensor("main_pandar64").model == "hesai-pandar64"
    everything_comes_back(imported.rig)


def test_pandaset_as_json_is_the_same_rig(shared_data: Path) -> None:
    from ruamel.yaml import YAML

    path = real(shared_data, "rigs", "pandaset", "static_extrinsic_calibration.yaml")
    twin = json.dumps(YAML(typ="safe").load(path))
    assert read_files({"calibration.json": twin}).rig == read_rig(path).rig


AUTOWARE = {
    ("autoware", "sample_sensor_kit"): (8, 4),
    ("autoware", "single_lidar_sensor_kit"): (0, 1),
    ("aip_launcher", "aip_x1_description"): None,
    ("aip_launcher", "aip_x2_description"): (8, 8),
    ("aip_launcher", "aip_xx1_description"): (8, 6),
    ("aip_launcher", "aip_xx1_gen2_description"): None,
}


def autoware_frames(folder: Path) -> dict[str, Matrix]:
    """Every frame of a kit in base_link, chained by SciPy."""
    from ruamel.yaml import YAML

    steps: dict[str, tuple[str, Matrix]] = {}
    for path in sorted(folder.glob("*_calibration.yaml")):
        for parent, children in YAML(typ="safe").load(path).items():
            for child, value in children.items():
                turn = Rotation.from_euler("xyz", [value[key] for key in ("roll", "pitch", "yaw")])
                steps[child] = (parent, transform(turn, [value[key] for key in "xyz"]))
    frames: dict[str, Matrix] = {}
    for child in steps:
        place, matrix = child, np.eye(4)
        while place in steps:
            place, matrix = steps[place][0], steps[place][1] @ matrix
        frames[child] = matrix
    return frames


@pytest.mark.parametrize("parts", AUTOWARE)
def test_autoware_kits_are_chained_to_base_link(shared_data: Path, parts: tuple[str, str]) -> None:
    folder = real(shared_data, "rigs", *parts)
    imported = read_rig(folder)
    frames = autoware_frames(folder / "config" if (folder / "config").is_dir() else folder)
    rear_axle = transform(Rotation.identity(), (-1.35, 0.0, 0.0))
    for sensor in imported.rig.sensors:
        first = {"camera": "/camera_link", "lidar": "_base_link", "radar": "/radar_link"}[sensor.kind]
        base = sensor.name.removesuffix("_2")  # a radar beside a camera of the same name
        frame = next(base + ending for ending in (first, "_link", "") if base + ending in frames)
        assert_same_pose(sensor_matrix(sensor), rear_axle @ frames[frame])
    assert_nothing_is_lost(imported, frames)
    counts = AUTOWARE[parts]
    assert (
        counts is None or (len(imported.rig.enabled_cameras()), len(imported.rig.enabled_lidars())) == counts
    )
    everything_comes_back(imported.rig)


def assert_nothing_is_lost(imported: OpenedRig, frames: dict[str, Matrix]) -> None:
    """Every frame is a sensor, one that others hang on, or named as left out."""
    left_out = {name for remark in imported.report.of_kind("ignored") for name in remark.about}
    names = {sensor.name for sensor in imported.rig.sensors}
    for frame in frames:
        is_kit = frame.endswith("unit_base_link") or frame == "sensor_kit_base_link"
        assert is_kit or frame in left_out or any(frame.startswith(name) for name in names), frame


def test_xacro_files_of_parts_are_read_or_refused_in_one_line(shared_data: Path) -> None:
    """They are macros for other files, which give them their arguments: none of them is a rig by itself."""
    for path in real(shared_data, "rigs").rglob("*.xacro"):
        with pytest.raises(InputError) as caught:
            read_rig(path)
        assert str(path) in str(caught.value) and str(caught.value).isprintable()


def test_the_carla_example_sees_ahead_and_looks_down_on_itself(shared_data: Path) -> None:
    imported = read_rig(real(shared_data, "rigs", "carla_ros_bridge", "objects.json"))
    rig = imported.rig
    assert (len(rig.enabled_cameras()), len(rig.enabled_lidars())) == (5, 2)
    assert rig.sensor("rgb_front").position == (2.0, 0.0, 2.0)
    assert sensor_matrix(rig.sensor("rgb_view"))[2, 0] == pytest.approx(-math.sin(math.radians(20.0)))
    lidar = rig.sensor("lidar")
    assert isinstance(lidar, Lidar) and lidar.beam_count == 32 and lidar.azimuths().size == 500
    assert lidar.elevations()[[0, -1]].tolist() == [-26.8, 2.0]
    everything_comes_back(rig)


def test_the_driveworks_template_knows_its_car(shared_data: Path) -> None:
    rig = read_rig(real(shared_data, "rigs", "driveworks", "hesai_lidar_rig_template.json")).rig
    assert (rig.vehicle.length, rig.vehicle.width, rig.vehicle.height) == (4.872, 1.852, 1.473)
    assert rig.vehicle.rear_axle_x == pytest.approx(1.109 - 4.872 / 2)
    assert rig.sensors[0].position == (rig.vehicle.rear_axle_x, 0.0, 0.0)


@pytest.mark.parametrize("parts", [("object", "calib", "000000.txt"), ("tracking", "calib", "0000.txt")])
def test_kitti_cameras_look_ahead_at_their_known_distances(shared_data: Path, parts: tuple[str, ...]) -> None:
    rig = read_rig(real(shared_data, "kitti", *parts)).rig
    for camera in rig.enabled_cameras():
        assert_looks_there(camera, 0.0, within_deg=2.0)
        assert camera.position[2] == pytest.approx(1.65, abs=0.03)
    left, right = (np.array(rig.sensor(name).position) for name in ("cam2", "cam3"))
    assert np.linalg.norm(left - right) == pytest.approx(0.54, abs=0.01)
    everything_comes_back(rig)
