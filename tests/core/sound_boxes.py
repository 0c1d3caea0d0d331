"""Box data of every source as they should be, for tests that break them."""

import gzip
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.csv
import pyarrow.parquet

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
    pa.parquet.write_table(pa.csv.read_csv(pa.BufferReader(CSV)), folder / "boxes.parquet")
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
)
