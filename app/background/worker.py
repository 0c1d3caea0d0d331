"""A thread that answers the latest wish and nothing else, started with the first one, and the object that owns it."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Generic, TypeVar

from PySide6.QtCore import QObject, Signal

from riglens.app.background.inbox import LatestInbox, unexpected
from riglens.core.errors import InputError

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


class Answerer(QObject, Generic[Wish]):
    """Owner of a thread that works for the latest wish; the interface thread calls every public method.

    A kind of answers is a class of its own: it says how it works for a wish (`_work`), with serial kernels, so that it
    may do so beside the thread that computes the scores.
    """

    made = Signal(object)
    """An answer."""
    failed = Signal(str)
    """There is none, and why."""

    def __init__(
        self,
        of: str,
        parent: QObject | None = None,
        close_s: float = CLOSE_S,
        inbox: LatestInbox[Wish] | None = None,
    ) -> None:
        """`of`: what answers are, for the name of the thread and for messages about errors nobody foresaw."""
        super().__init__(parent)
        self._of = of
        self._thread = LatestThread[Wish](of, self._answer, close_s, self._give_back, inbox)

    def ask(self, wish: Wish) -> None:
        """Ask for an answer; takes the place of a wish that still waits."""
        self._thread.ask(wish)

    def close(self) -> None:
        """End the thread, or leave it to itself when it takes too long."""
        self._thread.close()

    def wait_until_idle(self, timeout_s: float = 60.0) -> bool:
        """Block until nothing waits or runs; False on timeout. Answers may still be queued as Qt events."""
        return self._thread.wait_until_idle(timeout_s)

    # ------------------------------------------------------------------ the thread
    def _work(self, wish: Wish) -> None:
        """Find what is wanted and `_tell` it; InputError says why not, `Unwanted` gives up."""
        raise NotImplementedError

    def _give_back(self) -> None:
        """Let go of what the thread holds, when it ends."""

    def _tell(self, answer: object) -> None:
        self._thread.stop_if_closing()  # nobody hears it any more, and the signals may be gone
        self.made.emit(answer)

    def _fail(self, reason: str) -> None:
        self._thread.stop_if_closing()
        self.failed.emit(reason)

    def _answer(self, wish: Wish) -> None:
        try:
            self._work(wish)
        except InputError as error:
            self._fail(str(error))
        except Unwanted:
            raise
        except Exception as error:
            self._fail(unexpected(self._of, error))
