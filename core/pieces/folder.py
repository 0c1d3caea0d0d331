"""Finished pieces as files, each checked against its own checksum, in a folder with one run at a time."""

from __future__ import annotations

import contextlib
import hashlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Generic, TypeVar

from riglens.core.errors import InputError
from riglens.core.files import atomic_write, hold_lock, open_regular, release_lock

if TYPE_CHECKING:
    from filelock import BaseFileLock

Result = TypeVar("Result")

SUFFIX, LOCK = ".piece", ".lock"
_MAGIC = b"riglens piece 1 "


class PieceFolder(Generic[Result]):
    """Store of pieces, as files KEY.piece in a folder that is created when needed.

    read: makes the result of a key and its content, and raises whatever damaged or other content leads to.
    """

    def __init__(self, folder: Path, read: Callable[[str, bytes], Result]) -> None:
        self.folder, self._read = folder, read

    def load(self, key: str) -> Result | None:
        """Return a finished piece; None when its file is missing, damaged or altered."""
        try:
            with open_regular(self._file(key), "a finished piece") as file:
                seal, content = file.readline(200), file.read()
            return self._read(key, content) if seal == _seal(key, content) else None
        except Exception:  # damaged bytes make numpy, zipfile, zlib and json raise a dozen kinds of error
            return None

    def keep(self, key: str, content: bytes) -> Result:
        """Write a finished piece; ChildProcessError when its content is damaged or that of another piece."""
        try:
            result = self._read(key, content)
        except Exception as error:
            raise ChildProcessError(
                f"a worker returned an unexpected result ({error}); finished parts are kept"
            ) from error
        self.folder.mkdir(parents=True, exist_ok=True)
        with atomic_write(self._file(key), "wb") as file:
            file.write(_seal(key, content))
            file.write(content)
        return result

    def remove(self, key: str) -> None:
        """Remove a piece that is no longer needed."""
        self._file(key).unlink(missing_ok=True)

    def clear(self) -> None:
        """Remove the pieces, and the folder when nothing else is in it."""
        for file in (*self.folder.glob(f"*{SUFFIX}"), *self.folder.glob(f".*{SUFFIX}.*.tmp")):
            with contextlib.suppress(OSError):
                file.unlink()
        with contextlib.suppress(OSError):
            self.folder.rmdir()

    def _file(self, key: str) -> Path:
        return self.folder / f"{key}{SUFFIX}"


def count_kept(folder: Path) -> int:
    """Return how many finished pieces a folder holds."""
    return sum(1 for _ in folder.glob(f"*{SUFFIX}"))


@contextmanager
def sole_run(folder: Path) -> Iterator[None]:
    """Keep other runs out of a folder while the block runs; an empty folder goes at its end.

    Raise InputError when another run is at work there, or the folder cannot be made.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: folder cannot be created ({error.strerror})") from error
    lock: BaseFileLock | None = None
    try:
        lock = hold_lock(folder / LOCK)
    except BlockingIOError as error:
        raise InputError(
            f"{folder}: another run uses this folder; wait until it ends, or choose another one"
        ) from error
    except OSError:  # a file system without locks: as safe as atomic files are
        pass
    try:
        yield
    finally:
        if lock is not None:
            release_lock(lock)
        with contextlib.suppress(OSError):
            folder.rmdir()


def _seal(key: str, content: bytes) -> bytes:
    """Return the first line of a piece's file: its checksum covers the key, too, so that no file passes for another."""
    digest = hashlib.sha256(key.encode())
    digest.update(content)
    return _MAGIC + digest.hexdigest().encode() + b"\n"
