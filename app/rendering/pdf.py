"""A page of a report as a PDF with its figures attached: the same texts, tables and pictures, printed by Qt on A4."""

from __future__ import annotations

import base64
import re
from collections.abc import Mapping
from dataclasses import dataclass, field

from PySide6.QtCore import QBuffer, QByteArray, QIODevice, QMarginsF, QRectF, QSizeF, QUrl
from PySide6.QtGui import (
    QAbstractTextDocumentLayout,
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
WIDE_PX = 660
"""Width of the text in the units of the layout, of which an inch has 96."""
STYLE = """
body { font-family: "DejaVu Sans", sans-serif; font-size: 8pt; color: #000; }
h1 { font-size: 17pt; } h2 { font-size: 13pt; } h3 { font-size: 10pt; }
td, th { padding: 1px 6px 1px 0; font-size: 7pt; } th { white-space: nowrap; }
.quiet, caption, figcaption { color: #444; font-size: 7pt; }
.short { white-space: nowrap; }
.met { color: #14532b; } .not { color: #8c1d18; } code { font-family: "DejaVu Sans Mono", monospace; font-size: 6pt; }
"""
SVG_STYLE = (
    "<style>.car{fill:#eee;stroke:#444}.grid{stroke:#bbb}.lidar{fill:#174a85}.camera{fill:#a8681a}"
    ".view{fill:#c07a1e;fill-opacity:0.14}text{font:11px DejaVu Sans;fill:#000}</style>"
)


@dataclass
class _Pictures:
    """Pictures of a page by the names that take their places."""

    images: dict[str, QImage] = field(default_factory=dict)

    def svg(self, found: re.Match[str]) -> str:
        text = found[0].replace(">", ">" + SVG_STYLE, 1)
        renderer = QSvgRenderer(QByteArray(text.encode("utf-8")))
        size = renderer.defaultSize()
        image = QImage(size * 2, QImage.Format.Format_RGB32)
        image.fill(0xFFFFFFFF)
        painter = QPainter(image)
        renderer.render(painter, QRectF(image.rect()))
        painter.end()
        return self._named(image, min(1.0, WIDE_PX / size.width()) * size.width())

    def data(self, found: re.Match[str]) -> str:
        image = QImage.fromData(QByteArray(base64.b64decode(found[1])))
        return self._named(image, 0.8 * WIDE_PX)

    def _named(self, image: QImage, width: float) -> str:
        name = f"picture{len(self.images)}"
        self.images[name] = image
        return f'<img src="{name}" width="{round(width)}">'


def pdf_of(page: str, title: str, attached: Mapping[str, bytes]) -> bytes:
    """The PDF of a report's page; files are attached by name. Equal input gives equal bytes on the same system."""
    _ensure_application()
    return _without_time(_printed(printable(page), title, attached))


def page_images(page: str) -> list[QImage]:
    """The pages of a report's PDF as pictures, to be seen before it is written."""
    _ensure_application()
    document = printable(page)
    document.documentLayout().setPaintDevice(QImage(1, 1, QImage.Format.Format_RGB32))
    margin, scale = MARGIN_MM / 25.4 * 96.0, SCREEN_DPI / 96.0
    wide, high = (side_mm / 25.4 * 96.0 for side_mm in A4_MM)
    document.setPageSize(QSizeF(wide - 2.0 * margin, high - 2.0 * margin))
    keep_together(document)
    return [_drawn(document, number, (wide, high), margin, scale) for number in range(document.pageCount())]


def _drawn(
    document: QTextDocument, number: int, size: tuple[float, float], margin: float, scale: float
) -> QImage:
    """One page, white all around."""
    image = QImage(round(size[0] * scale), round(size[1] * scale), QImage.Format.Format_RGB32)
    image.fill(0xFFFFFFFF)
    wide, high = size[0] - 2.0 * margin, size[1] - 2.0 * margin
    painter = QPainter(image)
    painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform)
    painter.scale(scale, scale)
    painter.translate(margin, margin - number * high)
    document.drawContents(painter, QRectF(0.0, number * high, wide, high))
    painter.end()
    return image


def _ensure_application() -> None:
    app = QApplication.instance() or QApplication(["riglens", "-platform", "offscreen"])
    assert app is not None


