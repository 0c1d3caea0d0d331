"""Draw the LiDARs' figures of objects on the map from above: colours, legend and labels."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QRectF
from PySide6.QtGui import QPainter

from riglens.widgets.maps.paint import SHARE_MAP, colours, draw_bar
from riglens.widgets.theme import Tones

if TYPE_CHECKING:  # made by the thread that counts, which loads the compiler
    from riglens.core.targets.ground import GroundView

MISSED_MAP = "inferno"
ON_TARGET = "on_target"


def ground_colours(ground: GroundView, mode: str) -> NDArray[np.uint32]:
    """Return the colour of each cell (nx, ny), 0xAARRGGBB; nothing where no object is near."""
    if mode == ON_TARGET:
        share, table = np.nan_to_num(ground.on_target), colours(SHARE_MAP)
    else:
        share, table = ground.missed / most_missed(ground), colours(MISSED_MAP)
    found = table[np.clip(np.rint(255.0 * share), 0, 255).astype(np.int64)]
    return np.asarray(np.where(ground.objects > 0, found, 0), np.uint32)


def most_missed(ground: GroundView) -> int:
    """Return the end of the scale of missed objects."""
    return max(int(ground.missed.max(initial=0)), 1)


def draw_ground_legend(painter: QPainter, area: QRectF, ground: GroundView, mode: str, tones: Tones) -> None:
    """Draw the colour bar with its unit and the way in which it gets better."""
    if mode == ON_TARGET:
        marks = [(0.0, "0"), (0.5, "more is better"), (1.0, "100 % on target")]
        draw_bar(painter, area, SHARE_MAP, marks, tones)
    else:
        most = most_missed(ground)
        marks = [(0.0, "0"), (0.5, "less is better"), (1.0, f"{most:,} missed")]
        draw_bar(painter, area, MISSED_MAP, marks, tones)


def ground_text(ground: GroundView, mode: str, place_m: tuple[float, float]) -> str:
    """Describe a place of the ground."""
    cell = ground.cell_at(*place_m)
    objects = 0 if cell is None else int(ground.objects[cell])
    if cell is None or not objects:
        return f"no {ground.class_name} within {ground.near_m:g} m"
    near = f"of {objects:,} within {ground.near_m:g} m"
    if mode == ON_TARGET:
        return f"{100.0 * ground.on_target[cell]:.1f} % on target, mean {near}"
    return f"{int(ground.missed[cell]):,} {near} have fewer than {ground.min_points} points"


def summary_of(ground: GroundView, mode: str) -> str:
    """Describe the map."""
    what = "on target: mean" if mode == ON_TARGET else f"objects with fewer than {ground.min_points} points"
    return f"{what} of those within {ground.near_m:g} m, {ground.frames:,} frames"
