"""Whatever a byte of the input turns into, a reader reads it or refuses it in one line: no crash, no hang."""

import gzip
import shutil
import warnings
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.csv
import pyarrow.parquet
import pytest

from core.errors import InputError
from core.scene.readers import open_boxes

HEADER = "seq,frame,cls,x,y,z,length,width,height,yaw"
CSV = "\n".join([HEADER, *(f"s,{i // 3},car,{i}.5,1,2,4.5,2,1.5,0.{i}" for i in range(40))]).encode()
LABEL = b"0 1 Car 0 0 -1 1 1 2 2 1.5 1.8 4.5 1 2 9 0.5\n2 1 Van 0 0 -1 1 1 2 2 1.5 1.8 4.5 1 2 9 0.5\n"
CALIB = b"R0_rect: 1 0 0 0 1 0 0 0 1\nTr_velo_to_cam: 0 -1 0 0 0 0 -1 0 1 0 0 0\n"
CORNERS = np.array([[x, y, z] for x in (0.0, 4.0) for y in (0.0, 2.0) for z in (0.0, 1.5)])


def csv_file(folder: Path) -> tuple[Path, Path]:
    (folder / "boxes.csv").write_bytes(CSV)
    return folder / "boxes.csv", folder / "boxes.csv"


def gzip_file(folder: Path) -> tuple[Path, Path]:
    (folder / "boxes.csv.gz").write_bytes(gzip.compress(CSV))
    return folder / "boxes.csv.gz", folder / "boxes.csv.gz"


def parquet_file(folder: Path) -> tuple[Path, Path]:
    pa.parquet.write_table(pa.csv.read_csv(pa.BufferReader(CSV)), folder / "boxes.parquet")
    return folder / "boxes.parquet", folder / "boxes.parquet"


def kitti_label(folder: Path) -> tuple[Path, Path]:
    for name, data in (("label_02", LABEL), ("calib", CALIB)):
        (folder / name).mkdir()
        (folder / name / "0000.txt").write_bytes(data)
    return folder, folder / "label_02" / "0000.txt"


def kitti_calibration(folder: Path) -> tuple[Path, Path]:
    kitti_label(folder)
    return folder, folder / "calib" / "0000.txt"


def carla_file(folder: Path) -> tuple[Path, Path]:
    (folder / "vehicle").mkdir()
    np.save(folder / "vehicle" / "1_5.npy", CORNERS)
    return folder, folder / "vehicle" / "1_5.npy"


def mutated(data: bytes, random: np.random.Generator) -> bytes:
    """Some bytes changed, cut out, doubled or appended."""
    broken = bytearray(data)
    for _ in range(int(random.integers(1, 5))):
        place = int(random.integers(0, len(broken) + 1))
        length = int(random.integers(1, 9))
        kind = int(random.integers(0, 4))
        noise = random.integers(0, 256, length, dtype=np.uint8).tobytes()
        if kind == 0:
            broken[place : place + 1] = noise[:1]
        elif kind == 1:
            del broken[place : place + length]
        elif kind == 2:
            broken[place:place] = broken[place : place + length]
        else:
            broken[place : place + length] = noise
    return bytes(broken)


@pytest.mark.parametrize(
    "make", [csv_file, gzip_file, parquet_file, kitti_label, kitti_calibration, carla_file]
)
def test_broken_bytes_are_read_or_refused_in_one_line(tmp_path: Path, make: object) -> None:
    path, victim = make(tmp_path)  # type: ignore[operator]
    sound = victim.read_bytes()
    list(open_boxes(path).batches())
    random = np.random.default_rng(20260)
    refused = 0
    for _ in range(150):
        victim.write_bytes(mutated(sound, random))
        try:
            with warnings.catch_warnings(action="ignore"):
                source = open_boxes(path)
                for batch in source.batches():
                    assert np.isfinite(batch.centre_m).all()
                    assert (batch.size_m > 0).all()
                    assert (np.diff(batch.frame) >= 0).all()
                assert source.report().frames > 0
        except InputError as error:
            refused += 1
            assert "\n" not in str(error)
            assert len(str(error)) < 600
    assert refused > 20


def test_a_file_that_cannot_be_opened_is_named(tmp_path: Path) -> None:
    path, _ = csv_file(tmp_path)
    source = open_boxes(path)
    path.unlink()
    path.mkdir()
    with pytest.raises(InputError, match=r"boxes\.csv: cannot be read"):
        list(source.batches())
    shutil.rmtree(path)
    with pytest.raises(InputError, match=r"boxes\.csv: cannot be read"):
        _ = source.content_hash
