"""Where compiled kernels are kept: a folder named by all of their sources.

Numba keeps a compiled kernel as long as the file that the kernel stands in is the same, also when another file,
whose functions it inlines, has changed. Sources that differ in any kernel therefore share no folder.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import shutil
import time
from collections.abc import Iterator
from pathlib import Path

import numba

from riglens.core.cache_folder import cache_folder

PREFIX = "riglens-kernels-"
OLD_S = 14 * 24 * 3600.0
"""Folders of other sources go when nobody has used them for so long."""
SOURCES = Path(__file__).parent


def use_own_folder() -> bool:
    """Have Numba keep what it compiles from now on in that folder; False where there is no place for one.

    To be called before the first kernel is declared. It lies in the folder that the user gave to Numba
    (NUMBA_CACHE_DIR), if any.
    """
    name = PREFIX + digest_of(SOURCES)
    for root in _roots():
        if _is_usable(root / name):
            numba.config.CACHE_DIR = str(root / name)
            _remove_old(root, name)
            return True
    return False


def digest_of(sources: Path) -> str:
    """What names the folder: every source file of the kernels, and the version of Numba."""
    digest = hashlib.sha256(numba.__version__.encode())
    for path in sorted(sources.glob("*.py")):
        text = path.read_bytes()
        digest.update(f"\n{path.name} {len(text)}\n".encode() + text)
    return digest.hexdigest()[:20]


def _roots() -> Iterator[Path]:
    """Where the folder may be, the best place first; beside the sources where the user has no cache."""
    if numba.config.CACHE_DIR:
        yield Path(numba.config.CACHE_DIR)
    yield cache_folder()
    yield SOURCES / "__pycache__"


def _is_usable(folder: Path) -> bool:
    """Whether files can be put there; marks it as used now."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        os.utime(folder)
    except OSError:
        return False
    return os.access(folder, os.W_OK | os.X_OK)


def _remove_old(root: Path, used: str) -> None:
    """Remove folders of other sources that nobody has used for long; another process may do the same."""
    long_ago = time.time() - OLD_S
    for other in root.glob(PREFIX + "*"):
        with contextlib.suppress(OSError):
            if other.name != used and other.stat().st_mtime < long_ago:
                shutil.rmtree(other, ignore_errors=True)
