"""The window's end of the process that draws pictures: the latest job wins, and the window never waits."""

from __future__ import annotations

import pickle
import sys

from PySide6.QtCore import QObject, QProcess, Signal

from riglens.app.background.queue import Priority, RequestQueue
from riglens.app.rendering.picture_process import LENGTH_BYTES, PictureJob, packed

_END_MS = 3000


class PictureMaker(QObject):
    """Has one picture drawn at a time; a job that still waits gives way to a newer one. `close` it at the end."""

    made = Signal(object, object)
    """The PictureJob and its PNG file as bytes."""
    failed = Signal(str)

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._process: QProcess | None = None
        self._jobs = RequestQueue[PictureJob]()
        self._answer = b""

    @property
    def is_busy(self) -> bool:
        """Return whether a picture is being drawn."""
        return self._jobs.is_running(Priority.EDIT)

    def draw(self, job: PictureJob) -> None:
        """Draw a picture as soon as the current one is done."""
        self._jobs.put(job)
        self._start_next()

    def close(self) -> None:
        """End the process, even if it is busy."""
        process, self._process = self._process, None
        self._jobs, self._answer = RequestQueue(), b""
        if process is not None:
            process.blockSignals(True)
            process.kill()
            process.waitForFinished(_END_MS)
            process.deleteLater()

    def _start_next(self) -> None:
        if self.is_busy:
            return
        job = self._jobs.take(Priority.EDIT)
        if job is not None:
            self._process = self._process or self._start()
            self._process.write(packed(pickle.dumps(job.request)))

    def _start(self) -> QProcess:
        process = QProcess(self)
        process.setProcessChannelMode(QProcess.ProcessChannelMode.ForwardedErrorChannel)
        process.readyReadStandardOutput.connect(self._read)
        process.errorOccurred.connect(self._on_lost)
        process.finished.connect(self._on_lost)
        process.start(sys.executable, ["-m", "riglens.app.rendering.picture_process"])
        return process

    def _read(self) -> None:
        if self._process is None:
            return
        self._answer += bytes(self._process.readAllStandardOutput().data())
        length = int.from_bytes(self._answer[:LENGTH_BYTES], "little")
        if len(self._answer) < LENGTH_BYTES or len(self._answer) < LENGTH_BYTES + length:
            return
        answer, self._answer = self._answer[LENGTH_BYTES:], b""
        job = self._jobs.finish()
        if answer[:1] == b"\1":
            self.made.emit(None if job is None else job.request, answer[1:])
        else:
            self.failed.emit(answer[1:].decode("utf-8", "replace"))
        self._start_next()

    def _on_lost(self, _: object = None) -> None:
        """Forget a process that ended by itself: the next job starts another."""
        process, self._process = self._process, None
        if process is not None:
            process.deleteLater()
            self._jobs.finish()
            self._answer = b""
            self.failed.emit("the drawing process exited without a result")
