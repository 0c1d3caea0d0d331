"""A background thread that answers the latest request, and the object that owns it."""

from __future__ import annotations

import os
import sys
import threading
import traceback
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

from PySide6.QtCore import QObject, Signal

from riglens.app.background.queue import BackgroundRequest, Job, Priority, RequestQueue
from riglens.core.errors import Cancelled, InputError
from riglens.evaluation.names import label_of

Request = TypeVar("Request")
Answer = TypeVar("Answer")
CLOSE_S = 1.0
"""Seconds that closing waits for the thread: compiling a kernel cannot be cancelled."""
NICE = 3
"""Niceness of worker threads, so that drawing comes first: beside busy ones a frame of 60 sensors takes 97 ms in place
of 130 ms. With 10, two other busy programs would leave them next to nothing."""


class WorkerThread(Generic[Request]):
    """A daemon thread that passes each job of a queue to `work`; a cancelled background job is queued again.

    `at_end` releases what the thread holds, in the thread itself. Everything else is called by the owner's thread.
    """

    def __init__(
        self,
        name: str,
        queue: RequestQueue[Request],
        work: Callable[[Job[Request]], None],
        at_end: Callable[[], None] = lambda: None,
    ) -> None:
        self._queue, self._work, self._at_end = queue, work, at_end
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)

    def start(self) -> None:
        """Start the thread unless it was started."""
        if not self.is_started:
            self._thread.start()

    def close(self, timeout_s: float | None = None) -> None:
        """End the thread; one that does not end in time is left to itself."""
        self._queue.close()
        if self.is_started:
            self._thread.join(timeout_s)

    @property
    def is_started(self) -> bool:
        """Return whether the thread was ever started."""
        return self._thread.ident is not None

    def _run(self) -> None:
        if sys.platform == "linux":  # elsewhere threads have no niceness of their own
            os.nice(NICE)
        while self._work_once():
            pass
        self._at_end()

    def _work_once(self) -> bool:
        """Do the next job; return False at the end.

        A function of its own, so that a thread that waits holds no request, which may hold a scene of 100 MB.
        """
        job = self._queue.next_job()
        if job is None:
            return False
        try:
            self._work(job)
        except Cancelled:
            if job.priority is Priority.BACKGROUND:
                self._queue.put_back(job)
        return True


@dataclass(frozen=True)
class Context(Generic[Answer]):
    """Context of a computation: cancellation, progress, and a way to emit early results."""

    is_stale: Callable[[], bool]
    """Return True if a newer request waits, this one was dropped, or the program ends."""
    is_closing: Callable[[], bool]
    publish: Callable[[Answer], None]
    """Emit an early answer."""
    progress: Callable[[float], None]

    def stop_if_closing(self, _share: float = 0.0) -> None:
        """Raise Cancelled at the end of everything; also serves as a progress callback."""
        if self.is_closing():
            raise Cancelled

    def report(self, share: float) -> None:
        """Emit progress; raise Cancelled when the request is stale."""
        if self.is_stale():
            raise Cancelled
        self.progress(share)


class BackgroundWorker(QObject, Generic[Request, Answer]):
    """Worker that calls `answer` with the latest request in a thread of its own, which may call serial kernels only.

    `answer` raises InputError if there is no answer, or Cancelled if it was given up. The thread starts with the
    first request. Every public method is called by the interface thread.
    """

    answered = Signal(object, object)
    """A request and its answer; early answers, too."""
    answered_in_background = Signal(object, object)
    """A background request and its answer, None if there is none."""
    progressed = Signal(object, float)
    """A request, and the share of it that is done."""
    failed = Signal(str)
    """Reason why the last request failed."""

    def __init__(
        self,
        name: str,
        answer: Callable[[Request, Context[Answer]], Answer],
        parent: QObject | None = None,
        close_s: float = CLOSE_S,
        at_end: Callable[[], None] = lambda: None,
        rest: Callable[[], None] = lambda: None,
    ) -> None:
        """Set the function that answers requests; `name` names the thread in messages about unexpected errors; `rest`
        releases what is of no use at rest, from any thread."""
        super().__init__(parent)
        self.rest = rest
        self._name, self._answer, self._close_s = name, answer, close_s
        self._queue = RequestQueue[Request]()
        self._thread = WorkerThread(name, self._queue, self._work, at_end)

    def ask(self, request: Request) -> None:
        """Ask for an answer; replaces a request that waits."""
        self._queue.put(request)
        self._thread.start()

    def ask_in_background(self, requests: Sequence[Request]) -> None:
        """Ask for answers while no other request waits, in this order, by `answered_in_background`."""
        for request in requests:
            self._queue.put(request, Priority.BACKGROUND)
        self._thread.start()

    def drop(self) -> None:
        """Cancel the latest request."""
        self._queue.drop(Priority.EDIT)

    def drop_group(self, group: str) -> None:
        """Cancel a group's background requests; an answer may still arrive."""
        self._queue.drop(Priority.BACKGROUND, lambda request: group_of(request) == group)

    def close(self) -> None:
        """End the thread, or leave it to itself when it takes too long."""
        self._thread.close(self._close_s)

    def wait_until_idle(self, timeout_s: float = 60.0) -> bool:
        """Block until nothing waits or runs; False on timeout. Answers may still be queued as Qt events."""
        return self._queue.wait_until_idle(timeout_s)

    # ------------------------------------------------------------------ the thread
    def _work(self, job: Job[Request]) -> None:
        is_urgent = job.priority is not Priority.BACKGROUND
        signal = self.answered if is_urgent else self.answered_in_background

        def emit(answer: Answer | None) -> None:
            if self._queue.is_closing or job.is_dropped:
                raise Cancelled  # the signals may be gone
            signal.emit(job.request, answer)

        context = Context[Answer](
            lambda: self._queue.is_stale(job),
            lambda: self._queue.is_closing,
            emit,
            lambda share: self.progressed.emit(job.request, share),
        )
        try:
            emit(self._answer(job.request, context))
        except Cancelled:
            raise
        except Exception as error:
            line = problem_line(self._name, error)
            if not is_urgent:
                emit(None)
            elif not (self._queue.is_closing or job.is_dropped):
                self.failed.emit(line)


def group_of(request: object) -> str | None:
    """Return the group of a background request."""
    return request.group if isinstance(request, BackgroundRequest) else None


def problem_line(name: str, error: Exception) -> str:
    """Return one line for the user; the traceback of an unforeseen error goes to standard error."""
    if isinstance(error, InputError):
        return error.text(label_of)
    traceback.print_exception(error, file=sys.stderr)
    return f"Unexpected failure in the {name}: {type(error).__name__}: {error}"
