"""Write lines and tables as an HTML page."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape

from riglens.core.shown_tables import Cell, Column, ShownTable, Style, Styled

_STYLE = """
body { margin: 0 auto; padding: 2.5rem 2rem 4rem; max-width: 76rem; color: #1c2126; background: #fff;
  font: 15px/1.5 system-ui, "Segoe UI", "Noto Sans", "DejaVu Sans", sans-serif; }
h1 { margin: 0 0 .3rem; font-size: 1.75rem; }
h2 { margin: 2.8rem 0 .6rem; font-size: 1.25rem; }
p { max-width: 60rem; margin: .4rem 0 .8rem; }
.wide { overflow-x: auto; margin-bottom: 1rem; }
table { border-collapse: collapse; width: 100%; font-size: 13.5px; font-variant-numeric: tabular-nums; }
th { text-align: left; padding: .35rem .7rem; border-bottom: 2px solid #1c2126; vertical-align: bottom; }
td { padding: .38rem .7rem; border-bottom: 1px solid #d9dee3; vertical-align: top; }
.n { text-align: right; white-space: nowrap; }
@media print { body { padding: 0; font-size: 11px; } table { font-size: 10px; } tr { break-inside: avoid; } }
"""


_RED, _GREEN, _AMBER, _GREY = (
    f"color: {colour}; text-decoration-color: {colour}"
    for colour in ("#800000", "#008000", "#808000", "#7f7f7f")
)
_BOLD = "font-weight: bold"
_CSS: dict[Style, str] = {
    "": "",
    "bold": _BOLD,
    "dim": _GREY,
    "green": _GREEN,
    "yellow": _AMBER,
    "red": _RED,
    "bold red": f"{_RED}; {_BOLD}",
    "bold yellow": f"{_AMBER}; {_BOLD}",
}


def page(title: str, blocks: Iterable[str | Styled | ShownTable]) -> str:
    """Return paragraphs, headings (styled words) and tables as an HTML document that needs no other file."""
    return "\n".join(
        (
            '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">',
            f"<title>RigLens: {escape(title)}</title>\n<style>{_STYLE}</style>\n</head>",
            f"<body>\n<h1>{escape(title)}</h1>",
            *map(_html, blocks),
            "</body>\n</html>\n",
        )
    )


def _html(block: str | Styled | ShownTable) -> str:
    if isinstance(block, str):
        return f"<p>{escape(block)}</p>"
    if isinstance(block, Styled):
        return f"<h2>{escape(block.text)}</h2>"
    head = _row("th", block.columns, [column.title for column in block.columns])
    rows = [_row("td", block.columns, row.cells) for row in block.rows]
    return "\n".join(('<div class="wide"><table>', head, *rows, "</table></div>"))


def _row(tag: str, columns: Sequence[Column], cells: Sequence[Cell]) -> str:
    inside = (
        f"<{tag}{'' if column.is_words else ' class=n'}>{_marked(cell)}</{tag}>"
        for column, cell in zip(columns, cells, strict=True)
    )
    return f"<tr>{''.join(inside)}</tr>"


def _marked(cell: Cell) -> str:
    if isinstance(cell, tuple):
        return "".join(map(_marked, cell))
    text, css = (cell.text, _CSS[cell.style]) if isinstance(cell, Styled) else (cell, "")
    escaped = escape(text).replace("\n", "<br>")
    return f'<span style="{css}">{escaped}</span>' if css else escaped
