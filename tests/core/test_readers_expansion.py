"""Parquet and Feather files of some kilobytes that expand to gigabytes are refused before they do."""

import contextlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.csv
import pyarrow.feather
import pyarrow.parquet
import pytest

from riglens.core.errors import InputError
from riglens.core.scene.readers import argoverse, open_boxes, parquet_pages
from riglens.core.scene.readers import rows as row_readers
from riglens.core.scene.readers.feather_sizes import MAGIC_BYTES, feather_sizes
from tests.core.argoverse_log import random_columns, write_log
from tests.core.broken_files import CSV

_POOLS: list[pa.MemoryPool] = []
"""Arrow's buffers do not keep their pool alive."""
ROWS = pa.csv.read_csv(pa.BufferReader(CSV))


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
        assert "boxes.parquet: row 1: column 'cls': found 300000 characters" in refused(path)


@pytest.mark.parametrize("version", ["1.0", "2.0"])
def test_pages_that_expand_far_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, version: str
) -> None:
    how: dict[str, Any] = {
        "use_dictionary": False,
        "data_page_size": 1 << 28,
        "compression": "zstd",
        "data_page_version": version,
    }
    path = write(tmp_path, many(300_000), max_rows_per_page=300_000, **how)
    monkeypatch.setattr(parquet_pages, "MAX_PAGE_BYTES", 1 << 22)
    assert len(list(open_boxes(path).batches())) > 0
    monkeypatch.setattr(parquet_pages, "MAX_PAGE_BYTES", 1 << 20)
    with arrow_memory_below(2e6):
        assert "a page of 15000" in refused(path)


