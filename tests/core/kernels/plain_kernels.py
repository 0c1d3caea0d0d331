"""Have the kernels run as plain Python, without the compiler: a start takes a second instead of minutes.

A plugin for pytest (`-p plain_kernels`), to be loaded before any kernel, with NUMBA_DISABLE_JIT=1. What is compiled
to single instructions and has no Python of its own is given some here.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any

import numba.extending
import numpy as np


def _popcount(bits: Any) -> np.uint64:
    return np.uint64(int(bits).bit_count())


def _lowest_bit(bits: Any) -> np.uint64:
    return np.uint64((int(bits) & -int(bits)).bit_length() - 1)


def _take(counter: Any) -> int:
    counter[0] += 1
    return int(counter[0]) - 1


IN_PYTHON: dict[str, Callable[[Any], Any]] = {
    "popcount": _popcount,
    "lowest_bit": _lowest_bit,
    "take": _take,
}


def _in_python(function: Callable[..., Any]) -> Callable[[Any], Any]:
    return IN_PYTHON[function.__name__]


numba.extending.intrinsic = _in_python
warnings.simplefilter(
    "ignore"
)  # unsigned numbers wrap around, divisions by zero give inf: on purpose, as compiled
