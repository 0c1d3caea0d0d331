"""Sound box data of every source, and ways to break their bytes."""

import gzip
from collections.abc import Callable, Iterator
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

WORDS = (
    b"nan", b"NaN", b"inf", b"-Infinity", b"1e999", b"-1e308", b"1e-320", b"-0.0", b"9" * 30, b"9" * 400, b"0x1p3",
    b"1_000", b"-1", b"2147483648", b"9223372036854775808", b"", b'"', b"''", b",", b",,,,", b"\n", b"\r\n", b"\x00",
    b"\xff\xfe", b"\xef\xbb\xbf", b"\xed\xa0\x80", b"true", b"null", b"[]", b"{}", b"[" * 300, b'{"a":' * 200, b"]",
    b"}", b":", b" ", b"\t", b"Car", b"car", b"DontCare", b"\\u0000", b"\\ud800", b"cos\nsystem\n(S'x'\ntR.",
    b"\x80\x04\x95", b"\x1f\x8b", b"PAR1", b"ARROW1", b"|O8", b"<f8", b"(8, 999999999)", b"\xff\xff\xff\x7f",
    b"\xff" * 8, b"\x00" * 8,
)  # fmt: skip
"""What parsers trip over: extreme numbers, quotes, nesting, other encodings, marks of other formats, pickles."""


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


def mutated(data: bytes, random: np.random.Generator) -> bytes:
    """Some bytes changed, cut out, doubled, appended, or taken by words that parsers trip over."""
    broken = bytearray(data)
    for _ in range(int(random.integers(1, 5))):
        place = int(random.integers(0, len(broken) + 1))
        length = int(random.integers(1, 9))
        noise = random.integers(0, 256, length, dtype=np.uint8).tobytes()
        match int(random.integers(0, 7)):
            case 0:
                broken[place : place + 1] = noise[:1]
            case 1:
                del broken[place : place + length]
            case 2:
                broken[place:place] = broken[place : place + length]
            case 3:
                broken[place : place + length] = noise
            case 4:
                broken[place : place + length] = WORDS[int(random.integers(len(WORDS)))]
            case 5:
                _change_number(broken, WORDS[int(random.integers(len(WORDS)))], random)
            case 6 if random.random() < 0.2:
                del broken[place:]
    return bytes(broken)


def _change_number(data: bytearray, word: bytes, random: np.random.Generator) -> None:
    """Put a word in the place of a run of digits."""
    digits = np.flatnonzero(
        np.isin(np.frombuffer(bytes(data), np.uint8), np.frombuffer(b"0123456789", np.uint8))
    )
    if digits.size:
        start = end = int(random.choice(digits))
        while end < len(data) and data[end : end + 1].isdigit():
            end += 1
        data[start:end] = word


def broken_versions(sound: Sound, count: int, seed: int) -> Iterator[Path]:
    """`count` times one of the files broken, each time from the sound bytes; yields the file, then mends it."""
    random = np.random.default_rng(seed)
    bytes_of = {file: file.read_bytes() for file in sound.files}
    for _ in range(count):
        victim = sound.files[int(random.integers(len(sound.files)))]
        victim.write_bytes(mutated(bytes_of[victim], random))
        yield victim
        victim.write_bytes(bytes_of[victim])
