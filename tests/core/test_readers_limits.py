"""Files that would take all memory, or never end, are refused in one line before they do."""

import gzip
import json
import os
import shutil
import tracemalloc
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from riglens.core.errors import InputError
from riglens.core.scene import limits
from riglens.core.scene.boxes import CLASSES, DataReport
from riglens.core.scene.readers import common, frames, kitti, nuscenes_tables, open_boxes, text_blocks
from riglens.core.scene.readers.common import ReadingTally, added_up
from tests.core.sound_boxes import (
    HEADER,
    LABEL,
    SOURCES,
    Sound,
    carla_file,
    csv_file,
    kitti_object,
    kitti_tracking,
)
from tests.core.sound_boxes import (
    nuscenes_tables as nuscenes_folder,
)

CAR = ("s", "0", "car", "1", "2", "3", "4", "5", "6", "0")
ROW = "s,{frame},{name},1,2,3,4,5,6,0\n"


def refused(path: Path, **options: int) -> str:
    """The one line with which a data set is refused."""
    with pytest.raises(InputError) as caught:
        source = open_boxes(path, **options)  # type: ignore[arg-type]
        for _ in source.batches():
            pass
    message = str(caught.value)
    assert message.isprintable() and len(message) < 600
    return message


@contextmanager
def memory_below(limit_bytes: float) -> Iterator[None]:
    """Fail when the block takes more than that at any moment."""
    tracemalloc.start()
    try:
        yield
        assert tracemalloc.get_traced_memory()[1] < limit_bytes
    finally:
        tracemalloc.stop()


def table(folder: Path, rows: str) -> Path:
    (folder / "boxes.csv").write_text(f"{HEADER}\n{rows}", encoding="utf-8")
    return folder / "boxes.csv"


@pytest.mark.parametrize("make", SOURCES, ids=lambda make: make.__name__)
@pytest.mark.parametrize("target", ["device", "pipe"])
def test_no_reader_waits_for_a_pipe_or_reads_a_device(
    tmp_path: Path, make: Callable[[Path], Sound], target: str
) -> None:
    """A link to /dev/zero never ends, a pipe that nobody writes to never answers; nuScenes calls them missing."""
    sound = make(tmp_path)
    for victim in sound.files:
        content = victim.read_bytes()
        victim.unlink()
        if target == "device":
            victim.symlink_to("/dev/zero")
        else:
            os.mkfifo(victim)
        with memory_below(30e6):
            message = refused(sound.path)
        assert (
            "(got a" in message
            or "missing" in message
            or "no box data" in message
            or ("neither a file nor a folder" in message)
        )
        victim.unlink()
        victim.write_bytes(content)


def test_the_hash_of_a_data_set_waits_for_no_pipe(tmp_path: Path) -> None:
    source = open_boxes(csv_file(tmp_path).path)
    (tmp_path / "boxes.csv").unlink()
    os.mkfifo(tmp_path / "boxes.csv")
    with pytest.raises(InputError, match="got a pipe"):
        _ = source.content_hash


