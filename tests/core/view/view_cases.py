"""Random frames for the tests of pictures: boxes beside each other on the ground, and cameras among them."""

import numpy as np

from riglens.core.rig.model import Camera
from riglens.core.scene.boxes import rotations_from_yaw
from riglens.core.view.frames import FrameBoxes


def frame_of(*rows: tuple[int, tuple[float, float, float], tuple[float, float, float], float]) -> FrameBoxes:
    """Upright boxes from rows (class, centre, size, yaw in radians)."""
    return FrameBoxes(
        np.array([row[0] for row in rows], np.uint8),
        np.array([row[1] for row in rows], float).reshape(-1, 3),
        np.array([row[2] for row in rows], float).reshape(-1, 3),
        rotations_from_yaw(np.array([row[3] for row in rows], float)),
    )


def random_frame(seed: int, count: int = 30) -> FrameBoxes:
    """Boxes that do not touch each other nor the place of the car, one per cell of a chequer of 6 m."""
    rng = np.random.default_rng(seed)
    cells = [(i, j) for i in range(-4, 5) for j in range(-4, 5) if (i, j) != (0, 0)]
    rows = []
    for number in rng.choice(len(cells), count, replace=False):
        size = rng.uniform(0.5, 4.0, 3)
        x, y = np.array(cells[number]) * 6.0 + rng.uniform(-0.1, 0.1, 2)
        rows.append((int(rng.integers(3)), (x, y, size[2] / 2), tuple(size), rng.uniform(-3.2, 3.2)))
    return frame_of(*rows)


def camera(yaw_deg: float = 0.0, pitch_deg: float = 0.0, roll_deg: float = 0.0, **changes: object) -> Camera:
    """A camera above the middle of the car."""
    fields: dict[str, object] = {
        "name": "eye",
        "position": (0.0, 0.0, 1.6),
        "rpy_deg": (roll_deg, pitch_deg, yaw_deg),
        "image": (640, 360),
        "hfov_deg": 80.0,
        "cast": (64, 36),
    }
    return Camera(**(fields | changes))  # type: ignore[arg-type]
