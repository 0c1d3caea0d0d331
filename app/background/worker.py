"""A thread that answers the latest wish and nothing else, started with the first one."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Generic, TypeVar

from riglens.app.background.inbox import LatestInbox

Wish = TypeVar("Wish")
CLOSE_S = 1.0
"""How long closing waits for the thread: compiling a kernel cannot be given up."""


class Unwanted(Exception):
    """Raised by an answer in the making that nobody wants any more."""


class LatestThread(Generic[Wish]):
    """Calls `answer` with each wish that no newer one has taken the place of, in a thread of that name.

    `answer` handles its own errors, and may raise `Unwanted`. `at_end` gives back what the thread holds, in the thread
    itself. Every method is called by the interface thread.
    """

    def __init__(
        self,
        name: str,
        answer: Callable[[Wish], None],
        close_s: float = CLOSE_S,
        at_end: Callable[[], None] = lambda: None,
        inbox: LatestInbox[Wish] | None = None,
    ) -> None:
        self.inbox = LatestInbox[Wish]() if inbox is None else inbox
        self._name, self._answer, self._close_s, self._at_end = name, answer, close_s, at_end
        self._thread: threading.Thread | None = None

    def ask(self, wish: Wish) -> None:
        """Want this; it takes the place of a wish that still waits."""
        self.inbox.put(wish)
        self.start()

    def start(self) -> None:
        """Start the thread unless it runs."""
        if self._thread is None:
            self._thread = threading.Thread(target=self._run, name=self._name, daemon=True)
            self._thread.start()

    def close(self) -> None:
        """End the thread; one that does not end in `close_s` is left to itself."""
        self.inbox.close()
        self.wait_until_ended(self._close_s)

    def wait_until_idle(self, timeout_s: float = 60.0) -> bool:
        """Block until nothing waits or runs; False on timeout. Answers may still be queued as Qt events."""
        return self.inbox.wait_until_idle(timeout_s)

    @property
    def is_started(self) -> bool:
        """Whether anything was asked yet."""
        return self._thread is not None

    @property
    def is_alive(self) -> bool:
        """Whether the thread runs."""
        return self._thread is not None and self._thread.is_alive()

    def wait_until_ended(self, timeout_s: float) -> bool:
        """Block until the thread that was told to end is gone; False on timeout."""
        if self._thread is not None:
            self._thread.join(timeout_s)
        return not self.is_alive

    def stop_if_closing(self) -> None:
        """Raise `Unwanted` when everything ends."""
        if self.inbox.is_closing():
            raise Unwanted

    def _run(self) -> None:
        while (wish := self.inbox.next_work()) is not None:
            try:
                self._answer(wish)
            except Unwanted:
                continue
        self._at_end()
