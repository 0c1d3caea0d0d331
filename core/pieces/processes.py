"""Worker processes on this machine."""

from __future__ import annotations

import multiprocessing
import multiprocessing.connection
import os
import signal
import threading
from collections.abc import Callable, Collection, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor
from concurrent.futures import wait as wait_for
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing import resource_tracker


class WorkerProcesses:
    """Processes, each with its share of the cores."""

    def __init__(self, pool: ProcessPoolExecutor, count: int) -> None:
        self._pool = pool
        self.threads: int | None = max(1, (os.cpu_count() or 1) // count)
        self.ahead = count + 1

    def call(self, work: Callable[..., bytes], *arguments: object) -> Future[bytes]:
        """Begin to call a function as soon as a process is free."""
        with _ctrl_c_waits():
            return self._pool.submit(work, *arguments)

    def wait(self, waiting: Collection[Future[bytes]]) -> Collection[Future[bytes]]:
        """Wait for one of the futures at least, and return those that are done."""
        return wait_for(waiting, return_when=FIRST_COMPLETED).done


@contextmanager
def worker_processes(count: int) -> Iterator[WorkerProcesses]:
    """Run `count` processes while the block runs; on any exception, Ctrl-C included, they end at once.

    Raises ChildProcessError when one of them was killed, as the system does when memory runs out.
    """
    before = set(multiprocessing.active_children())
    # spawn: a forked copy of a process with threads (Numba's, Arrow's) may hang
    pool = ProcessPoolExecutor(count, multiprocessing.get_context("spawn"), _begin)
    try:
        yield WorkerProcesses(pool, count)
    except BaseException as error:
        for process in set(multiprocessing.active_children()) - before:
            process.terminate()
        pool.shutdown(cancel_futures=True)
        if isinstance(error, BrokenProcessPool):
            raise ChildProcessError(
                "a worker process ended before its work was done (out of memory?); finished parts are kept: run "
                "the same command again, with fewer workers"
            ) from error
        raise
    pool.shutdown()


@contextmanager
def _ctrl_c_waits() -> Iterator[None]:
    """Block Ctrl-C while a worker may be started: it inherits the block and is never interrupted before `_begin`."""
    if not hasattr(signal, "pthread_sigmask"):  # Windows
        yield
        return
    resource_tracker.ensure_running()  # when it is started later, it lets Ctrl-C through again
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _begin() -> None:
    """Leave Ctrl-C to the main process in a worker, and end the worker when the main process has been killed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        multiprocessing.connection.wait([parent.sentinel])
        os._exit(1)
