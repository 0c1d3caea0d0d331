"""Tables and lines of plain data as rich prints them."""

from __future__ import annotations

from collections.abc import Collection

from rich import box
from rich.table import Table
from rich.text import Text

from riglens.core import shown_tables
from riglens.core.shown_tables import Block, Cell, Paragraph, ShownTable, Styled


def table(
    *titles: str,
    words: Collection[int] = (0,),
    wraps: Collection[int] = (),
    title: str | None = None,
    dense: bool = False,
    widest: int | None = None,
) -> Table:
    """Return an empty table to print; arguments as for `riglens.core.shown_tables.table`."""
    plain = shown_tables.table(*titles, words=words, wraps=wraps, title=title, dense=dense, widest=widest)
    return printed_table(plain)


def printed(block: Block) -> Table | Text | str:
    """Return what rich prints for a block."""
    if isinstance(block, ShownTable):
        return printed_table(block)
    return block.text if isinstance(block, Paragraph) else printed_words(block)


def printed_words(words: Cell) -> Text | str:
    """Return a line or a cell as rich prints it."""
    if isinstance(words, str):
        return words
    if isinstance(words, Styled):
        return Text(words.text, words.style)
    return Text.assemble(*((one.text, one.style) if isinstance(one, Styled) else one for one in words))


def printed_table(plain: ShownTable) -> Table:
    """Return a table as rich prints it."""
    title = None if plain.title is None else printed_words(plain.title)
    if plain.bare:
        made = Table.grid(padding=(0, 1))
    else:
        padding = (0, 1, 0, 0) if plain.dense else (0, 1)
        made = Table(box=box.SIMPLE_HEAD, pad_edge=False, padding=padding, title_justify="left")
    made.title = title
    for column in plain.columns:
        made.add_column(
            column.title,
            justify="left" if column.is_words else "right",
            style=column.style or None,
            no_wrap=not column.wraps,
            max_width=column.widest,
        )
    for row in plain.rows:
        cells = map(printed_words, row.cells)
        made.add_row(*cells, style=row.style or None, end_section=row.ends_section)
    return made
