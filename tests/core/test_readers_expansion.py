"""Parquet and Feather files that expand or announce far more than a data set holds are refused."""

import contextlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.feather
import pyarrow.parquet
import pytest

from riglens.core.errors import InputError
from riglens.core.files import read_csv
from riglens.core.scene.readers import argoverse, open_boxes
from riglens.core.scene.readers import rows as row_readers
from tests.core.argoverse_log import random_columns, write_log
from tests.core.sound_boxes import CSV

_POOLS: list[pa.MemoryPool] = []
"""Arrow's buffers do not keep their pool alive."""
ROWS = read_csv(pa.BufferReader(CSV))


def many(rows: int, **columns: object) -> pa.Table:
    """A table of that many equal rows in one frame, some columns exchanged for another value."""
    values = {name: column[0].as_py() for name, column in zip(ROWS.column_names, ROWS.columns, strict=True)}
    return pa.table({name: pa.repeat(value, rows) for name, value in (values | columns).items()})


def write(folder: Path, content: pa.Table, **how: Any) -> Path:
    pa.parquet.write_table(content, folder / "boxes.parquet", **how)
    return folder / "boxes.parquet"


def refused(path: Path) -> str:
    with pytest.raises(InputError) as caught:
        for _ in open_boxes(path).batches():
            pass
    message = str(caught.value)
    assert message.isprintable() and str(path) in message and len(message) < 600
    return message


@contextmanager
def arrow_memory_below(limit_bytes: float) -> Iterator[None]:
    """Fail when Arrow takes more than that at any moment of the block."""
    before, pool = pa.default_memory_pool(), pa.proxy_memory_pool(pa.default_memory_pool())
    _POOLS.append(pool)
    pa.set_memory_pool(pool)
    try:
        yield
        assert (pool.max_memory() or 0) < limit_bytes
    finally:
        pa.set_memory_pool(before)


def test_a_long_name_is_not_repeated_for_each_row(tmp_path: Path) -> None:
    """One name of 300 kB, which 16,000 rows refer to: 4.8 GB when it is written out."""
    names = pa.DictionaryArray.from_arrays(np.zeros(16_000, np.int32), pa.array(["n" * 300_000]))
    content = many(16_000).drop_columns(["cls"]).append_column("cls", names)
    path = write(tmp_path, content, compression="zstd", store_schema=False)
    assert path.stat().st_size < 20_000
    with arrow_memory_below(50e6):
        assert "boxes.parquet: row 1: column 'cls': " in refused(path)


@pytest.mark.parametrize("encoding", ["DELTA_BYTE_ARRAY", "DELTA_LENGTH_BYTE_ARRAY", "PLAIN"])
def test_short_names_are_read_in_every_encoding(tmp_path: Path, encoding: str) -> None:
    expected = list(open_boxes(write(tmp_path, ROWS)).batches())
    how: dict[str, Any] = {"use_dictionary": False, "column_encoding": {"cls": encoding, "seq": encoding}}
    texts = ROWS.set_column(0, "seq", ROWS["seq"].cast(pa.string()))
    found = list(open_boxes(write(tmp_path, texts, **how)).batches())
    for one, other in zip(found, expected, strict=True):
        assert np.array_equal(one.frame, other.frame)
        assert np.array_equal(one.centre_m, other.centre_m)


def test_more_rows_than_any_data_set_has_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write(tmp_path, many(5000))
    monkeypatch.setattr(row_readers, "MAX_ROWS", 5000)
    assert len(list(open_boxes(path).batches())) == 1
    monkeypatch.setattr(row_readers, "MAX_ROWS", 4999)
    assert "at most 4999 rows" in refused(path)


def test_a_footer_of_gigabytes_is_not_read(tmp_path: Path) -> None:
    path = write(tmp_path, ROWS)
    content = path.read_bytes()
    path.write_bytes(content[:-8] + (1 << 31).to_bytes(4, "little") + content[-4:])
    assert "(got 2147483648)" in refused(path)


@pytest.mark.parametrize("step", [3, pytest.param(1, marks=pytest.mark.slow)])
def test_damaged_footers_never_end_the_process(tmp_path: Path, step: int) -> None:
    """Bytes of the footer changed in turn; Arrow aborts where its accessors of metadata meet nonsense."""
    path = write(tmp_path, many(20))
    sound = path.read_bytes()
    length = int.from_bytes(sound[-8:-4], "little")
    for place in range(len(sound) - 8 - length, len(sound) - 8, step):
        damaged = bytearray(sound)
        damaged[place] ^= 0x55
        path.write_bytes(bytes(damaged))
        with contextlib.suppress(InputError):
            list(open_boxes(path).batches())


def log_of(rows: int, folder: Path, compression: str = "zstd", **columns: object) -> Path:
    one = {name: values[0] for name, values in random_columns(1, 1).items()} | columns
    return write_log(
        folder, {name: pa.repeat(pa.scalar(value), rows) for name, value in one.items()}, compression
    )  # type: ignore[misc]


@pytest.mark.parametrize(
    ("limits", "message"),
    [({"rows": 40}, "at most 40 rows"), ({"memory_bytes": 1 << 20}, "at most 1048576 bytes")],
)
def test_logs_beyond_their_limits_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, limits: dict[str, int], message: str
) -> None:
    path = log_of(41, tmp_path, category="n" * 100_000)
    assert path.stat().st_size < 20_000
    monkeypatch.setattr(argoverse, "LOG", replace(argoverse.LOG, **limits))
    assert message in refused(path)


def test_columns_of_a_log_that_are_not_used_take_no_memory(tmp_path: Path) -> None:
    path = log_of(200, tmp_path, note="n" * 1_000_000)
    with arrow_memory_below(20e6):
        assert list(open_boxes(path).batches())


def test_a_log_cut_off_before_its_end_is_refused(tmp_path: Path) -> None:
    path = write_log(tmp_path, random_columns(2, 2))
    content = path.read_bytes()
    for length in range(0, len(content), 41):
        path.write_bytes(content[:length])
        assert "damaged Feather file" in refused(path)


@pytest.mark.parametrize("make", [many, None])
def test_very_many_names_are_refused_by_count(tmp_path: Path, make: Callable[..., pa.Table] | None) -> None:
    names = [f"thing {number}" for number in range(10_001)]
    if make is None:
        one = {name: np.repeat(values, 10_001) for name, values in random_columns(1, 1).items()}
        path = write_log(tmp_path, one | {"category": np.array(names)})
    else:
        path = write(tmp_path, make(10_001).drop_columns(["cls"]).append_column("cls", pa.array(names)))
    assert "too many class names" in refused(path)
