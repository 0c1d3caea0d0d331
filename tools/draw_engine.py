"""Draws docs/images/engine-*.svg: the five small drawings of docs/engine.md.

What they show is computed here from a few numbers, in plain Python, so that the same files come out everywhere.
Run it from the root of the project after changing a drawing: python tools/draw_engine.py
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import pairwise
from pathlib import Path
from xml.sax.saxutils import escape

FOLDER = Path("docs/images")
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
        self, x: float, y: float, width: float, height: float, fill: str = "none", stroke: str = FAINT
    ) -> None:
        """A rectangle."""
        self._parts.append(
            f'<rect x="{x:.1f}" y="{y:.1f}" width="{width:.1f}" height="{height:.1f}" fill="{fill}" stroke="{stroke}"/>'
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

    def svg(self) -> str:
        """The file's text."""
        return "\n".join([*self._parts, "</svg>"]) + "\n"


def columns() -> str:
    """A grid of columns, and the word of one of them."""
    d = Drawing(720, 270, "The voxels of one column (x, y) are the bits of one 64-bit word")
    d.text(20, 28, "*A column of voxels is a word")

    def place(x: float, y: float, z: float) -> Point:
        return 40 + 42 * x + 24 * y, 246 - 16 * y - 14 * z

    for x in range(6):
        d.line([place(x, 0, 0), place(x, 3, 0)], FAINT)
    for y in range(4):
        d.line([place(0, y, 0), place(5, y, 0)], FAINT)
    seen = {3, 4, 5, 8}
    for z in range(11):
        fill = PALE_BLUE if z in seen else "#ffffff"
        front = [place(2, 1, z), place(3, 1, z), place(3, 1, z + 1), place(2, 1, z + 1)]
        side = [place(3, 1, z), place(3, 2, z), place(3, 2, z + 1), place(3, 1, z + 1)]
        d.line(front, GREY, 0.8, fill=fill)
        d.line(side, GREY, 0.8, fill=fill)
    d.line([place(2, 1, 11), place(3, 1, 11), place(3, 2, 11), place(2, 2, 11)], GREY, 0.8, fill="#ffffff")
    d.arrow(place(0, -0.35, 0), place(1.2, -0.35, 0), INK)
    d.text(*place(1.35, -0.55, 0), "x", 12)
    d.arrow(place(5.3, 0, 0), place(5.3, 1.6, 0), INK)
    d.text(*place(5.4, 1.9, 0), "y", 12)
    d.text(place(3, 2, 0)[0] + 8, place(0, 0, 7)[1], "ix = 2, iy = 1", 11, GREY)

    left, top, cell = 350, 78, 21
    for bit in range(16):
        x = left + cell * bit
        shown = bit < 11
        d.box(x, top, cell, cell, PALE_BLUE if bit in seen else "#ffffff" if shown else "#eceff2", GREY)
        d.text(x + cell / 2, top + 15, "1" if bit in seen else "0", 11, INK if shown else GREY, "middle")
        d.text(x + cell / 2, top - 6, str(bit) if bit < 13 else "…", 9, GREY, "middle")
    d.text(left, top - 24, "bit = level iz % 64; bit 0 is the ground", 11, GREY)
    d.text(left, top + 48, "word  =  (ix · ny + iy) · depth  +  iz // 64", 13)
    d.text(left, top + 68, "depth = words per column: 1 up to 64 levels, 2 up to 128 …", 11, GREY)
    d.text(left, top + 104, "Levels 3, 4, 5 and 8 are seen: 2³ + 2⁴ + 2⁵ + 2⁸.", 12)
    d.text(left, top + 124, "A ray through levels 3 to 5 sets three bits with one OR.", 12)
    d.text(left, top + 144, "Bits above the top of the grid are never set.", 12)
    return d.svg()


