"""Run long work in the background: in a separate thread, with progress, Cancel, and one clear error.

    bench.tasks.run("Writing the report", lambda progress: write(rigs, path, progress), done=self._written)

`work` runs in the background: it knows neither Qt nor VTK, calls `progress(0..1)` now and then, also with the stage,
and must not call parallel kernels (those run on the thread of `Recompute` only). `done` gets what it returned, on the
interface thread. The status bar shows a bar with the time left as soon as the work takes more than half a second.
"""

from __future__ import annotations

import threading
import time
import traceback
from collections.abc import Callable
from typing import Any, Protocol, TypeVar

from PySide6.QtCore import QObject, Qt, Signal

from riglens.core.errors import Cancelled, InputError
from riglens.evaluation.names import label_of

Found = TypeVar("Found")


class Staged(Protocol):
    """Callback for the share done and, where known, the current stage."""

    def __call__(self, fraction: float, stage: str = "", /) -> None:
        """Report."""


CLOSE_S = 1.0
"""Seconds that closing waits for work that does not report progress."""


class Task(QObject):
    """One piece of work. Its signals arrive on the interface thread when connected as queued."""

    progressed = Signal(float)
    staged = Signal(str)
    """Name of the current stage."""
    succeeded = Signal(object)
    failed = Signal(str, str)
    """One line for the user, and details for the person who mends it (empty for bad input)."""
    ended = Signal()
    """The last word, after success, failure and cancel alike."""

    def __init__(self, title: str, work: Callable[[Staged], object]) -> None:
        super().__init__()
        self.title = title
        self._work = work
        self._unwanted = threading.Event()
        self.is_over = False
        """True from just before `ended`."""
        self._thread = threading.Thread(target=self._run, name=title, daemon=True)

    def start(self) -> None:
        """Begin, in the background."""
        self._thread.start()

    def cancel(self) -> None:
        """Stop at the next report of progress; returns at once."""
        self._unwanted.set()

    def join(self, limit_s: float | None = None) -> None:
        """Wait until the thread has ended, at most `limit_s`."""
        self._thread.join(limit_s)

    def _run(self) -> None:
        try:
            found = self._work(self._report)
            self._report(1.0)
        except Cancelled:
            pass
        except InputError as error:
            self.failed.emit(error.text(label_of), "")
        except Exception as error:
            line = f"{self.title}: unexpected failure: {type(error).__name__}: {error}"
            self.failed.emit(line, "".join(traceback.format_exception(error)))
        else:
            self.succeeded.emit(found)
        self.is_over = True
        self.ended.emit()

    def _report(self, fraction: float, stage: str = "", /) -> None:
        if self._unwanted.is_set():
            raise Cancelled
        if stage:
            self.staged.emit(stage)
        self.progressed.emit(fraction)


class Tasks(QObject):
    """Running tasks, kept until they end; `close` before the window goes."""

    started = Signal(object)
    """A Task is about to run."""
    failed = Signal(str, str)

    def __init__(self, parent: QObject | None = None, close_s: float = CLOSE_S) -> None:
        super().__init__(parent)
        self._close_s = close_s
        self._running: list[Task] = []

    def run(
        self,
        title: str,
        work: Callable[[Staged], Found],
        done: Callable[[Found], Any],
        ended: Callable[[], Any] | None = None,
    ) -> Task:
        """Do `work` in the background, then `done` with its result; `ended` is emitted in any case."""
        queued = Qt.ConnectionType.QueuedConnection
        task = Task(title, work)
        task.succeeded.connect(done, queued)
        task.failed.connect(self.failed, queued)
        if ended is not None:
            task.ended.connect(ended, queued)
        task.ended.connect(self._forget_ended, queued)
        self._running.append(task)
        self.started.emit(task)
        task.start()
        return task

    def close(self) -> None:
        """Cancel everything; threads that do not end within `close_s` in total are abandoned."""
        for task in self._running:
            task.cancel()
        end_s = time.monotonic() + self._close_s
        for task in self._running:
            task.join(max(0.0, end_s - time.monotonic()))
        self._running.clear()

    def _forget_ended(self) -> None:
        """Keep only what runs: a connection that named its own task would keep it, and the data it worked on, alive."""
        over = [task for task in self._running if task.is_over]
        self._running = [task for task in self._running if task not in over]
        for task in over:
            task.join()