def test_pages_of_columns_that_are_not_used_are_not_looked_at(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    content = ROWS.append_column("note", pa.repeat("n" * 100_000, ROWS.num_rows))
    monkeypatch.setattr(parquet_pages, "MAX_PAGE_BYTES", 1 << 12)
    assert len(list(open_boxes(write(tmp_path, content)).batches())) > 0


@pytest.mark.parametrize("encoding", ["DELTA_BYTE_ARRAY", "DELTA_LENGTH_BYTE_ARRAY", "PLAIN"])
def test_short_names_are_read_in_every_encoding(tmp_path: Path, encoding: str) -> None:
    expected = list(open_boxes(write(tmp_path, ROWS)).batches())
    how: dict[str, Any] = {"use_dictionary": False, "column_encoding": {"cls": encoding, "seq": encoding}}
    texts = ROWS.set_column(0, "seq", ROWS["seq"].cast(pa.string()))
    found = list(open_boxes(write(tmp_path, texts, **how)).batches())
    for one, other in zip(found, expected, strict=True):
        assert np.array_equal(one.frame, other.frame)
        assert np.array_equal(one.centre_m, other.centre_m)


def test_texts_by_prefix_do_not_expand(tmp_path: Path) -> None:
    """Each row repeats the 2 MB of the row before by its length alone."""
    how: dict[str, Any] = {"use_dictionary": False, "column_encoding": {"cls": "DELTA_BYTE_ARRAY"}}
    names = pa.array([f"{'n' * 200_000}{number}" for number in range(300)])
    content = many(300).drop_columns(["cls"]).append_column("cls", names)
    path = write(tmp_path, content, compression="zstd", data_page_size=1 << 28, **how)
    assert path.stat().st_size < 40_000
    with arrow_memory_below(5e6):
        assert "an encoding that repeats text" in refused(path)


def test_more_rows_than_any_data_set_has_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write(tmp_path, many(5000))
    monkeypatch.setattr(parquet_pages, "MAX_ROWS", 4999)
    assert "5000 rows, accepted are at most 4999" in refused(path)
    monkeypatch.setattr(parquet_pages, "MAX_ROWS", 5000)
    assert len(list(open_boxes(path).batches())) == 1
    monkeypatch.setattr(
        row_readers, "MAX_ROWS", 4999
    )  # where the description at the end says fewer than there are
    assert "more than 4999 rows" in refused(path)


def test_a_footer_of_gigabytes_is_not_read(tmp_path: Path) -> None:
    path = write(tmp_path, ROWS)
    content = path.read_bytes()
    path.write_bytes(content[:-8] + (1 << 31).to_bytes(4, "little") + content[-4:])
    assert "a footer of 2147483648 bytes" in refused(path)


def test_pages_are_found_as_arrow_finds_them(tmp_path: Path) -> None:
    path = write(
        tmp_path, many(5000, cls="car"), row_group_size=1000, data_page_size=100, write_batch_size=100
    )
    metadata = pa.parquet.read_metadata(path)
    columns = [
        metadata.row_group(group).column(index) for group in range(5) for index in range(metadata.num_columns)
    ]
    with path.open("rb") as file:
        number, chunks = parquet_pages._footer(path, file)
        assert number == 5000
        for column, chunk in zip(columns, chunks, strict=True):
            pages = parquet_pages._pages(path, file, chunk)
            full = sum(page.header_bytes + page.full_bytes for page in pages)
            assert full == column.total_uncompressed_size
            assert chunk.name == column.path_in_schema
            assert chunk.is_text == (column.physical_type == "BYTE_ARRAY")
            assert len(pages) > 2 or chunk.name != "x"


def test_a_damaged_footer_is_refused_where_arrow_would_end_the_process(tmp_path: Path) -> None:
    """Every byte of the footer changed in turn; a child would not come back from an abort, so this process is it."""
    path = write(tmp_path, many(20))
    sound = path.read_bytes()
    length = int.from_bytes(sound[-8:-4], "little")
    for place in range(len(sound) - 8 - length, len(sound) - 8):
        damaged = bytearray(sound)
        damaged[place] ^= 0x55
        path.write_bytes(bytes(damaged))
        with contextlib.suppress(InputError), path.open("rb") as file:
            parquet_pages._footer(path, file)


def log_of(rows: int, folder: Path, compression: str = "zstd", **columns: object) -> Path:
    one = {name: values[0] for name, values in random_columns(1, 1).items()} | columns
    return write_log(
        folder, {name: pa.repeat(pa.scalar(value), rows) for name, value in one.items()}, compression
    )  # type: ignore[misc]


@pytest.mark.parametrize("compression", ["zstd", "lz4"])
def test_logs_of_millions_of_rows_are_refused_unread(tmp_path: Path, compression: str) -> None:
    path = log_of(argoverse.MAX_ROWS + 1, tmp_path, compression)
    with arrow_memory_below(1e6):
        assert "more than 500000 rows" in refused(path)


@pytest.mark.parametrize("column", ["category", "note"])
def test_logs_that_expand_far_are_refused_unread(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, column: str
) -> None:
    path = log_of(20, tmp_path, **{column: "n" * 1_000_000})
    assert path.stat().st_size < 20_000
    assert (column == "note" and list(open_boxes(path).batches())) or "more than 200 characters" in refused(
        path
    )
    monkeypatch.setattr(argoverse, "MAX_FULL_BYTES", 19 << 20)
    with arrow_memory_below(1e6):
        assert "expands to more than 19 MiB" in refused(path)


@pytest.mark.parametrize("compression", ["zstd", "lz4", "uncompressed"])
@pytest.mark.parametrize("as_dictionary", [False, True])
def test_sizes_of_a_log_are_those_that_arrow_takes(
    tmp_path: Path, compression: str, as_dictionary: bool
) -> None:
    columns: dict[str, Any] = dict(random_columns(5, 200))
    if as_dictionary:
        columns["category"] = pa.array(columns["category"]).dictionary_encode()
    data = pa.py_buffer(write_log(tmp_path, columns, compression).read_bytes())
    sizes = feather_sizes(data.slice(MAGIC_BYTES))
    content = pa.ipc.open_file(data).read_all()
    assert sizes.batches == 1 and sizes.rows == 1000
    assert content.nbytes <= sizes.full_bytes <= content.nbytes + 64 * 13
    assert len(list(open_boxes(tmp_path / "annotations.feather").batches())) > 0


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
    assert "more than 10000 class names" in refused(path)
