"""Where the names of the chart's points go: near their points, and free of marks, fronts and other names."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

from matplotlib.axes import Axes
from matplotlib.patheffects import withStroke
from matplotlib.transforms import Bbox

from riglens.core.study.accuracy_points import Point, Study
from riglens.core.study.accuracy_text import point_text

Pixel = tuple[float, float]
INK, GREY = "#222222", "#6b6b6b"
DPI = 160
PIXELS_PER_POINT = DPI / 72
LEADER_FROM_PX = 40.0


def place_labels(
    axes: Axes,
    places: Sequence[tuple[Point, float]],
    front: Sequence[tuple[float, float]],
    study: Study,
) -> None:
    """Write each point's name beside it where it covers neither a mark, nor the front, nor another name."""
    taken = [_mark_box(axes, point, x, study) for point, x in places] + _front_boxes(axes, front)
    frame = axes.get_window_extent()
    for point, x in sorted(places, key=lambda place: (place[0] is not study.own, place[0].median_ms)):
        text = axes.annotate(
            point_text(point, study),
            (x, point.median_ms),
            xytext=(0, 0),
            textcoords="offset points",
            fontsize=9,
            fontweight="bold" if point is study.own else "normal",
            color=INK,
            zorder=6,
            path_effects=[withStroke(linewidth=2.5, foreground="white")],
        )
        size = text.get_window_extent()
        centre = _pixels(axes, x, point.median_ms)
        offset = _free_offset(centre, size, taken, frame)
        text.set_position((offset[0] / PIXELS_PER_POINT, offset[1] / PIXELS_PER_POINT))
        taken.append(_label_box(centre, offset, size))
        _draw_leader(axes, centre, taken[-1])
        taken += _leader(centre, taken[-1])


def _pixels(axes: Axes, x: float, y: float) -> Pixel:
    place = axes.transData.transform((x, y))
    return float(place[0]), float(place[1])


def _mark_box(axes: Axes, point: Point, x: float, study: Study) -> Bbox:
    """Where a mark is, in pixels."""
    cx, cy = _pixels(axes, x, point.median_ms)
    half = (9.0 if point is study.own else 6.5) * PIXELS_PER_POINT
    return Bbox.from_extents(cx - half, cy - half, cx + half, cy + half)


def _front_boxes(axes: Axes, front: Sequence[tuple[float, float]]) -> list[Bbox]:
    """The steps of the front as thin boxes, in pixels."""
    corners = [_pixels(axes, x, y) for x, y in front]
    boxes = []
    for (x0, y0), (x1, y1) in pairwise(corners):
        boxes.append(Bbox.from_extents(x0, y0 - 2, x1, y0 + 2))
        boxes.append(Bbox.from_extents(x1 - 2, y1, x1 + 2, y0))
    return boxes


def _label_box(centre: Pixel, offset: Pixel, size: Bbox) -> Bbox:
    return Bbox.from_bounds(centre[0] + offset[0], centre[1] + offset[1], size.width, size.height)


def _free_offset(centre: Pixel, size: Bbox, taken: Sequence[Bbox], frame: Bbox) -> Pixel:
    """Offset in pixels of a label's lower left corner: near its point, free of others, inside the frame."""
    best, least = (22.0, -size.height / 2), math.inf
    others = [box for box in taken if not box.contains(*centre)]
    for distance in (17.0, 22.0, 30.0, 44.0, 64.0, 90.0, 120.0, 160.0):
        for turn in range(24):
            dx, dy = math.cos(turn * math.pi / 12), math.sin(turn * math.pi / 12)
            x = distance * dx - size.width * (1.0 - dx) / 2
            y = distance * dy - size.height * (1.0 - dy) / 2
            box = _label_box(centre, (x, y), size)
            clashes = sum(box.padded(3).overlaps(other) for other in taken)
            pieces = _leader(centre, box)
            crossed = sum(any(piece.overlaps(other) for piece in pieces) for other in others)
            cost = (
                1000.0 * clashes
                + 200.0 * crossed
                + 100.0 * _outside(box, frame)
                + distance
                + 4.0 * (1.0 - dx)
            )
            if cost < least:
                best, least = (x, y), cost
    return best


def _outside(box: Bbox, frame: Bbox) -> float:
    """By how many pixels a box leaves the frame."""
    sideways = max(0.0, frame.x0 - box.x0) + max(0.0, box.x1 - frame.x1)
    updown = max(0.0, frame.y0 + 4 - box.y0) + max(0.0, box.y1 - frame.y1)
    return float(sideways + updown)


def _nearest(centre: Pixel, box: Bbox) -> Pixel:
    return min(max(centre[0], box.x0), box.x1), min(max(centre[1], box.y0), box.y1)


def _leader(centre: Pixel, box: Bbox) -> list[Bbox]:
    """The line from a point to its name as small boxes; none where the name stands beside the point."""
    end = _nearest(centre, box)
    if math.dist(centre, end) < LEADER_FROM_PX:
        return []
    steps = [(k + 0.5) / 12 for k in range(12)]
    ways = [(centre[0] + s * (end[0] - centre[0]), centre[1] + s * (end[1] - centre[1])) for s in steps]
    return [Bbox.from_extents(x - 2, y - 2, x + 2, y + 2) for x, y in ways]


def _draw_leader(axes: Axes, centre: Pixel, box: Bbox) -> None:
    """A thin line from a point to its name where the name stands away from it."""
    if _leader(centre, box):
        ends = axes.transData.inverted().transform([centre, _nearest(centre, box)])
        axes.plot(ends[:, 0], ends[:, 1], color=GREY, lw=0.7, zorder=3)
