"""Argoverse 2 calibrations: poses and lenses of a log, and files that are none."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.feather
import pytest
from scipy.spatial.transform import Rotation

from riglens.core.errors import InputError
from riglens.core.formats.argoverse import LENSES, POSES
from riglens.core.formats.exchange import detect, read_rig
from riglens.core.formats.mounts import ReadOptions
from riglens.core.formats.source import Source
from riglens.core.rig.model import Camera, Lidar
from riglens.core.rig.yaml.file import dumps, loads
from tests.core.formats.cases import VEHICLE, assert_same_pose, optical, pose_matrix, sensor_matrix
from tests.core.formats.test_reports import has
from tests.core.formats.test_unread import FIELDS

PLACES = {
    "ring_front_center": optical(pose_matrix(((1.6, 0.0, 1.4), (0.0, 2.0, 1.0)))),
    "ring_side_left": optical(pose_matrix(((1.3, 0.3, 1.4), (0.0, 0.0, 100.0)))),
    "up_lidar": pose_matrix(((1.35, 0.0, 1.64), (0.0, 0.0, -0.6))),
    "down_lidar": pose_matrix(((1.35, 0.0, 1.53), (180.0, 0.0, -11.0))),
    "gps": pose_matrix(((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))),
}


def poses() -> dict[str, Any]:
    """The columns of the file of poses."""
    xyzw = [Rotation.from_matrix(place[:3, :3]).as_quat() for place in PLACES.values()]
    columns: dict[str, Any] = {"sensor_name": list(PLACES)}
    columns |= {key: [q[index] for q in xyzw] for key, index in (("qw", 3), ("qx", 0), ("qy", 1), ("qz", 2))}
    return columns | {
        f"t{axis}_m": [place[i, 3] for place in PLACES.values()] for i, axis in enumerate("xyz")
    }


def lenses() -> dict[str, Any]:
    """The columns of the file of intrinsics."""
    numbers = {
        "fx_px": 1700.5,
        "fy_px": 1700.5,
        "cx_px": 777.0,
        "cy_px": 1013.0,
        "k1": -0.24,
        "k2": 0.0,
        "k3": 0.1,
    }
    columns: dict[str, Any] = {"sensor_name": ["ring_front_center", "ring_side_left", "stereo_front_left"]}
    columns |= {key: [value] * 3 for key, value in numbers.items()}
    sizes = {"height_px": np.full(3, 2048, np.uint16), "width_px": np.full(3, 1550, np.uint16)}
    return columns | sizes


def write(folder: Path, name: str, columns: Mapping[str, Any]) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    pyarrow.feather.write_feather(pa.table(dict(columns)), str(folder / name))


@pytest.fixture
def log(tmp_path: Path) -> Path:
    """A log with its calibration."""
    write(tmp_path / "log" / "calibration", POSES, poses())
    write(tmp_path / "log" / "calibration", LENSES, lenses())
    return tmp_path / "log"


@pytest.mark.parametrize("inner", [".", "calibration", f"calibration/{POSES}", f"calibration/{LENSES}"])
def test_log_folder_and_files_are_the_same_rig(log: Path, inner: str) -> None:
    assert detect(Source(log / inner)).name == "argoverse"
    read = read_rig(log / inner, options=ReadOptions(vehicle=VEHICLE, origin_m=(0.0, 0.0, 0.0)))
    found = {sensor.name: sensor for sensor in read.rig.sensors}
    assert list(found) == list(PLACES)[:4]
    for name, sensor in found.items():
        place = sensor_matrix(sensor)
        assert_same_pose(optical(place) if isinstance(sensor, Camera) else place, PLACES[name])
    front, up = found["ring_front_center"], found["up_lidar"]
    assert isinstance(front, Camera) and (front.image, front.fx, front.distortion) == (
        (1550, 2048),
        1700.5,
        None,
    )
    assert isinstance(up, Lidar) and up.model == "velodyne-vlp-32c"
    for words in ("not in egovehicle_SE3_sensor", "no LiDAR by its name", "k1 k2 k3: published images"):
        assert has(read.report, "ignored", words)
    assert loads(dumps(read.rig)).rig == read.rig


def test_origin_is_the_rear_axle_a_third_of_a_metre_above_the_ground(log: Path) -> None:
    read = read_rig(log)
    lidar = next(sensor for sensor in read.rig.sensors if sensor.name == "up_lidar")
    assert lidar.position == pytest.approx((1.35 - 1.34, 0.0, 1.64 + 0.33), abs=1e-9)
    assert read.rig.vehicle.rear_axle_x == -1.34


@pytest.mark.parametrize("key, value", FIELDS.values())
@pytest.mark.parametrize("name", [POSES, LENSES])
def test_columns_that_are_not_used_are_named_with_their_value(
    log: Path, name: str, key: str, value: object
) -> None:
    plain = read_rig(log)
    assert not any("is not used" in line for line in plain.report.lines())
    columns = poses() if name == POSES else lenses()
    write(log / "calibration", name, columns | {key: [value] * len(columns["sensor_name"])})
    read = read_rig(log)
    (line,) = [line for line in read.report.lines() if f"'{key}'" in line]
    assert line.startswith("ignored") and str(value).strip("[]")[:5] in line
    assert read.rig == plain.rig


def without(columns: dict[str, Any], name: str) -> dict[str, Any]:
    return {key: value for key, value in columns.items() if key != name}


@pytest.mark.parametrize(
    ("columns", "complaint"),
    [
        (without(poses(), "qw"), "column 'qw' is missing"),
        (poses() | {"tx_m": [float("nan")] * 5}, r"row 1\.tx_m: .*got nan"),
        (poses() | {"tx_m": [1e9] * 5}, r"row 1\.tx_m"),
        (poses() | {"tx_m": ["a"] * 5}, r"row 1\.tx_m"),
        (poses() | {"tx_m": [None] * 5}, r"row 1\.tx_m: missing"),
        (poses() | {"qw": [0.0] * 5, "qx": [0.0] * 5, "qy": [0.0] * 5, "qz": [0.0] * 5}, "row 1: "),
        (poses() | {"sensor_name": ["a"] * 5}, "row 2: sensor 'a' is given twice"),
        (poses() | {"sensor_name": [1, 2, 3, 4, 5]}, r"row 1\.sensor_name"),
        ({key: value * 2000 for key, value in poses().items()}, "at most 1000 rows"),
    ],
)
def test_wrong_columns_are_refused_in_one_line(log: Path, columns: dict[str, Any], complaint: str) -> None:
    write(log / "calibration", POSES, columns)
    with pytest.raises(InputError, match=complaint) as caught:
        read_rig(log)
    message = str(caught.value)
    assert message.isprintable() and len(message) < 400 and POSES in message


@pytest.mark.parametrize(
    "content", [b"", b"ARROW1", b"ARROW1\0\0" + b"\xff" * 4000, b"not arrow", b"\0" * 2_000_000]
)
def test_damaged_files_are_refused_in_one_line(log: Path, content: bytes) -> None:
    (log / "calibration" / POSES).write_bytes(content)
    with pytest.raises(InputError, match=r"damaged Feather file|at most 1000000 bytes"):
        read_rig(log)


def test_any_damaged_byte_is_read_or_refused(log: Path) -> None:
    path = log / "calibration" / POSES
    whole = path.read_bytes()
    random = np.random.default_rng(3)
    for _ in range(150):
        broken = bytearray(whole)
        for place in random.integers(0, len(whole), random.integers(1, 6)):
            broken[place] = random.integers(256)
        path.write_bytes(bytes(broken[: random.integers(len(whole) // 2, len(whole) + 1)]))
        try:
            read_rig(log)
        except InputError as error:
            assert str(error).isprintable()


def test_without_intrinsics_there_are_lidars_alone(log: Path) -> None:
    (log / "calibration" / LENSES).unlink()
    read = read_rig(log)
    assert [sensor.name for sensor in read.rig.sensors] == ["up_lidar", "down_lidar"]
