"""Which slots a signal wakes, and through which rooms of the house it goes: counted while something is done."""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from types import FrameType
from typing import Any

REPOSITORY = Path(__file__).resolve().parents[2]


@dataclass
class Woken:
    """What ran: `slots` by the name of the function, each with its number of calls; `rooms` and `files` entered."""

    slots: Counter[str] = field(default_factory=Counter)
    rooms: set[str] = field(default_factory=set)
    files: set[str] = field(default_factory=set)


class _Watch:
    """A profile function: a Python function entered by the frame that is inside `emit` is a slot."""

    def __init__(self) -> None:
        self.woken = Woken()
        self._emitting: list[FrameType] = []

    def __call__(self, frame: FrameType, event: str, arg: Any) -> None:
        is_emit = getattr(arg, "__name__", "") == "emit" and event.startswith("c_")
        if is_emit and event == "c_call":
            self._emitting.append(frame)
        elif is_emit and self._emitting:
            self._emitting.pop()
        elif event == "call":
            self._enter(frame)

    def _enter(self, frame: FrameType) -> None:
        place = _place(frame.f_code.co_filename)
        if place is None:
            return
        self.woken.files.add("/".join(place))
        self.woken.rooms.add("/".join(place[:2]))
        if self._emitting and frame.f_back is self._emitting[-1]:
            self.woken.slots[frame.f_code.co_qualname] += 1


@cache
def _place(name: str) -> tuple[str, ...] | None:
    """The parts of a file's path in the house, links resolved; None for files that are not the product's."""
    path = Path(name).resolve()
    if not path.is_relative_to(REPOSITORY):
        return None
    parts = path.relative_to(REPOSITORY).parts
    return parts if parts[0] in ("app", "riglens", "widgets", "core") else None


@contextmanager
def woken() -> Iterator[Woken]:
    """Count what is woken on this thread while the block runs."""
    watch = _Watch()
    before = sys.getprofile()
    sys.setprofile(watch)
    try:
        yield watch.woken
    finally:
        sys.setprofile(before)
