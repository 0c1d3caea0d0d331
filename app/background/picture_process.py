"""Draw pictures in a separate process, so that the window stays responsive: jobs go in, PNG files come out."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path

from PySide6.QtCore import QObject

from riglens.app.background.own_process import OwnProcess, Tell
from riglens.app.background.worker import BackgroundWorker, Context
from riglens.core.monitor import Monitor, Stage
from riglens.rendering.display import prepare_drawing

WORK = "riglens.app.background.picture_process:main"
SET_WORK = "riglens.app.background.picture_process:main_set"


@dataclass(frozen=True)
class PictureJob:
    """A scene state, the size of the picture before `scale` enlarges it, and whether it has no background.

    `purpose` is returned with the picture, for the caller.
    """

    state: object
    size_px: tuple[int, int]
    scale: float
    transparent: bool
    purpose: object = None


class PictureMaker(BackgroundWorker[PictureJob, bytes]):
    """Maker of pictures, one PNG file at a time; a newer job replaces one that still waits."""

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__("drawing of pictures", self._drawn, parent)
        self._process: OwnProcess | None = None

    def cancel(self) -> None:
        """Give up the picture that is being drawn, and end the process; the next job starts another."""
        self.drop()
        self._end_process()

    def close(self) -> None:
        """End the process and the thread."""
        self.cancel()
        super().close()

    def _end_process(self) -> None:
        process, self._process = self._process, None
        if process is not None:
            process.kill()

    def _drawn(self, job: PictureJob, context: Context[bytes]) -> bytes:
        """Return the picture of a job; raise InputError where there is none. Called by the thread."""
        process = self._process
        if process is None or not process.is_alive:
            process = self._process = OwnProcess(WORK)
        try:
            process.pipe.send(job)
            png: bytes = process.receive()
        except (EOFError, OSError) as error:
            raise process.lost("the drawing process") from error
        return png


def drawn_set(state: object, folder: Path, size_px: tuple[int, int], scale: int, tell: Tell) -> int:
    """Write the set of pictures of a scene state in a process of its own; return the number of files."""
    process = OwnProcess(SET_WORK)
    try:
        process.pipe.send((state, folder, size_px, scale))
        count: int = process.result(tell)
    except (EOFError, OSError) as error:
        raise process.lost("the drawing process") from error
    return count


# ---------------------------------------------------------------------- in the process
def main_set(pipe: Connection) -> None:
    """Write one set of pictures."""
    prepare_drawing()
    from riglens.rendering.picture_set import write_set

    state, folder, size_px, scale = pipe.recv()
    pipe.send(len(write_set(state, folder, size_px, scale, _Sent(pipe))))


class _Sent(Monitor):
    """Sends the progress of drawing through a pipe."""

    def __init__(self, pipe: Connection) -> None:
        self._pipe = pipe

    @contextmanager
    def stage(self, title: str) -> Iterator[Stage]:
        """Send the share that is done, with what is under way or the title."""
        yield lambda share, under_way="": self._pipe.send((share, under_way or title))


def _draw(job: PictureJob) -> bytes:
    from riglens.widgets.viewport.scene_state import SceneState
    from riglens.widgets.viewport.still import png_of, render_still

    assert isinstance(job.state, SceneState)
    return png_of(render_still(job.state, job.size_px, job.scale, transparent=job.transparent))


def main(pipe: Connection) -> None:
    """Draw until there are no more jobs; a picture that cannot be drawn ends the process."""
    prepare_drawing()
    with suppress(EOFError):
        while True:
            pipe.send(_draw(pipe.recv()))
