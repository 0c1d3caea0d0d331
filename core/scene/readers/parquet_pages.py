"""What the pages of a Parquet file expand to, from their headers, before any of them is decompressed.

Arrow takes as much memory as a page's header says, and as many texts as a page of prefixes or a dictionary leads to,
so a file of some kilobytes could fill the memory. Source of the format: parquet-format, PageHeader in Thrift's
compact protocol.
"""

from __future__ import annotations

import os
from collections.abc import Collection
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

from riglens.core.errors import InputError

MAX_ROWS = 1_000_000_000
MAX_FOOTER_BYTES = 1 << 25
MAX_PAGE_BYTES = 1 << 26
"""Pages have about a megabyte, whoever writes them."""
MAX_REPEATED_BYTES = 1 << 16
"""A page whose content is repeated for every row that refers to it, so that it counts thousands of times."""

_HEADER_BYTES = 1 << 12
_MAX_HEADER_BYTES = 1 << 20
_DICTIONARY_PAGE = 2
_DETAILS = {0: (5, 2), _DICTIONARY_PAGE: (7, 2), 3: (8, 4)}
"""By kind of page: the field that describes it, and the field in there that tells its encoding."""
_DELTA_BYTE_ARRAY = 7
_BYTE_ARRAY = 6
"""Number of the physical type of texts."""
_DEEPEST = 16
_DICTIONARY_READABLE = {0, 2, 3, 4, 8}
"""PLAIN, PLAIN_DICTIONARY, RLE, BIT_PACKED (of levels), RLE_DICTIONARY."""


class Page(NamedTuple):
    """What the header of one page says."""

    is_dictionary: bool
    stored_bytes: int
    full_bytes: int
    encoding: int
    header_bytes: int


def require_footer(path: Path, file: BinaryIO) -> None:
    """Raise InputError when the description at the end of the file is larger than that of any table."""
    size = file.seek(0, os.SEEK_END)
    file.seek(max(0, size - 8))
    length = int.from_bytes(file.read(8)[:4], "little")
    if length > MAX_FOOTER_BYTES:
        raise InputError(f"{path}: a footer of {length} bytes, accepted are at most {MAX_FOOTER_BYTES}")


def dictionary_columns(path: Path, file: BinaryIO, needed: Collection[str]) -> list[str]:
    """Return the columns of text that can be read as dictionaries, without repeating a text for each of its rows.

    Raise InputError when the rows are too many, or a page of a `needed` column expands too far.
    """
    rows, chunks = _footer(path, file)
    if rows > MAX_ROWS:
        raise InputError(f"{path}: {rows} rows, accepted are at most {MAX_ROWS}")
    by_name: dict[str, list[Page]] = {}
    texts = set()
    for chunk in chunks:
        if chunk.name in needed:
            by_name.setdefault(chunk.name, []).extend(_pages(path, file, chunk))
            texts |= {chunk.name} if chunk.is_text else set()
    readable = []
    for name, pages in by_name.items():
        _require_small(path, name, pages)
        if name in texts and all(page.encoding in _DICTIONARY_READABLE for page in pages):
            readable.append(name)
        elif name in texts:
            _require_unrepeated(path, name, pages)
    return readable


def _require_small(path: Path, name: str, pages: list[Page]) -> None:
    largest = max((page.full_bytes for page in pages), default=0)
    if largest > MAX_PAGE_BYTES:
        raise InputError(
            f"{path}: column {name!r}: a page of {largest} bytes, accepted are at most {MAX_PAGE_BYTES}; write the "
            "table again with smaller pages"
        )


def _require_unrepeated(path: Path, name: str, pages: list[Page]) -> None:
    repeated = (page.is_dictionary or page.encoding == _DELTA_BYTE_ARRAY for page in pages)
    largest = max((page.full_bytes for page, is_it in zip(pages, repeated, strict=True) if is_it), default=0)
    if largest > MAX_REPEATED_BYTES:
        raise InputError(
            f"{path}: column {name!r}: a page of {largest} bytes in an encoding that repeats text, accepted "
            f"are at most {MAX_REPEATED_BYTES}; write the table again with plain or dictionary encoding"
        )


class Chunk(NamedTuple):
    """Where the pages of one column of one row group are, as the footer says."""

    name: str
    is_text: bool
    values: int
    stored_bytes: int
    data_at: int
    dictionary_at: int


def _footer(path: Path, file: BinaryIO) -> tuple[int, list[Chunk]]:
    """Return the number of rows, and all column chunks.

    Arrow's own accessors of a damaged footer end the process: they let an exception of C++ out.
    """
    size = file.seek(0, os.SEEK_END)
    file.seek(max(0, size - 8))
    length = int.from_bytes(file.read(8)[:4], "little")
    file.seek(max(0, size - 8 - length))
    try:
        described, _ = _Compact(file.read(length)).struct()
        groups = described.get(4, [])
        rows = max(described[3], sum(group[3] for group in groups))
        return rows, [_chunk(column[3]) for group in groups for column in group[1]]
    except (IndexError, KeyError, TypeError, ValueError, AttributeError) as error:
        raise InputError(f"{path}: damaged Parquet file (its footer)") from error


