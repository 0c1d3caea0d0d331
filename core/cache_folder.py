"""Locate the cache folder, for things that can be made again. Nothing depends on it: a full disk only costs time."""

from __future__ import annotations

import contextlib
import hashlib
import logging
import os
from collections.abc import Callable, Iterable
from functools import lru_cache
from pathlib import Path

from riglens.core.errors import InputError
from riglens.core.files import atomic_write, open_regular
from riglens.core.user_folders import system_folders


def cache_folder() -> Path:
    """Return the user's cache folder of RigLens; the environment variable RIGLENS_CACHE_DIR wins."""
    return Path(os.environ.get("RIGLENS_CACHE_DIR") or system_folders().user_cache_dir)


def stored(name: str, maker: str, make: Callable[[], bytes]) -> bytes:
    """Return the result of `make`, from the file of that name in the cache if the same maker has written it.

    `maker` is a text that tells everything that the content depends on. The file begins with a checksum; one that is
    damaged or of another maker is replaced.
    """
    path = cache_folder() / name
    with contextlib.suppress(OSError, InputError), open_regular(path, "a cached file") as file:
        check, _, content = file.read().partition(b"\n")
        if check == _check(maker, content):
            return content
    content = make()

    def write(place: Path) -> None:
        with atomic_write(place) as file:
            file.write(_check(maker, content) + b"\n" + content)

    keep(path, write)
    return content


def _check(maker: str, content: bytes) -> bytes:
    return hashlib.sha256(maker.encode() + content).hexdigest().encode()


def digest_of_files(paths: Iterable[Path]) -> str:
    """Return a checksum of the content of files: of the sources that make something, for its maker."""
    return hashlib.sha256(b"".join(path.read_bytes() for path in paths)).hexdigest()


def keep(path: Path, write: Callable[[Path], object]) -> None:
    """Have `write` put a file into the cache; when that is impossible, log one warning per folder and go on without."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        write(path)
    except (OSError, InputError) as error:
        _tell(path.parent, str(getattr(error, "strerror", None) or error).rpartition(": ")[2])


@lru_cache(maxsize=8)
def tell_damaged(folder: Path, what: str) -> None:
    """Note that a file of the cache was damaged and is made again; once for each folder."""
    shown = str(folder) if str(folder).isprintable() else repr(str(folder))
    logging.getLogger("riglens").warning("note: damaged %s in %s are made again", what, shown)


@lru_cache(maxsize=8)
def _tell(folder: Path, reason: str) -> None:
    """Warn on standard error, unless the application handles the log; the same warning is not repeated."""
    shown = str(folder) if str(folder).isprintable() else repr(str(folder))
    logging.getLogger("riglens").warning(
        "note: the cache folder %s cannot be written (%s); continuing without it, more slowly: free space or allow "
        "writing there, or set RIGLENS_CACHE_DIR to another folder",
        shown,
        reason,
    )
