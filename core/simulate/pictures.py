"""Render the cameras of a rig in a frame: picture, labels and depth, from the shapes that LiDAR rays meet."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from riglens.core.kernels.objects import pictures as kernel
from riglens.core.kernels.objects.box_frames import Beams, Canvas
from riglens.core.kernels.objects.pictures import NO_RAY, OWN_CAR, SKY
from riglens.core.kernels.objects.sweeps import GROUND, STATIC
from riglens.core.rig.model import Camera, Rig
from riglens.core.simulate.clutter import KINDS
from riglens.core.simulate.sweeps import canvas_for, own_solid, stopped_m
from riglens.core.simulate.world import World, Worlds
from riglens.core.targets.beams import beams_of
from riglens.core.vehicle.solid import Solid

__all__ = ["NO_RAY", "OWN_CAR", "SKY", "CameraPicture", "Cameras", "class_labels"]

LABELS = ("none", "car", "bicycle", "pedestrian", "static", "ground", "sky", "own car")
"""Meanings of the numbers in a class picture."""
_CARS = (
    (196, 199, 205),
    (42, 45, 52),
    (225, 227, 230),
    (122, 28, 32),
    (32, 62, 118),
    (92, 97, 104),
    (52, 84, 62),
)
_CLOTHES = (
    (58, 66, 92),
    (140, 52, 48),
    (66, 66, 66),
    (188, 168, 120),
    (46, 98, 110),
    (172, 172, 176),
    (110, 62, 110),
)
_BIKES = ((150, 60, 40), (48, 88, 130), (70, 72, 76), (170, 150, 70))
_USERS = (_CARS, _BIKES, _CLOTHES)
_KINDS = {
    "bush": (72, 104, 54),
    "hedge": (58, 92, 48),
    "bin": (70, 88, 78),
    "container": (122, 116, 92),
    "pole": (128, 130, 132),
    "post": (150, 146, 132),
    "rack": (112, 114, 118),
    "wall": (158, 132, 112),
}
_GIVEN = (176, 166, 150)
_PLAIN = {
    "glass": (44, 58, 70),
    "road": (106, 107, 110),
    "own": (52, 60, 74),
    "zenith": (106, 152, 208),
    "horizon": (206, 216, 224),
}
_VARIED = 0.12
"""Largest difference between the colours of two things of a kind, as a share."""


@dataclass(frozen=True)
class CameraPicture:
    """Frame as a camera sees it; rows from above, columns from the left.

    what (rows, columns) int32: place of an object in the frame, GROUND, STATIC, SKY, OWN_CAR or NO_RAY; depth_m
    float32 along the camera's axis, inf: none; rgb (rows, columns, 3) uint8; of each object (n,): pixels, pixels if
    nothing stood before it, and bounds_px (n, 4) first column and row, end of columns and rows, zero without pixels.
    """

    what: NDArray[np.int32]
    depth_m: NDArray[np.float32]
    rgb: NDArray[np.uint8]
    pixels: NDArray[np.int64]
    alone: NDArray[np.int64]
    bounds_px: NDArray[np.int64]


class Cameras:
    """Pictures of a rig's enabled cameras, at native size or as they are cast. For one thread, which may be any."""

    def __init__(self, rig: Rig, worlds: Worlds, is_native: bool = True) -> None:
        self._worlds = worlds
        body = own_solid(rig, worlds.settings.body)
        self._beams = [_beams(camera, body, is_native) for camera in rig.enabled_cameras()]
        self._canvases = dict[tuple[int, int], Canvas]()

    def picture(self, camera: int, frame: int) -> CameraPicture:
        """Return the picture of a camera, by its index in `rig.enabled_cameras()`, in a frame."""
        beams, world = self._beams[camera], self._worlds.world(frame)
        rows, columns = beams.row_of.size, beams.columns
        if (rows, columns) not in self._canvases:
            self._canvases[rows, columns] = canvas_for(beams)
        alone, seen = (
            np.zeros(len(world.boxes.centres), np.int64),
            np.zeros((world.reflectivity.users, 5), np.int64),
        )
        image = kernel.Image(
            np.empty((rows, columns), np.int32),
            np.empty((rows, columns), np.float32),
            np.zeros((rows, columns, 3), np.uint8),
            seen,
        )
        paint = _paint(world, np.random.default_rng([self._worlds.settings.seed, frame, 1]))
        kernel.paint_frame(
            world.boxes, world.surface, beams, paint, self._canvases[rows, columns], alone, image
        )
        bounds = seen[:, [1, 3, 2, 4]] + np.array([0, 0, 1, 1]) * (seen[:, :1] > 0)
        return CameraPicture(image.what, image.depth, image.rgb, seen[:, 0], alone[: len(seen)], bounds)


def class_labels(what: NDArray[np.int32], cls: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return the indices into LABELS (rows, columns) of pixels; cls (n,): classes of the frame's objects."""
    table = np.zeros(5 + len(cls), np.uint8)
    for code, name in (
        (GROUND, "ground"),
        (STATIC, "static"),
        (SKY, "sky"),
        (OWN_CAR, "own car"),
        (NO_RAY, "none"),
    ):
        table[5 + code] = LABELS.index(name)
    table[5:] = cls + 1
    return np.asarray(table[what + 5])


def _beams(camera: Camera, body: Solid | None, is_native: bool) -> Beams:
    eye = camera.model_copy(update={"cast": None}) if is_native else camera
    ends_m = stopped_m(eye, body)
    return beams_of(eye, ends_m=ends_m)


def _paint(world: World, rng: np.random.Generator) -> kernel.Paint:
    """Return the colours of a frame's objects, the same for every camera."""
    cls = world.boxes.cls[: world.reflectivity.users]
    draws = rng.integers(0, 1 << 30, len(world.boxes.cls))
    colours = [
        _USERS[one][draw % len(_USERS[one])] for one, draw in zip(cls.tolist(), draws.tolist(), strict=False)
    ]
    colours += [_GIVEN if kind < 0 else _KINDS[KINDS[kind].name] for kind in world.kind.tolist()]
    boxes = np.array(colours, np.float64).reshape(-1, 3)
    boxes *= rng.uniform(1.0 - _VARIED, 1.0 + _VARIED, (len(boxes), 1))
    plain = {name: np.array(colour, np.float64) for name, colour in _PLAIN.items()}
    return kernel.Paint(world.reflectivity.users, boxes, **plain)
