"""Have the kernels run as plain Python, without the compiler: a start takes a second instead of minutes.

A plugin for pytest (`-p plain_kernels`), to be loaded before any kernel, with NUMBA_DISABLE_JIT=1. What is compiled
to single instructions and has no Python of its own is given some here. A test that takes too long fails.
"""

from __future__ import annotations

import signal
import warnings
from collections.abc import Callable, Generator
from typing import Any

import numba.extending
import numpy as np
import pytest

LONGEST_S = 20.0


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


def _end(*_: object) -> None:
    raise TimeoutError(f"takes more than {LONGEST_S:g} s as plain Python")


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call() -> Generator[None, object, object]:
    """End a test that takes too long."""
    before = signal.signal(signal.SIGALRM, _end)
    signal.setitimer(signal.ITIMER_REAL, LONGEST_S)
    try:
        return (yield)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)