def test_devices_and_pipes_themselves_are_no_data_set(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    assert "neither a file nor a folder" in refused(Path("/dev/zero"))
    assert "neither a file nor a folder" in refused(tmp_path / "pipe")


def test_very_many_class_names_are_refused(tmp_path: Path) -> None:
    names = [f"thing {number}" for number in range(limits.MAX_NAMES + 1)]
    rows = [ROW.format(frame=0, name=name) for name in names]
    path = table(tmp_path, "".join(rows[:-1]))
    source = open_boxes(path)
    assert list(source.batches()) == []
    assert len(source.report().unmapped) == limits.MAX_NAMES
    assert "boxes.csv: too many class names" in refused(table(tmp_path, "".join(rows)))


def test_names_of_several_data_sets_are_counted_together() -> None:
    def report(first: int) -> DataReport:
        tally = ReadingTally()
        tally.miss((f"{number}" for number in range(first, first + 6000)), "one")
        return DataReport("one", 1, dict.fromkeys(CLASSES, 0), tally.unmapped)

    assert len(added_up("all", "", [report(0), report(3000)]).unmapped) == 9000
    with pytest.raises(InputError, match="all: too many class names"):
        added_up("all", "", [report(0), report(6000)])


@pytest.mark.parametrize("column", ["seq", "cls"])
def test_names_of_absurd_length_are_refused_with_their_line(tmp_path: Path, column: str) -> None:
    def rows(length: int) -> str:
        row = dict(zip(HEADER.split(","), CAR, strict=True))
        return "s,0,car,1,2,3,4,5,6,0\n" + ",".join((row | {column: "n" * length}).values()) + "\n"

    assert len(list(open_boxes(table(tmp_path, rows(limits.MAX_NAME_CHARS))).batches())) > 0
    message = refused(table(tmp_path, rows(limits.MAX_NAME_CHARS + 1)))
    assert f"boxes.csv:3: column '{column}': " in message and "(got 201)" in message


def test_very_many_sequences_are_refused_with_their_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(frames, "MAX_SEQUENCES", 3)
    rows = [f"q{number},0,car,1,2,3,4,5,6,0\n" for number in range(4)]
    assert sum(1 for _ in open_boxes(table(tmp_path, "".join(rows[:3]))).batches()) > 0
    assert "boxes.csv:5: too many sequences" in refused(table(tmp_path, "".join(rows)))


@pytest.mark.parametrize("count", [0, -1, limits.MAX_FRAMES + 1, 10**400])
def test_impossible_numbers_of_frames_are_refused(tmp_path: Path, count: int) -> None:
    path = csv_file(tmp_path).path
    got = str(count) if count < 10**12 else "a very large number"
    for place in (path, tmp_path):
        assert "frames must be" in (said := refused(place, frames=count)) and f"(got {got})" in said
    report = DataReport("x", limits.MAX_FRAMES + 1, dict.fromkeys(CLASSES, 0))
    with pytest.raises(InputError, match=r"x: .*got 1000000001"):
        common.with_all_frames(report, None)


def test_compressed_data_that_expand_absurdly_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(text_blocks, "FREE_EXPANSION_BYTES", 1 << 22)
    blanks = HEADER.encode() + b"\n" * 9_000_000
    (tmp_path / "boxes.csv.gz").write_bytes(gzip.compress(blanks))
    assert "expand more than 200 times" in refused(tmp_path / "boxes.csv.gz")
    (tmp_path / "nuscenes").mkdir()
    sound = nuscenes_folder(tmp_path / "nuscenes")
    victim = sound.files[0]
    victim.with_suffix(".json.gz").write_bytes(gzip.compress(b" " * 9_000_000 + victim.read_bytes()))
    victim.unlink()
    assert "expand more than 200 times" in refused(sound.path)


def test_repetitive_tables_of_ordinary_size_are_read(tmp_path: Path) -> None:
    rows = f"{HEADER}\n" + "s,0,Tram,1,2,3,4,5,6,0\n" * 100_000
    (tmp_path / "boxes.csv.gz").write_bytes(gzip.compress(rows.encode(), 9))
    source = open_boxes(tmp_path / "boxes.csv.gz")
    assert list(source.batches()) == []
    assert source.report().unmapped["Tram"] == 100_000


@pytest.mark.parametrize("make", [kitti_tracking, kitti_object], ids=lambda make: make.__name__)
@pytest.mark.parametrize("which", [0, 1], ids=["label", "calib"])
def test_kitti_lines_of_megabytes_are_refused_without_being_split(
    tmp_path: Path, make: Callable[[Path], Sound], which: int
) -> None:
    sound = make(tmp_path)
    sound.files[which].write_bytes(b"1 " * 8_000_000)
    with memory_below(5e6):
        assert ":1: line too long" in refused(sound.path)


def test_kitti_files_of_very_many_lines_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    sound = kitti_tracking(tmp_path)
    monkeypatch.setattr(kitti, "MAX_LINES", len(LABEL.splitlines()))
    assert list(open_boxes(sound.path).batches())
    sound.files[0].write_bytes(LABEL * 2)
    assert "0000.txt: too many lines" in refused(sound.path)


def test_kitti_files_beyond_their_size_are_refused_unread(tmp_path: Path) -> None:
    sound = kitti_tracking(tmp_path)
    with sound.files[1].open("wb") as file:
        file.truncate(kitti.MAX_FILE_BYTES + 1)
    with memory_below(5e6):
        assert "0000.txt: too large" in refused(sound.path)


def test_kitti_types_of_absurd_length_are_refused(tmp_path: Path) -> None:
    sound = kitti_tracking(tmp_path)
    sound.files[0].write_bytes(LABEL.replace(b"Van", b"V" * 201))
    assert "0000.txt:2: type: must be at most 200 characters (got 201)" in refused(sound.path)


def test_carla_files_beyond_their_size_are_not_read(tmp_path: Path) -> None:
    sound = carla_file(tmp_path)
    with sound.files[0].open("wb") as file:
        file.truncate(1 << 30)
    with memory_below(5e6):
        assert "too large" in refused(sound.path)


@pytest.mark.parametrize("make", [kitti_object, carla_file, csv_file], ids=lambda make: make.__name__)
def test_folders_of_very_many_files_are_refused(
    tmp_path: Path, make: Callable[[Path], Sound], monkeypatch: pytest.MonkeyPatch
) -> None:
    sound = make(tmp_path)
    monkeypatch.setattr(limits, "MAX_FILES", 1)
    assert list(open_boxes(tmp_path).batches())
    first = sound.files[0]
    (first.parent / f"2_6{first.suffix}").write_bytes(first.read_bytes())
    assert "too many files" in refused(tmp_path)


@pytest.mark.parametrize("name", ["sample", "instance", "category", "sensor", "calibrated_sensor"])
def test_nuscenes_tables_that_are_held_in_memory_are_bounded(
    tmp_path: Path, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    sound = nuscenes_folder(tmp_path)
    (victim,) = (file for file in sound.files if file.stem == name)
    records = json.loads(victim.read_text(encoding="utf-8"))
    extra = [records[0] | {"token": f"more {number}", "timestamp": number} for number in range(200)]
    monkeypatch.setattr(nuscenes_tables, "MAX_KEPT_RECORDS", 150)
    assert list(open_boxes(sound.path).batches())
    victim.write_text(json.dumps(records + extra), encoding="utf-8")
    assert f"{name}.json: too many records" in refused(sound.path)


def test_nuscenes_texts_of_absurd_length_are_refused(tmp_path: Path) -> None:
    sound = nuscenes_folder(tmp_path)
    (victim,) = (file for file in sound.files if file.stem == "category")
    records = json.loads(victim.read_text(encoding="utf-8"))
    victim.write_text(json.dumps([*records[:-1], records[-1] | {"name": "n" * 201}]), encoding="utf-8")
    assert "'name'" in refused(sound.path)


def test_a_file_that_cannot_be_opened_is_named(tmp_path: Path) -> None:
    path = csv_file(tmp_path).path
    source = open_boxes(path)
    path.unlink()
    path.mkdir()
    with pytest.raises(InputError, match=r"boxes\.csv: cannot be read"):
        list(source.batches())
    shutil.rmtree(path)
    with pytest.raises(InputError, match=r"boxes\.csv: cannot be read"):
        _ = source.content_hash
