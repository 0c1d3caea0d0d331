"""The bundled town is what its scripts make, and what stands beside its streets stands in nobody's way."""

from __future__ import annotations

import csv
import gzip
import importlib.util
import math
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from tools.town.streets import street_table
from tools.town.surroundings import MAP, occluder_table, surroundings

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "assets" / "scenarios" / "town"
FOOTPRINT = ("x", "y", "length", "width", "yaw")


def text_of(name: str, folder: Path = FOLDER) -> str:
    return gzip.decompress((folder / name).read_bytes()).decode()


def rows_of(name: str) -> list[dict[str, str]]:
    return list(csv.DictReader(text_of(name).splitlines()))


def footprints(rows: list[dict[str, str]]) -> NDArray[np.float64]:
    return np.array([[float(row[name]) for name in FOOTPRINT] for row in rows], np.float64).reshape(-1, 5)


def corners(footprint: NDArray[np.float64]) -> NDArray[np.float64]:
    """Corners (4, 2) of one footprint."""
    x, y, length, width, yaw = footprint
    ahead = np.array([math.cos(yaw), math.sin(yaw)])
    left = np.array([-ahead[1], ahead[0]])
    return np.array(
        [
            (x, y) + i * length / 2 * ahead + j * width / 2 * left
            for i, j in ((1, 1), (1, -1), (-1, -1), (-1, 1))
        ]
    )


def overlap(a: NDArray[np.float64], b: NDArray[np.float64]) -> bool:
    """Whether two footprints overlap by more than what rounding to millimetres may bring (separating axes)."""
    first, second = corners(a), corners(b)
    for yaw in (a[4], a[4] + math.pi / 2, b[4], b[4] + math.pi / 2):
        axis = np.array([math.cos(yaw), math.sin(yaw)])
        p, q = first @ axis, second @ axis
        if p.max() < q.min() + 0.02 or q.max() < p.min() + 0.02:
            return False
    return True


def in_map(boxes: NDArray[np.float64], pose: dict[str, str]) -> NDArray[np.float64]:
    """Footprints of the vehicle frame in the map frame."""
    x, y, yaw = (float(pose[name]) for name in ("x", "y", "yaw"))
    cos, sin = math.cos(yaw), math.sin(yaw)
    moved = boxes.copy()
    moved[:, 0] = x + cos * boxes[:, 0] - sin * boxes[:, 1]
    moved[:, 1] = y + sin * boxes[:, 0] + cos * boxes[:, 1]
    moved[:, 4] += yaw
    return moved


def test_the_streets_are_those_that_the_script_makes() -> None:
    assert text_of("streets.csv.gz") == street_table(MAP)


@pytest.mark.slow
def test_the_occluders_are_those_that_the_script_makes() -> None:
    assert text_of("occluders.csv.gz") == occluder_table(surroundings())


def test_every_frame_has_a_pose() -> None:
    frames = [(row["seq"], row["frame"]) for row in rows_of("poses.csv.gz")]
    assert frames == [(str(seq), str(frame)) for seq in range(50) for frame in range(50)]


@pytest.mark.parametrize("step", [50, pytest.param(1, marks=pytest.mark.slow)])
def test_occluders_touch_no_road_user_and_not_the_ego_car(step: int) -> None:
    standing = footprints(rows_of("occluders.csv.gz"))
    reach_m = np.hypot(standing[:, 2], standing[:, 3]) / 2
    around: dict[tuple[str, str], list[dict[str, str]]] = {}
    for row in rows_of("boxes.csv.gz"):
        around.setdefault((row["seq"], row["frame"]), []).append(row)
    pairs = 0
    for pose in rows_of("poses.csv.gz")[::step]:
        boxes = footprints(around.get((pose["seq"], pose["frame"]), []))
        boxes = in_map(np.vstack([boxes, (0.0, 0.0, 4.6, 1.85, 0.0)]), pose)
        apart_m = np.hypot(*(boxes[:, None, :2] - standing[None, :, :2]).transpose(2, 0, 1))
        close = np.argwhere(apart_m < reach_m + np.hypot(boxes[:, 2], boxes[:, 3])[:, None] / 2)
        pairs += len(close)
        assert not [(boxes[i], standing[j]) for i, j in close if overlap(boxes[i], standing[j])]
    assert pairs > 10_000 / step


@pytest.mark.slow
@pytest.mark.skipif(importlib.util.find_spec("libsumo") is None, reason="SUMO is not installed")
def test_the_simulation_makes_the_same_tables(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "tools.town.make", "--out", str(tmp_path)]
    subprocess.run(command, cwd=ROOT, check=True, capture_output=True, env=dict(os.environ))
    for name in ("boxes.csv.gz", "occluders.csv.gz", "poses.csv.gz"):
        assert text_of(name, tmp_path) == text_of(name)