def _crossings(g: Point, h: Point, shape: tuple[int, int]) -> tuple[list[float], list[tuple[int, int]]]:
    """Distances at which a plane changes its column, from 0 to where it leaves the grid, and the columns."""
    faces = [(f - g[axis]) / h[axis] for axis in (0, 1) for f in range(shape[axis] + 1)]
    ends = min((shape[axis] - g[axis]) / h[axis] for axis in (0, 1))
    distances = [0.0, *sorted(s for s in faces if 0.0 < s < ends), ends]
    middles = [(a + b) / 2 for a, b in pairwise(distances)]
    return distances, [(int(g[0] + s * h[0]), int(g[1] + s * h[1])) for s in middles]


def fan() -> str:
    """A plane from above, and the same plane from the side with its profile."""
    d = Drawing(820, 380, "A fan: all rays of one azimuth share a vertical plane")
    g, z0, angle, shape, slopes = (0.55, 0.6), 2.4, math.radians(27.0), (7, 5), (-0.42, -0.2, 0.25)
    h = (math.cos(angle), math.sin(angle))
    distances, crossed = _crossings(g, h, shape)

    def above(x: float, y: float) -> Point:
        return 30 + 42 * x, 270 - 42 * y

    d.text(20, 28, "*From above: planes cross columns")
    for number, (ix, iy) in enumerate(crossed):
        x, y = above(ix, iy + 1)
        d.box(x, y, 42, 42, PALE_BLUE)
        d.text(x + 4, y + 12, str(number), 9, GREY)
    for ix in range(shape[0] + 1):
        d.line([above(ix, 0), above(ix, shape[1])], FAINT)
    for iy in range(shape[1] + 1):
        d.line([above(0, iy), above(shape[0], iy)], FAINT)
    for other in (-18.0, 4.5, 49.5, 72.0):
        a = math.radians(other)
        reach = 0.6 / abs(math.sin(a)) if other < 0 else min(6.4 / math.cos(a), 4.4 / math.sin(a))
        d.line([above(*g), above(g[0] + reach * math.cos(a), g[1] + reach * math.sin(a))], GREY, 1.0, "4 3")
    d.line([above(*g), above(g[0] + distances[-1] * h[0], g[1] + distances[-1] * h[1])], BLUE, 2.2)
    d.dot(*above(*g))
    d.text(30, 296, "One LiDAR azimuth, or one image column", 11, GREY)
    d.text(30, 312, "of an upright camera, is one plane (blue).", 11, GREY)

    left, unit = 400, 50.0

    def beside(s: float, z: float) -> Point:
        return left + unit * s, 270 - 42 * z

    d.text(left - 10, 28, "*From the side: one profile for all planes")
    stays = _stays(slopes, z0, distances[-1], 5)
    for level, spans in enumerate(stays):
        for number, (s0, s1) in enumerate(pairwise(distances)):
            if any(a < s1 and b > s0 for a, b in spans):
                x, y = beside(s0, level + 1)
                d.box(x, y, unit * (s1 - s0), 42, PALE_BLUE, "none")
            if level == 0:
                d.text(beside((s0 + s1) / 2, 5.1)[0], beside(0, 5.1)[1], str(number), 9, GREY, "middle")
    for level in range(6):
        d.line([beside(0, level), beside(distances[-1], level)], FAINT)
    for s in distances:
        d.line([beside(s, 0), beside(s, 5)], FAINT)
    for slope in slopes:
        end = min(distances[-1], (5 - z0) / slope if slope > 0 else -z0 / slope)
        d.line([beside(0, z0), beside(end, z0 + slope * end)], BLUE, 2.0)
    d.dot(*beside(0, z0))
    axis = 306.0
    d.line([(left, axis), (left + unit * distances[-1], axis)], INK, 1.2)
    for level, spans in enumerate(stays):
        for a, b in spans:
            for s, sign, colour in ((a, "+", GREEN), (b, "−", RED)):
                if 0.0 < s < distances[-1]:
                    x = left + unit * s
                    up = sign == "+"
                    d.line([(x, axis), (x, axis - 8 if up else axis + 8)], colour, 2.0)
                    d.text(x, axis - 11 if up else axis + 19, f"{sign}{level}", 10, colour, "middle")
    d.text(
        left,
        346,
        "Events by distance: +3 a ray enters level 3, −2 the last one leaves level 2.",
        11,
        GREY,
    )
    d.text(
        left, 362, "A column gets the levels in use where it begins, and those that begin in it.", 11, GREY
    )
    return d.svg()


