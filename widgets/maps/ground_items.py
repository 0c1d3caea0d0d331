"""Draw figures of objects on the map from above: colours, legend and labels."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QRectF
from PySide6.QtGui import QPainter

from riglens.widgets.maps.paint import SHARE_MAP, colours, draw_bar
from riglens.widgets.theme import Tones

if TYPE_CHECKING:  # made by the thread that counts, which loads the compiler
    from riglens.core.figures.heatmaps import OverGround

COUNT_MAP = "inferno"


def ground_colours(shown: OverGround) -> NDArray[np.uint32]:
    """Return the colour of each cell (nx, ny), 0xAARRGGBB; nothing where no object is near."""
    share = np.nan_to_num(shown.values) / shown.top
    found = colours(_map_of(shown))[np.clip(np.rint(255.0 * share), 0, 255).astype(np.int64)]
    return np.asarray(np.where(shown.objects > 0, found, 0), np.uint32)


def _map_of(shown: OverGround) -> str:
    return COUNT_MAP if shown.heat.are_counted else SHARE_MAP


def draw_ground_legend(painter: QPainter, area: QRectF, shown: OverGround, tones: Tones) -> None:
    """Draw the colour bar with its unit and the way in which it gets better."""
    heat = shown.heat
    unit = "" if heat.are_counted else heat.unit
    end = " ".join(filter(None, (f"{shown.top:,.4g}", unit, heat.on_map)))
    draw_bar(painter, area, _map_of(shown), [(0.0, "0"), (0.5, heat.direction), (1.0, end)], tones)


def ground_text(shown: OverGround, place_m: tuple[float, float]) -> str:
    """Describe a place of the ground."""
    heat, ground = shown.heat, shown.ground
    cell = ground.cell_at(*place_m)
    objects = 0 if cell is None else int(shown.objects[cell])
    if cell is None or not objects:
        return f"no {ground.class_name} within {ground.near_m:g} m"
    near = f"of {objects:,} within {ground.near_m:g} m"
    if heat.are_counted:
        return f"{int(shown.values[cell]):,} {near}: {heat.on_map}"
    return f"{shown.values[cell]:.1f} {heat.unit} {heat.on_map}, mean {near}"


def summary_of(shown: OverGround) -> str:
    """Describe the map."""
    heat, ground = shown.heat, shown.ground
    what = heat.on_map if heat.are_counted else f"{heat.on_map}: mean"
    return f"{what} of those within {ground.near_m:g} m, {ground.frames:,} frames"
