"""A report printed by Qt on A4: as a PDF with its figures attached, or as pictures of its pages."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from itertools import chain, repeat
from typing import NamedTuple

from PySide6.QtCore import QBuffer, QByteArray, QHashSeed, QIODevice, QMarginsF, QRectF, QSizeF, Qt, QUrl
from PySide6.QtGui import (
    QAbstractTextDocumentLayout,
    QColor,
    QFont,
    QImage,
    QPageLayout,
    QPageSize,
    QPainter,
    QPdfWriter,
    QTextBlock,
    QTextCursor,
    QTextDocument,
    QTextFormat,
    QTextTable,
)
from PySide6.QtSvg import QSvgRenderer
from PySide6.QtWidgets import QApplication

DPI, MARGIN_MM = 150, 14.0
SCREEN_DPI, A4_MM = 110.0, (210.0, 297.0)
MOST_BREAKS, SMALL, ROWS_PX = 60, 0.6, 40.0
"""So many parts are moved to a next page at most; tables up to this share of a page are not cut; a heading stays with
so much of a table."""
HEADER_PX = 9
"""Height of the letters above and below a page."""
MADE = "20000101000000"
"""The date in every PDF: that of its making would make two of the same report differ."""
Pictures = Mapping[str, bytes]


class Header(NamedTuple):
    """The title of a report, and words on the right of it, at the top of every page."""

    title: str
    words: str = ""


def pdf_of(text: str, pictures: Pictures, header: Header, attached: Mapping[str, bytes]) -> bytes:
    """Return the PDF of a text; pictures (PNG or SVG) and attached files are by name.

    Equal input gives equal bytes on the same system. The PDF has no tags: Qt writes none.
    """
    _ensure_application()
    with _in_utc():
        return _without_time(_printed(printable(text, pictures), header, attached))


def page_images(text: str, pictures: Pictures, header: Header) -> list[QImage]:
    """Return the pages of such a PDF as pictures, to be seen before it is saved."""
    _ensure_application()
    document = printable(text, pictures)
    document.documentLayout().setPaintDevice(QImage(1, 1, QImage.Format.Format_RGB32))
    margin, scale = MARGIN_MM / 25.4 * 96.0, SCREEN_DPI / 96.0
    wide, high = (side_mm / 25.4 * 96.0 for side_mm in A4_MM)
    document.setPageSize(QSizeF(wide - 2.0 * margin, high - 2.0 * margin))
    keep_together(document)
    pages = range(document.pageCount())
    return [_drawn(document, number, (wide, high), margin, scale, header) for number in pages]


def _drawn(
    document: QTextDocument,
    number: int,
    size: tuple[float, float],
    margin: float,
    scale: float,
    header: Header,
) -> QImage:
    """Draw one page with white margins."""
    image = QImage(round(size[0] * scale), round(size[1] * scale), QImage.Format.Format_RGB32)
    image.fill(0xFFFFFFFF)
    wide, high = size[0] - 2.0 * margin, size[1] - 2.0 * margin
    painter = QPainter(image)
    painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform)
    painter.scale(scale, scale)
    painter.translate(margin, margin)
    _draw_page(painter, document, number, QSizeF(wide, high), header)
    painter.end()
    return image


def _draw_page(painter: QPainter, document: QTextDocument, number: int, size: QSizeF, header: Header) -> None:
    """Draw a page at the origin, and in the margins above and below it the header and its number."""
    wide, high = size.width(), size.height()
    painter.save()
    painter.translate(0.0, -number * high)
    document.drawContents(painter, QRectF(0.0, number * high, wide, high))
    painter.restore()
    font = QFont("DejaVu Sans")
    font.setPixelSize(HEADER_PX)
    painter.setFont(font)
    painter.setPen(QColor(0x44, 0x44, 0x44))
    above, below = QRectF(0.0, -28.0, wide, 16.0), QRectF(0.0, high + 10.0, wide, 16.0)
    left, right = Qt.AlignmentFlag.AlignLeft, Qt.AlignmentFlag.AlignRight
    room = painter.fontMetrics().horizontalAdvance(header.words)
    title = painter.fontMetrics().elidedText(
        header.title, Qt.TextElideMode.ElideRight, max(120, int(wide) - room - 20)
    )
    words = painter.fontMetrics().elidedText(header.words, Qt.TextElideMode.ElideRight, int(wide) - 140)
    painter.drawText(above, left, title)
    painter.drawText(above, right, words)
    painter.drawText(below, right, f"{number + 1} / {document.pageCount()}")


def _ensure_application() -> None:
    if QApplication.instance() is None:
        QHashSeed.setDeterministicGlobalSeed()  # the order of fonts in a PDF is that of a hash
        QApplication(["riglens", "-platform", "offscreen"])


def printable(text: str, pictures: Pictures) -> QTextDocument:
    """Return a text with its pictures as it is laid out. Needs a QApplication."""
    document = QTextDocument()
    for name, content in pictures.items():
        image = (
            QImage.fromData(QByteArray(content)) if content.startswith(b"\x89PNG") else _drawn_svg(content)
        )
        document.addResource(QTextDocument.ResourceType.ImageResource, QUrl(name), image)
    document.setHtml(text)
    return document


def _drawn_svg(content: bytes) -> QImage:
    """Draw an SVG at twice its size, on white."""
    renderer = QSvgRenderer(QByteArray(content))
    image = QImage(renderer.defaultSize() * 2, QImage.Format.Format_RGB32)
    image.fill(0xFFFFFFFF)
    painter = QPainter(image)
    renderer.render(painter, QRectF(image.rect()))
    painter.end()
    return image


def keep_together(document: QTextDocument) -> None:
    """Begin a page before headings that end one, and before small tables that would be cut; the page size is set."""
    high = document.pageSize().height()
    for _ in range(MOST_BREAKS):
        if not _moved_one(document, high):
            return


def _moved_one(document: QTextDocument, high: float) -> bool:
    """Move the first such part of the document to the next page; False where all is well."""
    layout, root = document.documentLayout(), document.rootFrame()
    tables = {table.firstPosition(): table for table in root.childFrames() if isinstance(table, QTextTable)}
    block = document.begin()
    while block.isValid():
        top, followers = layout.blockBoundingRect(block).top(), _followers(block, tables)
        least = max((_least(layout, follower, tables) for follower in followers), default=top)
        if followers and _page(top, high) < _page(least, high):
            form = block.blockFormat()
            form.setPageBreakPolicy(QTextFormat.PageBreakFlag.PageBreak_AlwaysBefore)
            QTextCursor(block).setBlockFormat(form)
            for follower in followers:  # which needs no page of its own any more
                _begin_page(tables.get(follower.position()), False)
            return True
        if _is_cut(layout, tables.get(block.position()), high):
            _begin_page(tables[block.position()], True)
            return True
        block = block.next()
    return False


def _followers(block: QTextBlock, tables: dict[int, QTextTable]) -> list[QTextBlock]:
    """Return the blocks that must share the page on which a heading begins: the remark or picture after it, or a table,
    and one that follows a remark; none if the block is no heading."""
    found: list[QTextBlock] = []
    words, block = 0 if block.blockFormat().headingLevel() else 2, block.next()
    while words < 2 and block.isValid():
        found.append(block)
        if block.position() in tables:
            break
        words += bool(block.text().strip())
        block = block.next()
    return found[:-1] if words == 2 and found else found


def _is_cut(layout: QAbstractTextDocumentLayout, table: QTextTable | None, high: float) -> bool:
    """Return whether a small table is split across pages."""
    if table is None or table.format().pageBreakPolicy():
        return False
    top, bottom = _top(layout, table), layout.frameBoundingRect(table).bottom() - 2.0
    return bottom - top < SMALL * high and _page(top, high) < _page(bottom, high)


def _top(layout: QAbstractTextDocumentLayout, table: QTextTable) -> float:
    """Return the top of a table's first words: its frame may begin at the end of the page before."""
    return float(layout.blockBoundingRect(table.firstCursorPosition().block()).top())


