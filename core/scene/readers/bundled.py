"""Bundled scenario: a table of boxes, a note of its number of frames, its occluders, and its streets."""

from __future__ import annotations

import csv
import gzip
import json
from functools import lru_cache
from importlib import resources
from pathlib import Path

import numpy as np

from riglens.core.scene.boxes import DataReport
from riglens.core.scene.occluders import Occluders
from riglens.core.scene.readers.opening import Source, open_boxes
from riglens.core.scene.streets import Street, Streets, StreetView, surfaces

SCENARIO = "scenarios/town"
_NAME = "bundled scenario town"


def bundled_source() -> Source:
    """Return the boxes of the bundled town; scenario.json holds the number of frames, empty ones included."""
    frames = int(json.loads((_folder() / "scenario.json").read_text(encoding="utf-8"))["frames"])
    return open_boxes(_folder() / "boxes.csv.gz", frames=frames, name=_NAME)


def bundled_occluders() -> Occluders:
    """Return the occluders along the streets of the bundled town, and the pose of the car in each frame."""
    from riglens.core.scene.readers.occluders import open_occluders  # loads pyarrow, as open_boxes does

    return open_occluders(_folder() / "occluders.csv.gz", _folder() / "poses.csv.gz")


def streets_around(data: DataReport, frame: int) -> StreetView | None:
    """Return the streets around the car in a frame, by its number in the data; None in other data than the town."""
    if data.source != _NAME or data.labels is None:
        return None
    return _around(*data.labels.of(frame))


@lru_cache(maxsize=8)
def _around(sequence: str, frame: int) -> StreetView | None:
    return _streets().around((sequence, frame))


@lru_cache(maxsize=1)
def _streets() -> Streets:
    from riglens.core.scene.readers.occluders import read_poses

    rows: dict[tuple[str, str, str], list[tuple[float, float]]] = {}
    with gzip.open(_folder() / "streets.csv.gz", "rt", encoding="utf-8", newline="") as stream:
        for row in csv.DictReader(stream):
            places = rows.setdefault((row["map"], row["street"], row["lanes"]), [])
            places.append((float(row["x"]), float(row["y"])))
    maps: dict[str, list[Street]] = {}
    for (name, _, lanes), places in rows.items():
        parts = (lane.split(" ") for lane in lanes.split("/"))
        maps.setdefault(name, []).append(
            Street(np.array(places), tuple((use, float(width_m)) for use, width_m in parts))
        )
    found = {name: surfaces(streets) for name, streets in maps.items()}
    return Streets(found, read_poses(_folder() / "poses.csv.gz"))


def _folder() -> Path:
    return Path(str(resources.files("riglens.assets").joinpath(SCENARIO)))
