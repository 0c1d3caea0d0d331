"""The terminal: results on standard output, progress, notes and warnings on standard error."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable, Iterator
from contextlib import AbstractContextManager, contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import Any

from rich.console import Console, ConsoleOptions, ConsoleRenderable, RenderableType, RenderHook, RenderResult
from rich.measure import Measurement
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn
from rich.segment import Segment
from rich.table import Table
from rich.text import Text

from riglens.app.terminal.tables import printed
from riglens.core.files import is_stream
from riglens.core.monitor import Monitor, Stage
from riglens.core.shown_tables import Block, Paragraph, ShownTable
from riglens.core.shown_text import remark_text, visible, visible_lines
from riglens.evaluation.names import option_with

PIPE_WIDTH, FEWEST_LETTERS = 140, 12
"""Columns when standard output is a file or a pipe; letters that words keep in a line where a table is too wide."""
_noted = ContextVar[set[str] | None]("noted", default=None)


def results(beside: str | Path | None = None) -> Console:
    """Return the console for results; in a pipe its width does not depend on the terminal.

    beside: a file that the command writes; where that is standard output itself, the words go to standard error.
    """
    if beside is not None and is_standard_output(beside):
        return remarks()
    return _console(width=None if sys.stdout.isatty() else PIPE_WIDTH)


def is_standard_output(path: str | Path) -> bool:
    """Return whether a file is the pipe or device that standard output goes to, such as /dev/stdout."""
    try:
        return is_stream(path) and os.path.samestat(os.stat(path), os.fstat(sys.stdout.fileno()))
    except (OSError, ValueError):
        return False


def remarks() -> Console:
    """Return the console for progress, notes and warnings."""
    return _console(stderr=True)


def _console(stderr: bool = False, width: int | None = None) -> Console:
    console = _WholeLines(stderr=stderr, width=width, highlight=False, markup=False, emoji=False)
    console.push_render_hook(_WritesOut())
    return console


class _WholeLines(Console):
    """Console that breaks words, never numbers, where a table is wider than the terminal."""

    def print(self, *objects: Any, crop: bool = False, **options: Any) -> None:
        """Print whole lines; tables of many numbers are wider than the terminal."""
        before = self.width
        width = max((self._narrowest(made) for made in objects if isinstance(made, Table)), default=0)
        if width > before:
            self.width = width
        super().print(*objects, crop=crop, **options)
        if width > before:
            self.width = before

    def _narrowest(self, made: Table) -> int:
        """Let words of a table that is too wide be broken; return how narrow it can be, numbers whole."""
        whole = self.options.update_width(sys.maxsize)
        natural = Measurement.get(self, whole, made).maximum
        if natural <= self.width:
            return natural
        for column in made.columns:
            sizes = [Measurement.get(self, whole, cell) for cell in (column.header, *column.cells)]
            letters = min(max(size.maximum for size in sizes), column.max_width or sys.maxsize)
            column.min_width = min(letters, FEWEST_LETTERS)
            if column.justify == "right":
                column.min_width = letters if column.no_wrap else max(size.minimum for size in sizes)
            column.no_wrap &= column.justify == "right"
            natural -= letters - column.min_width
        return natural


class _WritesOut(RenderHook):
    """Console output that names and notes of files cannot use to steer the terminal: only what rich itself adds may
    do so."""

    def process_renderables(self, renderables: list[ConsoleRenderable]) -> list[ConsoleRenderable]:
        """Escape control characters in everything printed."""
        return [_WrittenOut(renderable) for renderable in renderables]


class _WrittenOut:
    """Printable object whose control characters are escaped."""

    def __init__(self, inner: RenderableType) -> None:
        self._inner = inner

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        for text, style, control in console.render(self._inner, options):
            yield Segment(text if control else visible_lines(text), style, control)


def show(blocks: Iterable[Block], beside: str | Path | None = None) -> None:
    """Print lines, paragraphs and tables on the console for results; `beside` as there."""
    console = results(beside)
    for block in blocks:
        console.print(printed(block), soft_wrap=not isinstance(block, Paragraph | ShownTable))


def note(message: str) -> None:
    """Print a remark, which is not an error, as one line on standard error; only once within `notes_once`."""
    noted = _noted.get()
    if noted is not None:
        if message in noted:
            return
        noted.add(message)
    remarks().print(Text(f"note: {remark_text(message)}"), soft_wrap=True)


@contextmanager
def notes_once() -> Iterator[None]:
    """Print each note once while the block runs: scene and objects of the same data have the same remarks."""
    token = _noted.set(set())
    try:
        yield
    finally:
        _noted.reset(token)


@contextmanager
def progress_bar(title: str) -> Iterator[Stage]:
    """Show a progress bar on standard error while the block runs, if that is a terminal; yield what takes the fraction
    done and what is under way."""
    console = remarks()
    columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TimeRemainingColumn())
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task(title, total=1.0)

        def tell(fraction: float, under_way: str = "", /) -> None:
            bar.update(task, completed=fraction, description=visible(under_way or title))

        yield tell


class _Terminal(Monitor):
    """Listener that prints remarks and shows progress bars."""

    def note(self, line: str) -> None:
        """Print a remark."""
        note(line)

    def advice(self, field: str, value: object) -> str:
        """Return an option."""
        return option_with(field, value)

    def stage(self, title: str) -> AbstractContextManager[Stage]:
        """Show a progress bar."""
        return progress_bar(title)


TERMINAL = _Terminal()