def _begin_page(table: QTextTable | None, is_wanted: bool) -> None:
    if table is not None:
        breaks, form = QTextFormat.PageBreakFlag, table.format()
        form.setPageBreakPolicy(breaks.PageBreak_AlwaysBefore if is_wanted else breaks.PageBreak_Auto)
        table.setFormat(form)


def _page(y: float, high: float) -> int:
    return int(y / high)


def _least(layout: QAbstractTextDocumentLayout, block: QTextBlock, tables: dict[int, QTextTable]) -> float:
    """Return how far down the page of the heading must reach: to the end of words, or into the first rows of a
    table."""
    if block.position() in tables:
        return _top(layout, tables[block.position()]) + ROWS_PX
    return float(layout.blockBoundingRect(block).bottom()) - 2.0


def _printed(document: QTextDocument, header: Header, attached: Mapping[str, bytes]) -> bytes:
    buffer = QBuffer()
    buffer.open(QIODevice.OpenModeFlag.WriteOnly)
    writer = QPdfWriter(buffer)
    writer.setResolution(DPI)
    writer.setPageLayout(
        QPageLayout(
            QPageSize(QPageSize.PageSizeId.A4),
            QPageLayout.Orientation.Portrait,
            QMarginsF(MARGIN_MM, MARGIN_MM, MARGIN_MM, MARGIN_MM),
            QPageLayout.Unit.Millimeter,
        )
    )
    writer.setTitle(header.title)
    writer.setCreator("RigLens")
    for name, content in attached.items():
        writer.addFileAttachment(name, QByteArray(content), _mime(name))
    painter = QPainter(writer)
    scale = DPI / 96.0
    area = writer.pageLayout().paintRectPixels(DPI)
    wide, high = area.width() / scale, area.height() / scale
    document.documentLayout().setPaintDevice(QImage(1, 1, QImage.Format.Format_RGB32))
    document.setPageSize(QSizeF(wide, high))
    keep_together(document)
    painter.scale(scale, scale)
    for page in range(document.pageCount()):
        if page:
            writer.newPage()
        _draw_page(painter, document, page, QSizeF(wide, high), header)
    painter.end()
    buffer.close()
    return bytes(buffer.data().data())


