"""Locate the cache folder, for things that can be made again. Nothing depends on it: a full disk only costs time."""

from __future__ import annotations

import logging
import os
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path

import platformdirs

from riglens.core.errors import InputError


def cache_folder() -> Path:
    """Return the user's cache folder of RigLens; the environment variable RIGLENS_CACHE_DIR wins."""
    override = os.environ.get("RIGLENS_CACHE_DIR")
    return Path(override) if override else Path(platformdirs.user_cache_dir("riglens"))


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
