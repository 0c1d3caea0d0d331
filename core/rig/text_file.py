"""Reading a text file from anywhere: limits, UTF-8, one line of complaint that names the file."""

from __future__ import annotations

import os
from pathlib import Path

from riglens.core.errors import InputError
from riglens.core.rig.yaml_nodes import MAX_BYTES, shortened


def read_text(path: str | os.PathLike[str], accepted: str) -> str:
    """The text of a file; InputError when it is missing, unreadable, too large or no text.

    `accepted` says in messages what the file should have been: "a rig YAML file".
    """
    where = shown_path(path)
    content = _content(path, where, accepted)
    if b"\0" in content:
        raise InputError(f"{where}: not a text file; accepted is {accepted} in UTF-8")
    try:
        return content.decode("utf-8")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        found = f"found byte 0x{content[error.start]:02x}"
        raise InputError(f"{where}:{line}: not UTF-8 text, {found}; accepted is UTF-8") from error


def shown_path(path: str | os.PathLike[str]) -> str:
    """A path on one line, for messages."""
    return shortened(os.fspath(path), 200)


def _content(path: str | os.PathLike[str], where: str, accepted: str) -> bytes:
    try:
        with Path(path).open("rb") as stream:
            content = stream.read(MAX_BYTES + 1)
    except FileNotFoundError as error:
        raise InputError(f"{where}: no such file") from error
    except IsADirectoryError as error:
        raise InputError(f"{where}: this is a folder; accepted is {accepted}") from error
    except OSError as error:
        raise InputError(f"{where}: cannot be read: {error.strerror}") from error
    if len(content) > MAX_BYTES:
        raise InputError(f"{where}: larger than {MAX_BYTES / 1e6:g} MB; accepted is {accepted}")
    return content
