"""How background threads are told what to do: the latest wish wins, and one lock guards everything that is asked for.

`Latest` is the rule by itself. `Inbox` is what one thread takes its work from, with the end of that thread and the
time for which work may have to rest. Clocks are handed in, so that tests need not wait.
"""

from __future__ import annotations

import sys
import threading
import time
import traceback
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from typing import Generic, Protocol, TypeVar

Wish = TypeVar("Wish")
Work = TypeVar("Work")


class Clock(Protocol):
    """Tells the time, and wakes threads by it."""

    def now_s(self) -> float:
        """Return seconds since some moment in the past."""

    def wait(self, condition: threading.Condition, until_s: float | None) -> None:
        """Block, with the condition held, until it is notified or the time has come; None: until it is notified."""


class SystemClock:
    """The clock of the computer."""

    def now_s(self) -> float:
        """Return seconds since some moment in the past."""
        return time.monotonic()

    def wait(self, condition: threading.Condition, until_s: float | None) -> None:
        """Block until the condition is notified or the time has come."""
        condition.wait(None if until_s is None else max(0.0, until_s - time.monotonic()))


SYSTEM_CLOCK = SystemClock()


class Latest(Generic[Wish]):
    """One piece of work at a time and room for one more wish; a newer one takes the place of one that waits.

    There is no lock inside: threads that share it hold one around every call.
    """

    def __init__(self) -> None:
        self.waiting: Wish | None = None
        self.current: Wish | None = None
        """What is being worked on."""

    @property
    def is_idle(self) -> bool:
        """Whether nothing waits and nothing is being worked on."""
        return self.waiting is None and self.current is None

    def put(self, wish: Wish) -> None:
        """Want this instead of whatever waits."""
        self.waiting = wish

    def withdraw(self) -> Wish | None:
        """Want nothing more; return what waited."""
        wish, self.waiting = self.waiting, None
        return wish

    def take(self) -> Wish | None:
        """Begin with the wish that waits; None if there is none, or while another one is being worked on."""
        if self.current is None:
            self.current = self.withdraw()
            return self.current
        return None

    def finish(self) -> Wish | None:
        """End the work on the current wish, and return it."""
        wish, self.current = self.current, None
        return wish


class Inbox(ABC, Generic[Work]):
    """The work of one background thread. A subclass says what there is, always called with the lock held."""

    def __init__(self, clock: Clock = SYSTEM_CLOCK) -> None:
        self.lock = threading.Condition()
        """Notified whenever anything changes."""
        self._clock = clock
        self._closing = False

    # ------------------------------------------------------------------ what a subclass says
    @abstractmethod
    def _take(self) -> Work | None:
        """Begin with the next piece of work; None if there is nothing to do yet."""

    @abstractmethod
    def _finish(self) -> None:
        """The thread has done what it took last."""

    @abstractmethod
    def _is_idle(self) -> bool:
        """Whether everything that somebody waits for is done."""

    def _due_s(self) -> float | None:
        """When there will be work, by the clock; None if not before something is asked for."""
        return None

    # ------------------------------------------------------------------ called by the thread
    def next_work(self) -> Work | None:
        """Block until there is something to do; None at the end of everything."""
        with self.lock:
            self._finish()
            self.lock.notify_all()
            while not self._closing:
                work = self._take()
                if work is not None:
                    return work
                self._clock.wait(self.lock, self._due_s())
            return None

    def is_closing(self) -> bool:
        """Whether everything ends."""
        with self.lock:
            return self._closing

    # ------------------------------------------------------------------ called by others
    def close(self) -> None:
        """Want the end of everything."""
        with self.lock:
            self._closing = True
            self.lock.notify_all()

    def wait_until_idle(self, timeout_s: float) -> bool:
        """Block until everything that somebody waits for is done; False on timeout."""
        with self.lock:
            return self.lock.wait_for(self._is_idle, timeout_s)


class LatestInbox(Inbox[Wish]):
    """The inbox of a thread that answers the latest wish and nothing else."""

    def __init__(self, clock: Clock = SYSTEM_CLOCK) -> None:
        super().__init__(clock)
        self._latest = Latest[Wish]()

    def put(self, wish: Wish) -> None:
        """Want this instead of whatever waits."""
        with self.lock:
            self._latest.put(wish)
            self.lock.notify_all()

    def is_stale(self) -> bool:
        """Whether the work under way is of no use any more, because of a newer wish or the end of everything."""
        with self.lock:
            return self._closing or self._latest.waiting is not None

    def _take(self) -> Wish | None:
        return self._latest.take()

    def _finish(self) -> None:
        self._latest.finish()

    def _is_idle(self) -> bool:
        return self._latest.is_idle


class AsideInbox(LatestInbox[Wish]):
    """Work, too, for the time in which no latest wish waits: in the order of asking, until it is done or dropped."""

    def __init__(self, clock: Clock = SYSTEM_CLOCK) -> None:
        super().__init__(clock)
        self._aside: list[Wish] = []

    def put_aside(self, wishes: Sequence[Wish]) -> None:
        """Want these, too, when there is time."""
        with self.lock:
            self._aside.extend(wishes)
            self.lock.notify_all()

    def drop_aside(self, is_unwanted: Callable[[Wish], bool]) -> None:
        """Want some of them no more."""
        with self.lock:
            self._aside = [wish for wish in self._aside if not is_unwanted(wish)]
            self.lock.notify_all()

    def done_aside(self, wish: Wish) -> bool:
        """A wish is done; whether it is still wanted."""
        with self.lock:
            before = len(self._aside)
            self._aside = [other for other in self._aside if other is not wish]
            return len(self._aside) < before

    def gives_way(self, wish: Wish) -> bool:
        """Whether a wish aside has to wait for a latest one, or is not wanted any more."""
        with self.lock:
            is_wanted = any(other is wish for other in self._aside)
            return self._closing or self._latest.waiting is not None or not is_wanted

    def _take(self) -> Wish | None:
        return self._latest.take() or (self._aside[0] if self._aside else None)

    def _is_idle(self) -> bool:
        return super()._is_idle() and not self._aside


def unexpected(where: str, error: Exception) -> str:
    """Return one line for the user; the traceback goes to standard error for the person who mends it."""
    traceback.print_exception(error, file=sys.stderr)
    return f"Unexpected failure in the {where}: {type(error).__name__}: {error}"
