"""Limit the size of POGs and box data sets.

The limits lie far above any real data set. They exist so that a damaged or hostile file is refused in one line
before it takes memory or hours. `docs/formats-boxes.md` lists them.
"""

from __future__ import annotations

from collections.abc import Sized
from pathlib import Path

from riglens.core.errors import InputError

MAX_FRAMES = 1_000_000_000
"""More than three years at ten frames a second; counts of frames have 32 bits."""
MAX_NAMES = 10_000
"""Distinct class names of one data set that belong to no class; real ones have a few dozen."""
MAX_NAME_CHARS = 200
MAX_SEQUENCES = 1_000_000
MAX_FILES = 1_000_000
"""Files of one folder."""


def require_few_files(count: int, folder: Path) -> None:
    """Raise InputError when a folder holds more files than can be kept in mind."""
    if count > MAX_FILES:
        raise InputError(f"{folder}: too many files (at most {MAX_FILES})")


def require_few_names(names: Sized, where: object) -> None:
    """Raise InputError when there are more distinct class names than any data set has."""
    if len(names) > MAX_NAMES:
        raise InputError(f"{where}: too many class names (at most {MAX_NAMES})")


def one_line(text: str, limit: int = 200) -> str:
    """Return foreign text as one line of at most `limit` characters, with ? for what cannot be printed."""
    line = " ".join(text.split())[:limit]
    return "".join(character if character.isprintable() else "?" for character in line)
