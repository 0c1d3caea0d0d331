"""Run shares of work side by side: a compiled kernel does not hold Python's lock, so one for a single thread serves any
number of them, in any thread."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, wait
from functools import cache
from typing import TypeVar

Found = TypeVar("Found")
HELPER = "helper"
"""Start of the names of threads."""


@cache
def _pool() -> ThreadPoolExecutor:
    """Return the threads that help; they start when they are first needed, and sleep between."""
    return ThreadPoolExecutor(os.cpu_count() or 1, HELPER)


def in_threads(workers: int, work: Callable[[int], Found]) -> list[Found]:
    """Return what `work` returns for each share, 0 to workers - 1. The caller does the first, and then those that no
    thread has begun: busy threads delay nothing. Raise the first error once all have ended."""
    others = [_pool().submit(work, share) for share in range(1, workers)]
    try:
        found = [work(0)]
        for share, other in enumerate(others, 1):
            found.append(work(share) if other.cancel() else other.result())
    finally:
        wait([other for other in others if not other.cancel()])
    return found
