"""The picture detector learns from colours alone, the same each time, and joins what several cameras find."""

from __future__ import annotations

import numpy as np
import pytest

from riglens.core.detect.net import Training, machine, train_task
from riglens.core.detect.picture_net import PictureTask, detect_in, joined
from riglens.core.detect.pillars import Region
from riglens.core.detect.precision import Detections, Matched, Truth
from riglens.core.detect.views import Lenses, Marks, Views, marks_of
from riglens.core.rig.model import Camera
from riglens.core.sensors.camera import project_px
from tests.core.detect.test_net import one_thread  # noqa: F401

REGION = Region(60.0, 40.0)
CAMERA = Camera(name="front", position=(0.0, 0.0, 1.5), hfov_deg=80.0, image=(320, 128), cast=(160, 64))
COLOURS = ((200, 40, 40), (40, 200, 40), (40, 40, 200))


def pictures(frames: int, seed: int) -> Views:
    """One object a picture, a square of its class's colour as large as it is near, on grey."""
    rng = np.random.default_rng(seed)
    pixels = np.full((frames, 1, 64, 160, 3), 100, np.uint8)
    marks, centres, kinds = [], [], []
    for frame in range(frames):
        cls = np.array([rng.integers(3)], np.uint8)
        away, turn = rng.uniform(6.0, 20.0), rng.uniform(-0.5, 0.5)
        centre_m = np.array([[away * np.cos(turn), away * np.sin(turn), 0.8]])
        column, row = (project_px(CAMERA, centre_m - CAMERA.position)[0] / 2.0).astype(int)
        half = max(1, round(80.0 / away))
        bounds = np.clip([[column - half, row - half, column + half, row + half]], 0, [160, 64, 160, 64])
        left, top, right, bottom = bounds[0]
        pixels[frame, 0, top:bottom, left:right] = COLOURS[cls[0]]
        area = np.array([(right - left) * (bottom - top)])
        marks.append(marks_of(CAMERA, area, bounds, cls, centre_m))
        centres.append(centre_m[:, :2])
        kinds.append(cls)
    lenses = Lenses.of([CAMERA])
    return Views(
        np.arange(frames),
        pixels,
        lenses.rays,
        lenses.place_m,
        lenses.focal_px,
        np.cumsum([0, *(len(one.cls) for one in marks)]),
        *Marks(*(np.concatenate(column) for column in zip(*marks, strict=True))),
        np.arange(frames + 1),
        np.concatenate(kinds),
        np.concatenate(centres),
        np.ones(frames, np.int64),
    )


@pytest.mark.usefixtures("one_thread")
def test_it_learns_and_goes_on_with_the_same_bits() -> None:
    held, unseen, on = pictures(120, 1), pictures(40, 2), machine("cpu")
    training, task = Training(epochs=10, batch=4), PictureTask([held])
    half = train_task(task, training, on, until=5)
    state = train_task(task, training, on, half)
    again = train_task(task, training, on)
    assert all((state[key] == again[key]).all() for key in state)
    found = detect_in(state, unseen, REGION, on)
    truth = Truth(np.arange(40), unseen.cls, unseen.centre_m, unseen.points)
    one = np.zeros(40, np.int64)
    assert min(float(Matched.of(truth, found, k, one).precision()[0]) for k in range(3)) > 0.3


def test_of_detections_of_one_object_the_best_stays() -> None:
    found = Detections(
        np.array([0, 0, 0, 1, 0]),
        np.array([0, 0, 1, 0, 0], np.uint8),
        np.array([[20.0, 0.0], [21.5, 0.0], [20.0, 0.0], [20.0, 0.0], [24.0, 0.0]]),
        np.array([0.4, 0.9, 0.3, 0.2, 0.1]),
    )
    assert joined(found).score.tolist() == [0.9, 0.3, 0.2, 0.1]  # another class, another frame, far enough
