"""Workers of a Dask cluster that build groups of a data set, on as many machines as it has.

The workers read the data themselves, under the same paths, and send back finished POG files. A task whose worker
dies is given to another one by Dask itself.
"""

from __future__ import annotations

import re
import socket
from collections.abc import Iterator
from concurrent.futures import CancelledError, Executor, Future
from contextlib import contextmanager
from typing import Any
from urllib.parse import urlsplit

from riglens.core.errors import InputError
from riglens.core.scene.grid import VoxelGrid
from riglens.core.scene.pog_parts import group_file
from riglens.core.scene.readers.collection import BoxCollection

TIMEOUT_S = 10
_ADDRESS = re.compile(r"(tcp|tls)://[^\s/]+:\d{1,5}")


class ClusterWorkers:
    """The workers of a cluster, as an executor."""

    def __init__(self, executor: Executor, count: int) -> None:
        self._executor = executor
        self.ahead = 2 * count

    def submit(self, group: BoxCollection, grid: VoxelGrid) -> Future[bytes]:
        """Begin to build one group on some worker."""
        return self._executor.submit(group_file, group, grid)


@contextmanager
def cluster_workers(address: str) -> Iterator[ClusterWorkers]:
    """The workers of the cluster whose scheduler listens at `address` (tcp://HOST:PORT), while the block runs.

    Raises InputError when Dask is not installed or nothing answers within TIMEOUT_S, ChildProcessError when the
    cluster goes away or several workers died of the same group.
    """
    if not _ADDRESS.fullmatch(address):
        raise InputError(f"--dask: found '{address}', accepted is tcp://HOST:PORT")
    distributed = _distributed()
    where = urlsplit(address)
    try:
        # a client that finds nobody would leave its thread behind
        socket.create_connection((where.hostname or "", where.port or 0), TIMEOUT_S).close()
        client = distributed.Client(address, timeout=TIMEOUT_S, set_as_default=False)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or f"not within {TIMEOUT_S} s"
        raise InputError(f"--dask: no scheduler answers at {address} ({reason})") from error
    with client:
        yield from _workers(client, address)


def _workers(client: Any, address: str) -> Iterator[ClusterWorkers]:
    try:
        client.wait_for_workers(1, timeout=TIMEOUT_S)
    except TimeoutError as error:
        raise InputError(f"--dask: the scheduler at {address} has no workers") from error
    distributed = _distributed()
    try:
        executor = client.get_executor(pure=False)
        try:
            yield ClusterWorkers(executor, len(client.nthreads()))
        finally:
            executor.shutdown(wait=False)
    except (distributed.KilledWorker, distributed.CommClosedError, CancelledError) as error:
        raise ChildProcessError(
            f"--dask: the cluster at {address} lost its workers ({type(error).__name__}); what is finished is kept: "
            "run the same command again"
        ) from error


def _distributed() -> Any:
    try:
        import distributed
    except ImportError as error:
        raise InputError(
            "--dask: needs the package distributed; install it with: pip install 'riglens[cluster]'"
        ) from error
    return distributed
