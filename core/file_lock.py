"""Locks on files that the system drops by itself when their process ends, however it ends."""

from __future__ import annotations

import contextlib
import os
import sys
from pathlib import Path

if sys.platform == "win32":
    import msvcrt

    def _lock(descriptor: int) -> None:
        try:
            msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)
        except PermissionError as error:
            raise BlockingIOError(error.errno, error.strerror) from error
else:
    import fcntl

    def _lock(descriptor: int) -> None:
        # flock, not lockf: two holders in one process are kept apart too
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)


class FileLock:
    """An exclusive lock on a file made for it; held until `release`, or until the process is gone."""

    def __init__(self, path: Path) -> None:
        """Make and lock the file; a file that a killed process left is taken over.

        Raise BlockingIOError when another process holds the lock, another OSError when the folder or the file system
        does not allow one.
        """
        self._path = path
        while True:
            self._descriptor = os.open(path, os.O_RDWR | os.O_CREAT, 0o600)
            try:
                _lock(self._descriptor)
                if _is_file(self._descriptor, path):
                    return
            except BlockingIOError:
                os.close(self._descriptor)
                raise
            except OSError:
                self.release()
                raise
            os.close(self._descriptor)  # its holder deleted it before we had the lock

    def release(self) -> None:
        """Give the lock back and delete its file."""
        if sys.platform == "win32":  # which deletes no open file
            os.close(self._descriptor)
        with contextlib.suppress(OSError):
            self._path.unlink()
        if sys.platform != "win32":
            os.close(self._descriptor)


def _is_file(descriptor: int, path: Path) -> bool:
    try:
        return os.path.samestat(os.fstat(descriptor), os.stat(path))
    except FileNotFoundError:
        return False


def is_locked(path: Path) -> bool:
    """Return whether a process holds the lock on this file; raise FileNotFoundError when there is no such file."""
    descriptor = os.open(path, os.O_RDWR | getattr(os, "O_NONBLOCK", 0))
    try:
        _lock(descriptor)
    except OSError:
        return True
    finally:
        os.close(descriptor)
    return False
