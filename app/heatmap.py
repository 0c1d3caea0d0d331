"""Which cells of the display grid are drawn, and in what colours; the same for window and pictures."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from core.engine.engine import Evaluation
from core.scene.boxes import CLASSES
from core.scene.display import DisplayGrid
from widgets.viewport.heatmap_layer import HeatmapData

HeatMode = Literal["off", "probability", "entropy", "seen"]
HEAT_TITLES: dict[HeatMode, str] = {
    "off": "Off",
    "probability": "POG probability",
    "entropy": "Entropy",
    "seen": "Seen entropy",
}
Values = NDArray[np.float32]


def heatmap(
    display: DisplayGrid, evaluation: Evaluation, mode: HeatMode, class_name: str
) -> HeatmapData | None:
    """One heatmap for one picture; None when the mode is "off"."""
    return Heatmaps(display).heatmap(mode, class_name, evaluation)


@dataclass(frozen=True)
class _Base:
    """What does not change in a drag: the cells with anything in them, their full values and the scale."""

    shown: NDArray[np.bool_]
    centres_m: Values
    full: Values
    vmax: float


class Heatmaps:
    """Makes heatmaps on a display grid.

    Which cells are shown depends on mode and class only, and they come back as the same array, so that a view
    has to change nothing but values in a drag.
    """

    def __init__(self, display: DisplayGrid) -> None:
        self._display = display
        self._bases: dict[tuple[bool, str], _Base] = {}

    def heatmap(self, mode: HeatMode, class_name: str, evaluation: Evaluation) -> HeatmapData | None:
        """What to draw for a mode; None when it is "off"."""
        if mode == "off":
            return None
        is_probability = mode == "probability"
        base = self._base(is_probability, class_name)
        values = base.full
        if mode == "seen":
            seen = evaluation.seen_camera | evaluation.seen_lidar
            values = values * self._display.seen_share(CLASSES.index(class_name), seen)[base.shown]
        return HeatmapData(
            centres_m=base.centres_m,
            cell_m=self._display.cell_m,
            values=values,
            title=f"{HEAT_TITLES[mode]}, {class_name}",
            unit="" if is_probability else "nat per cell",
            vmin=0.0,
            vmax=base.vmax,
            note=self._note("largest" if is_probability else "sum"),
        )

    def _base(self, is_probability: bool, class_name: str) -> _Base:
        key = (is_probability, class_name)
        if key not in self._bases:
            cls = CLASSES.index(class_name)
            full = self._display.probability(cls) if is_probability else self._display.entropy(cls)
            shown = full > 0
            centres_m = np.ascontiguousarray(self._display.centres_m[shown])
            self._bases[key] = _Base(shown, centres_m, full[shown], float(full.max(initial=0.0)) or 1.0)
        return self._bases[key]

    def _note(self, how: str) -> str:
        """Which grid the picture shows; the scores always use the full one."""
        cell_m, block = self._display.cell_m, self._display.block
        return f"cells of {cell_m:g} m" if block == 1 else f"cells of {cell_m:g} m, {how} of {block}³ voxels"
