"""Unsaved rigs on the disk: one file per running window, so that a crash costs no work.

A file whose window is no longer running is an orphan, and is offered at the next start. The owner is known by
process number and start time, because numbers are used again.
"""

from __future__ import annotations

import contextlib
import itertools
import json
import os
import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import psutil

from riglens.core.errors import InputError
from riglens.core.files import atomic_write
from riglens.core.rig.model import Rig
from riglens.core.rig.yaml.file import dumps, loads
from riglens.core.rig.yaml.nodes import MAX_BYTES

VERSION = 1
SUFFIX = ".autosave.json"
_numbers = itertools.count(1)


@dataclass(frozen=True)
class Unsaved:
    """A rig with changes, the rig that they began with, and the file that it belongs to (None: never saved)."""

    rig: Rig
    base: Rig
    path: Path | None


@dataclass(frozen=True)
class Orphan:
    """What a window that is gone left behind; `saved_at` in seconds since 1970."""

    file: Path
    unsaved: Unsaved
    saved_at: float


class AutosaveFile:
    """The file of one window. `write` may be called from any one thread at a time."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self.path = folder / f"{os.getpid()}-{next(_numbers)}{SUFFIX}"

    def write(self, unsaved: Unsaved) -> None:
        """Keep this state in place of the one before; InputError when that is impossible."""
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(
                f"{self._folder}: cannot be made: {error.strerror}; changes are not autosaved"
            ) from error
        content = {
            "riglens_autosave": VERSION,
            "owner": asdict(_owner()),
            "saved_at": time.time(),
            "path": None if unsaved.path is None else str(unsaved.path.absolute()),
            "rig": dumps(unsaved.rig),
            "base": dumps(unsaved.base),
        }
        with atomic_write(self.path, "w") as stream:
            json.dump(content, stream)

    def take(self, orphan: Orphan) -> bool:
        """Make an orphan's file this window's own; False when somebody else was quicker."""
        try:
            os.rename(orphan.file, self.path)
        except OSError:
            return False
        self.write(orphan.unsaved)
        return True

    def remove(self) -> None:
        """Nothing is unsaved any more."""
        with contextlib.suppress(OSError):
            self.path.unlink(missing_ok=True)


def orphans(folder: Path) -> list[Orphan]:
    """What windows that are gone left behind, the newest first; files that make no sense are passed over."""
    found = [orphan for file in _files(folder) if (orphan := _orphan(file)) is not None]
    return sorted(found, key=lambda orphan: orphan.saved_at, reverse=True)


@dataclass(frozen=True)
class _Owner:
    pid: int
    started_at: float


def _owner() -> _Owner:
    return _Owner(os.getpid(), psutil.Process().create_time())


def _files(folder: Path) -> Iterator[Path]:
    with contextlib.suppress(OSError):
        yield from folder.glob(f"*{SUFFIX}")


def _orphan(file: Path) -> Orphan | None:
    try:
        with file.open("rb") as stream:
            content = stream.read(3 * MAX_BYTES + 1)
        if len(content) > 3 * MAX_BYTES:
            return None
        said = json.loads(content)
        if _is_running(said["owner"]):
            return None
        path = said["path"]
        unsaved = Unsaved(_rig(said["rig"]), _rig(said["base"]), None if path is None else Path(path))
        return Orphan(file, unsaved, float(said["saved_at"]))
    except (OSError, ValueError, TypeError, KeyError, RecursionError):  # InputError is a ValueError
        return None


def _rig(text: str) -> Rig:
    return loads(text, "autosave").rig


def _is_running(owner: dict[str, Any]) -> bool:
    """Whether the very process that wrote a file still runs."""
    try:
        process = psutil.Process(int(owner["pid"]))
        return abs(process.create_time() - float(owner["started_at"])) < 1.0
    except psutil.NoSuchProcess:
        return False
