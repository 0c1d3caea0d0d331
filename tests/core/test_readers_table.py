"""Box tables are streamed into whole frames, and every mistake in them is named with its line."""

import gc
import gzip
import itertools
import math
import tracemalloc
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet
import pytest

from riglens.core.errors import InputError
from riglens.core.files import read_csv
from riglens.core.scene.boxes import CLASSES, BoxBatch
from riglens.core.scene.readers import open_boxes
from riglens.core.scene.readers.common import join
from riglens.core.scene.survey import doubts

HEADER = "seq,frame,cls,x,y,z,length,width,height,yaw"
ROW = "a,{frame},{cls},1.5,-2,0.75,4.5,1.8,1.5,0.5"
Writer = Callable[[Path, str], Path]


def write_csv(folder: Path, text: str) -> Path:
    path = folder / "boxes.csv"
    path.write_text(text, encoding="utf-8")
    return path


def write_gzip(folder: Path, text: str) -> Path:
    path = folder / "boxes.csv.gz"
    path.write_bytes(gzip.compress(text.encode()))
    return path


def write_parquet(folder: Path, text: str) -> Path:
    table = read_csv(pa.BufferReader(text.encode()))
    pa.parquet.write_table(table, folder / "boxes.parquet")
    return folder / "boxes.parquet"


def table(*rows: str, header: str = HEADER) -> str:
    return "\n".join([header, *rows]) + "\n"


def boxes_of(path: Path, **options: object) -> tuple[BoxBatch, dict[str, int], int]:
    source = open_boxes(path, **options)  # type: ignore[arg-type]
    batches = list(source.batches())
    report = source.report()
    return join(batches), report.boxes, report.frames


def message(path: Path, **options: object) -> str:
    with pytest.raises(InputError) as error:
        for _ in open_boxes(path, **options).batches():  # type: ignore[arg-type]
            pass
    text = str(error.value)
    assert "\n" not in text
    return text


every_writer = pytest.mark.parametrize("write", [write_csv, write_gzip, write_parquet])


@every_writer
def test_a_box_arrives_with_class_centre_size_and_rotation(tmp_path: Path, write: Writer) -> None:
    box, counts, frames = boxes_of(write(tmp_path, table(ROW.format(frame=7, cls="Cyclist"))))
    assert (box.cls[0], box.frame[0], frames) == (CLASSES.index("bicycle"), 0, 1)
    assert counts == {"car": 0, "bicycle": 1, "pedestrian": 0}
    np.testing.assert_array_equal(box.centre_m, [[1.5, -2.0, 0.75]])
    np.testing.assert_array_equal(box.size_m, [[4.5, 1.8, 1.5]])
    ahead = [math.cos(0.5), math.sin(0.5), 0.0]
    np.testing.assert_allclose(box.rotation[0] @ [1, 0, 0], ahead, atol=1e-15)


@every_writer
def test_columns_may_come_in_any_order_and_unused_ones_are_reported(tmp_path: Path, write: Writer) -> None:
    text = table("0.5,speed,car,3,a,1,2,3,4,5,6", header="yaw,note,cls,frame,seq,x,y,z,length,width,height")
    source = open_boxes(write(tmp_path, text))
    (batch,) = source.batches()
    np.testing.assert_array_equal(batch.centre_m, [[1, 2, 3]])
    assert source.report().notes == ("columns not used: note",)


@every_writer
def test_names_that_map_to_no_class_are_counted_and_their_frames_too(tmp_path: Path, write: Writer) -> None:
    rows = [ROW.format(frame=frame, cls=cls) for frame, cls in enumerate(["Tram", "car", "Tram", "animal"])]
    source = open_boxes(write(tmp_path, table(*rows)))
    batches = list(source.batches())
    report = source.report()
    assert report.unmapped == {"Tram": 2, "animal": 1}
    assert (report.frames, report.boxes["car"], join(batches).frame.tolist()) == (4, 1, [1])


@every_writer
def test_the_user_decides_about_classes_last(tmp_path: Path, write: Writer) -> None:
    rows = [ROW.format(frame=0, cls=cls) for cls in ("Tram", "car", "truck")]
    source = open_boxes(write(tmp_path, table(*rows)), class_map={"tram": "car", "truck": "ignore"})
    list(source.batches())
    assert (source.report().boxes["car"], source.report().unmapped) == (2, {"truck": 1})


