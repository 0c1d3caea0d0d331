"""Show figures of objects as a heatmap and on the map, from all frames; none of it is computed in a drag."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from riglens.app.window.feature import Feature
from riglens.app.window.features.heat import Heat
from riglens.app.window.features.maps import Map
from riglens.app.window.features.targets import Targets
from riglens.app.window.workbench import Workbench
from riglens.core.figures.heatmaps import ObjectHeatMap
from riglens.core.scene.boxes import CLASSES

if TYPE_CHECKING:  # made by the thread that counts, which loads the compiler
    from riglens.core.targets.ground import GroundView

COUNTING = "Counting the objects of all frames"


class TargetMaps(Feature):
    """Show the last counts of all frames, marked while those of an edit are pending."""

    def __init__(self, bench: Workbench, heat: Heat, targets: Targets, map_: Map) -> None:
        super().__init__(bench)
        self._heat, self._targets, self._map, self._map_in_sight = heat, targets, map_.panel, map_.in_sight
        self._ground: tuple[GroundView, ...] = ()
        self._shown: tuple[object, ...] = ()
        targets.counted.connect(self._take)
        self.session.heat_changed.connect(self._show)
        self._map.shown_chosen.connect(self._show)
        map_.in_sight.changed.connect(lambda _: self._show())

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
        heat, on_map = self.session.heat, self._map.of_objects
        of_objects = heat.map if isinstance(heat.map, ObjectHeatMap) else None
        seen = (of_objects, on_map if self._map_in_sight else None)
        with_losses = any(one is not None and one.with_losses for one in seen)
        self._targets.want_losses(with_losses)
        ground = self._ground[CLASSES.index(heat.class_name)] if self._ground else None
        if with_losses and ground is not None and ground.counted.losses is None:
            ground = None
        now = (of_objects, on_map, ground, self._targets.is_current)
        if now == self._shown:
            return
        self._shown = now
        if of_objects is not None:
            data = (
                None if ground is None else of_objects.data(of_objects.over(ground), self._targets.is_current)
            )
            self.viewport.show_state(replace(self.viewport.state, heatmap=data))
            self._heat.panel.set_data(data)
        if on_map is not None:
            self._map.set_class(heat.class_name)
            self._map.map.set_message("" if ground is not None else COUNTING)
        self._map.map.set_ground(None if on_map is None or ground is None else on_map.over(ground))
