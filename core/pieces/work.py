"""Work in resumable pieces: their definition, computation, storage, and the loop over all of them.

A job is a list of pieces, each with a key that depends on all of its content and a pure function that returns the
content as bytes. Whatever the order, the split or the number of workers, the store ends with the same bytes.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Collection, Iterator, Sequence
from concurrent.futures import Future
from dataclasses import dataclass
from itertools import islice
from typing import Protocol, TypeVar

Result = TypeVar("Result")
Kept = TypeVar("Kept", covariant=True)


@dataclass(frozen=True)
class Piece:
    """One piece: `work(*arguments())` returns its content.

    key: a name that other content does not share, fit for a file name. arguments: called when the piece begins, so that
    memory stays flat. needs: keys of pieces that have to be done before.
    """

    key: str
    work: Callable[..., bytes]
    arguments: Callable[[], tuple[object, ...]]
    needs: tuple[str, ...] = ()


class Store(Protocol[Kept]):
    """Finished pieces."""

    def load(self, key: str) -> Kept | None:
        """Return a finished piece; None when it is missing, damaged or altered, so that it is made again."""

    def keep(self, key: str, content: bytes) -> Kept:
        """Check and store a worker's result; ChildProcessError when it is not the content of this piece."""


class Workers(Protocol):
    """Workers that compute pieces.

    ahead: how many pieces to hand in before waiting for the first. threads: how many threads a piece may use there,
    None for one per core.
    """

    ahead: int
    threads: int | None

    def call(self, work: Callable[..., bytes], *arguments: object) -> Future[bytes]:
        """Begin to call a function as soon as a worker is free."""

    def wait(self, waiting: Collection[Future[bytes]]) -> Collection[Future[bytes]]:
        """Wait for one of the futures at least, and return those that are done."""


class OwnProcess:
    """Workers that compute in the calling process, one piece after another."""

    ahead = 1
    threads: int | None = None

    def call(self, work: Callable[..., bytes], *arguments: object) -> Future[bytes]:
        """Call a function now."""
        done: Future[bytes] = Future()
        done.set_result(work(*arguments))
        return done

    def wait(self, waiting: Collection[Future[bytes]]) -> Collection[Future[bytes]]:
        """Return them all: they were done before they were handed out."""
        return list(waiting)


def results(
    pieces: Sequence[Piece], store: Store[Result], workers: Workers
) -> Iterator[tuple[Piece, Result]]:
    """Yield every piece with its result: first those in the store, then the others as they are computed and stored.

    Re-raise the exception of a piece after yielding all pieces that are done by then.
    """
    missing = list[Piece]()
    for piece in pieces:
        found = store.load(piece.key)
        if found is None:
            missing.append(piece)
        else:
            yield piece, found
    for piece, content in _made(missing, workers):
        yield piece, store.keep(piece.key, content)


def _made(pieces: Sequence[Piece], workers: Workers) -> Iterator[tuple[Piece, bytes]]:
    """Yield contents as they come, with at most `ahead` pieces handed in at a time."""
    pending = {piece.key for piece in pieces}
    blocked, ready = list(pieces), deque[Piece]()
    waiting = dict[Future[bytes], Piece]()
    while blocked or ready or waiting:
        if blocked:
            ready.extend(piece for piece in blocked if pending.isdisjoint(piece.needs))
            blocked = [piece for piece in blocked if not pending.isdisjoint(piece.needs)]
        for piece in list(islice(ready, max(0, workers.ahead - len(waiting)))):
            ready.popleft()
            waiting[workers.call(piece.work, *piece.arguments())] = piece
        if not waiting:
            raise ValueError(f"pieces that need each other: {', '.join(sorted(pending))}")
        # failures come last, so that what is done by then is kept
        for future in sorted(workers.wait(waiting), key=lambda one: one.exception() is not None):
            piece = waiting.pop(future)
            yield piece, future.result()
            pending.discard(piece.key)  # two pieces of equal content share a key
