"""Draw pictures in a separate process, so that the window stays responsive: jobs go in, PNG files come out.

Both ends belong to one program, and pickle what they say. Run as `python -m riglens.app.rendering.picture_process`.
"""

from __future__ import annotations

import pickle
import subprocess
import sys
from contextlib import suppress
from dataclasses import dataclass

from PySide6.QtCore import QObject

from riglens.app.background.worker import BackgroundWorker, Context
from riglens.app.launch.display import prepare_drawing
from riglens.core.errors import InputError

COMMAND = (sys.executable, "-m", "riglens.app.rendering.picture_process")


@dataclass(frozen=True)
class PictureJob:
    """A scene state, the size of the picture before `scale` enlarges it, and whether it has no background.

    `purpose` is returned with the picture, for the caller.
    """

    state: object
    size_px: tuple[int, int]
    scale: int
    transparent: bool
    purpose: object = None


class PictureMaker(BackgroundWorker[PictureJob, bytes]):
    """Maker of pictures, one PNG file at a time; a newer job replaces one that still waits."""

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__("drawing of pictures", self._drawn, parent)
        self._process: subprocess.Popen[bytes] | None = None

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
            with suppress(OSError), process:
                pass  # closes the pipes

    def _drawn(self, job: PictureJob, context: Context[bytes]) -> bytes:
        """Return the picture of a job; raise InputError where there is none. Called by the thread."""
        process = self._process
        if process is None or process.poll() is not None:
            self._end_process()
            process = subprocess.Popen(COMMAND, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
            self._process = process
        assert process.stdin is not None and process.stdout is not None
        try:
            pickle.dump(job, process.stdin)
            process.stdin.flush()
            answer: bytes | str = pickle.load(process.stdout)  # by this program
        except (EOFError, OSError, ValueError, pickle.UnpicklingError) as error:
            raise InputError("the drawing process exited without a result") from error
        if isinstance(answer, str):
            raise InputError(answer)
        return answer


# ---------------------------------------------------------------------- in the process
def _draw(job: PictureJob) -> bytes:
    from riglens.widgets.viewport.scene_state import SceneState
    from riglens.widgets.viewport.still import png_of, render_still

    assert isinstance(job.state, SceneState)
    return png_of(render_still(job.state, job.size_px, job.scale, transparent=job.transparent))


def main() -> None:
    """Draw until there are no more jobs."""
    prepare_drawing()
    with suppress(EOFError):
        while True:
            job = pickle.load(sys.stdin.buffer)  # by the window, which is the same program
            try:
                answer: bytes | str = _draw(job)
            except Exception as error:  # the window says it; the next job may do better
                answer = f"{type(error).__name__}: {error}"
            pickle.dump(answer, sys.stdout.buffer)
            sys.stdout.buffer.flush()


if __name__ == "__main__":
    main()
