"""Decorator presets of all kernels, and the thread count, in one place.

No fast-math anywhere: every kernel must give the same doubles as the same formula in plain numpy.
Parallel kernels are called from one thread at a time only (the `workqueue` layer does not allow more).
"""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any, TypeVar

import numba

from riglens.core.kernels.compiled import use_own_folder

F = TypeVar("F", bound=Callable[..., Any])
CACHED = use_own_folder()
"""Whether compiled kernels are kept for the next process."""


def kernel(function: F) -> F:
    """A compiled, cached function; division by zero gives inf as in numpy."""
    return numba.njit(cache=CACHED, nogil=True, error_model="numpy")(function)  # type: ignore[no-any-return]


def inlined(function: F) -> F:
    """A compiled function that LLVM inlines into its caller."""
    return numba.njit(cache=CACHED, nogil=True, error_model="numpy", forceinline=True)(function)  # type: ignore[no-any-return]


def parallel_kernel(function: F) -> F:
    """A compiled, cached function with `prange`; each iteration writes its own data."""
    return numba.njit(cache=CACHED, nogil=True, error_model="numpy", parallel=True)(function)  # type: ignore[no-any-return]


def use_threads(threads: int | None) -> int:
    """Set the number of threads of the parallel kernels for the calling thread; returns the number used."""
    most = int(numba.config.NUMBA_NUM_THREADS)
    count = min(threads or os.cpu_count() or 1, most)
    numba.set_num_threads(count)
    return count
