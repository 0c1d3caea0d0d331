"""Decorator presets of all kernels, and the thread count, in one place.

Fast-math is never used: every kernel must give the same doubles as the same formula in plain numpy. Parallel kernels
are called from one thread at a time only (the `workqueue` layer does not allow more).
"""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any, TypeVar

import numba

from riglens.core.kernels.runtime.compiled import KernelCache, KernelFolder
from riglens.core.kernels.runtime.linked import KernelDispatcher

F = TypeVar("F", bound=Callable[..., Any])
FOLDER = KernelFolder()
"""Folder of compiled kernels, shared with later processes."""


def kernel(function: F) -> F:
    """Compile a function and cache it; division by zero gives inf as in numpy."""
    return _compiled(function)


def inlined(function: F) -> F:
    """Compile a function that LLVM inlines into its caller."""
    return _compiled(function, forceinline=True)


def lean(function: F) -> F:
    """Compile a function without reference counts, for inner loops: it may not make arrays, only views.

    Every array that is passed on costs two locked instructions elsewhere, and threads that share it wait for each
    other.
    """
    return _compiled(function, _nrt=False)


def lean_inlined(function: F) -> F:
    """As `lean`, and LLVM inlines it into its caller."""
    return _compiled(function, _nrt=False, forceinline=True)


def parallel_kernel(function: F) -> F:
    """Compile a function with `prange` and cache it; each iteration writes its own data."""
    return _compiled(function, parallel=True)


def _compiled(function: F, **options: bool) -> F:
    """Return a dispatcher that asks our cache for compiled code."""
    if numba.config.DISABLE_JIT:
        return function
    usual = {"nopython": True, "nogil": True, "error_model": "numpy", "boundscheck": None}
    dispatcher = KernelDispatcher(function, targetoptions=usual | options)
    dispatcher._cache = KernelCache(FOLDER, function)
    return dispatcher


SPIN = "GOMP_SPINCOUNT"
_SPIN_COUNT, _SPIN_CHOICES = "2000", (SPIN, "OMP_WAIT_POLICY")


def use_threads(threads: int | None) -> int:
    """Set the number of threads of the parallel kernels for the calling thread; return the number used.

    By default idle threads of GNU OpenMP spin for milliseconds while other programs, the drawing among them, wait: an
    edit of 6 ms cost 80 ms of four processors' time. RigLens makes them sleep soon, unless the user's environment says
    what they do. The library reads it once, when the first kernel starts its threads.
    """
    if not any(name in os.environ for name in _SPIN_CHOICES):
        os.environ[SPIN] = _SPIN_COUNT
    count = thread_count(threads)
    numba.set_num_threads(count)
    return count


def thread_count(threads: int | None) -> int:
    """Return a number of threads, None for one on each processor, as far as the user's environment allows."""
    return min(threads or os.cpu_count() or 1, int(numba.config.NUMBA_NUM_THREADS))
