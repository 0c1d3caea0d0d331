"""Draw one sensor's view of one frame in a separate thread, always for the latest request.

Its kernels are serial, so that it can run in parallel with the thread that computes the scores.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import singledispatch

from PySide6.QtCore import QObject

from riglens.app.background.worker import CLOSE_S, BackgroundWorker, Context
from riglens.core.rig.model import Camera, Lidar, Sensor, Vehicle
from riglens.core.vehicle.housings import with_housings
from riglens.core.vehicle.solid import Solid, solid_of
from riglens.core.view.camera_picture import CameraPicture, camera_picture
from riglens.core.view.frames import FrameBoxes, FrameStore
from riglens.core.view.range_image import RangeImage, range_image
from riglens.evaluation.options import SceneOptions
from riglens.evaluation.requests import LoadedScene

NO_BOXES = "A stored POG holds no boxes of single frames: load the box data set to see its traffic here."
TOO_MANY = "Only the first {count:,} frames of this data set can be shown here: it has too many boxes."


@dataclass(frozen=True)
class PictureRequest:
    """Request for a picture."""

    sensor: Sensor
    frame: int
    scene: LoadedScene
    vehicle: Vehicle
    obstacles: tuple[Sensor, ...] = ()


@dataclass(frozen=True)
class SensorPicture:
    """View of a frame by a sensor, None for kinds that have none; `note` names what is missing in it."""

    image: CameraPicture | RangeImage | None
    note: str


@singledispatch
def _image_of(
    sensor: Sensor, request: PictureRequest, boxes: FrameBoxes, solid: Solid
) -> CameraPicture | RangeImage | None:
    """Return a sensor's picture; None for a kind without pictures."""
    return None


@_image_of.register
def _(sensor: Camera, request: PictureRequest, boxes: FrameBoxes, solid: Solid) -> CameraPicture:
    return camera_picture(sensor, request.scene.field.grid, boxes, solid)


@_image_of.register
def _(sensor: Lidar, request: PictureRequest, boxes: FrameBoxes, solid: Solid) -> RangeImage:
    return range_image(sensor, boxes, solid)


Pictures = BackgroundWorker[PictureRequest, SensorPicture]


def make_pictures(parent: QObject | None = None, close_s: float = CLOSE_S) -> Pictures:
    """Return a worker that makes pictures."""
    pictures = FramePictures()
    return Pictures("sensor view", pictures, parent, close_s, at_end=pictures.close)


class FramePictures:
    """Pictures of what sensors see in single frames, which are kept once read; called by one thread."""

    def __init__(self) -> None:
        self._frames: tuple[SceneOptions, FrameStore] | None = None

    def __call__(self, request: PictureRequest, context: Context[SensorPicture]) -> SensorPicture:
        """Return the picture of a request."""
        boxes, note = self._boxes(request, context)
        solid = with_housings(solid_of(request.vehicle), request.obstacles)
        context.stop_if_closing()
        return SensorPicture(_image_of(request.sensor, request, boxes, solid), note)

    def _boxes(self, request: PictureRequest, context: Context[SensorPicture]) -> tuple[FrameBoxes, str]:
        """Return the boxes of the frame, and a note on them."""
        options = request.scene.options
        if options.pog is not None:
            return FrameBoxes.none(), NO_BOXES
        store = self._store_of(options)
        boxes = store.boxes(request.frame, context.is_stale)
        is_missing = store.is_full and request.frame >= store.frames_read
        return boxes, TOO_MANY.format(count=store.frames_read) if is_missing else ""

    def _store_of(self, options: SceneOptions) -> FrameStore:
        """Return the frames of a data set, which do not depend on an automatic voxel edge."""
        if self._frames is None or self._frames[0] is not options:
            self.close()
            # loads the compiler: not while the window opens
            from riglens.evaluation.scenario import source_of

            self._frames = (options, FrameStore(source_of(options)))
        return self._frames[1]

    def close(self) -> None:
        """Forget the frames."""
        if self._frames is not None:
            self._frames[1].close()
            self._frames = None
