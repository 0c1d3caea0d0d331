"""Names of arguments: fields as core and Python have them, options on the command line, labels in the window."""

from __future__ import annotations

import re

_UNIT = re.compile(r"_(m|mm|px|s|mps2|pp|deg|kmh)$")
_OPTIONS = {
    "camera_weight": "lambda",
    "class_name": "class",
    "find_ground": "ground",
    "px_per_m": "px-per-m",
    "source_format": "from",
    "target_format": "to",
    "tolerance_pp": "voxel-tolerance",
}
"""Options that are not called like their field without its unit."""
_LABELS = {
    "beyond_m": "Maximum overhang",
    "blind_m": "Blind to height",
    "camera_weight": "λ",
    "count": "Pairs to add",
    "find_ground": "Put the ground at z = 0",
    "lowest_m": "Minimum height",
    "origin_m": "Origin",
    "px_per_m": "Pixels per metre",
    "roi_m": "Region",
    "singles": "Allow single sensors",
    "objective": "For",
    "spacing_m": "Minimum distance",
    "spots_m": "Mount spacing",
    "tilt_deg": "Tilts outwards",
    "tolerance_pp": "Tolerance",
    "yaw_deg": "Turns",
}


def option_of(field: str) -> str:
    """Return the option of the command line for a field: `voxel_m` is --voxel."""
    return "--" + _OPTIONS.get(field, _UNIT.sub("", field).replace("_", "-"))


def option_with(field: str, value: object) -> str:
    """Return the option of the command line that gives a field a value: `--origin 0 0 1.73`."""
    words = "auto" if value is True else " ".join(_words(value))
    return f"{option_of(field)} {words}"


def label_with(field: str, value: object) -> str:
    """Return the entry of the window that gives a field a value: `Origin 0 0 1.73`."""
    return f"“{label_of(field)}”" if value is True else f"{label_of(field)} {' '.join(_words(value))}"


def argument_with(field: str, value: object) -> str:
    """Return the argument of the Python interface that gives a field a value: `origin_m=(0, 0, 1.73)`."""
    words = _words(value)
    return f"{field}={words[0] if len(words) == 1 else '(' + ', '.join(words) + ')'}"


def _words(value: object) -> list[str]:
    """Return a value, or the parts of several, as words; numbers as short as they can be."""
    parts = value if isinstance(value, tuple) else (value,)
    return [f"{part:g}" if isinstance(part, float) else str(part) for part in parts]


def label_of(field: str) -> str:
    """Return the label of the window for a field: `voxel_m` is Voxel."""
    return _LABELS.get(field, _UNIT.sub("", field).replace("_", " ").capitalize())
