"""Kernels that other kernels call are made into machine code in these, and on their own when Python calls them."""

from __future__ import annotations

import gc
from collections.abc import Callable
from typing import Any

import numba
import numpy as np
import pytest

from riglens.core.kernels.runtime.linked import KernelDispatcher

OPTIONS = {"nopython": True, "nogil": True, "error_model": "numpy"}


def _dispatcher(function: Callable[..., Any], **options: bool) -> Any:
    return KernelDispatcher(function, targetoptions=OPTIONS | options)


def _is_only_linked(kernel: Any) -> list[bool]:
    return [made.library.is_only_linked for made in kernel.overloads.values()]


def _half(x: int) -> float:
    return np.full(2, x).sum() / 4


def test_a_kernel_is_optimised_on_its_own_once_python_calls_it() -> None:
    half = _dispatcher(_half)
    quarter = _dispatcher(lambda x: half(half(x)) if x else half(x))
    assert quarter(8) == 2.0
    assert (_is_only_linked(quarter), set(_is_only_linked(half))) == ([False], {True})
    assert (half(8), half(8.0), quarter(4)) == (4.0, 4.0, 1.0)
    assert set(_is_only_linked(half)) == {False}
    eighth = _dispatcher(lambda x: quarter(x) / 2)
    assert eighth(8) == 1.0


def test_a_parallel_loop_has_linked_code_in_it() -> None:
    half = _dispatcher(_half)

    def sum_halves(xs: np.ndarray) -> float:
        total = 0.0
        for i in numba.prange(xs.size):
            total += half(xs[i])
        return total

    assert _dispatcher(sum_halves, parallel=True)(np.array([2, 4])) == 3.0
    assert _is_only_linked(half) == [True]


def test_functions_of_others_are_compiled_as_ever() -> None:
    half = _dispatcher(_half)
    theirs = numba.njit(lambda x: half(x) + 1)
    twice = numba.njit(lambda x: theirs(x) * 2)
    assert (twice(4), theirs(4), half(4)) == (6.0, 3.0, 2.0)
    assert not any(hasattr(made.library, "is_only_linked") for made in theirs.overloads.values())


def test_cycles_are_collected_as_often_as_before_once_a_kernel_is_compiled() -> None:
    before = gc.get_threshold()
    assert _dispatcher(_half)(8) == 4.0
    assert gc.get_threshold() == before
    with pytest.raises(numba.TypingError):
        _dispatcher(lambda x: x.nothing)(8)
    assert gc.get_threshold() == before
