"""Label LiDAR points with the cameras of a rig: each gets the class that a simulated segmentation shows at its pixel.

As in PointPainting (Vora et al., CVPR 2020), but nothing is trained: labels are those of the simulated picture, spoilt
by errors that are stated here. All numbers are our choice.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from riglens.core.kernels.objects.sweeps import STATIC
from riglens.core.rig.model import Camera, Rig
from riglens.core.scene.boxes import CLASSES
from riglens.core.sensors.camera import project_px
from riglens.core.simulate.pictures import NO_RAY, OWN_CAR, CameraPicture, Cameras
from riglens.core.simulate.world import Worlds
from riglens.core.targets.draws import sensor_key

Doubles = NDArray[np.float64]
Ids = NDArray[np.int64]
Quality = Literal["good", "usual", "poor"]

STRIDE_PX = 4
"""Native pixels per label of a segmented picture, as in segmentation networks."""
PATCH_LABELS = 8
"""Edge, in labels, of the patches of background in which false alarms are drawn."""
SCORES = 1 + len(CLASSES)
_UNSEEN, _OTHER = -1, 0


@dataclass(frozen=True)
class Segmentation:
    """Quality of the segmentation, per object and picture.

    An object of h visible pixels in height is found with probability top / (1 + (half_px / h)^3), and then taken for
    one of the other classes with probability `mistaken`. false_alarms: share of patches of what stands around that are
    taken for an object. aim_px: standard deviation of the error by which a camera's picture is shifted in each frame,
    native pixels.
    """

    top: float
    half_px: float
    mistaken: float
    false_alarms: float
    aim_px: float

    def as_dict(self) -> dict[str, float]:
        """Return the numbers as plain data."""
        return asdict(self)

    def found(self, height_px: Doubles) -> Doubles:
        """Return the probability (n,) that objects with these visible heights in pixels (n,) are found; 0 without
        pixels."""
        ratio = np.divide(self.half_px, height_px, out=np.full(len(height_px), np.inf), where=height_px > 0)
        return np.asarray(self.top / (1.0 + ratio**3))


QUALITIES: dict[Quality, Segmentation] = {
    "good": Segmentation(top=0.98, half_px=12.0, mistaken=0.02, false_alarms=0.002, aim_px=1.0),
    "usual": Segmentation(top=0.95, half_px=20.0, mistaken=0.05, false_alarms=0.005, aim_px=2.0),
    "poor": Segmentation(top=0.85, half_px=35.0, mistaken=0.10, false_alarms=0.02, aim_px=4.0),
}


class _Draws(NamedTuple):
    """Draws of one camera and frame: shift of its picture in native pixels (2,), label of each object (n,), and of each
    patch (rows, columns) that shows occluders."""

    shift_px: Doubles
    label: Ids
    patches: Ids


class Painter:
    """Label points with a rig's enabled cameras. For one thread, which may be any."""

    def __init__(self, rig: Rig, worlds: Worlds, segmentation: Segmentation) -> None:
        self._eyes = [_eye(camera) for camera in rig.enabled_cameras()]
        self._worlds, self._segmentation = worlds, segmentation
        self._cameras = Cameras(rig.only(self._eyes), worlds, False)

    def scores(self, frame: int, points_m: NDArray[np.float32]) -> Doubles:
        """Return the camera scores of points (n, 3) of a frame in the vehicle frame, (n, SCORES): whether a camera sees
        it, and the share of those cameras that label it car, bicycle and pedestrian."""
        votes, points = np.zeros((len(points_m), SCORES)), points_m.astype(np.float64)
        for number, eye in enumerate(self._eyes):
            label = self._labels(number, eye, frame, points)
            votes[:, 0] += label != _UNSEEN
            for cls in range(len(CLASSES)):
                votes[:, 1 + cls] += label == cls + 1
        looks = np.maximum(votes[:, :1], 1.0)
        return np.concatenate([np.minimum(votes[:, :1], 1.0), votes[:, 1:] / looks], axis=1)

    def _labels(self, number: int, eye: Camera, frame: int, points: Doubles) -> Ids:
        """Return the labels by a camera of points (n, 3), (n,): _UNSEEN, _OTHER, or an index of CLASSES + 1."""
        picture = self._cameras.picture(number, frame)
        cls = self._worlds.truth(frame).cls
        draws = self._draws(eye, frame, picture, cls)
        said = np.full(len(points), _UNSEEN)
        inside, row, column = _pixels(eye, points, draws.shift_px)
        what = picture.what[row, column]
        alarm = draws.patches[row // PATCH_LABELS, column // PATCH_LABELS]
        label = np.where(what == STATIC, alarm, _OTHER)
        label[what >= 0] = draws.label[what[what >= 0]]
        label[(what == OWN_CAR) | (what == NO_RAY)] = _UNSEEN
        said[inside] = label
        return said

    def _draws(self, eye: Camera, frame: int, picture: CameraPicture, cls: NDArray[np.uint8]) -> _Draws:
        how, seed = self._segmentation, self._worlds.settings.seed
        rng = np.random.default_rng([sensor_key(seed, f"segmentation of {eye.name}"), frame])
        shift_px = rng.normal(0.0, 1.0, 2) * how.aim_px
        luck, mistake, other = rng.random((3, len(cls)))
        height_px = (picture.bounds_px[:, 3] - picture.bounds_px[:, 1]) * eye.image[1] / eye.resolution[1]
        wrong = (cls + 1 + (other * (len(CLASSES) - 1)).astype(np.int64)) % len(CLASSES)
        columns, rows = (-(-cells // PATCH_LABELS) for cells in eye.resolution)
        alarms, kinds = rng.random((rows, columns)), rng.integers(1, len(CLASSES) + 1, (rows, columns))
        return _Draws(
            shift_px,
            np.where(luck >= how.found(height_px), _OTHER, 1 + np.where(mistake < how.mistaken, wrong, cls)),
            np.where(alarms < how.false_alarms, kinds, _OTHER),
        )


def _eye(camera: Camera) -> Camera:
    """Return the camera with a ray for each label."""
    width_px, height_px = camera.image
    return camera.model_copy(update={"cast": (-(-width_px // STRIDE_PX), -(-height_px // STRIDE_PX))})


def _pixels(eye: Camera, points: Doubles, shift_px: Doubles) -> tuple[Ids, Ids, Ids]:
    """Return which of the points (n, 3) are in the picture, and the rows and columns of their labels."""
    local = (points - np.array(eye.position)) @ eye.pose.rotation()
    place = (project_px(eye, local) + shift_px) * np.array(eye.resolution) / np.array(eye.image)
    with np.errstate(invalid="ignore"):
        inside = np.flatnonzero(((place >= 0.0) & (place < np.array(eye.resolution))).all(axis=1))
    column, row = place[inside].astype(np.int64).T
    return inside, row, column
