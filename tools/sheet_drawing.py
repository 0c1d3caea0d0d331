"""The drawing of core and sheets in docs/engine.md; `draw_engine.py` writes it."""

from __future__ import annotations

import math

from tools.drawing import BLUE, GREY, PALE_BLUE, PALE_GREEN, PALE_ORANGE, RED, Drawing, Point


def sheets() -> str:
    """Return cores and cones from the side, and the columns of one cone with its certain parts."""
    d = Drawing(
        820, 400, "Core and sheets: between close beams, and along one beam, voxels are hit for certain"
    )
    _core_and_sheets(d)
    _sheet_in_columns(d)
    return d.svg()


SHEET_BEAMS = (-15.0, -11.0, -7.0, -3.0, 1.0, 12.0)
SHEET_PLACE, SHEET_TILT = (0.4, 5.3), -2.0


def _core_and_sheets(d: Drawing) -> None:
    """Beams from the side: the core of those that are close, the columns in which the others are."""
    nx, nz, cell, radius = 16, 7, 26.0, 7.4

    def place(x: float, z: float) -> Point:
        return 30 + cell * x, 246 - cell * z

    d.text(20, 28, "*A tilted LiDAR from the side")
    tangents = [math.tan(math.radians(a + SHEET_TILT)) for a in SHEET_BEAMS]
    for ix in range(nx):
        for iz in range(nz):
            x, z = ix + 0.5 - SHEET_PLACE[0], iz + 0.5 - SHEET_PLACE[1]
            in_core = tangents[0] * x <= z <= tangents[4] * x and math.hypot(x, z) <= radius
            ends = [sorted((t * (x - 0.5), t * (x + 0.5))) for t in tangents]
            met = [(a, b) for a, b in ends if b > z - 0.5 and a < z + 0.5]
            sure = any(min(b, z + 0.5) - max(a, z - 0.5) > 0.5 * (b - a) for a, b in met)
            fill = PALE_GREEN if in_core else PALE_BLUE if sure else PALE_ORANGE if met else "#ffffff"
            d.box(*place(ix, iz + 1), cell, cell, fill)
    for tangent in tangents:
        reach = min(
            nx - SHEET_PLACE[0],
            *(h / tangent for h in (nz - SHEET_PLACE[1], -SHEET_PLACE[1]) if h / tangent > 0),
        )
        d.line(
            [place(*SHEET_PLACE), place(SHEET_PLACE[0] + reach, SHEET_PLACE[1] + tangent * reach)], BLUE, 1.5
        )
    d.dot(*place(*SHEET_PLACE), 5)
    key = (
        (PALE_GREEN, "core: centre between close beams"),
        (PALE_BLUE, "a sheet stays in the level: certain"),
        (PALE_ORANGE, "a sheet grazes it: rays are tested"),
    )
    for number, (fill, words) in enumerate(key):
        d.box(30, 268 + 22 * number, 15, 15, fill, GREY)
        d.text(53, 280 + 22 * number, words, 11.5)
    d.text(30, 352, "Where the rays of a beam are more than a voxel apart,", 11, GREY)
    d.text(30, 368, "they are walked one by one.", 11, GREY)


def _sheet_in_columns(d: Drawing) -> None:
    """Some columns from above: rays, and where the sheet changes its level."""
    left, top, cell = 510.0, 60.0, 62.0

    def place(x: float, y: float) -> Point:
        return left + cell * x, top + cell * (3 - y)

    d.text(left - 10, 28, "*One sheet from above")
    far = (-9.0, -4.4)
    rings = (11.45, 13.4)
    for ix in range(4):
        for iy in range(3):
            corners = [math.hypot(x - far[0], y - far[1]) for x in (ix, ix + 1) for y in (iy, iy + 1)]
            crossed = [ring for ring in rings if min(corners) < ring < max(corners)]
            thin = [ring for ring in crossed if min(ring - min(corners), max(corners) - ring) < 0.22]
            d.box(*place(ix, iy + 1), cell, cell, PALE_ORANGE if thin else PALE_BLUE)
    for step in range(40):
        a = math.radians(14.0 + 1.9 * step)
        near, end = _across(far, a)
        if near < end:
            d.line(
                [place(far[0] + s * math.cos(a), far[1] + s * math.sin(a)) for s in (near, end)], BLUE, 1.0
            )
    for ring in rings:
        angles = [math.radians(5.0 + 0.5 * n) for n in range(120)]
        points = [(far[0] + ring * math.cos(a), far[1] + ring * math.sin(a)) for a in angles]
        inside = [place(x, y) for x, y in points if 0.0 <= x <= 4.0 and 0.0 <= y <= 3.0]
        if len(inside) > 1:
            d.line(inside, RED, 1.8, "6 4")
    told = (
        "Blue: rays. Red: here the sheet passes from one",
        "level to the next. In the other columns the level",
        "is certain, and both are where each part is wider",
        "than the way from ray to ray. A narrow corner may",
        "lie between two rays (orange): it is tested.",
    )
    for row, words in enumerate(told):
        d.text(left - 10, 274 + 16 * row, words, 11, GREY)


def _across(far: Point, a: float) -> Point:
    """From where to where along a direction the drawn columns are crossed."""
    h = (math.cos(a), math.sin(a))
    spans = [sorted((-far[axis] / h[axis], (size - far[axis]) / h[axis])) for axis, size in ((0, 4), (1, 3))]
    return max(span[0] for span in spans), min(span[1] for span in spans)
