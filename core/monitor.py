"""Define what long work tells while it runs: remarks, and how far its stages are."""

from __future__ import annotations

from contextlib import AbstractContextManager, nullcontext
from typing import Protocol


class Stage(Protocol):
    """Takes the fraction of a stage that is done, 0 to 1, and what is under way; may raise to cancel the work."""

    def __call__(self, fraction: float, under_way: str = "", /) -> None:
        """Tell how far the stage is."""


class Monitor:
    """Listener to long work. This one drops everything; the terminal and Python have their own."""

    def note(self, line: str) -> None:
        """Take a remark that is not an error, one line."""

    def advice(self, field: str, value: object) -> str:
        """Return what gives a field a value where remarks are read: an option, or an argument in Python."""
        return f"{field}={value}"

    def stage(self, title: str) -> AbstractContextManager[Stage]:
        """Follow a stage of the work while the block runs; yield what takes its progress."""
        return nullcontext(_drop)


def _drop(fraction: float, under_way: str = "", /) -> None:
    pass


SILENT = Monitor()
