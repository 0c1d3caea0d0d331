"""Read a report back: the figures of a page or a PDF, and the differences between two of them.

Foreign files may be anything: nothing is executed, sizes have limits, and missing parts are reported.
"""

from __future__ import annotations

import base64
import hashlib
import json
import os
import re
import zlib
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from html.parser import HTMLParser
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image
from pydantic import ValidationError

from riglens.core.errors import InputError
from riglens.core.files import open_regular
from riglens.core.formats.source import is_encodable
from riglens.core.rig.model import FORMAT_VERSION
from riglens.core.rig.yaml.nodes import shortened
from riglens.reporting.figures import Inputs

FIGURES_NAME = "figures.json"
MAX_BYTES = MAX_FIGURES_BYTES = 200_000_000
_ACCEPTED = "a page or PDF made by riglens report"
FIGURES_START = b'{\n "riglens_report": '
MAX_PIXELS = 100_000_000
_AROUND, _HEAD = 60, 1000
_DIGEST = r"(?<=picture)[0-9a-f]{64}"
_FEW_COLOURS, _SQUARE_PX, _MOST_APART = 256, 8, 30.0
"""Colours of a map, edge of the squares, and the difference of their means, of 255, that drivers may make: our choice.
With and without smooth edges the picture of the nuScenes car differs by 20, with a sensor moved by 1 cm by 42 or
more."""


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
    said = figures.get("inputs")
    if not is_encodable(
        json.dumps(said, ensure_ascii=False)
    ):  # halves of characters, which no message can hold
        raise InputError(f"{where}: inputs: must be UTF-8 text")
    try:
        return Inputs.model_validate(said)
    except ValidationError as error:
        first = error.errors()[0]
        field = ".".join(map(str, ("inputs", *first["loc"])))
        raise InputError(f"{where}: {shortened(field)}: {shortened(first['msg'], 200)}") from error


# ---------------------------------------------------------------- what a report says


@dataclass(frozen=True)
class _Part:
    """Something that a report says: words, a row, a picture; `key` is what is compared, `place` where it stands."""

    place: str
    words: str
    key: str


def first_difference(content: bytes, again: bytes, where: str) -> str | None:
    """Return the first difference of what two reports of one form say, with its place; None if it is the same.

    Compared are words and rows in their order, pictures by the SHA-256 of their pixels, drawings by that of their
    outlines, and attached files; of a page also its tags, styles and scripts. Pictures of the car count as the same
    where they differ by what drivers of graphics do alike. White space, the breaks of lines and pages, and how a file
    is packed say nothing. Raise InputError for a PDF that cannot be read.
    """
    if content == again:
        return None
    say = {".pdf": _pdf_parts, ".html": _page_parts, ".json": _json_parts}[form_of(content)]
    before, after = Pixels(), Pixels()
    fresh = say(again, where, after)
    parts = _with_alike(say(content, where, before), before, fresh, after)
    texts = ["".join(part.key for part in some) for some in (parts, fresh)]
    same = len(os.path.commonprefix(texts))  # noqa: RUF071 (no paths)
    if all(len(text) == same for text in texts):
        return None
    (place, words), (_, recomputed) = _said_at(parts, same), _said_at(fresh, same)
    return f"{place}: report has {words}, recomputed {recomputed}"


def _said_at(parts: Sequence[_Part], offset: int) -> tuple[str, str]:
    """Return the place and the words of the part at an offset in all keys; some of it where it is long."""
    for part in parts:
        if offset < len(part.key):
            is_short = len(part.words) <= 2 * _AROUND
            words = part.words if is_short else part.key[max(0, offset - _AROUND) : offset + _AROUND]
            return part.place, shortened(words, 2 * _AROUND)
        offset -= len(part.key)
    return "the end", "nothing"


Pixels = dict[str, Image.Image]
"""Pictures by their digests, in the order in which they are met."""


def _with_alike(
    parts: Sequence[_Part], before: Pixels, fresh: Sequence[_Part], after: Pixels
) -> Sequence[_Part]:
    """Return parts that name the pictures of the fresh ones in place of those that look alike."""
    named, again = (re.findall(_DIGEST, "".join(part.key for part in some)) for some in (parts, fresh))
    pairs = {old: new for old, new in zip(named, again, strict=False) if old != new}
    for old, new in pairs.items():
        if old in before and new in after and look_alike(before[old], after[new]):
            parts = [replace(part, key=part.key.replace(old, new)) for part in parts]
    return parts


