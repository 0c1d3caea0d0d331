"""Marks that a widget paints, read from the vector picture that it draws of itself."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QBuffer, QPoint
from PySide6.QtGui import QColor
from PySide6.QtSvg import QSvgGenerator
from PySide6.QtWidgets import QWidget

_SVG = "{http://www.w3.org/2000/svg}"
_DPI = 96


@dataclass(frozen=True)
class Mark:
    """One painted shape: `circle` (its points: the centre, and the radius twice), `line` (open), `polygon`, `path`,
    `rect` (its points: corner and size) or `text` (its point: where it starts, on its base line), in pixels."""

    shape: str
    points: NDArray[np.float64]
    line: str = "none"
    fill: str = "none"
    opacity: float = 1.0
    """Of the fill."""
    width_px: float = 0.0
    """Of the line."""
    text: str = ""

    @property
    def at(self) -> tuple[float, float]:
        """First point."""
        return float(self.points[0, 0]), float(self.points[0, 1])


def marks(widget: QWidget) -> list[Mark]:
    """Return what a widget paints, in that order."""
    buffer, svg = QBuffer(), QSvgGenerator()
    buffer.open(QBuffer.OpenModeFlag.WriteOnly)
    svg.setOutputDevice(buffer)
    svg.setSize(widget.size())
    svg.setResolution(_DPI)
    widget.render(svg, QPoint(0, 0))
    root = ElementTree.fromstring(buffer.data().data())
    return [mark for group in root.findall(f"{_SVG}g/{_SVG}g") for mark in _marks_of(group)]


def texts(found: list[Mark]) -> list[str]:
    """Return the painted words."""
    return [mark.text for mark in found if mark.shape == "text"]


def colour(name: str) -> str:
    """Return a colour as marks have it."""
    return QColor(name).name()


def _marks_of(group: ElementTree.Element) -> Iterator[Mark]:
    line, fill = group.get("stroke", "none"), group.get("fill", "none")
    opacity, width_px = float(group.get("fill-opacity", "1")), float(group.get("stroke-width", "0"))
    for element in group:
        found = element.attrib
        match element.tag.removeprefix(_SVG):
            case "circle" | "ellipse":
                radii = (found.get("r") or found["rx"], found.get("r") or found["ry"])
                yield Mark(
                    "circle",
                    _points(f"{found['cx']} {found['cy']} {' '.join(radii)}"),
                    line,
                    fill,
                    opacity,
                    width_px,
                )
            case "polyline":
                yield Mark("line", _points(found["points"]), line, fill, opacity, width_px)
            case "polygon":
                yield Mark("polygon", _points(found["points"]), line, fill, opacity, width_px)
            case "path":
                yield Mark("path", _points(found["d"]), line, fill, opacity, width_px)
            case "rect":
                sides = " ".join(found[name] for name in ("x", "y", "width", "height"))
                yield Mark("rect", _points(sides), line, fill, opacity, width_px)
            case "text":
                words = (element.text or "").strip()
                yield Mark("text", _points(f"{found['x']} {found['y']}"), fill=found["fill"], text=words)


def _points(text: str) -> NDArray[np.float64]:
    return np.array([float(number) for number in re.findall(r"-?[\d.]+(?:e-?\d+)?", text)]).reshape(-1, 2)
