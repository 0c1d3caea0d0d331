"""Decorator presets of all kernels, the thread count and the one atomic operation, in one place.

No fast-math anywhere: every kernel must give the same doubles as the same formula in plain numpy.
Parallel kernels are called from one thread at a time only (the `workqueue` layer does not allow more).
"""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any, TypeVar

import numba
from numba.core import types
from numba.core.errors import TypingError
from numba.extending import intrinsic

F = TypeVar("F", bound=Callable[..., Any])


def kernel(function: F) -> F:
    """A compiled, cached function; division by zero gives inf as in numpy."""
    return numba.njit(cache=True, nogil=True, error_model="numpy")(function)  # type: ignore[no-any-return]


def inlined(function: F) -> F:
    """A compiled function that LLVM inlines into its caller."""
    return numba.njit(cache=True, nogil=True, error_model="numpy", forceinline=True)(function)  # type: ignore[no-any-return]


def parallel_kernel(function: F) -> F:
    """A compiled, cached function with `prange`; each iteration writes its own data or uses `atomic_or`."""
    return numba.njit(cache=True, nogil=True, error_model="numpy", parallel=True)(function)  # type: ignore[no-any-return]


def use_threads(threads: int | None) -> int:
    """Set the number of threads of the parallel kernels for the calling thread; returns the number used."""
    most = int(numba.config.NUMBA_NUM_THREADS)
    count = min(threads or os.cpu_count() or 1, most)
    numba.set_num_threads(count)
    return count


@intrinsic  # type: ignore[untyped-decorator]
def atomic_or(typingctx: Any, array: Any, index: Any, bits: Any) -> Any:
    """array[index] |= bits for a contiguous uint64 array, safe between threads; the order cannot matter."""
    if not (isinstance(array, types.Array) and array.dtype == types.uint64 and array.ndim == 1):
        raise TypingError("atomic_or takes a one-dimensional uint64 array")

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        array_value, index_value, bits_value = args
        array_struct = context.make_array(signature.args[0])(context, builder, array_value)
        pointer = builder.gep(array_struct.data, [index_value])
        builder.atomic_rmw("or", pointer, bits_value, "monotonic")
        return context.get_dummy_value()

    return types.void(array, types.int64, types.uint64), codegen
