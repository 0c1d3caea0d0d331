"""Write tables that the terminal shows as an HTML page."""

from __future__ import annotations

from collections.abc import Iterable
from html import escape

from rich.console import Console
from rich.table import Table
from rich.text import Text

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


def page(title: str, blocks: Iterable[str | Text | Table]) -> str:
    """Return headings (Text), paragraphs and tables as an HTML document that needs no other file."""
    console = Console()

    def marked(cell: object) -> str:
        text = cell if isinstance(cell, Text) else Text(str(cell))
        pieces = []
        for words, style, _ in text.render(console):
            css, escaped = style.get_html_style() if style else "", escape(words).replace("\n", "<br>")
            pieces.append(f'<span style="{css}">{escaped}</span>' if css else escaped)
        return "".join(pieces)

    def row(tag: str, made: Table, cells: Iterable[object]) -> str:
        pairs = zip(made.columns, cells, strict=True)
        inside = (
            f"<{tag}{' class=n' if column.justify == 'right' else ''}>{marked(cell)}</{tag}>"
            for column, cell in pairs
        )
        return f"<tr>{''.join(inside)}</tr>"

    def html(block: str | Text | Table) -> str:
        if isinstance(block, str):
            return f"<p>{escape(block)}</p>"
        if isinstance(block, Text):
            return f"<h2>{escape(block.plain)}</h2>"
        head = row("th", block, [column.header for column in block.columns])
        rows = [
            row("td", block, cells) for cells in zip(*(column.cells for column in block.columns), strict=True)
        ]
        return "\n".join(('<div class="wide"><table>', head, *rows, "</table></div>"))

    return "\n".join(
        (
            '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">',
            f"<title>RigLens: {escape(title)}</title>\n<style>{_STYLE}</style>\n</head>",
            f"<body>\n<h1>{escape(title)}</h1>",
            *map(html, blocks),
            "</body>\n</html>\n",
        )
    )
