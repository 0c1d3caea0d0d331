"""Locks on files that the system drops by itself when their process ends, however it ends."""

from __future__ import annotations

import contextlib
import os
import sys
from pathlib import Path

if sys.platform == "win32":
    import msvcrt

    def _lock(descriptor: int) -> None:
        msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)
else:
    import fcntl

    def _lock(descriptor: int) -> None:
        # flock, not lockf: two holders in one process are kept apart too
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)


class FileLock:
    """An exclusive lock on a file made for it; held until `release`, or until the process is gone."""

    def __init__(self, path: Path) -> None:
        """Make and lock the file; raise OSError when the folder or the file system does not allow that."""
        self._path = path
        self._descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_EXCL, 0o600)
        try:
            _lock(self._descriptor)
        except OSError:
            self.release()
            raise

    def release(self) -> None:
        """Give the lock back and delete its file."""
        os.close(self._descriptor)  # first, because Windows deletes no open file
        with contextlib.suppress(OSError):
            self._path.unlink()


def is_locked(path: Path) -> bool:
    """Return whether somebody holds the lock on this file; raise FileNotFoundError when there is no such file."""
    descriptor = os.open(path, os.O_RDWR | getattr(os, "O_NONBLOCK", 0))
    try:
        _lock(descriptor)
    except OSError:
        return True
    finally:
        os.close(descriptor)
    return False
