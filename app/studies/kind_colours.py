"""Colours of kinds of sensors in charts and reports."""

from __future__ import annotations

from riglens.core.sensors.camera import CAMERA
from riglens.core.sensors.lidar import LIDAR
from riglens.core.sensors.registry import kind_names

_COLOURS = {LIDAR.name: "#1f5fa8", CAMERA.name: "#a0702a"}
_FURTHER = ("#6b4fa0", "#2e7d5b", "#a8324a")


def kind_colour(name: str) -> str:
    """Return the colour of a kind, #rrggbb; further kinds take those of a list in turn."""
    further = [kind for kind in kind_names() if kind not in _COLOURS]
    return _COLOURS.get(name) or _FURTHER[further.index(name) % len(_FURTHER)]
