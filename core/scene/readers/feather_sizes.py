"""How many rows and bytes a Feather file expands to, from the headers of its messages, before it is decompressed.

Source of the format: Arrow's Message.fbs (tables of flatbuffers) and the columnar format's page on IPC: a compressed
buffer begins with its length, eight bytes, after decompression.
"""

from __future__ import annotations

import struct
from typing import NamedTuple

import pyarrow as pa

MAGIC_BYTES = 8
_NOT_COMPRESSED = -1
_DICTIONARY, _RECORDS = 2, 3


class Sizes(NamedTuple):
    """What the messages of a file expand to; `batches` counts those with rows."""

    batches: int
    rows: int
    full_bytes: int


def feather_sizes(stream: pa.Buffer) -> Sizes:
    """Return the sizes of a stream of Arrow messages; raise ValueError or pa.ArrowException where it is broken."""
    batches = rows = full_bytes = 0
    for message in pa.ipc.MessageReader.open_stream(stream):
        table = _Table.root(message.metadata.to_pybytes())
        kind = table.number(1, "<B")
        if kind not in (_DICTIONARY, _RECORDS):
            continue
        header = table.table(2)
        records = header.table(1) if kind == _DICTIONARY else header
        full_bytes += _full_bytes(records, message.body)
        if kind == _RECORDS:
            batches, rows = batches + 1, rows + records.number(0, "<q")
    return Sizes(batches, rows, full_bytes)


def _full_bytes(records: _Table, body: pa.Buffer | None) -> int:
    is_compressed, total = records.place(3) is not None, 0
    data = memoryview(body) if body is not None else memoryview(b"")
    for offset, length in records.pairs(2):
        if length < 0:
            raise ValueError("a buffer of negative length")
        full = _at(data, "<q", offset) if is_compressed and length else length
        if full < _NOT_COMPRESSED:
            raise ValueError("a buffer of negative length")
        total += length if full == _NOT_COMPRESSED else full
    return total


class _Table:
    """A table of a flatbuffer: fields by number, absent ones at their default."""

    def __init__(self, data: bytes, at: int) -> None:
        self._data, self._at = data, at

    @classmethod
    def root(cls, data: bytes) -> _Table:
        return cls(data, _at(data, "<I", 0))

    def place(self, field: int) -> int | None:
        """Return where a field is, None when it is absent."""
        table = self._at - _at(self._data, "<i", self._at)
        if 4 + 2 * field + 2 > _at(self._data, "<H", table):
            return None
        offset = _at(self._data, "<H", table + 4 + 2 * field)
        return self._at + offset if offset else None

    def number(self, field: int, kind: str) -> int:
        place = self.place(field)
        return 0 if place is None else _at(self._data, kind, place)

    def table(self, field: int) -> _Table:
        return _Table(self._data, self._target(field))

    def pairs(self, field: int) -> list[tuple[int, int]]:
        """Return a vector of structs of two numbers of 64 bits; empty when absent."""
        if self.place(field) is None:
            return []
        start = self._target(field)
        count = _at(self._data, "<I", start)
        if count > len(self._data) // 16:
            raise ValueError("a vector beyond the end of its message")
        places = range(start + 4, start + 4 + 16 * count, 16)
        return [(_at(self._data, "<q", place), _at(self._data, "<q", place + 8)) for place in places]

    def _target(self, field: int) -> int:
        place = self.place(field)
        if place is None:
            raise ValueError("a message without its header")
        return place + _at(self._data, "<I", place)


def _at(data: bytes | memoryview, kind: str, place: int) -> int:
    """Return the number at a place; raise ValueError when it lies outside."""
    if not 0 <= place <= len(data) - struct.calcsize(kind):
        raise ValueError("a place outside of its message")
    (value,) = struct.unpack_from(kind, data, place)
    return int(value)
