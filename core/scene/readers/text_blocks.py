"""Read plain or gzip-compressed text in blocks of whole lines, with bounded memory."""

from __future__ import annotations

import gzip
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO, cast

from riglens.core.errors import InputError
from riglens.core.files import open_regular
from riglens.core.scene.boxes import Progress

BLOCK_BYTES = 1 << 20
MAX_LINE_BYTES = 1 << 16
MAX_EXPANSION = 200
FREE_EXPANSION_BYTES = 1 << 30
"""Tables shrink to a third or a twentieth; up to this size they may consist of nothing but repetitions."""
GZIP_MAGIC = b"\x1f\x8b"


@dataclass(frozen=True)
class TextBlock:
    """Whole lines of a file as bytes; `first_line` is the number of the first one, from 1."""

    first_line: int
    data: bytes

    @property
    def has_lines(self) -> bool:
        """Return whether there is more in it than line ends."""
        return bool(self.data.strip(b"\r\n"))

    def lines(self) -> list[tuple[int, bytes]]:
        """Yield (line number, line without its end) of every line that is not empty."""
        numbered = enumerate(self.data.split(b"\n"), start=self.first_line)
        return [(number, line) for number, line in numbered if line.strip(b"\r")]


def text_blocks(path: Path, progress: Progress) -> Iterator[TextBlock]:
    """Yield the text of a file block by block; progress is the share of the file's bytes that were read.

    Raise InputError when the compression is damaged or cut off, or a line is too long.
    """
    rest, line = b"", 1
    for piece in byte_pieces(path, progress):
        head, newline, tail = piece.rpartition(b"\n")
        data = rest + head + newline if newline else b""
        rest = tail if newline else rest + tail
        if len(rest) > MAX_LINE_BYTES:
            number = line + data.count(b"\n")
            raise InputError(
                f"{path}:{number}: line too long for a CSV table (at most {MAX_LINE_BYTES} bytes)"
            )
        if data:
            yield TextBlock(line, data)
            line += data.count(b"\n")
    if rest:
        yield TextBlock(line, rest)


def byte_pieces(path: Path, progress: Progress) -> Iterator[bytes]:
    """Yield a file's content, decompressed, piece by piece; progress is the share of its bytes that were read.

    Raise InputError when the compression is damaged or cut off.
    """
    size = max(1, path.stat().st_size)
    with open_regular(path, "a file of text or records") as raw:
        for piece in _decompressed(path, raw):
            yield piece
            progress(raw.tell() / size)


def _decompressed(path: Path, raw: BinaryIO) -> Iterator[bytes]:
    """Yield decompressed pieces of a file; gzip is recognised by its first bytes or by the file's name."""
    compressed = raw.read(2) == GZIP_MAGIC or path.suffix.lower() == ".gz"
    raw.seek(0)
    stream = cast(BinaryIO, gzip.GzipFile(fileobj=raw)) if compressed else raw
    total = 0
    try:
        while piece := stream.read(BLOCK_BYTES):
            total += len(piece)
            if compressed and total > max(FREE_EXPANSION_BYTES, MAX_EXPANSION * raw.tell()):
                raise InputError(f"{path}: gzip data must not expand more than {MAX_EXPANSION} times")
            yield piece
    except (EOFError, zlib.error, gzip.BadGzipFile) as error:
        raise InputError(f"{path}: damaged or truncated gzip data ({error})") from error