def test_an_override_to_no_class_is_refused(tmp_path: Path) -> None:
    path = write_csv(tmp_path, table(ROW.format(frame=0, cls="car")))
    assert "must map 'truck' to one of car" in message(path, class_map={"truck": "lorry"})


def test_the_origin_is_added_to_every_box(tmp_path: Path) -> None:
    path = write_csv(tmp_path, table(ROW.format(frame=0, cls="car")))
    box, _, _ = boxes_of(path, origin_m=(-1.5, 2.0, 0.25))
    np.testing.assert_array_equal(box.centre_m, [[0.0, 0.0, 1.0]])


def test_frames_are_the_distinct_pairs_of_sequence_and_frame(tmp_path: Path) -> None:
    rows = ["b,4,car", "b,4,car", "b,9,car", "a,4,car", "a,5,car"]
    path = write_csv(tmp_path, table(*[row + ",0,0,0,1,1,1,0" for row in rows]))
    box, _, frames = boxes_of(path)
    assert (frames, box.frame.tolist()) == (4, [0, 0, 1, 2, 3])


def test_a_given_number_of_frames_counts_the_empty_ones(tmp_path: Path) -> None:
    path = write_csv(tmp_path, table(*[ROW.format(frame=frame, cls="car") for frame in range(3)]))
    assert boxes_of(path, frames=10)[2] == 10
    assert "frames must be at least 3" in message(path, frames=2)
    assert "frames must be an integer from 1" in message(path, frames=0)


