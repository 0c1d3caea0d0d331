"""Draws docs/images/engine-*.svg: the seven small drawings of docs/engine.md.

What they show is computed here from a few numbers, in plain Python, so that the same files come out everywhere.
Run it from the root of the project after changing a drawing: python -m tools.draw_engine
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import pairwise
from pathlib import Path

from tools.drawing import (
    BLUE,
    FAINT,
    GREEN,
    GREY,
    INK,
    ORANGE,
    PALE_BLUE,
    PALE_GREEN,
    PALE_ORANGE,
    PALE_RED,
    RED,
    Drawing,
    Point,
)
from tools.mesh_drawing import mesh
from tools.sheet_drawing import sheets

FOLDER = Path("docs/images")


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


FAN_PLACE, FAN_HEIGHT, FAN_SHAPE, FAN_SLOPES = (0.55, 0.6), 2.4, (7, 5), (-0.42, -0.2, 0.25)
FAN_HEADING = (math.cos(math.radians(27.0)), math.sin(math.radians(27.0)))
OTHER_PLANES = ((-18.0, 1.94), (4.5, 6.42), (49.5, 5.79), (72.0, 4.63))
"""Angles of some more planes, and their drawn lengths."""


def fan() -> str:
    """A plane from above, and the same plane from the side with its profile."""
    d = Drawing(820, 380, "A fan: all rays of one azimuth share a vertical plane")
    distances, crossed = _crossings(FAN_PLACE, FAN_HEADING, FAN_SHAPE)
    _from_above(d, distances[-1], crossed)
    stays = _stays(FAN_SLOPES, FAN_HEIGHT, distances[-1], 5)
    _from_the_side(d, distances, stays)
    _events(d, distances[-1], stays)
    return d.svg()


def _from_above(d: Drawing, end: float, crossed: Sequence[tuple[int, int]]) -> None:
    """The grid, the columns that a plane crosses, and some planes."""

    def place(x: float, y: float) -> Point:
        return 30 + 42 * x, 270 - 42 * y

    def plane(along: Point, reach: float, colour: str, width: float, dashes: str = "") -> None:
        tip = (FAN_PLACE[0] + reach * along[0], FAN_PLACE[1] + reach * along[1])
        d.line([place(*FAN_PLACE), place(*tip)], colour, width, dashes)

    d.text(20, 28, "*From above: planes cross columns")
    for number, (ix, iy) in enumerate(crossed):
        x, y = place(ix, iy + 1)
        d.box(x, y, 42, 42, PALE_BLUE)
        d.text(x + 4, y + 12, str(number), 9, GREY)
    for ix in range(FAN_SHAPE[0] + 1):
        d.line([place(ix, 0), place(ix, FAN_SHAPE[1])], FAINT)
    for iy in range(FAN_SHAPE[1] + 1):
        d.line([place(0, iy), place(FAN_SHAPE[0], iy)], FAINT)
    for degrees, reach in OTHER_PLANES:
        plane((math.cos(math.radians(degrees)), math.sin(math.radians(degrees))), reach, GREY, 1.0, "4 3")
    plane(FAN_HEADING, end, BLUE, 2.2)
    d.dot(*place(*FAN_PLACE))
    d.text(30, 296, "One LiDAR azimuth, or one image column", 11, GREY)
    d.text(30, 312, "of an upright camera, is one plane (blue).", 11, GREY)


LEFT, UNIT = 400.0, 50.0
"""Left end of the side view, and the length of a voxel along it."""


def _from_the_side(d: Drawing, distances: Sequence[float], stays: Sequence[Sequence[Point]]) -> None:
    """The rays of the plane, and the levels that each column gets."""

    def place(s: float, z: float) -> Point:
        return LEFT + UNIT * s, 270 - 42 * z

    d.text(LEFT - 10, 28, "*From the side: one profile for all planes")
    for number, (near, far) in enumerate(pairwise(distances)):
        d.text(place((near + far) / 2, 0)[0], place(0, 5.1)[1], str(number), 9, GREY, "middle")
        for level, spans in enumerate(stays):
            if any(a < far and b > near for a, b in spans):
                d.box(*place(near, level + 1), UNIT * (far - near), 42, PALE_BLUE, "none")
    for level in range(6):
        d.line([place(0, level), place(distances[-1], level)], FAINT)
    for s in distances:
        d.line([place(s, 0), place(s, 5)], FAINT)
    for slope in FAN_SLOPES:
        end = min(distances[-1], ((5 if slope > 0 else 0) - FAN_HEIGHT) / slope)
        d.line([place(0, FAN_HEIGHT), place(end, FAN_HEIGHT + slope * end)], BLUE, 2.0)
    d.dot(*place(0, FAN_HEIGHT))


def _events(d: Drawing, end: float, stays: Sequence[Sequence[Point]]) -> None:
    """Draw where levels begin (upwards) and end (downwards), along the distance."""
    axis = 306.0
    d.line([(LEFT, axis), (LEFT + UNIT * end, axis)], INK, 1.2)
    for level, spans in enumerate(stays):
        for begins, ends in spans:
            x = LEFT + UNIT * begins
            if 0.0 < begins < end:
                d.line([(x, axis), (x, axis - 8)], GREEN, 2.0)
                d.text(x, axis - 11, f"+{level}", 10, GREEN, "middle")
            x = LEFT + UNIT * ends
            if ends < end:
                d.line([(x, axis), (x, axis + 8)], RED, 2.0)
                d.text(x, axis + 19, f"−{level}", 10, RED, "middle")
    told = (
        "Events by distance: +3 a ray enters level 3, −2 the last one leaves level 2.",
        "A column gets the levels in use where it begins, and those that begin in it.",
    )
    for row, words in enumerate(told):
        d.text(LEFT, 346 + 16 * row, words, 11, GREY)


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
        "Each column of the grid is visited once: the image borders cut it into one",
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
    "engine-mesh.svg": mesh,
    "engine-sheets.svg": sheets,
}


def main() -> None:
    """Write all drawings."""
    for name, draw in DRAWINGS.items():
        (FOLDER / name).write_text(draw(), encoding="utf-8")


if __name__ == "__main__":
    main()
