"""Objects all around the car, for searches of rigs."""

import csv
from pathlib import Path

import numpy as np

SIZES_M = {"car": (4.5, 1.9, 1.6), "bicycle": (1.8, 0.6, 1.7), "pedestrian": (0.6, 0.6, 1.8)}


def write_town(path: Path, frames: int, each: int, far_m: float) -> Path:
    """Write a box table with a number of objects of each class in each frame, up to a distance."""
    rng = np.random.default_rng(0)
    with open(path, "w", encoding="utf-8", newline="") as stream:
        table = csv.writer(stream)
        table.writerow(["seq", "frame", "cls", "x", "y", "z", "length", "width", "height", "yaw"])
        for frame in range(frames):
            for cls in [cls for cls in SIZES_M for _ in range(each)]:
                turn = rng.uniform(0.0, 6.28)
                x, y = rng.uniform(6.0, far_m) * np.array([np.cos(turn), np.sin(turn)])
                table.writerow(["s", frame, cls, f"{x:.2f}", f"{y:.2f}", 0.9, *SIZES_M[cls], 0])
    return path