def _stays(slopes: Sequence[float], z0: float, end: float, levels: int) -> list[list[Point]]:
    """Distances between which any ray is in a level; those that overlap are one, as in the profile."""
    found: list[list[Point]] = []
    for level in range(levels):
        spans: list[Point] = []
        for slope in slopes:
            a, b = sorted(((level - z0) / slope, (level + 1 - z0) / slope))
            if b > 0.0 and a < end:
                spans.append((max(a, 0.0), b))
        merged: list[Point] = []
        for a, b in sorted(spans):
            if merged and a <= merged[-1][1]:
                merged[-1] = (merged[-1][0], max(b, merged[-1][1]))
            else:
                merged.append((a, b))
        found.append(merged)
    return found


def ties() -> str:
    """Three places of an event: clear of a face, at a face, at an edge."""
    d = Drawing(820, 300, "Ties: events at the face between two columns are decided by the exact walk")
    titles = (
        "*Clear: the fan decides",
        "*At one face: two columns walked",
        "*At two faces: the plane walked",
    )
    shifts = (-0.38, 0.0, 0.0)
    for number, (title, shift) in enumerate(zip(titles, shifts, strict=True)):
        x0, y0, cell = 30 + 265 * number, 214, 76.0
        d.text(x0 - 10, 28, title, 12)
        if number == 2:
            _edge(d, x0, y0, cell)
            continue
        for column in range(3):
            for level in range(2):
                inside = (column < 1 or (column == 1 and shift < 0)) if level == 0 else column >= 1
                if column == 0 and level == 1 and shift < 0:
                    inside = True
                fill = PALE_BLUE if inside else "#ffffff"
                if number == 1 and column in (0, 1):
                    fill = PALE_ORANGE
                if number == 0:
                    fill = PALE_BLUE if (level == 0 and column == 0) or level == 1 else "#ffffff"
                d.box(x0 + cell * column, y0 - cell * (level + 1), cell, cell, fill)
        slope, event = 0.36, 1.0 + shift
        ends = [(0.0, 1.0 - slope * event), (3.0, 1.0 + slope * (3.0 - event))]
        d.line([(x0 + cell * s, y0 - cell * z) for s, z in ends], BLUE, 2.2)
        x, y = x0 + cell * event, y0 - cell
        if number == 1:
            d.line([(x, y0 + 6), (x, y0 - 2 * cell - 6)], ORANGE, 2.0, "5 3")
        d.dot(x, y, 5, ORANGE if number else BLUE)
    lines = (
        "The ray enters level 1 inside the|first column: that column gets both|levels, all further ones level 1.",
        "Within 1e-8 of the face: level 1 begins|behind it, level 0 ends before it; the ray|"
        "is walked exactly through both columns.",
        "Close to two faces at once (an edge, seen|from above), or a plane that grazes one:|"
        "every ray of this plane is walked exactly.",
    )
    for number, told in enumerate(lines):
        for row, words in enumerate(told.split("|")):
            d.text(20 + 265 * number, 244 + 16 * row, words, 11, GREY)
    return d.svg()


def _edge(d: Drawing, x0: float, y0: float, cell: float) -> None:
    """From above: a plane that runs through the common edge of four columns."""
    for column in range(2):
        for row in range(2):
            d.box(x0 + 30 + cell * column, y0 - cell * (row + 1), cell, cell, PALE_ORANGE)
    x, y = x0 + 30 + cell, y0 - cell
    d.line([(x - 1.15 * cell, y + 0.69 * cell), (x + 1.15 * cell, y - 0.69 * cell)], BLUE, 2.2)
    d.dot(x, y, 5, ORANGE)
    d.text(x0 + 36, y0 - 2 * cell - 8, "from above", 10, GREY)


