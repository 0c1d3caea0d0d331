"""Keep the last answers of functions by their bytes: the rays of one camera take a thousand times those of another."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable, Hashable
from functools import wraps
from typing import Any, TypeVar

import numpy as np

_Asked = TypeVar("_Asked", bound=Hashable)
_Found = TypeVar("_Found")
LIMIT_BYTES = 576 << 20
"""Of all functions together: the directions of the five cameras of 2.5 megapixels of the Waymo car, and their bins."""
_kept: OrderedDict[tuple[Callable[..., Any], Hashable], tuple[Any, dict[int, int]]] = OrderedDict()
"""Answers by function and argument, the last used last, with the bytes of their arrays by identity."""
_lock = threading.Lock()


def kept_by_bytes(find: Callable[[_Asked], _Found]) -> Callable[[_Asked], _Found]:
    """Keep what a function of one argument found last, in a room shared with all such functions, but always the very
    last answer; for all threads."""

    @wraps(find)
    def found(asked: _Asked) -> _Found:
        key = find, asked
        with _lock:
            if key in _kept:
                _kept.move_to_end(key)
                answer: _Found = _kept[key][0]
                return answer
        new = find(asked)
        with _lock:
            _kept[key] = new, _arrays_of(new)
            _kept.move_to_end(key)
            while len(_kept) > 1 and kept_bytes() > LIMIT_BYTES:
                _kept.popitem(last=False)
        return new

    return found


def kept_bytes() -> int:
    """Return the bytes of all that is kept; arrays that several answers share count once."""
    each = {name: size for _, arrays in _kept.values() for name, size in arrays.items()}
    return sum(each.values())


def keep_at_most(size_bytes: int) -> None:
    """Keep less or more than LIMIT_BYTES in this process."""
    global LIMIT_BYTES
    LIMIT_BYTES = size_bytes


def forget_kept() -> None:
    """Let go of everything: what is needed again is made again."""
    with _lock:
        _kept.clear()


def _arrays_of(found: object) -> dict[int, int]:
    """Return the bytes of all arrays in an array, a tuple or an object of fields, by their identity."""
    if isinstance(found, np.ndarray):
        return {id(found): found.nbytes}
    parts = found if isinstance(found, tuple) else vars(found).values() if hasattr(found, "__dict__") else ()
    return {name: size for part in parts for name, size in _arrays_of(part).items()}
