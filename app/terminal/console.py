"""The terminal: results on standard output, progress, notes and warnings on standard error."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path

from rich.console import Console, ConsoleOptions, ConsoleRenderable, RenderableType, RenderHook, RenderResult
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn
from rich.segment import Segment
from rich.text import Text

from riglens.app.evaluation.names import option_of
from riglens.core.files import is_stream
from riglens.core.formats.report import Report
from riglens.core.shown_text import visible, visible_lines

PIPE_WIDTH = 140
"""Columns when standard output is a file or a pipe: wide enough that no number is cut off."""
_listener = ContextVar[Callable[[str], object] | None]("listener", default=None)


def results(beside: str | Path | None = None) -> Console:
    """Return the console for results; in a pipe its width does not depend on the terminal.

    beside: a file that the command writes; where that is standard output itself, the words go to standard error.
    """
    if _listener.get() is not None:
        return Console(quiet=True)
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
    console = Console(stderr=stderr, width=width, highlight=False, markup=False, emoji=False)
    console.push_render_hook(_WritesOut())
    return console


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


def note(message: str) -> None:
    """Print a remark, which is not an error, as one line on standard error."""
    tell = _listener.get()
    if tell is not None:
        tell(message)
    else:
        remarks().print(Text(f"note: {visible(message)}"), soft_wrap=True)


@contextmanager
def called_from_python(tell: Callable[[str], object]) -> Iterator[None]:
    """Hand notes to a function and print no results while the block runs."""
    token = _listener.set(tell)
    try:
        yield
    finally:
        _listener.reset(token)


def note_report(report: Report | None) -> None:
    """Print what became of a rig of another program, one remark per line, on standard error."""
    if report is not None:
        for line in report.lines(option_of):
            note(f"{report.title}: {line}")


@contextmanager
def progress_bar(title: str) -> Iterator[Callable[[float], None]]:
    """Show a progress bar on standard error while the block runs, if that is a terminal.

    Yields the function that takes the fraction done, 0 to 1.
    """
    with stage_bar(title) as tell:
        yield lambda fraction: tell(fraction, "")


@contextmanager
def stage_bar(title: str) -> Iterator[Callable[[float, str], None]]:
    """Show a progress bar with stages; yield its callback for the fraction done and the current stage."""
    console = remarks()
    columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TimeRemainingColumn())
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task(title, total=1.0)
        yield lambda fraction, stage: bar.update(
            task, completed=fraction, description=visible(stage or title)
        )