def settle() -> str:
    """One word of the union, before and after a sensor moved."""
    d = Drawing(820, 350, "Settling one word: what arrives, what leaves, what changed in the union")
    d.text(20, 28, "*One word of a kind, while one of its sensors moves")
    leaving = "0011110000000000"
    arrived = "0000111110000000"
    staying = "0110000000000110"
    keep = "1111111101111111"
    before = [(a == "1" or s == "1") and k == "1" for a, s, k in zip(leaving, staying, keep, strict=True)]
    now = [(a == "1" or s == "1") and k == "1" for a, s, k in zip(arrived, staying, keep, strict=True)]
    gained = [n and not b for n, b in zip(now, before, strict=True)]
    lost = [b and not n for n, b in zip(now, before, strict=True)]
    left, cell = 212, 23

    def row(y: float, name: str, flags: Sequence[bool], colour: str) -> None:
        d.text(left - 12, y + 15, name, 12, INK, "end")
        for bit, flag in enumerate(flags):
            d.box(left + cell * bit, y, cell, 20, colour if flag else "#ffffff")
            d.text(
                left + cell * (bit + 0.5), y + 14, "1" if flag else "·", 10, INK if flag else FAINT, "middle"
            )

    def flags(word: str) -> list[bool]:
        return [bit == "1" for bit in word]

    row(46, "leaving (old place)", flags(leaving), PALE_RED)
    row(70, "arrived (new place)", flags(arrived), PALE_GREEN)
    row(94, "staying (other sensors)", flags(staying), "#d9dee3")
    row(118, "keep (informative)", flags(keep), "#eceff2")
    row(156, "union before", before, PALE_BLUE)
    row(180, "union now", now, PALE_BLUE)
    row(204, "gained  = now & ~before", gained, PALE_GREEN)
    row(228, "lost  = before & ~now", lost, PALE_RED)
    runs = ((0, 4, "A"), (4, 7, "B"), (7, 8, "A"), (9, 16, "C"))
    d.text(left - 12, 271, "code of each run", 12, INK, "end")
    tallies = {"A": "", "B": "", "C": ""}
    for start, end, code in runs:
        d.box(left + cell * start, 256, cell * (end - start), 20, "#eceff2", GREY)
        d.text(left + cell * (start + end) / 2, 270, code, 11, INK, "middle")
        for sign, bits in (("+", gained), ("−", lost)):
            tallies[code] += f" {sign}{sum(bits[start:end])}" if any(bits[start:end]) else ""
    x = left + 16 * cell + 22
    told = ",  ".join(f"{code} {more}" for code, more in tallies.items() if more)
    notes = (
        (60, "leaving ≠ arrived? Only then can the"),
        (75, "union of this word have changed."),
        (194, "(arrived | staying) & keep"),
        (218, "whole numbers from here on"),
    )
    for y, words in notes:
        d.text(x, y, words, 10.5, GREY)
    d.text(left, 304, f"Tallies of this word, gained minus lost by code:  {told}", 12)
    d.text(
        left, 326, "At the end:  change of the sums = Σ tally · entropy of the code, in 64-bit integers", 12
    )
    return d.svg()