def _chunk(described: dict[int, Any]) -> Chunk:
    """Return what the fields of a ColumnMetaData say; raise KeyError, TypeError or ValueError for nonsense."""
    name = ".".join(part.decode("utf-8") for part in described[3])
    numbers = [described[number] for number in (1, 5, 7, 9)]
    kind, values, stored_bytes, data_at = (_whole(number) for number in numbers)
    return Chunk(name, kind == _BYTE_ARRAY, values, stored_bytes, data_at, _whole(described.get(11, 0)))


def _whole(value: Any) -> int:
    if not isinstance(value, int):
        raise TypeError(value)
    return value


def _pages(path: Path, file: BinaryIO, chunk: Chunk) -> list[Page]:
    """Return the pages of one column chunk, found as Arrow finds them."""
    at = chunk.dictionary_at if 0 < chunk.dictionary_at < chunk.data_at else chunk.data_at
    pages: list[Page] = []
    end = at + chunk.stored_bytes if chunk.values > 0 else 0
    while 0 <= at < end:
        page = _page(path, file, at)
        if page is None:
            break
        pages.append(page)
        at += page.header_bytes + page.stored_bytes
    return pages


def _page(path: Path, file: BinaryIO, at: int) -> Page | None:
    """Return the page at a place of the file; None at its end."""
    length = _HEADER_BYTES
    while True:
        file.seek(at)
        data = file.read(length)
        if not data:
            return None
        try:
            fields, size = _Compact(data).struct()
            page = _described(fields, size)
        except (IndexError, TypeError):
            if len(data) == length < _MAX_HEADER_BYTES:  # longer than what was read
                length = _MAX_HEADER_BYTES
                continue
            page = None
        if page is None:
            raise InputError(f"{path}: damaged Parquet file (the header of a page at byte {at})")
        return page


def _described(fields: dict[int, Any], size: int) -> Page | None:
    """Return what the fields of a PageHeader mean; None when they make no sense."""
    kind, full, stored = fields.get(1), fields.get(2), fields.get(3)
    if (
        not (isinstance(kind, int) and isinstance(full, int) and isinstance(stored, int))
        or min(full, stored) < 0
    ):
        return None
    number, encoding_number = _DETAILS.get(kind, (0, 0))
    detail = fields.get(number)
    encoding = detail.get(encoding_number) if isinstance(detail, dict) else None
    return Page(kind == _DICTIONARY_PAGE, stored, full, encoding if isinstance(encoding, int) else 0, size)


class _Compact:
    """Reads structs of Thrift's compact protocol, as far as Parquet uses it; raise IndexError past the end."""

    def __init__(self, data: bytes) -> None:
        self._data, self._at = data, 0

    def struct(self, depth: int = 0) -> tuple[dict[int, Any], int]:
        """Return the fields of a struct by number, and where it ends."""
        fields: dict[int, Any] = {}
        number = 0
        while header := self._byte():
            number = number + (header >> 4) if header >> 4 else self._signed()
            fields[number] = self._value(header & 15, depth)
        return fields, self._at

    def _value(self, kind: int, depth: int) -> Any:
        if kind in (1, 2):
            return kind == 1
        if kind == 3:
            return self._byte()
        if kind in (4, 5, 6):
            return self._signed()
        if kind == 7:
            return self._bytes(8)
        if kind == 8:
            return self._bytes(self._varint())
        if kind in (9, 10) and depth < _DEEPEST:
            return self._list(depth + 1)
        if kind == 12 and depth < _DEEPEST:
            return self.struct(depth + 1)[0]
        raise TypeError("a kind of field that Parquet does not have")

    def _list(self, depth: int) -> list[Any]:
        """Return the values of a list, of which each takes a byte at least."""
        header = self._byte()
        count, kind = header >> 4, header & 15
        count = self._varint() if count == 15 else count
        if count > len(self._data) - self._at:
            raise IndexError(count)
        if kind in (1, 2):
            return [self._byte() == 1 for _ in range(count)]
        return [self._value(kind, depth) for _ in range(count)]

    def _byte(self) -> int:
        value = self._data[self._at]
        self._at += 1
        return value

    def _varint(self) -> int:
        value = shift = 0
        while True:
            byte = self._byte()
            value |= (byte & 127) << shift
            if byte < 128:
                return value
            shift += 7
            if shift > 63:
                raise TypeError("a number of more than 64 bits")

    def _signed(self) -> int:
        value = self._varint()
        return (value >> 1) ^ -(value & 1)

    def _bytes(self, count: int) -> bytes:
        begin, self._at = self._at, self._at + count
        if self._at > len(self._data):
            raise IndexError(count)
        return self._data[begin : self._at]
