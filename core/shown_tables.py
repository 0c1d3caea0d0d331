"""Define tables and lines for a reader as plain data, which the terminal prints and pages set."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, field
from typing import Literal

Style = Literal["", "bold", "dim", "green", "yellow", "red", "bold red", "bold yellow"]


@dataclass(frozen=True)
class Styled:
    """Words in one style."""

    text: str
    style: Style


Line = tuple[str | Styled, ...]
Cell = str | Styled | Line


@dataclass(frozen=True)
class Paragraph:
    """Words that are broken into lines where they are wider than the terminal."""

    text: str


@dataclass
class Column:
    """Column: left-aligned words or right-aligned numbers; `wraps`: cells may be broken into lines; widest: in
    letters."""

    title: str
    is_words: bool
    wraps: bool
    style: Style
    widest: int | None


@dataclass
class Row:
    """Row of cells; `ends_section`: a line or a gap follows."""

    cells: tuple[Cell, ...]
    style: Style
    ends_section: bool = False


@dataclass
class ShownTable:
    """Table to show; `dense`: columns are closer together, `bare`: neither a heading nor lines."""

    columns: tuple[Column, ...]
    title: str | Styled | None
    dense: bool
    bare: bool
    rows: list[Row] = field(default_factory=list)

    def add_row(self, *cells: Cell, style: Style = "") -> None:
        """Append a row; cells that are left out at its end are empty."""
        self.rows.append(Row(cells + ("",) * (len(self.columns) - len(cells)), style))

    def add_section(self) -> None:
        """End a section after the last row."""
        if self.rows:
            self.rows[-1].ends_section = True


Block = str | Styled | Line | Paragraph | ShownTable
"""A line, a paragraph or a table by itself."""


def table(
    *titles: str,
    words: Collection[int] = (0,),
    wraps: Collection[int] = (),
    dim: Collection[int] = (),
    title: str | Styled | None = None,
    dense: bool = False,
    bare: bool = False,
    widest: int | None = None,
) -> ShownTable:
    """Return an empty table of these columns: those of `words`, by number, are set left, all others right.

    wraps: columns whose cells may be broken into lines; dim: columns in a paler colour; widest: letters of the first
    column, whose cells are cut.
    """
    columns = tuple(
        Column(one, at in words, at in wraps, "dim" if at in dim else "", None if at else widest)
        for at, one in enumerate(titles)
    )
    return ShownTable(columns, title, dense, bare)