def voxels() -> str:
    """A tilted camera from the side: sure, tested and ray by ray."""
    d = Drawing(820, 380, "Voxel walking: a voxel whose centre is in the image is hit for certain")
    d.text(20, 28, "*A tilted camera from the side")
    nx, nz, cell, camera = 15, 8, 32.0, (0.7, 6.2)
    tilt, half, limit, room = math.radians(-16.0), math.radians(14.5), 10.4, math.sqrt(0.5)

    def place(x: float, z: float) -> Point:
        return 30 + cell * x, 306 - cell * z

    ahead = (math.cos(tilt), math.sin(tilt))
    sides = [(math.sin(half), s * math.cos(half)) for s in (1.0, -1.0)]
    for ix in range(nx):
        for iz in range(nz):
            x, z = ix + 0.5 - camera[0], iz + 0.5 - camera[1]
            along, across = x * ahead[0] + z * ahead[1], z * ahead[0] - x * ahead[1]
            inside = min(s[0] * along + s[1] * across for s in sides)
            fill = "#ffffff"
            if along <= limit and inside >= 0.0:
                fill = PALE_BLUE
            elif along <= limit and inside >= -room and along >= -room:
                fill = PALE_ORANGE
            x0, y0 = place(ix, iz + 1)
            d.box(x0, y0, cell, cell, fill)
    for step in range(9):
        a = tilt - half + 2 * half * (step + 0.5) / 9
        reach = min((nx - camera[0]) / math.cos(a), (camera[1] / -math.sin(a)) if a < 0 else 99.0)
        ends = (camera[0] + reach * math.cos(a), camera[1] + reach * math.sin(a))
        start = min((limit - 1.0) / math.cos(a - tilt), reach)
        far = (camera[0] + start * math.cos(a), camera[1] + start * math.sin(a))
        d.line([place(*camera), place(*far)], BLUE, 0.7, "2 3")
        d.line([place(*far), place(*ends)], BLUE, 1.4)
    for side in (-half, half):
        a, reach = tilt + side, min(14.2, camera[1] / max(-math.sin(tilt + side), 1e-3))
        d.line(
            [place(*camera), place(camera[0] + reach * math.cos(a), camera[1] + reach * math.sin(a))],
            INK,
            1.6,
        )
    middle = (camera[0] + limit * ahead[0], camera[1] + limit * ahead[1])
    drawn = [(middle[0] - s * ahead[1], middle[1] + s * ahead[0]) for s in (-3.1, 3.1)]
    d.line([place(*p) for p in drawn], RED, 1.6, "6 4")
    d.dot(*place(*camera), 5)
    top = place(*drawn[1])
    d.text(top[0] + 6, top[1] - 4, "depth limit", 11, RED)
    told = (
        "Each column of the grid is looked at once: the image borders cut it into one",
        "sure run of levels, and a few levels at its ends to test. What lies beyond the",
        "depth limit is walked ray by ray, from there on.",
    )
    for row, words in enumerate(told):
        d.text(30, 328 + 16 * row, words, 11, GREY)

    x, y = 540.0, 60.0
    key = (
        (PALE_BLUE, "centre in the image: sure"),
        (PALE_ORANGE, "at the border: its rays are tested"),
        ("#ffffff", "outside, or beyond the limit"),
    )
    for number, (fill, words) in enumerate(key):
        d.box(x, y + 24 * number, 16, 16, fill, GREY)
        d.text(x + 24, y + 13 + 24 * number, words, 11.5)
    size, cx, cy = 110.0, 660.0, 224.0
    d.box(cx - size / 2, cy - size / 2, size, size, PALE_BLUE, GREY)
    d.dot(cx, cy, size / 2 - 1, "#ffffff", GREY)
    d.dot(cx, cy, 3)
    for shift in (-62.0, -18.0, 26.0):
        d.line([(cx - 100, cy + shift + 14), (cx + 100, cy + shift - 14)], BLUE, 1.4)
    d.text(cx, cy + 84, "Up to the limit, neighbouring rays are so close", 10.5, GREY, "middle")
    d.text(cx, cy + 99, "that one always passes through the ball.", 10.5, GREY, "middle")
    return d.svg()


DRAWINGS: dict[str, Callable[[], str]] = {
    "engine-columns.svg": columns,
    "engine-fan.svg": fan,
    "engine-ties.svg": ties,
    "engine-settle.svg": settle,
    "engine-voxels.svg": voxels,
}


def main() -> None:
    """Write all drawings."""
    for name, draw in DRAWINGS.items():
        (FOLDER / name).write_text(draw(), encoding="utf-8")


if __name__ == "__main__":
    main()
