"""Tables of words and figures in the terminal."""

from __future__ import annotations

from collections.abc import Collection

from rich import box
from rich.table import Table


def table(
    *titles: str,
    words: Collection[int] = (0,),
    wraps: Collection[int] = (),
    title: str | None = None,
    dense: bool = False,
    widest: int | None = None,
) -> Table:
    """Return an empty table of these columns: those of `words`, by number, are set left, all others right.

    wraps: columns whose cells may be broken into lines; dense: columns are closer together; widest: letters of the
    first column, whose cells are cut.
    """
    padding = (0, 1, 0, 0) if dense else (0, 1)
    made = Table(box=box.SIMPLE_HEAD, pad_edge=False, padding=padding, title=title, title_justify="left")
    for place, heading in enumerate(titles):
        made.add_column(
            heading,
            justify="left" if place in words else "right",
            no_wrap=place not in wraps,
            max_width=None if place else widest,
        )
    return made
