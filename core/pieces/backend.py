"""Choose where pieces are computed, from the user's options."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from riglens.core.errors import InputError
from riglens.core.pieces.cluster import cluster_workers
from riglens.core.pieces.processes import worker_processes
from riglens.core.pieces.work import OwnProcess, Workers

MOST_WORKERS = 1024


@dataclass(frozen=True)
class Backend:
    """Place of the computation: processes on this machine, None for one per core; or a Dask cluster, by its scheduler's
    address."""

    workers: int | None = None
    dask: str | None = None

    def __post_init__(self) -> None:
        if self.workers is not None and not 1 <= self.workers <= MOST_WORKERS:
            raise InputError(f"must be between 1 and {MOST_WORKERS} (got {self.workers})", "workers")
        if self.workers is not None and self.dask is not None:
            raise InputError(
                "cannot be combined with a cluster, which has its own workers; leave out", "workers", "dask"
            )


@contextmanager
def workers_at(backend: Backend, pieces: int) -> Iterator[Workers]:
    """Start workers for `pieces` pieces while the block runs; a single process is the calling one.

    Raise InputError when the cluster cannot be reached, ChildProcessError when workers are lost.
    """
    count = min(backend.workers or os.cpu_count() or 1, pieces)
    if backend.dask is not None:
        with cluster_workers(backend.dask) as cluster:
            yield cluster
    elif count <= 1:
        yield OwnProcess()
    else:
        with worker_processes(count) as processes:
            yield processes
