"""Read a JSON file that is one array of records, record by record, with bounded memory however large it is."""

from __future__ import annotations

import codecs
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from riglens.core.errors import InputError
from riglens.core.scene.boxes import Progress
from riglens.core.scene.readers.text_blocks import byte_pieces

MAX_RECORD_CHARS = 1 << 16
"""Far more than any record of a box data set; limits the search in a broken file."""

_ACCEPTED = "an array of JSON records"
_BLANKS = " \t\r\n"


class Record(NamedTuple):
    """One record and its number in the file, from 1."""

    number: int
    fields: dict[str, Any]


def json_records(path: Path, progress: Progress) -> Iterator[Record]:
    """Yield the records of a JSON array, plain or gzip-compressed; progress is the share of bytes read.

    Raise InputError, naming the record, for anything that is not an array of objects.
    """
    text, number = _Text(path, progress), 1
    if text.next_char() != "[":
        raise InputError(f"{path}: must be {_ACCEPTED}, starting with '['")
    text.skip()
    if text.next_char() == "]":
        text.skip()
    else:
        while True:
            yield Record(number, text.record(number))
            separator = text.next_char()
            text.skip()
            if separator == "]":
                break
            if separator != ",":
                found = repr(separator) if separator else "the end of the file"
                raise InputError(f"{path}: after record {number}: must be ',' or ']' (got {found})")
            number += 1
    if text.next_char():
        raise InputError(f"{path}: must be {_ACCEPTED}, with nothing after the closing ']'")


class _Text:
    """The text of a file from the current place on; more is read when needed."""

    def __init__(self, path: Path, progress: Progress) -> None:
        self._path = path
        self._pieces = byte_pieces(path, progress)
        self._decode = codecs.getincrementaldecoder("utf-8-sig")().decode
        self._scan = json.JSONDecoder().raw_decode
        self._text, self._place = "", 0

    def next_char(self) -> str:
        """Return the next non-blank character without consuming it; empty at the end of the file."""
        while True:
            while self._place < len(self._text) and self._text[self._place] in _BLANKS:
                self._place += 1
            if self._place < len(self._text):
                return self._text[self._place]
            if not self._more():
                return ""

    def skip(self) -> None:
        """Take one character."""
        self._place += 1

    def record(self, number: int) -> dict[str, Any]:
        """Read one object; raise InputError for anything else, or for one that is cut off or too long."""
        if self.next_char() != "{":
            raise InputError(f"{self._path}: record {number}: must be a JSON object, starting with '{{'")
        while True:
            try:
                fields, self._place = self._scan(self._text, self._place)
            except (ValueError, RecursionError) as error:
                # Either the rest is still to be read, or it is broken: then reading on does not help.
                if len(self._text) - self._place <= MAX_RECORD_CHARS and self._more():
                    continue
                reason = error.msg if isinstance(error, json.JSONDecodeError) else type(error).__name__
                raise InputError(
                    f"{self._path}: record {number}: must be a JSON object (broken or too long: {reason})"
                ) from error
            return dict(fields)

    def _more(self) -> bool:
        """Read on; False at the end of the file."""
        piece = next(self._pieces, None)
        try:
            more = self._decode(piece or b"", piece is None)
        except UnicodeDecodeError as error:
            raise InputError(f"{self._path}: must be UTF-8 text") from error
        self._text, self._place = self._text[self._place :] + more, 0
        return piece is not None