@every_writer
def test_a_frame_never_goes_on_in_the_next_batch(tmp_path: Path, write: Writer) -> None:
    rows = [f"s,{i // 23},car,{i}.25,0,0,4.123456789,1.123456789,1,0" for i in range(60_000)]
    batches = list(open_boxes(write(tmp_path, table(*rows))).batches())
    assert len(batches) > 1
    for before, after in itertools.pairwise(batches):
        assert before.frame[-1] + 1 == after.frame[0]
    np.testing.assert_array_equal(join(batches).frame, np.arange(60_000) // 23)
    np.testing.assert_array_equal(join(batches).centre_m[:, 0], np.arange(60_000) + 0.25)


def test_one_source_can_be_streamed_again(tmp_path: Path) -> None:
    source = open_boxes(write_csv(tmp_path, table(ROW.format(frame=0, cls="car"))))
    next(iter(source.batches()))
    with pytest.raises(RuntimeError):
        source.report()
    list(source.batches())
    list(source.batches())
    assert source.report().boxes["car"] == 1


def test_windows_line_ends_byte_order_mark_and_blank_lines_are_read(tmp_path: Path) -> None:
    path = tmp_path / "boxes.csv"
    row = ROW.format(frame=0, cls="car")
    path.write_bytes(f"\ufeff{HEADER}\r\n\r\n{row}\r\n\r\n{row}".encode())
    assert boxes_of(path)[1]["car"] == 2


def test_progress_rises_to_one(tmp_path: Path) -> None:
    rows = [f"s,{i},car,0.123456,0,0,4.123456789,1,1,0" for i in range(60_000)]
    fractions: list[float] = []
    list(open_boxes(write_csv(tmp_path, table(*rows))).batches(fractions.append))
    assert fractions == sorted(fractions)
    assert 0.0 < fractions[0] < 1.0 == fractions[-1]


def test_the_content_hash_follows_bytes_and_options_but_not_the_name(tmp_path: Path) -> None:
    path = write_csv(tmp_path, table(ROW.format(frame=0, cls="car")))
    copy = tmp_path / "copy.csv"
    copy.write_bytes(path.read_bytes())
    reference = open_boxes(path).content_hash
    assert open_boxes(copy).content_hash == reference
    variants = [
        open_boxes(path, origin_m=(1.0, 0.0, 0.0)),
        open_boxes(path, frames=5),
        open_boxes(path, class_map={"car": "ignore"}),
    ]
    copy.write_text(table(ROW.format(frame=0, cls="car"), ""), encoding="utf-8")
    hashes = {reference, open_boxes(copy).content_hash, *(source.content_hash for source in variants)}
    assert len(hashes) == 5


# ---------------------------------------------------------------- bad input

BAD_FIELDS = [
    ("x", "abc", "'abc'"),
    ("y", "", "''"),
    ("z", "nan", "nan"),
    ("x", "inf", "inf"),
    ("x", "1e7", "1e+07"),
    ("length", "-4.5", "-4.5"),
    ("width", "0", "0"),
    ("height", "1_0", "'1_0'"),
    ("yaw", "-inf", "-inf"),
    ("yaw", "1e308", "1e+308"),
    ("frame", "-1", "-1"),
    ("frame", "2.5", "'2.5'"),
    ("frame", "9" * 30, "'999"),
]


@pytest.mark.parametrize(("column", "value", "got"), BAD_FIELDS)
@pytest.mark.parametrize("write", [write_csv, write_gzip])
def test_a_broken_number_is_named_with_its_line(
    tmp_path: Path, write: Writer, column: str, value: str, got: str
) -> None:
    rows = [ROW.format(frame=frame, cls="car") for frame in range(5_000)]
    fields = rows[4709].split(",")
    fields[HEADER.split(",").index(column)] = value
    rows[4709] = ",".join(fields)
    path = write(tmp_path, table(*rows))
    assert message(path).startswith(f"{path}:4711: column {column!r}: ") and f"(got {got}" in message(path)


def test_the_line_is_right_behind_the_first_block_and_blank_lines(tmp_path: Path) -> None:
    rows = [ROW.format(frame=frame, cls="car") + "\n" for frame in range(30_000)]
    rows[29_000] = "a,29000,car,1,2,3,4,5,zero,0"
    path = write_csv(tmp_path, table(*rows))
    line = path.read_text(encoding="utf-8").split("\n").index(rows[29_000]) + 1
    assert message(path).startswith(f"{path}:{line}: column 'height': ") and "(got 'zero')" in message(path)


@pytest.mark.parametrize(
    ("row", "expected"),
    [
        ("a,1,car,1,2,3", "10 values, as in the header (got 6)"),
        (ROW.format(frame=1, cls="car") + ",extra", "10 values, as in the header (got 11)"),
        ('"' + ROW.format(frame=1, cls="car"), "one row of a CSV table"),
        (
            "a,0,car,1,2,3,4,5,6,0",
            "(got frame 0 after frame 1 of sequence 'a')",
        ),
        ("z,0,car,1,2,3,4,5,6,0", "(got sequence 'z' again)"),
    ],
)
def test_a_row_that_is_no_row_is_named_with_its_line(tmp_path: Path, row: str, expected: str) -> None:
    good = [row.format(cls="car", frame=1) for row in ("z,0,car,1,2,3,4,5,6,0", ROW, ROW)]
    after = ROW.format(frame=2, cls="car")
    path = write_csv(tmp_path, table(*good, row, after))
    text = message(path)
    assert text.startswith(f"{path}:5: ")
    assert expected in text


def test_a_quote_cannot_swallow_lines(tmp_path: Path) -> None:
    row = ROW.format(frame=0, cls="car")
    path = write_csv(tmp_path, table(row, '"' + row, '"' + row, row))
    assert message(path).startswith(f"{path}:3: ")


def test_text_that_is_not_utf8_is_named_with_its_line(tmp_path: Path) -> None:
    path = tmp_path / "boxes.csv"
    path.write_bytes(table(ROW.format(frame=0, cls="car")).encode() + b"\xff\xfe,1,car,1,2,3,4,5,6,0\n")
    assert message(path) == f"{path}:3: must be UTF-8 text"


@every_writer
def test_missing_and_doubled_columns_are_named(tmp_path: Path, write: Writer) -> None:
    path = write(tmp_path, table("a,0,car,1,2,3,4,5,0", header=HEADER.replace("height,", "")))
    assert f"column 'height' missing (a table needs {HEADER})" in message(path)


def test_a_doubled_column_is_refused(tmp_path: Path) -> None:
    path = write_csv(tmp_path, table("a,0,car,1,2,3,4,5,6,0,1", header=HEADER + ",x"))
    assert "column 'x' must appear once" in message(path)


@pytest.mark.parametrize("content", ["", HEADER, HEADER + "\n\n\n"])
def test_an_empty_table_is_refused(tmp_path: Path, content: str) -> None:
    text = message(write_csv(tmp_path, content))
    assert "empty" in text or "at least one frame" in text


@pytest.mark.parametrize("content", [b"", gzip.compress(b"", mtime=0)], ids=["no bytes", "no text"])
def test_an_empty_gzip_table_is_refused(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "boxes.csv.gz").write_bytes(content)
    assert "empty" in message(tmp_path / "boxes.csv.gz")


def test_an_empty_parquet_table_is_refused(tmp_path: Path) -> None:
    path = write_parquet(tmp_path, table(ROW.format(frame=0, cls="car")))
    pa.parquet.write_table(pa.parquet.read_table(path).slice(0, 0), path)
    assert "at least one frame" in message(path)


def test_cut_and_damaged_gzip_is_refused(tmp_path: Path) -> None:
    rows = [f"s,{i},car,{math.sin(i)},0,0,4,1,1,0" for i in range(20_000)]
    path = write_gzip(tmp_path, table(*rows))
    whole = path.read_bytes()
    for broken in (whole[: len(whole) // 2], whole[:-4], whole[:9000] + b"\0" * 64 + whole[9064:]):
        path.write_bytes(broken)
        assert message(path).startswith(str(path))


def test_a_gzip_bomb_is_refused_with_flat_memory(tmp_path: Path) -> None:
    path = tmp_path / "bomb.csv.gz"
    path.write_bytes(gzip.compress(HEADER.encode() + b"\n" + b"1" * 200_000_000, compresslevel=1))
    tracemalloc.start()
    try:
        assert "line too long" in message(path)
        assert tracemalloc.get_traced_memory()[1] < 20_000_000
    finally:
        tracemalloc.stop()


def test_parquet_columns_of_the_wrong_type_and_missing_values_are_named(tmp_path: Path) -> None:
    path = write_parquet(tmp_path, table(ROW.format(frame=0, cls="car").replace("1.5,", "wide,", 1)))
    assert "column 'x': must be numbers (got type string)" in message(path)
    good = pa.parquet.read_table(write_parquet(tmp_path, table(*[ROW.format(frame=0, cls="car")] * 3)))
    holes = pa.array([1.0, None, 2.0])
    pa.parquet.write_table(good.set_column(good.schema.get_field_index("x"), "x", holes), path)
    assert message(path).startswith(f"{path}: row 2: column 'x': ")


def test_a_yaw_in_degrees_is_doubted(tmp_path: Path) -> None:
    for yaw, facts in ((6.2, 0), (90, 1)):
        source = open_boxes(write_csv(tmp_path, table(f"a,0,car,1,2,3,4,5,6,{yaw}")))
        list(source.batches())
        assert len([doubt for doubt in doubts(source.report()) if "radians" in doubt.fact]) == facts


@pytest.mark.parametrize("name", ["boxes.csv", "boxes.parquet", "boxes.csv.gz", "picture.png"])
def test_bytes_that_are_no_table_are_refused(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + bytes(range(256)) * 300)
    assert message(path).startswith(str(path))


def test_a_path_that_holds_nothing_readable_is_refused(tmp_path: Path) -> None:
    assert "no such file or folder" in message(tmp_path / "missing.csv")
    assert "no box data in this folder" in message(tmp_path)
    assert "neither a file nor a folder" in message(Path("/dev/null"))


# ---------------------------------------------------------------- memory


def peak_bytes(path: Path) -> tuple[int, int]:
    """Largest memory of Python and numpy, and of Arrow, while a table is streamed."""
    arrow = 0
    gc.collect()  # what earlier tests left would be missed from the sum when it goes
    before = pa.total_allocated_bytes()
    tracemalloc.start()
    try:
        for _ in open_boxes(path).batches():
            arrow = max(arrow, pa.total_allocated_bytes() - before)
        return tracemalloc.get_traced_memory()[1], arrow
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize("write", [write_csv, write_gzip])
def test_memory_does_not_grow_with_the_number_of_frames(tmp_path: Path, write: Writer) -> None:
    peaks = []
    for count in (80_000, 320_000):
        rows = [f"s,{i // 5},car,{i}.5,0.25,0.75,4.5,1.875,1.5,0.5" for i in range(count)]
        peaks.append(peak_bytes(write(tmp_path, table(*rows))))
    small, large = peaks
    assert large[0] < 1.1 * small[0]
    assert large[1] <= 1.1 * small[1]
    assert small[0] < 30_000_000
