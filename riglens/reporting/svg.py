"""Draw for a page and its PDF alike: SVG in millimetres, in a few colours that a dark page replaces."""

from __future__ import annotations

import base64
import math
from collections.abc import Iterable, Sequence

import numpy as np
from markupsafe import Markup, escape
from numpy.typing import NDArray

from riglens.core.shown_text import visible

INK, SOFT, LINE, PANEL, PAPER = "#1b2430", "#56616e", "#c8cfd7", "#e8ecf0", "#ffffff"
GAIN, LOSS, LOSS_TEXT = "#0072b2", "#d55e00", "#b84a00"
"""Blue: this rig, gained, better; vermilion: worse, lost, unseen (Okabe and Ito, told apart by everybody)."""
ON_LOSS = "#1a222d"
"""Words on areas of a strong vermilion, dark on every page."""
DEGREES = ("#f6dcc7", "#eaaf80", LOSS, "#7a3300", "#3a1800")
"""Vermilion by degrees, each further from the paper than the one before, on a dark page too."""
DARK = {
    INK: "#e7ecf1", SOFT: "#a7b2be", LINE: "#3b4652", PANEL: "#2a333d", PAPER: "#161c23",
    GAIN: "#56b4e9", LOSS: "#e07b28", LOSS_TEXT: "#f0a060", ON_LOSS: "#161c23",
} | dict(zip(DEGREES, ("#493424", "#7b4c26", "#e07b28", "#ffb877", "#ffe3c8"), strict=True))  # fmt: skip
TEXT_MM = 2.5
FONT = "Liberation Sans, Arial, DejaVu Sans"
Point = tuple[float, float]


class Drawing:
    """Shapes and words within a rectangle, in millimetres right and down from its upper left corner.

    key: part of the names that the drawing gives to its parts, unique on a page; title: what it shows, in words.
    """

    def __init__(self, key: str, width: float, height: float, title: str) -> None:
        self.key, self.width, self.height, self.title = key, width, height, title
        self._parts: list[str] = []

    def _add(self, tag: str, words: str = "", **attributes: object) -> None:
        """Add an element; numbers are rounded to a hundredth of a millimetre, None is left out."""
        given = ((name.replace("_", "-"), value) for name, value in attributes.items() if value is not None)
        text = " ".join(f'{name}="{escape(_text(value))}"' for name, value in given)
        self._parts.append(f"<{tag} {text}>{escape(visible(words))}</{tag}>" if words else f"<{tag} {text}/>")

    def line(
        self, points: Iterable[Point], stroke: str = LINE, width: float = 0.2, dash: str | None = None
    ) -> None:
        """Draw a line through points."""
        self._add(
            "polyline",
            points=_points(points),
            fill="none",
            stroke=stroke,
            stroke_width=width,
            stroke_dasharray=dash,
        )

    def area(
        self,
        points: Iterable[Point],
        fill: str,
        opacity: float = 1.0,
        stroke: str | None = None,
        width: float = 0.2,
        dash: str | None = None,
    ) -> None:
        """Draw a polygon."""
        seen = None if opacity == 1.0 else round(opacity, 3)
        self._add(
            "polygon", points=_points(points), fill=fill, fill_opacity=seen, stroke=stroke,
            stroke_width=width if stroke else None, stroke_dasharray=dash,
        )  # fmt: skip

    def circle(
        self, at: Point, radius: float, fill: str = "none", stroke: str | None = None, width: float = 0.2,
        opacity: float | None = None, dash: str | None = None,
    ) -> None:  # fmt: skip
        """Draw a circle."""
        self._add(
            "circle", cx=at[0], cy=at[1], r=radius, fill=fill, fill_opacity=opacity, stroke=stroke,
            stroke_width=width if stroke else None, stroke_dasharray=dash,
        )  # fmt: skip

    def rect(
        self, x: float, y: float, width: float, height: float, fill: str, opacity: float | None = None,
        stroke: str | None = None, radius: float | None = None, dash: str | None = None,
    ) -> None:  # fmt: skip
        """Draw a rectangle."""
        self._add(
            "rect", x=x, y=y, width=max(width, 0.0), height=height, rx=radius, fill=fill, fill_opacity=opacity,
            stroke=stroke, stroke_width=0.2 if stroke else None, stroke_dasharray=dash,
        )  # fmt: skip

    def text(
        self, x: float, y: float, words: str, anchor: str = "start", colour: str = INK, bold: bool = False,
        halo: bool = False, path: str | None = None, size_mm: float = TEXT_MM,
    ) -> None:  # fmt: skip
        """Write words on a base line; `halo`: readable over shapes, `path`: the place of a figure that they say."""
        if halo:
            self._add(
                "text", words, x=x, y=y, text_anchor=anchor, font_size=size_mm, fill=PAPER, stroke=PAPER,
                stroke_width=0.8, stroke_linejoin="round", font_weight="bold" if bold else None, aria_hidden="true",
            )  # fmt: skip
        self._add(
            "text", words, x=x, y=y, text_anchor=anchor, font_size=size_mm, fill=colour,
            font_weight="bold" if bold else None, data_from=path,
        )  # fmt: skip

    def badge(self, at: Point, number: int, radius: float = 2.0) -> None:
        """Draw a number in a circle."""
        self.circle(at, radius, PAPER, INK, 0.22)
        self.text(at[0], at[1] + 0.36 * TEXT_MM, str(number), "middle", bold=True)

    def outline(self, path: str, at: Point, scale: float, fill: str, width: float = 0.2) -> None:
        """Draw an outline given as a path in units of its own, `scale` millimetres each, with its origin at a point."""
        self._add(
            "path", d=path, fill=fill, fill_rule="evenodd", stroke=INK, stroke_width=round(width / scale, 2),
            transform=f"translate({at[0]:.2f} {at[1]:.2f}) scale({scale:.5f})",
        )  # fmt: skip

    def cells(self, chosen: NDArray[np.bool_], at: Point, side: float, fill: str) -> None:
        """Draw cells of a lattice (rows down, columns), of a side in millimetres, from its upper left corner."""
        ends = np.diff(np.pad(chosen.astype(np.int8), ((0, 0), (1, 1))), axis=1)
        (rows, starts), stops = np.nonzero(ends == 1), np.nonzero(ends == -1)[1]
        runs = zip(rows.tolist(), starts.tolist(), (stops - starts).tolist(), strict=True)
        self._add(
            "path", d="".join(f"M{column} {row}h{wide}v1h-{wide}z" for row, column, wide in runs), fill=fill,
            shape_rendering="crispEdges", transform=f"translate({at[0]:.3f} {at[1]:.3f}) scale({side:.5f})",
        )  # fmt: skip

    def image(self, png: bytes, x: float, y: float, width: float, height: float) -> None:
        """Draw a picture."""
        data = base64.b64encode(png).decode("ascii")
        self._add(
            "image", href=f"data:image/png;base64,{data}", x=x, y=y, width=width, height=height,
            preserveAspectRatio="none",
        )  # fmt: skip

    def clip(self, width: float, height: float) -> None:
        """Cut what has been drawn so far at a rectangle from the upper left corner."""
        name = f"clip-{self.key}"
        held = "".join(self._parts)
        self._parts = [
            f'<clipPath id="{name}"><rect x="0" y="0" width="{width:g}" height="{height:g}"/></clipPath>'
            f'<g clip-path="url(#{name})">{held}</g>'
        ]

    def __html__(self) -> Markup:
        """Return the drawing as an element of a page."""
        size = f"{self.width:g}mm"
        return Markup(
            f'<svg viewBox="0 0 {self.width:g} {self.height:g}" width="{size}" height="{self.height:g}mm" '
            f'font-family="{FONT}" role="img"><title>{escape(visible(self.title))}</title>{"".join(self._parts)}</svg>'
        )


