"""Bundled scenario: a table of boxes, a note of its number of frames, and its occluders."""

from __future__ import annotations

import json
from importlib import resources
from pathlib import Path

from riglens.core.scene.occluders import Occluders
from riglens.core.scene.readers.opening import Source, open_boxes

SCENARIO = "scenarios/town"


def bundled_source() -> Source:
    """Return the boxes of the bundled town; scenario.json holds the number of frames, empty ones included."""
    frames = int(json.loads((_folder() / "scenario.json").read_text(encoding="utf-8"))["frames"])
    return open_boxes(_folder() / "boxes.csv.gz", frames=frames, name="bundled scenario town")


def bundled_occluders() -> Occluders:
    """Return the occluders along the streets of the bundled town, and the pose of the car in each frame."""
    from riglens.core.scene.readers.occluders import open_occluders  # loads pyarrow, as open_boxes does

    return open_occluders(_folder() / "occluders.csv.gz", _folder() / "poses.csv.gz")


def _folder() -> Path:
    return Path(str(resources.files("riglens.assets").joinpath(SCENARIO)))
