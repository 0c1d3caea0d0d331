"""What a POG or a box data set may hold at most, and how their files are opened: regular files alone.

The limits lie far above any real data set. They exist so that a damaged or hostile file is refused in one line
before it takes memory or hours. `docs/formats-boxes.md` lists them.
"""

from __future__ import annotations

import errno
import os
import stat
from collections.abc import Sized
from pathlib import Path
from typing import BinaryIO

from riglens.core.errors import InputError

MAX_FRAMES = 1_000_000_000
"""More than three years at ten frames a second; counts of frames have 32 bits."""
MAX_NAMES = 10_000
"""Distinct class names of one data set that belong to no class; real ones have a few dozen."""
MAX_NAME_CHARS = 200
MAX_SEQUENCES = 1_000_000
MAX_FILES = 1_000_000
"""Files of one folder."""


def open_regular(path: Path, accepted: str) -> BinaryIO:
    """Open a file for reading; raise InputError for a device, pipe or socket, which may have no end or never answer.

    `accepted` describes in the message what the file should have been. Raise OSError as `open` does.
    """
    # a pipe that nobody writes to would keep an ordinary `open` waiting
    descriptor = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
    try:
        require_regular(path, os.fstat(descriptor), accepted)
        return os.fdopen(descriptor, "rb")
    except BaseException:
        os.close(descriptor)
        raise


def require_regular(path: Path, status: os.stat_result, accepted: str) -> None:
    """Raise InputError unless this is the status of a regular file."""
    if stat.S_ISDIR(status.st_mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
    if not stat.S_ISREG(status.st_mode):
        raise InputError(f"{path}: found {_kind(status.st_mode)}, accepted is {accepted}")


def require_few_files(count: int, folder: Path) -> None:
    """Raise InputError when a folder holds more files than can be kept in mind."""
    if count > MAX_FILES:
        raise InputError(f"{folder}: more than {MAX_FILES} files, accepted are fewer")


def require_few_names(names: Sized, where: object) -> None:
    """Raise InputError when there are more distinct class names than any data set has."""
    if len(names) > MAX_NAMES:
        raise InputError(f"{where}: more than {MAX_NAMES} class names, accepted are fewer")


def one_line(text: str, limit: int = 200) -> str:
    """Return foreign text as one line of at most `limit` characters, with ? for what cannot be printed."""
    line = " ".join(text.split())[:limit]
    return "".join(character if character.isprintable() else "?" for character in line)


def _kind(mode: int) -> str:
    if stat.S_ISFIFO(mode):
        return "a pipe"
    return "a device" if stat.S_ISCHR(mode) or stat.S_ISBLK(mode) else "something that is not a file"
