"""Names of points in a chart: near their points, free of marks, lines and other names, and the same each time."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from matplotlib.axes import Axes
from matplotlib.text import Annotation
from matplotlib.transforms import Bbox
from numpy.typing import NDArray

GREY = "#6b6b6b"
Pixel = tuple[float, float]
Doubles = NDArray[np.float64]
Boxes = NDArray[np.float64]
"""Left, low, right and high ends of each, in pixels."""
TURNS, PIECES = 24, 12
DISTANCES_PT = (7.65, 9.9, 13.5, 19.8, 28.8, 40.5, 54.0, 72.0)
FAR_PT = 18.0
"""A line leads to a name that is farther from its point than this."""


def set_beside(axes: Axes, text: Annotation, centre: Pixel, taken: Boxes, frame: Bbox) -> Boxes:
    """Put an annotation, whose offset is in points, near its point, with a line to it where it is far.

    centre, taken (n, 4), frame: the point, what names may not cover and what they may not leave, in pixels of the
    figure as it is drawn. Returns all that is taken then: the name and its line as well.
    """
    unit = float(axes.figure.dpi) / 72.0
    size = np.array(text.get_window_extent().size)
    low = _free_place(np.array(centre), size, taken, frame, unit)
    text.set_position(tuple((low - centre) / unit))
    box = np.concatenate([low, low + size])[None]
    pieces, is_far = _leaders(np.array(centre), box, unit)
    if not is_far[0]:
        return np.concatenate([taken, box])
    end = np.clip(centre, box[0, :2], box[0, 2:])
    ends = axes.transData.inverted().transform(np.stack([np.array(centre), end]))
    axes.plot(ends[:, 0], ends[:, 1], color=GREY, lw=0.7, zorder=3)
    return np.concatenate([taken, box, pieces[0]])


def boxes_of(boxes: Iterable[Bbox]) -> Boxes:
    """Return boxes as an array (n, 4) of left, low, right and high ends."""
    return np.array([box.extents for box in boxes]).reshape(-1, 4)


def _free_place(centre: Doubles, size: Doubles, taken: Boxes, frame: Bbox, unit: float) -> Doubles:
    """Lower left corner of a label (2,): near its point, free of others, inside the frame."""
    turns = np.arange(TURNS) * 2.0 * np.pi / TURNS
    ways = np.stack([np.cos(turns), np.sin(turns)], axis=1)
    distances = unit * np.array(DISTANCES_PT)[:, None, None]
    low = (centre + distances * ways - size * (1.0 - ways) / 2).reshape(-1, 2)
    boxes = np.concatenate([low, low + size], axis=1)
    room = 1.35 * unit * np.array([-1.0, -1.0, 1.0, 1.0])
    clashes = _overlap(boxes + room, taken).sum(axis=1)
    holds = (taken[:, :2] <= centre).all(axis=1) & (centre <= taken[:, 2:]).all(axis=1)
    pieces, is_far = _leaders(centre, boxes, unit)
    crossed = _overlap(pieces.reshape(-1, 4), taken[~holds]).reshape(len(boxes), PIECES, -1).any(axis=1)
    floor = frame.min + np.array([0.0, 1.8 * unit])
    outside = np.maximum(floor - low, 0.0) + np.maximum(low + size - frame.max, 0.0)
    leaves = outside.sum(axis=1)
    away = np.repeat(distances.ravel(), TURNS) / unit + 1.8 * np.tile(1.0 - ways[:, 0], len(DISTANCES_PT))
    cost = (
        1000.0 * clashes
        + 400.0 * crossed.sum(axis=1) * is_far
        + 500.0 * (leaves > 0.0)
        + 45.0 * leaves / unit
        + 2.2 * away
    )
    return np.asarray(low[int(np.argmin(cost))])


def _overlap(some: Boxes, others: Boxes) -> NDArray[np.bool_]:
    """Return which boxes (n, 4) overlap which others (m, 4)."""
    some, others = some[:, None], others[None]
    return np.asarray((some[..., :2] < others[..., 2:]).all(-1) & (others[..., :2] < some[..., 2:]).all(-1))


def _leaders(centre: Doubles, boxes: Boxes, unit: float) -> tuple[Doubles, NDArray[np.bool_]]:
    """Return the lines from a point to boxes (n, 4) as small boxes (n, PIECES, 4), and which are so far as to need
    one."""
    ends = np.clip(centre, boxes[:, :2], boxes[:, 2:])
    steps = ((np.arange(PIECES) + 0.5) / PIECES)[None, :, None]
    at = centre + steps * (ends - centre)[:, None]
    half = 0.9 * unit
    return np.concatenate([at - half, at + half], axis=2), np.hypot(*(ends - centre).T) >= FAR_PT * unit
