"""Names of arguments: fields as core and Python have them, options on the command line, labels in the window."""

from __future__ import annotations

import re

_UNIT = re.compile(r"_(m|mm|px|s|mps2|pp|deg|kmh)$")
_OPTIONS = {
    "camera_weight": "lambda",
    "class_name": "class",
    "find_ground": "ground",
    "source_format": "from",
    "target_format": "to",
    "tolerance_pp": "voxel-tolerance",
}
"""Options that are not called like their field without its unit."""
_LABELS = {"camera_weight": "λ", "origin_m": "Origin", "roi_m": "Region", "tolerance_pp": "Tolerance"}


def option_of(field: str) -> str:
    """Return the option of the command line for a field: `voxel_m` is --voxel."""
    return "--" + _OPTIONS.get(field, _UNIT.sub("", field).replace("_", "-"))


def label_of(field: str) -> str:
    """Return the label of the window for a field: `voxel_m` is Voxel."""
    return _LABELS.get(field, _UNIT.sub("", field).replace("_", " ").capitalize())
