"""Save unsaved rigs on the disk: one file per running window, so that a crash costs no work.

A file whose window is no longer running is an orphan, and is offered at the next start. A window holds a lock next to
its file while that file exists. Where the file system has no locks, the owner is known by process number
and start time.
"""

from __future__ import annotations

import contextlib
import json
import os
import secrets
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import psutil
from pydantic import BaseModel, ConfigDict, Field

from riglens.core.errors import InputError
from riglens.core.files import atomic_write, hold_lock, release_lock
from riglens.core.rig.model import Rig
from riglens.core.rig.ray_file import reader_in
from riglens.core.rig.yaml.file import dumps, loads
from riglens.core.rig.yaml.nodes import MAX_BYTES

if TYPE_CHECKING:
    from filelock import BaseFileLock

VERSION = 1
SUFFIX, LOCK_SUFFIX = ".autosave.json", ".autosave.lock"


@dataclass(frozen=True)
class Unsaved:
    """A rig with changes, the rig that they began with, and the file that it belongs to (None: never saved)."""

    rig: Rig
    base: Rig
    path: Path | None


@dataclass(frozen=True)
class Orphan:
    """Autosave of a window that is gone; `saved_at` in seconds since 1970."""

    file: Path
    unsaved: Unsaved
    saved_at: float


class AutosaveFile:
    """The file of one window. `write` may be called from any one thread at a time."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._lock: BaseFileLock | None = None
        # not by process number alone: in containers, a window that crashed often had the same one
        self.path = folder / f"{os.getpid()}-{secrets.token_hex(6)}{SUFFIX}"

    def write(self, unsaved: Unsaved) -> None:
        """Keep this state in place of the one before; InputError when that is impossible."""
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(
                f"{self._folder}: cannot be created: {error.strerror}; changes are not autosaved"
            ) from error
        content = {
            "riglens_autosave": VERSION,
            "owner": _Owner(pid=os.getpid(), started_at=psutil.Process().create_time()).model_dump(),
            "saved_at": time.time(),
            "path": None if unsaved.path is None else str(unsaved.path.absolute()),
            "rig": dumps(unsaved.rig),
            "base": dumps(unsaved.base),
        }
        self._hold()
        with atomic_write(self.path, "w") as stream:
            json.dump(content, stream)

    def take(self, orphan: Orphan) -> bool:
        """Claim an orphaned file for this window; False when another window was faster."""
        self._hold()
        try:
            os.rename(orphan.file, self.path)
        except OSError:
            return False
        _lock_of(orphan.file).unlink(missing_ok=True)
        self.write(orphan.unsaved)
        return True

    def remove(self) -> None:
        """Remove the file: nothing is unsaved."""
        with contextlib.suppress(OSError):
            self.path.unlink(missing_ok=True)
        if self._lock is not None:
            release_lock(self._lock)
            self._lock = None

    def _hold(self) -> None:
        """Mark this window as running, before its file appears; without locks the owner in the file does so."""
        if self._lock is None:
            with contextlib.suppress(OSError):
                self._lock = hold_lock(_lock_of(self.path))


def orphans(folder: Path) -> list[Orphan]:
    """Return the autosaves of windows that are gone, the newest first; unreadable files are skipped."""
    found = [orphan for file in _files(folder) if (orphan := _orphan(file)) is not None]
    return sorted(found, key=lambda orphan: orphan.saved_at, reverse=True)


def discard(orphan: Orphan) -> None:
    """Delete the autosave of a window; raise InputError when that is impossible."""
    try:
        orphan.file.unlink(missing_ok=True)
        _lock_of(orphan.file).unlink(missing_ok=True)
    except OSError as error:
        raise InputError(f"{orphan.file}: cannot be deleted: {error.strerror}") from error


class _Owner(BaseModel):
    model_config = ConfigDict(frozen=True, strict=True)

    pid: Annotated[int, Field(ge=1, lt=1 << 31)]
    started_at: Annotated[float, Field(ge=0.0, le=1e11)]


class _Said(BaseModel):
    """Content of an autosave file; anything else is rejected."""

    model_config = ConfigDict(frozen=True, strict=True)

    riglens_autosave: Literal[1]
    owner: _Owner
    saved_at: Annotated[float, Field(ge=0.0, le=1e11)]
    path: Any  # judged below, because names of files need not be Unicode
    rig: str
    base: str


def _lock_of(file: Path) -> Path:
    return file.with_name(file.name.removesuffix(SUFFIX) + LOCK_SUFFIX)


def _files(folder: Path) -> Iterator[Path]:
    with contextlib.suppress(OSError):
        yield from folder.glob(f"*{SUFFIX}")


def _orphan(file: Path) -> Orphan | None:
    try:
        if not file.is_file():  # a pipe would be waited for
            return None
        with file.open("rb") as stream:
            content = stream.read(3 * MAX_BYTES + 1)
        if len(content) > 3 * MAX_BYTES:
            return None
        said = _Said.model_validate(json.loads(content))
        if _is_live(file, said.owner):
            return None
        path = _path(said.path)
        return Orphan(file, Unsaved(_rig(said.rig, path), _rig(said.base, path), path), said.saved_at)
    except (OSError, ValueError, RecursionError):  # InputError and pydantic's error are a ValueError
        return None


def _rig(text: str, path: Path | None) -> Rig:
    return loads(text, "autosave", None if path is None else reader_in(path.parent)).rig


def _path(said: object) -> Path | None:
    """Return the saved path of a rig's file, None if it has none; raise ValueError unless it is absolute."""
    if said is None:
        return None
    if not isinstance(said, str) or "\0" in said or not os.path.isabs(said):
        raise ValueError("path must be absolute")
    os.fsencode(said)  # a ValueError for what no file can be called
    return Path(said)


def _is_live(file: Path, owner: _Owner) -> bool:
    """Return whether the window that wrote a file still runs: by its lock, which changes of the clock do not affect."""
    lock = _lock_of(file)
    if lock.is_file():
        try:
            hold_lock(lock).release()
            return False
        except BlockingIOError:
            return True
        except OSError:  # a file system without locks
            pass
    try:
        return abs(psutil.Process(owner.pid).create_time() - owner.started_at) < 1.0
    except psutil.NoSuchProcess:
        return False
    except psutil.Error:  # it runs, but is not ours to look at
        return True
