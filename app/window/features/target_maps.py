"""Show figures of objects as a heatmap and on the map, from all frames; none of it is computed in a drag."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from riglens.app.window.feature import Feature
from riglens.app.window.features.heat import Heat
from riglens.app.window.features.maps import Map
from riglens.app.window.features.targets import Targets
from riglens.app.window.workbench import Workbench
from riglens.core.scene.boxes import CLASSES
from riglens.evaluation.options import TARGET_HEAT_TITLES
from riglens.widgets.heatmap.scale import HeatmapData

if TYPE_CHECKING:  # made by the thread that counts, which loads the compiler
    from riglens.core.targets.ground import GroundView

FAINTEST = 0.35
"""Opacity of cells with almost no objects, as a share of that of the others: hit coverage is also visible there."""
COUNTING = "Counting the objects of all frames"


class TargetMaps(Feature):
    """Show the last counts of all frames, marked while those of an edit are pending."""

    def __init__(self, bench: Workbench, heat: Heat, targets: Targets, map_: Map) -> None:
        super().__init__(bench)
        self._heat, self._targets, self._map = heat, targets, map_.panel
        self._ground: tuple[GroundView, ...] = ()
        self._shown: tuple[object, ...] = ()
        targets.counted.connect(self._take)
        self.session.heat_changed.connect(self._show)
        self._map.shown_chosen.connect(self._show)

    def _take(self) -> None:
        """Take the counts of all frames; without any answer there is nothing to show."""
        answer = self._targets.answer
        if answer is None:
            self._ground = ()
        elif answer.ground:
            self._ground = answer.ground
        self._show()

    def forget_scene(self) -> None:
        """Forget the maps of earlier traffic."""
        self._ground, self._shown = (), ()
        self._show()

    def _show(self) -> None:
        """Show heatmap and map if they are enabled, unless they are shown already."""
        heat, on_map = self.session.heat, self._map.target_mode
        mode = heat.mode if heat.mode in TARGET_HEAT_TITLES else ""
        ground = self._ground[CLASSES.index(heat.class_name)] if self._ground else None
        now = (mode, on_map, ground, self._targets.is_current)
        if now == self._shown:
            return
        self._shown = now
        if mode:
            self._show_heatmap(mode, ground)
        if on_map:
            self._map.set_class(heat.class_name)
            self._map.map.set_message("" if ground is not None else COUNTING)
        self._map.map.set_ground(ground if on_map else None, on_map)

    def _show_heatmap(self, mode: str, ground: GroundView | None) -> None:
        data = None if ground is None else heatmap_of(mode, ground, self._targets.is_current)
        self.viewport.show_state(replace(self.viewport.state, heatmap=data))
        self._heat.panel.set_data(data)


def heatmap_of(mode: str, ground: GroundView, is_current: bool = True) -> HeatmapData:
    """Return the cells on the ground with objects near them; `is_current`: no edit is being counted."""
    ix, iy = np.nonzero(ground.objects)
    x_m, y_m = (low + (i + 0.5) * ground.cell_m for low, i in zip(ground.origin_m, (ix, iy), strict=True))
    centres_m = np.stack([x_m, y_m, np.full(len(ix), ground.cell_m / 2)], axis=1).astype(np.float32)
    title = f"{'Missed' if mode == 'missed' else 'On target'}, {ground.class_name}"
    near = f"within {ground.near_m:g} m" if is_current else "recounting"
    if mode == "missed":
        values = ground.missed[ix, iy].astype(np.float32)
        return HeatmapData(
            centres_m, ground.cell_m, values, title, "objects", 0.0, max(float(values.max(initial=0.0)), 1.0),
            f"less is better · < {ground.min_points} points, {near}",
        )  # fmt: skip
    many = ground.objects[ix, iy] / max(int(ground.objects.max(initial=1)), 1)
    weights = (FAINTEST + (1.0 - FAINTEST) * np.sqrt(many)).astype(np.float32)
    return HeatmapData(
        centres_m, ground.cell_m, (100.0 * ground.on_target[ix, iy]).astype(np.float32), title, "%", 0.0, 100.0,
        f"more is better · objects {near}", scale="level", weights=weights,
    )  # fmt: skip
