"""Reading regular files alone, and writing files so that an interrupted run leaves no half and destroys no old one."""

from __future__ import annotations

import contextlib
import errno
import os
import re
import secrets
import shutil
import stat
import time
from collections.abc import Iterable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any, BinaryIO, Literal, overload

from riglens.core.errors import InputError

if TYPE_CHECKING:
    from filelock import BaseFileLock
    from pyarrow import Table

_NO_ROOM = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)


def open_regular(path: str | os.PathLike[str], accepted: str) -> BinaryIO:
    """Open a file for reading; raise InputError for a device, pipe or socket, which may have no end or never answer.

    `accepted` describes in the message what the file should have been. Raise OSError as `open` does.
    """
    # a pipe that nobody writes to would keep an ordinary `open` waiting
    descriptor = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
    try:
        _require_regular(path, os.fstat(descriptor), accepted)
        return os.fdopen(descriptor, "rb")
    except BaseException:
        os.close(descriptor)
        raise


def _require_regular(path: str | os.PathLike[str], status: os.stat_result, accepted: str) -> None:
    if stat.S_ISDIR(status.st_mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
    if not stat.S_ISREG(status.st_mode):
        raise InputError(f"{_shown(path)}: must be {accepted} (got {_kind(status.st_mode)})")


def _kind(mode: int) -> str:
    if stat.S_ISFIFO(mode):
        return "a pipe"
    return "a device" if stat.S_ISCHR(mode) or stat.S_ISBLK(mode) else "something that is not a file"


def read_csv(source: object, **options: object) -> Table:
    """Read a table as `pyarrow.csv.read_csv` does, with Python's own handlers of signals.

    Those that Arrow puts in their place meanwhile lose a Ctrl-C that comes as a read ends.
    """
    import pyarrow
    from pyarrow import csv

    pyarrow.enable_signal_handlers(False)
    try:
        return csv.read_csv(source, **options)  # noqa: TID251
    finally:
        pyarrow.enable_signal_handlers(True)


@overload
def atomic_write(path: str | os.PathLike[str], mode: Literal["w"]) -> AbstractContextManager[IO[str]]: ...


@overload
def atomic_write(
    path: str | os.PathLike[str], mode: Literal["wb"] = ...
) -> AbstractContextManager[IO[bytes]]: ...


def atomic_write(
    path: str | os.PathLike[str], mode: Literal["w", "wb"] = "wb"
) -> AbstractContextManager[IO[Any]]:
    """Open `path` for writing; the content appears there at once and complete, or not at all.

    Everything goes to a temporary file in the same folder, is flushed to the disk and renamed when the
    block ends. On any exception, Ctrl-C included, the temporary file is removed and the old file stays; those
    of runs that were killed are removed by the first write into the folder after a day.
    Text is UTF-8 with line ends as written. Devices and pipes (/dev/null, /dev/stdout) are written directly; a
    symbolic link keeps pointing where it did. Raise InputError (one line) when the target cannot be written.
    """
    require_writable(path)
    if is_stream(path):
        return _open_stream(path, mode)
    return _replace_when_done(Path(os.path.realpath(path)), path, mode)


def write_file(path: str | os.PathLike[str], content: str | bytes) -> None:
    """Write a whole file, as `atomic_write` does."""
    with atomic_write(path) as stream:
        stream.write(content.encode("utf-8") if isinstance(content, str) else content)


def is_stream(path: str | os.PathLike[str]) -> bool:
    """Return whether this is a device, pipe or socket: no file can be next to it or replace it."""
    try:
        mode = os.stat(path).st_mode  # /dev/fd/3 leads to a pipe, but to no path
    except OSError:
        return False
    return not (stat.S_ISREG(mode) or stat.S_ISDIR(mode))


def require_writable(path: str | os.PathLike[str], reads: Iterable[str | os.PathLike[str]] = ()) -> None:
    """Raise InputError when `path` cannot be written, or is one of the files that the work `reads`.

    Call this before long work whose result goes there.
    """
    try:
        problem = "" if is_stream(path) else _problem(Path(os.path.realpath(path)))
    except OSError as error:
        problem = str(error.strerror)
    if problem:
        raise InputError(f"{_shown(path)}: cannot be written: {problem}")
    require_apart(path, reads)


def require_ending(field: str, path: Path | None, *endings: str) -> None:
    """Raise InputError unless a file that is named has one of these endings."""
    if path is not None and path.suffix.lower() not in endings:
        raise InputError(f"must end in {' or '.join(endings)} (got {path})", field)


def require_apart(path: str | os.PathLike[str], reads: Iterable[str | os.PathLike[str]]) -> None:
    """Raise InputError when a file or folder to be written is also read, by whatever name."""
    for read in reads:
        with contextlib.suppress(OSError):
            if os.path.samefile(path, read):
                raise InputError(f"{_shown(path)}: cannot be written: it is read as well; name another file")


def atomic_folder(path: str | os.PathLike[str], files: Mapping[str, bytes]) -> None:
    """Make a folder with these files (plain names); it appears at once and complete, or not at all.

    An existing folder is replaced when it holds files of these names and nothing else; any other is refused with
    InputError, and so is a place that cannot be written.
    """
    target = Path(os.path.realpath(path))
    _remove_leftovers(target.parent)
    temporary = _temporary(target)
    try:
        _require_replaceable(target, path, files)
        temporary.mkdir()
        for name, content in files.items():
            _write_to_disk(temporary / name, content)
        _swap_in(temporary, target)
    except OSError as error:
        raise InputError(f"{_shown(path)}: cannot be written: {error.strerror}") from error
    finally:
        shutil.rmtree(temporary, ignore_errors=True)
    _sync_folder(target.parent)


def write_files(folder: str | os.PathLike[str], files: Mapping[str, bytes]) -> None:
    """Write files by their paths in a folder, creating folders; each appears at once and complete.

    Raise InputError when something cannot be written.
    """
    root = Path(folder)
    made = {(root / name).parent for name in files}
    place = root
    try:
        for parent in sorted(made):
            parent.mkdir(parents=True, exist_ok=True)
            _remove_leftovers(parent)
        for name, content in files.items():
            place = root / name
            temporary = _temporary(place)
            try:
                _write_to_disk(temporary, content)
                os.replace(temporary, place)
            finally:
                temporary.unlink(missing_ok=True)
    except OSError as error:
        raise InputError(f"{_shown(place)}: cannot be written: {error.strerror}") from error
    for parent in sorted(made):
        _sync_folder(parent)


def _write_to_disk(path: Path, content: bytes) -> None:
    with path.open("xb") as stream:
        stream.write(content)
        stream.flush()
        os.fsync(stream.fileno())


def _require_replaceable(target: Path, path: str | os.PathLike[str], files: Mapping[str, bytes]) -> None:
    problem = "" if target.parent.is_dir() else f"no such folder: {_shown(target.parent)}"
    if not problem and target.is_dir():
        others = [entry.name for entry in target.iterdir() if entry.name not in files or not entry.is_file()]
        problem = f"must be a new or an empty folder (holds {_shown(others[0])})" if others else ""
    elif not problem and target.exists():
        problem = "must be a folder (got a file)"
    if problem:
        raise InputError(f"{_shown(path)}: cannot be written: {problem}")


def _swap_in(temporary: Path, target: Path) -> None:
    """Give the new folder its name; the old one has another name for a moment.

    Should the run be killed in that moment, `_remove_leftovers` gives the old folder its name back.
    """
    if not target.exists():
        os.rename(temporary, target)
        return
    old = _temporary(target, "old")
    os.rename(target, old)
    try:
        os.rename(temporary, target)
    except BaseException:
        with contextlib.suppress(OSError):
            os.rename(old, target)
        raise
    shutil.rmtree(old, ignore_errors=True)


# ---------------------------------------------------------------- temporary names, and what killed runs left


_LEFTOVER = re.compile(r"\.(?P<name>.+)\.riglens-[0-9a-f]{12}\.(?P<kind>tmp|old)")
_LEFTOVER_AGE_S = 86_400.0
"""No file is written for so long without a change; clocks of servers may be minutes ahead."""
_NAME_BYTES = 80


def _temporary(target: Path, kind: Literal["tmp", "old"] = "tmp") -> Path:
    """Return a new name next to the target."""
    name = os.fsencode(target.name)[:_NAME_BYTES].decode("utf-8", "ignore")
    return target.parent / f".{name}.riglens-{secrets.token_hex(6)}.{kind}"


def _remove_leftovers(folder: Path) -> None:
    """Remove temporary files and folders of yesterday; rename an old folder back if it lost its name."""
    with contextlib.suppress(OSError):
        for entry in [Path(found) for found in os.scandir(folder) if found.name.startswith(".")]:
            found = _LEFTOVER.fullmatch(entry.name)
            if found is None:
                continue
            lost = folder / found["name"]
            is_whole_name = len(os.fsencode(found["name"])) < _NAME_BYTES - 3
            if found["kind"] == "old" and is_whole_name and not os.path.lexists(lost):
                entry.rename(lost)
            elif time.time() - entry.lstat().st_mtime < _LEFTOVER_AGE_S:
                continue
            elif entry.is_dir() and not entry.is_symlink():
                shutil.rmtree(entry, ignore_errors=True)
            else:
                entry.unlink(missing_ok=True)


# ---------------------------------------------------------------- locks


def hold_lock(path: Path) -> BaseFileLock:
    """Make and lock a file until `release_lock`, or until the process is gone, however it ends.

    Raise BlockingIOError when someone else holds the lock, another OSError when the folder or the file system does
    not allow one.
    """
    from filelock import FileLock, Timeout  # takes 40 ms, which most commands need not wait for

    # One holder whichever thread calls; a marker instead of a lock would outlive its process.
    lock = FileLock(path, timeout=0, mode=0o600, thread_local=False, fallback_to_soft=False)
    try:
        lock.acquire()
    except Timeout as error:
        raise BlockingIOError(errno.EWOULDBLOCK, os.strerror(errno.EWOULDBLOCK), str(path)) from error
    return lock


def release_lock(lock: BaseFileLock) -> None:
    """Give the lock back and delete its file."""
    with contextlib.suppress(OSError):  # Windows deletes no open file: there `release` does it
        os.unlink(lock.lock_file)
    lock.release()


# ---------------------------------------------------------------- one file


def _problem(target: Path) -> str:
    if not target.parent.is_dir():
        return f"no such folder: {_shown(target.parent)}"
    if target.is_dir():
        return "must be a file (got a folder)"
    if target.exists() and not os.access(target, os.W_OK):
        return "the file is write-protected"
    with contextlib.suppress(FileNotFoundError):
        os.lstat(_temporary(target))  # whose name, or whole path, is longer
    if not os.access(target.parent, os.W_OK | os.X_OK):
        return f"{os.strerror(errno.EACCES)} in {_shown(target.parent)}"
    return ""


@contextmanager
def _replace_when_done(
    target: Path, path: str | os.PathLike[str], mode: Literal["w", "wb"]
) -> Iterator[IO[Any]]:
    _remove_leftovers(target.parent)
    temporary = _temporary(target)
    try:
        with _open(temporary, mode, "x") as stream:
            yield stream
            stream.flush()
            os.fsync(stream.fileno())
        if target.exists():
            os.chmod(temporary, stat.S_IMODE(target.stat().st_mode))
        os.replace(temporary, target)
    except BaseException as error:
        with contextlib.suppress(OSError):
            temporary.unlink()
        if isinstance(error, OSError) and (error.errno in _NO_ROOM or error.filename == str(temporary)):
            raise InputError(f"{_shown(path)}: cannot be written: {error.strerror}") from error
        raise
    _sync_folder(target.parent)


def _open(path: Path, mode: Literal["w", "wb"], how: Literal["w", "x"] = "w") -> IO[Any]:
    if mode == "wb":
        return path.open(f"{how}b")
    return path.open(how, encoding="utf-8", newline="")


def _open_stream(path: str | os.PathLike[str], mode: Literal["w", "wb"]) -> IO[Any]:
    """Open a device or pipe; raise InputError for a pipe that no process reads, which would keep `open` waiting."""
    try:
        descriptor = os.open(path, os.O_WRONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
    except OSError as error:
        why = "not a regular file, and no process reads it" if error.errno == errno.ENXIO else error.strerror
        raise InputError(f"{_shown(path)}: cannot be written: {why}") from error
    if hasattr(os, "set_blocking"):  # Windows opens nothing without waiting
        os.set_blocking(descriptor, True)
    return (
        os.fdopen(descriptor, "wb")
        if mode == "wb"
        else os.fdopen(descriptor, "w", encoding="utf-8", newline="")
    )


def _sync_folder(folder: Path) -> None:
    """Make the rename itself survive a power cut, where the system can open folders (not on Windows)."""
    with contextlib.suppress(OSError):
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)


def _shown(path: str | os.PathLike[str]) -> str:
    """Return a path on one line, whatever its name contains."""
    text = os.fspath(path)
    return text if text.isprintable() else repr(text)
