"""Pictures of what one sensor sees of one frame, made by a thread of their own, always for the latest request.

Its kernels are serial, so that it may work beside the thread that computes the scores.
"""

from __future__ import annotations

from dataclasses import dataclass

from PySide6.QtCore import QObject

from riglens.app.background.worker import CLOSE_S, Answerer, Unwanted
from riglens.app.evaluation.options import SceneOptions
from riglens.app.evaluation.requests import LoadedScene
from riglens.core.rig.model import Camera, Lidar
from riglens.core.vehicle.solid import CarBody
from riglens.core.view.camera_picture import CameraPicture, camera_picture
from riglens.core.view.frames import FrameBoxes, FrameStore
from riglens.core.view.range_image import RangeImage, range_image

NO_BOXES = "A stored POG holds no boxes of single frames: load the box data set to see its traffic here."
TOO_MANY = "Of this data set only the first {count:,} frames can be shown here: it has very many boxes."


@dataclass(frozen=True)
class PictureRequest:
    """What to draw."""

    sensor: Lidar | Camera
    frame: int
    scene: LoadedScene
    body: CarBody

    def asks_same(self, other: PictureRequest) -> bool:
        """Whether the answer to both is the same picture."""
        same_data = self.scene is other.scene and self.body == other.body
        return same_data and (self.sensor, self.frame) == (other.sensor, other.frame)


@dataclass(frozen=True)
class SensorPicture:
    """The answer to one request; `note` says what is missing in it."""

    request: PictureRequest
    image: CameraPicture | RangeImage
    note: str


class Pictures(Answerer[PictureRequest]):
    """Answers with a SensorPicture."""

    def __init__(self, parent: QObject | None = None, close_s: float = CLOSE_S) -> None:
        super().__init__("sensor view", parent, close_s)
        self._frames: tuple[SceneOptions, FrameStore] | None = None

    def _work(self, request: PictureRequest) -> None:
        self._tell(self._picture(request))

    def _picture(self, request: PictureRequest) -> SensorPicture:
        boxes, note = self._boxes(request)
        solid, sensor = request.body.solid(), request.sensor
        self._thread.stop_if_closing()
        if isinstance(sensor, Camera):
            grid = request.scene.field.grid
            return SensorPicture(request, camera_picture(sensor, grid, boxes, solid), note)
        return SensorPicture(request, range_image(sensor, boxes, solid), note)

    def _boxes(self, request: PictureRequest) -> tuple[FrameBoxes, str]:
        """Boxes of the frame, and what to say about them."""
        options = request.scene.options
        if options.pog is not None:
            return FrameBoxes.none(), NO_BOXES
        store = self._store_of(options)
        boxes = store.boxes(request.frame, self._thread.inbox.is_stale)
        if boxes is None:
            raise Unwanted
        is_missing = store.is_full and request.frame >= store.frames_read
        return boxes, TOO_MANY.format(count=store.frames_read) if is_missing else ""

    def _store_of(self, options: SceneOptions) -> FrameStore:
        """The frames of a data set; an automatic voxel edge has no part in them."""
        if self._frames is None or self._frames[0] is not options:
            self._give_back()
            # loads the compiler: not while the window opens
            from riglens.app.evaluation.scenario import source_of

            self._frames = (options, FrameStore(source_of(options)))
        return self._frames[1]

    def _give_back(self) -> None:
        if self._frames is not None:
            self._frames[1].close()
            self._frames = None
