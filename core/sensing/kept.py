"""Keep the last answers of functions: by their bytes, since the rays of one camera take a thousand times those of
another, or by their number."""

from __future__ import annotations

import threading
from collections.abc import Callable, Hashable
from functools import wraps
from typing import Any, Generic, TypeVar

import numpy as np

_Asked = TypeVar("_Asked", bound=Hashable)
_Found = TypeVar("_Found")


class KeptAnswers:
    """Cache of `limit_bytes` for the latest results of several functions; for all threads."""

    def __init__(self, limit_bytes: int) -> None:
        self.limit_bytes = limit_bytes
        self._answers = dict[tuple[Callable[..., Any], Hashable], tuple[Any, dict[int, int]]]()
        """By function and argument, the last used last, with the bytes of the arrays of argument and answer by
        identity. An ordered dict would hash all its keys, whole sensors, whenever the bytes are added up."""
        self._used = set[tuple[Callable[..., Any], Hashable]]()
        """Used since the last `release_unused`."""
        self._lock = threading.Lock()
        self._finding: dict[tuple[Callable[..., Any], Hashable], threading.Lock] = {}

    def of(self, find: Callable[[_Asked], _Found]) -> Callable[[_Asked], _Found]:
        """Cache the results of a function of one argument; the latest result of all functions is always kept."""

        @wraps(find)
        def found(asked: _Asked) -> _Found:
            key = find, asked
            with self._lock:
                if (held := self._held(key)) is not None:
                    answer: _Found = held[0]
                    return answer
                finding = self._finding.setdefault(key, threading.Lock())
            with finding:  # of two threads that ask for the same one waits for the other
                with self._lock:
                    if (held := self._held(key)) is not None:
                        answer = held[0]
                        return answer
                try:
                    new = find(asked)
                    with self._lock:
                        self._answers[key] = new, _arrays_of((asked, new))
                        self._used.add(key)
                        while len(self._answers) > 1 and self.size_bytes > self.limit_bytes:
                            del self._answers[next(iter(self._answers))]
                finally:
                    with self._lock:
                        self._finding.pop(key, None)
            return new

        return found

    def _held(self, key: tuple[Callable[..., Any], Hashable]) -> tuple[Any, dict[int, int]] | None:
        """Return what is held by a key, which is now the last one used."""
        held = self._answers.pop(key, None)
        if held is not None:
            self._answers[key] = held
            self._used.add(key)
        return held

    @property
    def size_bytes(self) -> int:
        """The bytes of all that is kept; arrays that several answers share count once."""
        each = {name: size for _, arrays in self._answers.values() for name, size in arrays.items()}
        return sum(each.values())

    def release_unused(self) -> None:
        """Release what was not used since the last call, the longest unused first, down to a quarter of the limit."""
        with self._lock:
            for key in [key for key in self._answers if key not in self._used]:
                if self.size_bytes <= self.limit_bytes // 4:
                    break
                del self._answers[key]
            self._used.clear()

    def forget(self) -> None:
        """Release everything: what is needed again is made again."""
        with self._lock:
            self._answers.clear()


class LatestAnswers(Generic[_Asked, _Found]):
    """Latest `most` answers, which can be looked up without finding them; for all threads."""

    def __init__(self, most: int) -> None:
        self._most = most
        self._answers = dict[_Asked, _Found]()
        self._lock = threading.Lock()

    def known(self, asked: _Asked) -> _Found | None:
        """Return an answer that is kept."""
        with self._lock:  # `found` takes it out for a moment
            return self._answers.get(asked)

    def found(self, asked: _Asked, find: Callable[[], _Found]) -> _Found:
        """Return the answer that is kept, or find it; it is the latest one."""
        answer = self.known(asked)
        if answer is None:
            answer = find()
        with self._lock:
            self._answers.pop(asked, None)
            self._answers[asked] = answer
            if len(self._answers) > self._most:
                del self._answers[next(iter(self._answers))]
        return answer


RAYS = KeptAnswers(576 << 20)
"""Tables of rays of this process: the directions of the five cameras of 2.5 megapixels of the Waymo car, and their
bins."""
SHADOWS = KeptAnswers(64 << 20)
"""Shadows on rays without straight rows: voxels, objects and all parts of a review are cut by the same one, that of a
bent lens of 2.3 megapixels takes 6 MB."""


def _arrays_of(found: object) -> dict[int, int]:
    """Return the bytes of all arrays in an array, a tuple or an object of fields, by their identity."""
    if isinstance(found, np.ndarray):
        return {id(found): found.nbytes}
    parts = found if isinstance(found, tuple) else vars(found).values() if hasattr(found, "__dict__") else ()
    return {name: size for part in parts for name, size in _arrays_of(part).items()}
