"""The terminal: results on standard output, progress, notes and warnings on standard error."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn
from rich.text import Text

from riglens.core.formats.report import Report

PIPE_WIDTH = 120
"""Columns when standard output is a file or a pipe: wide enough that no number is cut off."""


def results() -> Console:
    """Return the console for results; in a pipe its width does not depend on the terminal."""
    return Console(width=None if sys.stdout.isatty() else PIPE_WIDTH, highlight=False)


def remarks() -> Console:
    """Return the console for progress, notes and warnings."""
    return Console(stderr=True, highlight=False)


def note(message: str) -> None:
    """Print a remark, which is not an error, as one line on standard error."""
    remarks().print(Text(f"note: {message}"), soft_wrap=True)


def note_report(report: Report | None) -> None:
    """Print what became of a rig of another program, one remark per line, on standard error."""
    if report is not None:
        for line in report.lines():
            note(f"{report.title}: {line}")


@contextmanager
def progress_bar(title: str) -> Iterator[Callable[[float], None]]:
    """Show a progress bar on standard error while the block runs, if that is a terminal.

    Yields the function that takes the fraction done, 0 to 1.
    """
    console = remarks()
    columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TimeRemainingColumn())
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task(title, total=1.0)
        yield lambda fraction: bar.update(task, completed=fraction)