def look_alike(one: Image.Image, other: Image.Image) -> bool:
    """Return whether two photographs differ by less than drivers of graphics do; a map of few colours has to be equal.

    Compared are means of squares of pixels: edges are smoothed otherwise, but nothing is missing or elsewhere.
    """
    if one.size != other.size or other.getcolors(_FEW_COLOURS) is not None:
        return False
    small, means = (max(1, one.width // _SQUARE_PX), max(1, one.height // _SQUARE_PX)), []
    for image in (one, other):
        flat = Image.new("RGBA", image.size, "white")
        flat.alpha_composite(image.convert("RGBA"))
        means.append(np.asarray(flat.resize(small, Image.Resampling.BOX), np.float64))
    return bool(np.abs(means[0] - means[1]).max() <= _MOST_APART)


def _part(place: str, words: str, mark: str = "") -> _Part:
    """Return a part without its white space; `mark` keeps a tag apart from words that look like one."""
    return _Part(place, " ".join(words.split()), mark + "".join(words.split()))


def _json_parts(content: bytes, where: str, pixels: Pixels) -> list[_Part]:
    return [_part("line 1", content.decode("utf-8", errors="replace"))]


def _page_parts(content: bytes, where: str, pixels: Pixels) -> list[_Part]:
    page = _PageParts(pixels)
    page.feed(content.decode("utf-8", errors="replace"))
    page.close()
    return page.parts


class _PageParts(HTMLParser):
    def __init__(self, pixels: Pixels) -> None:
        super().__init__()
        self.parts: list[_Part] = []
        self._pixels = pixels

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        said = [f'{name}="{_embedded(value or "", self._pixels)}"' for name, value in sorted(attrs)]
        self.parts.append(_part(f"line {self.getpos()[0]}", f"<{' '.join([tag, *said])}>", "\1"))

    def handle_data(self, data: str) -> None:
        self.parts.append(_part(f"line {self.getpos()[0]}", data))


def _embedded(value: str, pixels: Pixels) -> str:
    """Return the value of an attribute, a digest for a picture."""
    head, comma, content = value.partition(";base64,")
    if not comma or not head.startswith("data:image/"):
        return value
    try:
        return _picture(base64.b64decode(content, validate=True), pixels)
    except ValueError:
        return value


def _picture(content: bytes, pixels: Pixels) -> str:
    """Return the digest of the pixels of a PNG, however they are packed, and note them."""
    with suppress(OSError, ValueError, SyntaxError), Image.open(BytesIO(content), formats=("PNG",)) as image:
        if image.width * image.height <= MAX_PIXELS:
            content = f"{image.mode} {image.size} ".encode() + image.tobytes()
            pixels[hashlib.sha256(content).hexdigest()] = image.copy()
    return f"[picture {hashlib.sha256(content).hexdigest()}]"


def _pdf_parts(content: bytes, where: str, pixels: Pixels) -> list[_Part]:
    """Return what a tagged PDF says, in the order of its tags; the words of margins last, each once."""
    from riglens.reporting.marked_pdf import marked_pages  # pdfium

    parts: list[_Part] = []
    margins: dict[str, str] = {}
    head = letters = ""
    pages, attached = marked_pages(content, where, pixels)
    for number, page in enumerate(pages, 1):
        place = f"page {number}"
        for first, (kind, words) in enumerate(page.blocks):
            if kind == "THead":  # repeated at the top of each page of a long table
                if first == 0 and words == head:
                    continue
                head = words
            parts.append(_part(place, words))
        for words in page.margins:
            if (
                len(words.strip()) <= 1
            ):  # of drawings: WeasyPrint writes anchored words letter by letter, untagged
                letters += words
            elif words.split() != [str(number), "/", str(len(pages))]:
                margins.setdefault(words, place)
    parts += [_part(place, words) for words, place in margins.items()]
    parts.append(_part("words in drawings", letters))
    return parts + [
        _part("attachments", f"[{name} {hashlib.sha256(data).hexdigest()}]") for name, data in attached
    ]


# ---------------------------------------------------------------- figures in a PDF


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
