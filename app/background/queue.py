"""Latest-wins work queue of a background thread, with jobs for the time in which nothing urgent waits."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Hashable
from dataclasses import dataclass
from enum import IntEnum
from typing import Generic, Protocol, TypeVar

Request = TypeVar("Request")


class Clock(Protocol):
    """A source of time that can wake threads."""

    def now_s(self) -> float:
        """Return the seconds since some moment in the past."""

    def wait(self, condition: threading.Condition, until_s: float | None) -> None:
        """Block, with the condition held, until it is notified or the time has come; None: until it is notified."""


class SystemClock:
    """The clock of the computer."""

    def now_s(self) -> float:
        """Return the seconds since some moment in the past."""
        return time.monotonic()

    def wait(self, condition: threading.Condition, until_s: float | None) -> None:
        """Block until the condition is notified or the time has come."""
        condition.wait(None if until_s is None else max(0.0, until_s - time.monotonic()))


SYSTEM_CLOCK = SystemClock()


class Priority(IntEnum):
    """The order in which jobs are handed out."""

    LOAD = 0
    EDIT = 1
    BACKGROUND = 2


@dataclass(frozen=True)
class BackgroundRequest:
    """A request that can wait; a newer one of the same group and name replaces it."""

    group: str
    name: str


@dataclass(eq=False)
class Job(Generic[Request]):
    """A request on its way through the queue."""

    request: Request
    priority: Priority
    is_dropped: bool = False

    @property
    def key(self) -> Hashable:
        """Key of the request: only the newest request of a priority and key waits."""
        request = self.request
        return (request.group, request.name) if isinstance(request, BackgroundRequest) else None


class RequestQueue(Generic[Request]):
    """Queue that returns the newest request of each key, urgent ones first, in the order in which they were put.

    Background jobs begin when nothing was edited for `rest_s` by the clock. All methods are safe in any thread.
    """

    def __init__(self, clock: Clock = SYSTEM_CLOCK, rest_s: float = 0.0) -> None:
        self.lock = threading.Condition()
        """Notified at every change; may be held around several calls."""
        self._clock, self._rest_s = clock, rest_s
        self._waiting: dict[Priority, dict[Hashable, Job[Request]]] = {level: {} for level in Priority}
        self._running: list[Job[Request]] = []
        self._held: set[Priority] = set()
        self._edited_s = clock.now_s()
        self._closing = False

    # ------------------------------------------------------------------ called by the owner
    def put(self, request: Request, priority: Priority = Priority.EDIT) -> None:
        """Queue a request in place of one of the same key that waits."""
        job = Job(request, priority)
        with self.lock:
            if priority is Priority.EDIT:
                self._edited_s = self._clock.now_s()
            self._waiting[priority].pop(job.key, None)
            self._waiting[priority][job.key] = job
            self.lock.notify_all()

    def drop(
        self, priority: Priority, is_unwanted: Callable[[Request], bool] = lambda _: True
    ) -> list[Request]:
        """Cancel requests, running ones as well; return those that had not begun."""
        with self.lock:
            jobs = self._waiting[priority]
            dropped = [job for job in jobs.values() if is_unwanted(job.request)]
            for job in dropped:
                del jobs[job.key]
            for job in self._running:
                job.is_dropped |= job.priority is priority and is_unwanted(job.request)
            self.lock.notify_all()
            return [job.request for job in dropped]

    def hold(self, *priorities: Priority) -> None:
        """Hand out no jobs of these priorities until `release`."""
        with self.lock:
            self._held.update(priorities)

    def release(self, *priorities: Priority) -> None:
        """Hand out jobs of these priorities again."""
        with self.lock:
            self._held.difference_update(priorities)
            self.lock.notify_all()

    def close(self) -> None:
        """End the thread; everything is stale from now on."""
        with self.lock:
            self._closing = True
            self.lock.notify_all()

    def wait_until_idle(self, timeout_s: float, down_to: Priority = Priority.BACKGROUND) -> bool:
        """Block until nothing as urgent as `down_to` waits or runs; False on timeout. What is held does not count."""
        with self.lock:
            return self.lock.wait_for(lambda: not self._is_busy(down_to), timeout_s)

    # ------------------------------------------------------------------ called by the thread
    def next_job(self) -> Job[Request] | None:
        """Finish the running job and block until there is another; None once the queue is closed."""
        with self.lock:
            self._running.clear()
            self.lock.notify_all()
            while not self._closing:
                for priority in Priority:
                    if (job := self.take(priority)) is not None:
                        return job
                self._clock.wait(self.lock, self._due_s())
            return None

    def take(self, priority: Priority) -> Job[Request] | None:
        """Begin the first job of a priority, perhaps within another one; None if there is none to begin now."""
        with self.lock:
            jobs = self._waiting[priority]
            if not jobs or priority in self._held or not self._is_due(priority):
                return None
            job = jobs.pop(next(iter(jobs)))
            self._running.append(job)
            return job

    def finish(self) -> Job[Request] | None:
        """End the job that was taken last."""
        with self.lock:
            job = self._running.pop() if self._running else None
            self.lock.notify_all()
            return job

    def put_back(self, job: Job[Request], last: bool = False) -> None:
        """Queue a job again that yielded, first or last of its priority, unless it is obsolete."""
        with self.lock:
            jobs = self._waiting[job.priority]
            if not job.is_dropped and job.key not in jobs:
                self._waiting[job.priority] = {**jobs, job.key: job} if last else {job.key: job, **jobs}

    # ------------------------------------------------------------------ asked in the midst of a job
    @property
    def is_closing(self) -> bool:
        """Return whether the queue is closing."""
        with self.lock:
            return self._closing

    def is_running(self, priority: Priority) -> bool:
        """Return whether a job of a priority is running."""
        with self.lock:
            return any(job.priority is priority for job in self._running)

    def waiting(self, priority: Priority) -> Request | None:
        """Return the first request of a priority that waits."""
        with self.lock:
            return next((job.request for job in self._waiting[priority].values()), None)

    def is_stale(self, job: Job[Request]) -> bool:
        """Return whether to abandon a job: it is replaced, dropped or closing, or something urgent waits."""
        with self.lock:
            gives_way = job.priority is Priority.BACKGROUND and self._is_busy(Priority.EDIT)
            return self._closing or job.is_dropped or gives_way or job.key in self._waiting[job.priority]

    def is_followed(self, priority: Priority, within_s: float = 0.0) -> bool:
        """Wait for a request of a priority up to a time limit; return whether one waits or the queue is closing."""
        with self.lock:
            end_s = self._clock.now_s() + within_s
            while not (self._closing or self._waiting[priority]) and self._clock.now_s() < end_s:
                self._clock.wait(self.lock, end_s)
            return self._closing or bool(self._waiting[priority])

    # ------------------------------------------------------------------ with the lock held
    def _is_busy(self, down_to: Priority) -> bool:
        waits = any(
            self._waiting[level] and level not in self._held for level in Priority if level <= down_to
        )
        return waits or any(job.priority <= down_to for job in self._running)

    def _is_due(self, priority: Priority) -> bool:
        return priority is not Priority.BACKGROUND or self._edited_s + self._rest_s <= self._clock.now_s()

    def _due_s(self) -> float | None:
        """Return when a background job is due; None if only a call can bring one."""
        level = Priority.BACKGROUND
        return self._edited_s + self._rest_s if self._waiting[level] and level not in self._held else None
