"""Keep the last answers of a function by their bytes: the rays of one camera take a thousand times those of another."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable, Hashable
from functools import wraps
from typing import TypeVar

import numpy as np

_Asked = TypeVar("_Asked", bound=Hashable)
_Found = TypeVar("_Found")
LIMIT_BYTES = 320 << 20
"""Of one function: the directions of the five cameras of 2.5 megapixels of the Waymo car."""


def kept_by_bytes(find: Callable[[_Asked], _Found]) -> Callable[[_Asked], _Found]:
    """Keep what a function of one argument found last, up to LIMIT_BYTES, but always the last; for all threads."""
    kept: OrderedDict[_Asked, tuple[_Found, int]] = OrderedDict()
    lock = threading.Lock()

    @wraps(find)
    def found(asked: _Asked) -> _Found:
        with lock:
            if asked in kept:
                kept.move_to_end(asked)
                return kept[asked][0]
        new = find(asked)
        with lock:
            kept[asked] = new, size_bytes(new)
            while len(kept) > 1 and sum(size for _, size in kept.values()) > LIMIT_BYTES:
                kept.popitem(last=False)
        return new

    return found


def size_bytes(found: object) -> int:
    """Return the bytes of all arrays in an array, a tuple or an object of fields, and a few for the rest."""
    if isinstance(found, np.ndarray):
        return found.nbytes
    parts = found if isinstance(found, tuple) else vars(found).values() if hasattr(found, "__dict__") else ()
    return 100 + sum(size_bytes(part) for part in parts)