def sector(at: Point, radii: tuple[float, float], middle_deg: float, half_deg: float = 22.5) -> list[Point]:
    """Return the outline of a sector of a ring; bearings turn left from straight up."""
    steps = [math.radians(middle_deg + half_deg * step / 7.0) for step in range(-7, 8)]
    outer = [(at[0] - radii[1] * math.sin(turn), at[1] - radii[1] * math.cos(turn)) for turn in steps]
    inner = [
        (at[0] - radii[0] * math.sin(turn), at[1] - radii[0] * math.cos(turn)) for turn in reversed(steps)
    ]
    return [*outer, *(inner if radii[0] else [at])]


def apart(dots: Sequence[Point], box: Point, radius: float, reach: float) -> list[Point]:
    """Return places for labels of some radius beside dots, within a box, none over another or over a dot where there
    is room: each begins `reach` farther from the middle of all dots."""
    middle = [sum(dot[axis] for dot in dots) / max(1, len(dots)) for axis in (0, 1)]
    places = []
    for number, (x, y) in enumerate(dots):
        dx, dy = x - middle[0] + 1e-3 * math.cos(number), y - middle[1] + 1e-3 * math.sin(number)
        away = math.hypot(dx, dy)
        places.append([x + reach * dx / away, y + reach * dy / away])
    for _ in range(200):
        for number, place in enumerate(places):
            others = [(other, 2.0 * radius + 0.4) for k, other in enumerate(places) if k != number]
            others += [([*dot], radius + 1.0) for dot in dots] if reach else []
            for other, least in others:
                dx, dy = place[0] - other[0], place[1] - other[1]
                away = math.hypot(dx, dy) or 1e-6
                if away < least:
                    place[0] += 0.3 * (least - away) * dx / away
                    place[1] += 0.3 * (least - away) * dy / away
            for axis in (0, 1):
                place[axis] = min(max(place[axis], radius + 0.3), box[axis] - radius - 0.3)
    return [(x, y) for x, y in places]


def _points(points: Iterable[Point]) -> str:
    return " ".join(f"{x:.2f},{y:.2f}" for x, y in points)


def _text(value: object) -> str:
    return f"{value:.2f}".rstrip("0").rstrip(".") if isinstance(value, float) else str(value)
