"""The bundled scenario: its table and sidecar agree, and its boxes look like traffic around an ego car."""

from __future__ import annotations

import csv
import gzip
import hashlib
import json
import math
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

FOLDER = Path(__file__).parents[2] / "assets" / "scenarios" / "town"
COLUMNS = ["seq", "frame", "cls", "x", "y", "z", "length", "width", "height", "yaw"]
PRODUCT_CLASS = {
    "car": "car",
    "van": "car",
    "truck": "car",
    "bus": "car",
    "bicycle": "bicycle",
    "motorcycle": "bicycle",
    "pedestrian": "pedestrian",
}
# Smallest and largest (length, width, height) in metres that pass for a real one.
SIZE_LIMITS_M = {
    "car": ((3.4, 1.5, 1.3), (5.3, 2.1, 2.0)),
    "van": ((4.6, 1.7, 1.9), (6.5, 2.3, 2.9)),
    "truck": ((6.5, 2.1, 2.5), (12.0, 2.8, 4.0)),
    "bus": ((10.0, 2.4, 2.8), (13.0, 2.8, 3.5)),
    "bicycle": ((1.5, 0.4, 1.4), (2.1, 0.8, 2.0)),
    "motorcycle": ((1.8, 0.6, 1.2), (2.5, 1.0, 1.9)),
    "pedestrian": ((0.3, 0.4, 1.4), (0.8, 0.8, 2.1)),
}
EGO_LENGTH_M, EGO_WIDTH_M = 4.6, 1.85


@dataclass(frozen=True)
class Row:
    """One box; metres and radians in the ego vehicle frame."""

    seq: int
    frame: int
    cls: str
    centre_m: tuple[float, float, float]
    size_m: tuple[float, float, float]
    yaw_rad: float


def _row(text: list[str]) -> Row:
    x, y, z, length, width, height, yaw = map(float, text[3:])
    return Row(int(text[0]), int(text[1]), text[2], (x, y, z), (length, width, height), yaw)


@pytest.fixture(scope="module")
def sidecar() -> dict[str, Any]:
    content: dict[str, Any] = json.loads((FOLDER / "scenario.json").read_text(encoding="utf-8"))
    return content


@pytest.fixture(scope="module")
def rows() -> list[Row]:
    with gzip.open(FOLDER / "boxes.csv.gz", "rt", encoding="utf-8", newline="") as table:
        reader = csv.reader(table)
        assert next(reader) == COLUMNS
        return [_row(text) for text in reader]


def _overlap_along(row: Row, axis_rad: float) -> bool:
    """Whether box and ego body overlap when projected on a horizontal axis through the origin."""
    turn_rad = row.yaw_rad - axis_rad
    box_half_m = (row.size_m[0] * abs(math.cos(turn_rad)) + row.size_m[1] * abs(math.sin(turn_rad))) / 2
    ego_half_m = (EGO_LENGTH_M * abs(math.cos(axis_rad)) + EGO_WIDTH_M * abs(math.sin(axis_rad))) / 2
    distance_m = abs(row.centre_m[0] * math.cos(axis_rad) + row.centre_m[1] * math.sin(axis_rad))
    return distance_m < box_half_m + ego_half_m - 0.005


def test_tables_are_those_that_the_sidecar_describes(sidecar: dict[str, Any]) -> None:
    tables = {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in FOLDER.glob("*.gz")}
    assert tables == sidecar["sha256"]


def test_sidecar_counts_the_boxes_of_the_table(sidecar: dict[str, Any], rows: list[Row]) -> None:
    assert Counter(row.cls for row in rows) == Counter(sidecar["boxes"])


def test_the_scenario_is_small_enough_to_ship() -> None:
    assert sum(path.stat().st_size for path in FOLDER.rglob("*") if path.is_file()) <= 4_000_000


def test_at_least_two_thousand_frames_with_dense_traffic(sidecar: dict[str, Any], rows: list[Row]) -> None:
    assert sidecar["frames"] >= 2000
    near = [row for row in rows if abs(row.centre_m[0]) <= 37 and abs(row.centre_m[1]) <= 27]
    assert 15 <= len(near) / sidecar["frames"] <= 30


def test_boxes_reach_out_to_a_hundred_metres_on_all_sides(rows: list[Row]) -> None:
    distance_m = [math.hypot(*row.centre_m[:2]) for row in rows]
    assert 99.9 < max(distance_m) <= 100.001
    for side in range(8):
        far = [
            row
            for row, away_m in zip(rows, distance_m, strict=True)
            if away_m > 90
            and int((math.atan2(row.centre_m[1], row.centre_m[0]) % math.tau) / math.tau * 8) == side
        ]
        assert len(far) > 500, side


def test_frames_without_boxes_are_counted(sidecar: dict[str, Any], rows: list[Row]) -> None:
    frames_with_boxes = {(row.seq, row.frame) for row in rows}
    assert len(frames_with_boxes) < sidecar["frames"]


def test_rows_are_sorted_by_sequence_and_frame(rows: list[Row]) -> None:
    keys = [(row.seq, row.frame) for row in rows]
    assert keys == sorted(keys)
    assert min(row.seq for row in rows) == min(row.frame for row in rows) == 0


def test_every_product_class_is_well_represented(rows: list[Row]) -> None:
    counts = Counter(PRODUCT_CLASS[row.cls] for row in rows)
    assert all(counts[cls] > 2000 for cls in ("car", "bicycle", "pedestrian"))


@pytest.mark.parametrize("cls", sorted(SIZE_LIMITS_M))
def test_sizes_are_those_of_real_road_users(cls: str, rows: list[Row]) -> None:
    smallest_m, largest_m = SIZE_LIMITS_M[cls]
    sizes_m = {row.size_m for row in rows if row.cls == cls}
    assert len(sizes_m) > 1
    for size_m in sizes_m:
        assert all(
            low <= value <= high for low, value, high in zip(smallest_m, size_m, largest_m, strict=True)
        )


def test_boxes_stand_on_the_ground(rows: list[Row]) -> None:
    assert all(abs(row.centre_m[2] - row.size_m[2] / 2) <= 0.001 for row in rows)


def test_no_box_overlaps_the_ego_body(rows: list[Row]) -> None:
    for row in rows:
        axes_rad = (0.0, math.pi / 2, row.yaw_rad, row.yaw_rad + math.pi / 2)
        assert not all(_overlap_along(row, axis) for axis in axes_rad), row


def test_traffic_keeps_right_around_the_ego_car(rows: list[Row]) -> None:
    """Cars beside the ego that head the other way pass on its left; those ahead in its lane head its way."""
    cars = [row for row in rows if row.cls == "car"]
    beside = [row for row in cars if abs(row.centre_m[0]) < 8 and abs(row.centre_m[1]) < 8]
    oncoming = [row for row in beside if abs(row.yaw_rad) > math.pi - 0.1]
    assert len(oncoming) > 100
    assert all(row.centre_m[1] > 0 for row in oncoming)
    queue = [row for row in cars if 5 < row.centre_m[0] < 9 and abs(row.centre_m[1]) < 0.8]
    assert len(queue) > 100
    assert sum(abs(row.yaw_rad) < 0.2 for row in queue) / len(queue) > 0.9
