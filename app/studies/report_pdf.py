"""The figures in a report's PDF: read out of the file as this program writes it, without any library for PDF.

Foreign files may be anything: nothing is executed, sizes have limits, and what is not found is told.
"""

from __future__ import annotations

import re
import zlib

from riglens.core.errors import InputError

FIGURES_NAME = "figures.json"
MAX_FIGURES_BYTES = 200_000_000
_SAVE_IT = f"save the attachment {FIGURES_NAME} with a PDF viewer and verify that"


def is_pdf(content: bytes) -> bool:
    """Whether this is a PDF by its first bytes."""
    return content.startswith(b"%PDF-")


def figures_in_pdf(content: bytes, where: str) -> str:
    """The text of the attached figures; InputError when there are none that this program wrote."""
    name = re.escape("\ufeff".encode("utf-16-be") + FIGURES_NAME.encode("utf-16-be"))
    found = re.search(rb"/F \(" + name + rb"\)\s*/EF <</F (\d{1,9}) 0 R>>", content)
    if found is None:
        raise InputError(
            f"{where}: found no attached {FIGURES_NAME}; accepted is a PDF made by riglens report"
        )
    head = re.search(rb"[\r\n]" + found[1] + rb" 0 obj\s*<<([^>]{0,500}?)>>\s*stream\r?\n", content)
    length = None if head is None else _length(content, head[1])
    if head is None or length is None or head.end() + length > len(content):
        raise InputError(f"{where}: the attached {FIGURES_NAME} cannot be read; {_SAVE_IT}")
    data = content[head.end() : head.end() + length]
    return (_inflated(data, where) if b"/FlateDecode" in head[1] else data).decode("utf-8", errors="replace")


def _length(content: bytes, entries: bytes) -> int | None:
    """How long a stream is: a number among its entries, or in an object that they name."""
    direct = re.search(rb"/Length (\d{1,10})(?: 0 R)?", entries)
    if direct is None or not direct[0].endswith(b" 0 R"):
        return None if direct is None else int(direct[1])
    named = re.search(rb"[\r\n]" + direct[1] + rb" 0 obj\s*(\d{1,10})\s*endobj", content)
    return None if named is None else int(named[1])


def _inflated(data: bytes, where: str) -> bytes:
    unpacker = zlib.decompressobj()
    try:
        text = unpacker.decompress(data, MAX_FIGURES_BYTES)
    except zlib.error as error:
        raise InputError(f"{where}: the attached {FIGURES_NAME} is damaged; {_SAVE_IT}") from error
    if unpacker.unconsumed_tail:
        raise InputError(
            f"{where}: the attached {FIGURES_NAME} is larger than {MAX_FIGURES_BYTES / 1e6:g} MB"
        )
    return text
