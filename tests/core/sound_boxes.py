"""Box data of every source as they should be, for tests that break them."""

import gzip
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet

from riglens.core.files import read_csv
from tests.core.argoverse_log import random_columns, write_log
from tests.core.nuscenes_folder import random_boxes, write_tables

HEADER = "seq,frame,cls,x,y,z,length,width,height,yaw"
CSV = "\n".join([HEADER, *(f"s,{i // 3},car,{i}.5,1,2,4.5,2,1.5,0.{i}" for i in range(40))]).encode()
LABEL = b"0 1 Car 0 0 -1 1 1 2 2 1.5 1.8 4.5 1 2 9 0.5\n2 1 Van 0 0 -1 1 1 2 2 1.5 1.8 4.5 1 2 9 0.5\n"
CALIB = b"R0_rect: 1 0 0 0 1 0 0 0 1\nTr_velo_to_cam: 0 -1 0 0 0 0 -1 0 1 0 0 0\n"
CORNERS = np.array([[x, y, z] for x in (0.0, 4.0) for y in (0.0, 2.0) for z in (0.0, 1.5)])


@dataclass(frozen=True)
class Sound:
    """A data set as it should be: the path to open, and the files to break, one at a time."""

    path: Path
    files: tuple[Path, ...]


def csv_file(folder: Path) -> Sound:
    (folder / "boxes.csv").write_bytes(CSV)
    return Sound(folder / "boxes.csv", (folder / "boxes.csv",))


def gzip_file(folder: Path) -> Sound:
    (folder / "boxes.csv.gz").write_bytes(gzip.compress(CSV))
    return Sound(folder / "boxes.csv.gz", (folder / "boxes.csv.gz",))


def parquet_file(folder: Path) -> Sound:
    pa.parquet.write_table(read_csv(pa.BufferReader(CSV)), folder / "boxes.parquet")
    return Sound(folder / "boxes.parquet", (folder / "boxes.parquet",))


def kitti_tracking(folder: Path) -> Sound:
    for name, data in (("label_02", LABEL), ("calib", CALIB)):
        (folder / name).mkdir()
        (folder / name / "0000.txt").write_bytes(data)
    return Sound(folder, (folder / "label_02" / "0000.txt", folder / "calib" / "0000.txt"))


def kitti_object(folder: Path) -> Sound:
    for name, data in (("label_2", LABEL.replace(b"0 1 ", b"").replace(b"2 1 ", b"")), ("calib", CALIB)):
        (folder / name).mkdir()
        (folder / name / "000000.txt").write_bytes(data)
    return Sound(folder, (folder / "label_2" / "000000.txt", folder / "calib" / "000000.txt"))


def carla_file(folder: Path) -> Sound:
    (folder / "vehicle").mkdir()
    np.save(folder / "vehicle" / "1_5.npy", CORNERS)
    return Sound(folder, (folder / "vehicle" / "1_5.npy",))


def nuscenes_tables(folder: Path) -> Sound:
    tables = write_tables(folder / "v1.0-mini", random_boxes(1, 2, 3), scenes=1, samples=2)
    return Sound(folder, tuple(sorted(tables.glob("*.json"))))


def nuscenes_compressed(folder: Path) -> Sound:
    sound = nuscenes_tables(folder)
    for file in sound.files:
        file.with_suffix(".json.gz").write_bytes(gzip.compress(file.read_bytes()))
        file.unlink()
    return Sound(folder, tuple(file.with_suffix(".json.gz") for file in sound.files))


ONCE = b"""{"meta_info": {}, "calib": {}, "frames": [{"frame_id": "1", "annos": {"names": ["Car", "Cyclist"],
"boxes_3d": [[1,-9,-1,4.5,1.8,1.5,0.5], [2,3,-1,2,1,2,0]]}}, {"frame_id": "2"}]}"""
ZOD_CALIBRATION = b'{"FC": {"lidar_extrinsics": [[0,1,0,1.5],[-1,0,0,0],[0,0,1,2],[0,0,0,1]]}}'
ZOD = b"""[{"properties": {"class": "Vehicle", "object_type": "Car", "location_3d": {"coordinates": [-2, 20, -1.25]},
"size_3d_length": 4.5, "size_3d_width": 1.8, "size_3d_height": 1.5, "orientation_3d_qw": 0.8, "orientation_3d_qx": 0,
"orientation_3d_qy": 0, "orientation_3d_qz": 0.6}}, {"properties": {"class": "TrafficSign"}}]"""
DAIR = b"""[{"type": "Car", "3d_dimensions": {"h": "1.5", "w": 1.8, "l": 4.5}, "rotation": "0.5",
"3d_location": {"x": 12.5, "y": -3, "z": -1}}]"""
OPV2V = b"""true_ego_pos: [100.0, 50.0, 0.1, 0.0, 90.0, 0.0]
vehicles:
  42: {angle: [0.0, 60.0, 0.0], center: [0.0, 0.0, 0.75], extent: [2.25, 0.9, 0.75], location: [102.0, 70.0, 0.1]}
"""


def _files(folder: Path, files: dict[str, bytes], path: str = ".") -> Sound:
    for name, data in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(data)
    return Sound(folder / path, tuple(folder / name for name in files))


def once(folder: Path) -> Sound:
    return _files(folder, {"000027/000027.json": ONCE}, "000027")


def zod(folder: Path) -> Sound:
    return _files(
        folder, {"000001/annotations/object_detection.json": ZOD, "000001/calibration.json": ZOD_CALIBRATION}
    )


def dair_v2x(folder: Path) -> Sound:
    return _files(folder, {"label/lidar/000000.json": DAIR})


def opv2v(folder: Path) -> Sound:
    return _files(folder, {"641/000069.yaml": OPV2V})


def argoverse_lz4(folder: Path) -> Sound:
    file = write_log(folder, random_columns(3, 4))
    return Sound(folder, (file,))


def argoverse_plain(folder: Path) -> Sound:
    file = write_log(folder, random_columns(3, 4), "uncompressed")
    return Sound(file, (file,))


SOURCES: tuple[Callable[[Path], Sound], ...] = (
    csv_file,
    gzip_file,
    parquet_file,
    kitti_tracking,
    kitti_object,
    carla_file,
    nuscenes_tables,
    nuscenes_compressed,
    argoverse_lz4,
    argoverse_plain,
    once,
    zod,
    dair_v2x,
    opv2v,
)
