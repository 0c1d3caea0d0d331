"""The drawing of the mesh of rays in docs/engine.md; `draw_engine.py` writes it."""

from __future__ import annotations

import math

from tools.drawing import BLUE, FAINT, GREY, INK, ORANGE, PALE_BLUE, PALE_ORANGE, RED, Drawing, Point

COLUMNS, ROWS = 13, 9
BEND = -0.16
"""First radial coefficient of the lens that is drawn: a barrel."""
ROLL = math.radians(16.0)
SECTORS = 11


def mesh() -> str:
    """Rays of a bent lens joined to triangles; by bearing, which slopes are inside and which at the border."""
    d = Drawing(820, 372, "A mesh of rays: a lens with distortion, its triangles, and its border by bearing")
    _triangles(d)
    _by_bearing(d)
    return d.svg()


def _tangents(column: float, row: float) -> Point:
    """Return the direction of a pixel of the picture, to the right and up, at a distance of one."""
    x, y = 1.5 * (column / (COLUMNS - 1) - 0.5), 1.0 * (0.5 - row / (ROWS - 1))
    stretch = 1.0 / (1.0 + BEND * (x * x + y * y)) ** 1.6
    return x * stretch, y * stretch


def _triangles(d: Drawing) -> None:
    """The rays where they pass a wall in front of the camera."""

    def place(column: float, row: float) -> Point:
        x, y = _tangents(column, row)
        return 205 + 190 * x, 178 - 190 * y

    d.text(20, 28, "*Neighbouring rays are joined to triangles")
    for row in range(ROWS - 1):
        for column in range(COLUMNS - 1):
            corners = [
                place(column, row), place(column + 1, row), place(column + 1, row + 1), place(column, row + 1)
            ]  # fmt: skip
            d.line(corners, FAINT, 0.8, fill=PALE_BLUE)
            d.line([corners[0], corners[2]], FAINT, 0.8)
    border = [(c, 0) for c in range(COLUMNS)] + [(COLUMNS - 1, r) for r in range(ROWS)]
    border += [(c, ROWS - 1) for c in reversed(range(COLUMNS))] + [(0, r) for r in reversed(range(ROWS))]
    d.line([place(c, r) for c, r in border], ORANGE, 2.2)
    for row in range(ROWS):
        for column in range(COLUMNS):
            d.dot(*place(column, row), 2.0, BLUE)
    (ax, ay), (bx, by), (cx, cy) = place(8, 3), place(9, 3), place(9, 4)
    d.line([(ax, ay), (bx, by), (cx, cy)], RED, 1.6, fill="none")
    d.line([(cx, cy), (ax, ay)], RED, 1.6)
    centre = ((ax + bx + cx) / 3, (ay + by + cy) / 3)
    d.dot(*centre, 3.2, INK)
    d.line([centre, (300, 312)], GREY, 0.8, "3 3")
    d.text(30, 328, "The centre of a voxel in a triangle: up to the depth at which the radius", 11, GREY)
    d.text(30, 344, "of the triangle is half a voxel, one of its corners hits the voxel.", 11, GREY)


def _slopes(bearing: float) -> list[float]:
    """Slopes at which the rolled border is crossed at a bearing, the lowest and the highest."""
    found = []
    for step in range(4 * 400):
        side, share = divmod(step, 400)
        along = share / 400
        column, row = [
            (along * (COLUMNS - 1), 0.0), (COLUMNS - 1.0, along * (ROWS - 1)),
            ((1 - along) * (COLUMNS - 1), ROWS - 1.0), (0.0, (1 - along) * (ROWS - 1)),
        ][side]  # fmt: skip
        x, y = _tangents(column, row)
        x, y = x * math.cos(ROLL) - y * math.sin(ROLL), x * math.sin(ROLL) + y * math.cos(ROLL)
        if abs(math.atan(x) - bearing) < 0.006:
            found.append(y * math.cos(math.atan(x)))
    return [min(found), max(found)] if found else []


def _by_bearing(d: Drawing) -> None:
    """The border in sectors of bearing: certain slopes and slopes that are tested."""
    left, width, middle, scale = 478.0, 300.0, 166.0, 170.0
    low, high = -0.72, 0.72

    def place(bearing: float, slope: float) -> Point:
        return left + width * (bearing - low) / (high - low), middle - scale * slope

    d.text(460, 28, "*The border by bearing, of a camera that rolls")
    for sector in range(SECTORS):
        a = low + (high - low) * sector / SECTORS
        b = low + (high - low) * (sector + 1) / SECTORS
        crossings = [_slopes(a + (b - a) * share) for share in (0.02, 0.25, 0.5, 0.75, 0.98)]
        if not all(crossings):
            continue
        bottoms, tops = [c[0] for c in crossings], [c[1] for c in crossings]
        x0, x1 = place(a, 0)[0], place(b, 0)[0]
        for from_slope, to_slope, fill in (
            (min(bottoms), max(tops), PALE_ORANGE), (max(bottoms), min(tops), PALE_BLUE)
        ):  # fmt: skip
            y0, y1 = place(0, to_slope)[1], place(0, from_slope)[1]
            d.box(x0, y0, x1 - x0, y1 - y0, fill)
    for end in (0, 1):
        bearings = [low + (high - low) * step / 120 for step in range(121)]
        points = [place(b, s[end]) for b in bearings if (s := _slopes(b))]
        d.line(points, ORANGE, 2.0)
    d.arrow((left - 12, middle + 132), (left + 88, middle + 132), INK)
    d.text(left + 94, middle + 136, "bearing: which column of the grid", 11)
    d.arrow((left - 12, middle + 132), (left - 12, middle - 110), INK)
    d.text(left - 20, middle - 116, "slope: which levels of it", 11)
    d.text(left - 20, 328, "Blue: inside all over the sector, certain. Orange: the border", 11, GREY)
    d.text(left - 20, 344, "passes here, so rays beside the voxel are tested.", 11, GREY)
