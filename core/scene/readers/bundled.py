"""The scenario that comes with the program: a table of boxes and a note of its number of frames."""

from __future__ import annotations

import json
from importlib import resources
from pathlib import Path

from riglens.core.scene.boxes import BoxSource
from riglens.core.scene.readers.opening import open_boxes

SCENARIO = "scenarios/town"


def bundled_source() -> BoxSource:
    """Return the boxes of the bundled town; scenario.json holds the number of frames, empty ones included."""
    folder = Path(str(resources.files("riglens.assets").joinpath(SCENARIO)))
    frames = int(json.loads((folder / "scenario.json").read_text(encoding="utf-8"))["frames"])
    return open_boxes(folder / "boxes.csv.gz", frames=frames)
