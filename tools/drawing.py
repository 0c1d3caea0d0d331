"""Shapes for the drawings of the documentation, written as plain SVG: the same text comes out everywhere."""

from __future__ import annotations

import math
from collections.abc import Sequence
from xml.sax.saxutils import escape

INK, GREY, FAINT, PAPER = "#1f2933", "#5f6b76", "#c3cbd3", "#fbfcfd"
BLUE, ORANGE, GREEN, RED = "#1565c0", "#d9480f", "#2e7d32", "#c62828"
PALE_BLUE, PALE_ORANGE, PALE_GREEN, PALE_RED = "#bfdcf7", "#ffd8b5", "#c5e6c7", "#f6c9c9"
Point = tuple[float, float]


class Drawing:
    """Shapes on a light card of their own, which is legible on a light page and on a dark one."""

    def __init__(self, width: int, height: int, title: str) -> None:
        card = f'<rect x="1" y="1" width="{width - 2}" height="{height - 2}" rx="8" fill="{PAPER}" stroke="{FAINT}"/>'
        self._parts = [
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" '
            f'height="{height}" font-family="DejaVu Sans, Verdana, sans-serif">',
            f"<title>{escape(title)}</title>",
            card,
        ]

    def text(
        self, x: float, y: float, words: str, size: float = 12, colour: str = INK, at: str = "start"
    ) -> None:
        """A line of text; bold where it starts with an asterisk."""
        weight = ' font-weight="bold"' if words.startswith("*") else ""
        style = f'font-size="{size:g}" fill="{colour}" text-anchor="{at}"{weight}'
        self._parts.append(f'<text x="{x:.1f}" y="{y:.1f}" {style}>{escape(words.lstrip("*"))}</text>')

    def box(
        self,
        x: float,
        y: float,
        width: float,
        height: float,
        fill: str = "none",
        stroke: str = FAINT,
        radius: float = 0.0,
    ) -> None:
        """A rectangle, perhaps with round corners."""
        round_ = f' rx="{radius:g}"' if radius else ""
        self._parts.append(
            f'<rect x="{x:.1f}" y="{y:.1f}" width="{width:.1f}" height="{height:.1f}"{round_} fill="{fill}" '
            f'stroke="{stroke}"/>'
        )

    def line(
        self,
        points: Sequence[Point],
        colour: str = GREY,
        width: float = 1.0,
        dashes: str = "",
        fill: str = "none",
    ) -> None:
        """A line through points; closed where it has a filling."""
        dashed = f' stroke-dasharray="{dashes}"' if dashes else ""
        path = "M " + " L ".join(f"{x:.1f} {y:.1f}" for x, y in points) + (" Z" if fill != "none" else "")
        self._parts.append(
            f'<path d="{path}" fill="{fill}" stroke="{colour}" stroke-width="{width:g}" '
            f'stroke-linejoin="round"{dashed}/>'
        )

    def dot(self, x: float, y: float, radius: float = 4.0, fill: str = INK, stroke: str = "none") -> None:
        """A circle."""
        self._parts.append(
            f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{radius:g}" fill="{fill}" stroke="{stroke}"/>'
        )

    def arrow(self, start: Point, end: Point, colour: str = GREY) -> None:
        """A line with a small head."""
        (x0, y0), (x1, y1) = start, end
        length = math.hypot(x1 - x0, y1 - y0)
        ux, uy = (x1 - x0) / length, (y1 - y0) / length
        base = (x1 - 7 * ux, y1 - 7 * uy)
        self.line([start, base], colour, 1.4)
        head = [(base[0] - 3.5 * uy, base[1] + 3.5 * ux), end, (base[0] + 3.5 * uy, base[1] - 3.5 * ux)]
        self.line(head, colour, 1.0, fill=colour)

    def shape(self, path: str, x: float, y: float, fill: str = "none", stroke: str = GREY) -> None:
        """A path of SVG around a place."""
        self._parts.append(
            f'<path transform="translate({x:.1f} {y:.1f})" d="{path}" fill="{fill}" stroke="{stroke}" '
            'stroke-width="1.5"/>'
        )

    def svg(self) -> str:
        """The file's text."""
        return "\n".join([*self._parts, "</svg>"]) + "\n"
