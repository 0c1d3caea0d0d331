"""Errors with a meaning of their own: wrong input, and work that was given up."""

from __future__ import annotations

from collections.abc import Callable


class InputError(ValueError):
    """Bad input or usage, as one line: file and place, or field; fact; remedy.

    Parameters
    ----------
    message
        What is wrong. With a field it continues the field's name: "must be above 0 (got -1)".
    field
        The argument that is wrong, by its name in the Python API, such as `voxel_m`.
    other
        Another argument that the message ends in.
    """

    def __init__(self, message: str, field: str = "", other: str = "") -> None:
        super().__init__(message, field, other)
        self.message, self.field, self.other = message, field, other

    def text(self, name: Callable[[str], str]) -> str:
        """Return the line with each field under the name that a front end has for it."""
        named = (name(field) if field else "" for field in (self.field, self.other))
        first, last = named
        return " ".join(part for part in (first, self.message, last) if part)

    def __str__(self) -> str:
        return self.text(str)


class Cancelled(Exception):
    """Raised by work that was given up, and by the callbacks that give it up."""


IsStale = Callable[[], bool]
"""Called every few milliseconds by work that is given up as soon as it returns True."""


def never_stale() -> bool:
    """Return False, for callers that want every result."""
    return False