def printable(page: str) -> QTextDocument:
    """A page as it is printed: its texts, tables and pictures, without what needs a browser. Needs a QApplication."""
    pictures = _Pictures()
    text = re.sub(
        r"<script.*?</script>|<style>.*?</style>|<figure data-view.*?</figure>", "", page, flags=re.S
    )
    text = re.sub(r"<svg.*?</svg>", pictures.svg, text, flags=re.S)
    text = re.sub(r'<img [^>]*src="data:image/png;base64,([^"]*)">', pictures.data, text)
    text = re.sub(r"<caption>(.*?)</caption><thead><tr>(.*?)</tr></thead>", _table_head, text)
    text = text.replace("<td data-from=", '<td align="right" class="short" data-from=')
    text = re.sub(r"<figcaption>(.*?)</figcaption>", r"<br>\1", text, flags=re.S)
    text = re.sub(r"<(/?)figure>", r"<\1p>", text).replace(" %</td>", "\u00a0%</td>")
    document = QTextDocument()
    for name, image in pictures.images.items():
        document.addResource(QTextDocument.ResourceType.ImageResource, QUrl(name), image)
    document.setDefaultStyleSheet(STYLE)
    document.setHtml(text)
    return document


def _table_head(found: re.Match[str]) -> str:
    """Caption and names of columns, which are repeated on each page: over words and the rows' titles to the left, over
    numbers to the right."""
    names = found[2].replace("<th>", '<th align="left">', 1).replace("<th>", '<th align="right">')
    names = names.replace("<th class", '<th align="left" class')
    words = f'<tr><td colspan="{names.count("<th")}"><i>{found[1]}</i></td></tr>' if found[1] else ""
    return f"<thead>{words}<tr>{names}</tr></thead>"


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
    """What must not be on another page than a heading begins on: the remark or picture after it, or a table, and one
    that follows a remark; none of what is no heading."""
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
    """Whether a small table goes on on another page than it begins."""
    if table is None or table.format().pageBreakPolicy():
        return False
    top, bottom = _top(layout, table), layout.frameBoundingRect(table).bottom() - 2.0
    return bottom - top < SMALL * high and _page(top, high) < _page(bottom, high)


def _top(layout: QAbstractTextDocumentLayout, table: QTextTable) -> float:
    """Where the first words of a table stand: its frame may begin at the end of the page before."""
    return float(layout.blockBoundingRect(table.firstCursorPosition().block()).top())


def _begin_page(table: QTextTable | None, is_wanted: bool) -> None:
    if table is not None:
        breaks, form = QTextFormat.PageBreakFlag, table.format()
        form.setPageBreakPolicy(breaks.PageBreak_AlwaysBefore if is_wanted else breaks.PageBreak_Auto)
        table.setFormat(form)


def _page(y: float, high: float) -> int:
    return int(y / high)


def _least(layout: QAbstractTextDocumentLayout, block: QTextBlock, tables: dict[int, QTextTable]) -> float:
    """How far down the page of the heading has to reach: to the end of words, or into the first rows of a table."""
    if block.position() in tables:
        return _top(layout, tables[block.position()]) + ROWS_PX
    return float(layout.blockBoundingRect(block).bottom()) - 2.0


def _printed(document: QTextDocument, title: str, attached: Mapping[str, bytes]) -> bytes:
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
    writer.setTitle(title)
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
        painter.save()
        painter.translate(0.0, -page * high)
        document.drawContents(painter, QRectF(0.0, page * high, wide, high))
        painter.restore()
    painter.end()
    buffer.close()
    return bytes(buffer.data().data())


def _mime(name: str) -> str:
    return "application/json" if name.endswith(".json") else "text/yaml"


def _without_time(content: bytes) -> bytes:
    """The same file with the time of its making, and what is drawn by chance, set to zeros of the same length."""

    def zeros(found: re.Match[bytes]) -> bytes:
        return found[1] + re.sub(rb"[0-9a-fA-F]", b"0", found[2]) + found[3]

    for pattern in (
        rb"(/(?:CreationDate|ModDate) \(D:)([^)]*)(\))",
        rb"(/ID \[ ?)(<[0-9a-fA-F]+> ?<[0-9a-fA-F]+>)( ?\])",
        rb"(uuid:)([0-9a-fA-F-]{36})()",
        rb"(xmp:(?:CreateDate|ModifyDate|MetadataDate)=.)([^\"]*)(.)",
    ):
        content = re.sub(pattern, zeros, content)
    return content
