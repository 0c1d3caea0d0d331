"""Read a report back: the figures of a page or a PDF, and the differences between two of them.

Foreign files may be anything: nothing is executed, sizes have limits, and missing parts are reported.
"""

from __future__ import annotations

import json
import re
import zlib
from contextlib import suppress
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from riglens.core.errors import InputError
from riglens.core.files import open_regular
from riglens.core.rig.model import FORMAT_VERSION
from riglens.core.rig.yaml.nodes import shortened
from riglens.reporting.figures import Inputs

FIGURES_NAME = "figures.json"
MAX_BYTES = MAX_FIGURES_BYTES = 200_000_000
_ACCEPTED = "a page or PDF made by riglens report"
FIGURES_START = b'{\n "riglens_report": '
_AROUND, _HEAD = 60, 1000


def read_report(path: Path) -> bytes:
    """Return the content of a page, a PDF or its attachment; InputError where it cannot be read or is too large."""
    try:
        with open_regular(path, _ACCEPTED) as stream:
            content = stream.read(MAX_BYTES + 1)
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror} (must be {_ACCEPTED})") from error
    if len(content) > MAX_BYTES:
        raise InputError(f"{path}: too large for {_ACCEPTED} (at most {MAX_BYTES / 1e6:g} MB)")
    return content


def form_of(content: bytes) -> str:
    """Return the form of a report by its first bytes: .pdf, .html, or .json for the attachment of a PDF on its own."""
    if content.startswith(b"%PDF-"):
        return ".pdf"
    return ".json" if content.lstrip()[:1] == b"{" else ".html"


def attached_figures(content: bytes, where: str) -> dict[str, Any]:
    """Return the figures of a report; InputError when there are none."""
    form = form_of(content)
    text = figures_in_pdf(content, where) if form == ".pdf" else content.decode("utf-8", errors="replace")
    if form == ".html":
        begin = text.find('<script type="application/json" id="figures">')
        end = text.find("</script>", begin)
        if begin < 0 or end < 0:
            raise InputError(f"{where}: must be a page made by riglens report (no attached figures)")
        text = text[text.index(">", begin) + 1 : end]
    try:
        found = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise InputError(f"{where}: the attached figures are damaged") from error
    if not isinstance(found, dict) or found.get("riglens_report") != FORMAT_VERSION:
        raise InputError(f"{where}: must be a report of version {FORMAT_VERSION}")
    return found


def inputs_of(figures: dict[str, Any], where: str) -> Inputs:
    """Return the inputs of a report; InputError names the first wrong field."""
    try:
        return Inputs.model_validate(figures.get("inputs"))
    except ValidationError as error:
        first = error.errors()[0]
        field = ".".join(map(str, ("inputs", *first["loc"])))
        raise InputError(f"{where}: {shortened(field)}: {shortened(first['msg'], 200)}") from error


def first_difference(content: bytes, again: bytes) -> str | None:
    """Return the first difference between a report and the recomputed one, with its place; None if they are
    equal."""
    if content == again:
        return None
    pairs = enumerate(zip(content, again, strict=False))
    here = next((n for n, (one, other) in pairs if one != other), min(len(content), len(again)))
    if form_of(content) == ".pdf":
        return f"byte {here}, {_part_of_pdf(content, here)}"
    line = content.count(b"\n", 0, here) + 1
    return f"line {line}: report has {_around(content, here)}, recomputed {_around(again, here)}"


def _around(content: bytes, here: int) -> str:
    """Return the end of the line before a place, and some of what follows."""
    begin = max(content.rfind(b"\n", 0, here) + 1, here - _AROUND)
    return shortened(
        content[begin : here + _AROUND].split(b"\n")[0].decode("utf-8", errors="replace"), 2 * _AROUND
    )


def _part_of_pdf(content: bytes, here: int) -> str:
    """Return the page, or another object of a PDF, in which a place lies: pages come first, in their order."""
    heads = re.findall(rb"\n(\d{1,9}) 0 obj", content[:here])
    if not heads:
        return "its head"
    before_files = content[: content.find(b"/EmbeddedFile")]
    pages = re.findall(rb"\n(\d{1,9}) 0 obj\n<</Filter /FlateDecode/Length \d{1,9}>>", before_files)
    return f"page {pages.index(heads[-1]) + 1}" if heads[-1] in pages else f"object {heads[-1].decode()}"


def figures_in_pdf(content: bytes, where: str) -> str:
    """Return the text of the attached figures; InputError when there are none from this program.

    What is attached is packed: the figures are the stream that begins as they do.
    """
    for found in re.finditer(rb"stream\r?\n", content):
        with suppress(zlib.error):
            head = content[found.end() : found.end() + _HEAD]
            if zlib.decompressobj().decompress(head, len(FIGURES_START)) == FIGURES_START:
                return _unpacked(content[found.end() :], where).decode("utf-8", errors="replace")
    raise InputError(
        f"{where}: must be a PDF made by riglens report (no attached {FIGURES_NAME}). If a PDF viewer shows "
        f"that attachment, save it and verify that"
    )


def _unpacked(packed: bytes, where: str) -> bytes:
    unpacker = zlib.decompressobj()
    text = unpacker.decompress(packed, MAX_FIGURES_BYTES)
    if unpacker.unconsumed_tail and not unpacker.eof:
        raise InputError(
            f"{where}: the attached {FIGURES_NAME} is larger than {MAX_FIGURES_BYTES / 1e6:g} MB"
        )
    return text
