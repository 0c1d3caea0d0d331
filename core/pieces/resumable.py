"""Long work in pieces next to its output: other runs are refused, interruptions and open clusters are reported."""

from __future__ import annotations

import hashlib
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from riglens.core.files import is_stream
from riglens.core.monitor import Monitor
from riglens.core.pieces.backend import Backend, workers_at
from riglens.core.pieces.cluster import is_unencrypted
from riglens.core.pieces.folder import count_kept, sole_run
from riglens.core.pieces.work import Workers

LONGEST_NAME_BYTES = 240
"""File systems allow 255, some with encryption 143, which `require_writable` finds out."""


@contextmanager
def parts_folder(out: Path) -> Iterator[Path]:
    """Return the folder of finished parts, next to the output; a pipe or device has none."""
    if is_stream(out):
        with tempfile.TemporaryDirectory(prefix="riglens-") as folder:
            yield Path(folder) / "parts"
        return
    name = os.fsencode(out.name)
    if len(name) > LONGEST_NAME_BYTES:
        name = name[:200] + hashlib.sha256(name).hexdigest()[:16].encode()
    yield out.with_name(os.fsdecode(name) + ".parts")


@contextmanager
def resumable(folder: Path, backend: Backend, pieces: int, monitor: Monitor) -> Iterator[Workers]:
    """Start workers for `pieces` pieces, which are kept in a folder, while the block runs.

    Raise InputError when another run is at work in the folder or the workers cannot be reached; a KeyboardInterrupt of
    the block says how many pieces are kept.
    """
    with sole_run(folder), workers_for(folder, backend, pieces, monitor) as workers:
        yield workers


@contextmanager
def workers_for(folder: Path, backend: Backend, pieces: int, monitor: Monitor) -> Iterator[Workers]:
    """Do the same in a folder that is locked already."""
    if backend.dask is not None and is_unencrypted(backend.dask):
        monitor.note(
            f"{backend.dask} is not encrypted: anyone on the cluster's network can run code on all of its machines "
            "and on this one; use tls:// (docs/security.md)"
        )
    try:
        with workers_at(backend, pieces) as workers:
            yield workers
    except KeyboardInterrupt as error:
        if kept := count_kept(folder):
            raise KeyboardInterrupt(
                f"{kept} finished parts are kept in {folder}: run the same command again to continue"
            ) from error
        raise
