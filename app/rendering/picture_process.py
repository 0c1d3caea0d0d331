"""Draw pictures in a separate process, so that the window stays responsive: jobs come in, PNG files go out.

Both ends belong to one program. A message is its length, 8 bytes little-endian, and then its bytes: a pickled
PictureJob on the way in; on the way out one byte, 1 for a picture and 0 for an error, and the PNG or the text.
Run as `python -m riglens.app.rendering.picture_process` by picture_maker.py.
"""

from __future__ import annotations

import pickle
import sys
from dataclasses import dataclass
from typing import BinaryIO

from riglens.app.launch.display import prepare_drawing

LENGTH_BYTES = 8


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


def packed(message: bytes) -> bytes:
    """A message with its length in front."""
    return len(message).to_bytes(LENGTH_BYTES, "little") + message


def _read(stream: BinaryIO) -> bytes | None:
    """The next message; None at the end of the stream."""
    head = stream.read(LENGTH_BYTES)
    return stream.read(int.from_bytes(head, "little")) if len(head) == LENGTH_BYTES else None


def _draw(job: PictureJob) -> bytes:
    from riglens.widgets.viewport.scene_state import SceneState
    from riglens.widgets.viewport.still import png_of, render_still

    assert isinstance(job.state, SceneState)
    return png_of(render_still(job.state, job.size_px, job.scale, transparent=job.transparent))


def main() -> None:
    """Draw until there are no more jobs."""
    prepare_drawing()
    while (message := _read(sys.stdin.buffer)) is not None:
        try:
            answer = b"\1" + _draw(pickle.loads(message))
        except Exception as error:  # the window says it; the next job may do better
            answer = b"\0" + f"{type(error).__name__}: {error}".encode()
        sys.stdout.buffer.write(packed(answer))
        sys.stdout.buffer.flush()


if __name__ == "__main__":
    main()
