"""Read a tagged PDF with pdfium: words, rows, pictures and outlines by its tags, and attached files."""

from __future__ import annotations

import ctypes
import hashlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

import pypdfium2
import pypdfium2.raw as raw
from PIL.Image import Image

from riglens.core.errors import InputError

MAX_PAGES, MAX_DEPTH = 10_000, 50
_BLOCKS = frozenset(("H1", "H2", "H3", "H4", "H5", "H6", "P", "Caption", "LI", "THead", "TR", "Figure"))
_CELLS = frozenset(("TH", "TD"))
_NO_MARK = -1


@dataclass(frozen=True)
class MarkedPage:
    """One page: blocks as (kind of tag, what it says) in their order, and the words outside of all tags."""

    blocks: list[tuple[str, str]]
    margins: list[str]


def marked_pages(
    content: bytes, where: str, pixels: dict[str, Image]
) -> tuple[list[MarkedPage], list[tuple[str, bytes]]]:
    """Return the pages of a PDF, and its attached files by name; InputError when it cannot be read.

    Pictures are noted among `pixels` by their digests.
    """
    try:
        with pypdfium2.PdfDocument(content) as document:
            if len(document) > MAX_PAGES:
                raise InputError(f"{where}: must have at most {MAX_PAGES} pages (got {len(document)})")
            files = [document.get_attachment(number) for number in range(document.count_attachments())]
            attached = [(file.get_name(), bytes(file.get_data())) for file in files]
            return [_read(page, pixels) for page in document], attached
    except pypdfium2.PdfiumError as error:
        raise InputError(f"{where}: damaged PDF ({error})") from error


@dataclass
class _Content:
    """Everything drawn under each mark of a page, and the marks that its tags name."""

    by_mark: dict[int, list[str]] = field(default_factory=dict)
    outlines: dict[int, Any] = field(default_factory=dict)
    named: set[int] = field(default_factory=set)


def _read(page: pypdfium2.PdfPage, pixels: dict[str, Image]) -> MarkedPage:
    drawn, text = _Content(), page.get_textpage()
    for one in page.get_objects(max_depth=MAX_DEPTH):
        mark = raw.FPDFPageObj_GetMarkedContentID(one.raw)
        if one.type == raw.FPDF_PAGEOBJ_TEXT:
            words = _text(lambda *room, one=one: raw.FPDFTextObj_GetText(one.raw, text.raw, *room), 2)
            drawn.by_mark.setdefault(mark, []).append(words)
        elif one.type == raw.FPDF_PAGEOBJ_IMAGE:
            digest = hashlib.sha256(bytes(one.get_data(decode_simple=True))).hexdigest()
            pixels[digest] = one.get_bitmap(render=True).to_pil().copy()
            drawn.by_mark.setdefault(mark, []).append(f" [picture {digest}] ")
        elif one.type == raw.FPDF_PAGEOBJ_PATH and mark != _NO_MARK:  # others are lines and grounds of tables
            drawn.outlines.setdefault(mark, hashlib.sha256()).update(_outline(one.raw).encode())
    blocks: list[tuple[str, str]] = []
    tree = raw.FPDF_StructTree_GetForPage(page.raw)
    try:
        for number in range(raw.FPDF_StructTree_CountChildren(tree)):
            _collect(raw.FPDF_StructTree_GetChildAtIndex(tree, number), drawn, blocks)
    finally:
        raw.FPDF_StructTree_Close(tree)
    others = [words for mark, some in drawn.by_mark.items() if mark not in drawn.named for words in some]
    return MarkedPage(blocks, others)


def _collect(element: Any, drawn: _Content, blocks: list[tuple[str, str]], depth: int = 0) -> None:
    """Add the blocks below a tag."""
    kind = _text(lambda *room: raw.FPDF_StructElement_GetType(element, *room))
    if kind in _BLOCKS or depth > MAX_DEPTH:
        blocks.append((kind, "".join(_words(element, kind, drawn, depth))))
        return
    blocks += [(kind, words) for words in _own(element, drawn)]
    for child in _children(element):
        _collect(child, drawn, blocks, depth + 1)


def _words(element: Any, kind: str, drawn: _Content, depth: int) -> Iterator[str]:
    """Yield what a tag and those below it say; a cell begins with a bar."""
    if kind in _CELLS:
        yield " | "
    yield from _own(element, drawn)
    if kind == "Figure":
        yield f" ({_text(lambda *room: raw.FPDF_StructElement_GetAltText(element, *room))}) "
    if depth <= MAX_DEPTH:
        for child in _children(element):
            below = _text(lambda *room, child=child: raw.FPDF_StructElement_GetType(child, *room))
            yield from _words(child, below, drawn, depth + 1)


def _own(element: Any, drawn: _Content) -> Iterator[str]:
    for number in range(raw.FPDF_StructElement_GetMarkedContentIdCount(element)):
        mark = raw.FPDF_StructElement_GetMarkedContentIdAtIndex(element, number)
        if mark != _NO_MARK:
            drawn.named.add(mark)
            yield from drawn.by_mark.get(mark, ())
            if mark in drawn.outlines:
                yield f" [drawing {drawn.outlines[mark].hexdigest()}] "


def _children(element: Any) -> Iterator[Any]:
    for number in range(raw.FPDF_StructElement_CountChildren(element)):
        if child := raw.FPDF_StructElement_GetChildAtIndex(element, number):
            yield child


def _outline(path: Any) -> str:
    """Return the points of a path in units of its drawing, and the colours that it is drawn in."""
    x, y = ctypes.c_float(), ctypes.c_float()
    said = []
    for number in range(raw.FPDFPath_CountSegments(path)):
        segment = raw.FPDFPath_GetPathSegment(path, number)
        raw.FPDFPathSegment_GetPoint(segment, x, y)
        said.append(f"{raw.FPDFPathSegment_GetType(segment)} {x.value:.2f} {y.value:.2f}")
    rgba, filled, stroked = [ctypes.c_uint() for _ in range(4)], ctypes.c_int(), ctypes.c_int()
    raw.FPDFPath_GetDrawMode(path, filled, stroked)
    uses = ((raw.FPDFPageObj_GetFillColor, filled), (raw.FPDFPageObj_GetStrokeColor, stroked))
    for colour, is_used in uses:
        if is_used.value:  # what is not used is that of whatever was drawn before
            colour(path, *rgba)
            said.append(" ".join(str(one.value) for one in rgba))
    return ";".join(said)


def _text(read: Callable[..., int], unit: int = 1) -> str:
    """Return a text of pdfium, which tells its length in bytes; `unit`: bytes of the buffer's elements."""
    length = read(None, 0)
    room = (ctypes.c_ushort * (length // 2 + 1))() if unit == 2 else ctypes.create_string_buffer(length)
    read(room, length)
    text = bytes(room)[:length].decode("utf-16-le", errors="replace").rstrip("\0")
    return text.replace("\x02", "-")  # the hyphen of a word that goes on in the next line