def _mime(name: str) -> str:
    return "application/json" if name.endswith(".json") else "text/yaml"


@contextmanager
def _in_utc() -> Iterator[None]:
    """Make Qt write dates in UTC inside the block, because their length differs between time zones."""
    before = os.environ.get("TZ")
    os.environ["TZ"] = "UTC"
    try:
        yield
    finally:
        if before is None:
            del os.environ["TZ"]
        else:
            os.environ["TZ"] = before


def _without_time(content: bytes) -> bytes:
    """Return the file with a constant creation date and constant identifiers; all lengths stay the same."""

    def digits(found: re.Match[bytes], given: str = "") -> bytes:
        source = chain(given, repeat("0"))
        return found[1] + re.sub(rb"[0-9a-fA-F]", lambda _: next(source).encode(), found[2]) + found[3]

    for pattern in (rb"(/ID \[ ?)(<[0-9a-fA-F]+> ?<[0-9a-fA-F]+>)( ?\])", rb"(uuid:)([0-9a-fA-F-]{36})()"):
        content = re.sub(pattern, digits, content)
    for pattern in (
        rb"(/(?:CreationDate|ModDate) \(D:)([^)]*)(\))",
        rb"(xmp:(?:CreateDate|ModifyDate|MetadataDate)=.)([^\"]*)(.)",
    ):
        content = re.sub(pattern, partial(digits, given=MADE), content)
    return content
