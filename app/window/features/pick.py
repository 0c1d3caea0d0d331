"""A voxel picked on the heatmap: what is known about it follows the rig while it changes."""

from __future__ import annotations

from typing import TYPE_CHECKING, cast

from PySide6.QtWidgets import QWidget

from riglens.app.evaluation.picked import PickedVoxel, sight_text
from riglens.app.evaluation.requests import LoadedScene, Result
from riglens.app.window.actions import Spec
from riglens.app.window.feature import Feature
from riglens.app.window.features.heat import Heat
from riglens.core.scene.boxes import CLASSES
from riglens.widgets.heatmap.pick import PickedCell
from riglens.widgets.panels.scores.text import MINUS
from riglens.widgets.panels.voxel_card import SensorLine, VoxelCard, VoxelText
from riglens.widgets.viewport.marker_layer import Marker

if TYPE_CHECKING:
    from riglens.app.window.main_window import MainWindow
    from riglens.core.scene.voxel import Voxel


class Pick(Feature):
    """Alt+click, or the tool: `voxel` is what evaluations have to explain."""

    specs = (
        Spec(
            "pick", "Pick a voxel", "Click on the heatmap to see who looks there; Alt+click does so at any time",
            "I", "pick", "view/shown", "heat", is_checkable=True,
        ),
    )  # fmt: skip

    mouse = (("Alt and left button on the heatmap", "says who sees that voxel, and why others do not"),)

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        self.voxel: Voxel | None = None
        self._scene: LoadedScene | None = None
        self.card = VoxelCard(cast(QWidget, window.viewport))
        self.bind(pick=self._set_tool)
        self.card.closed.connect(self.clear)
        self.viewport.cell_picked.connect(self._on_picked)
        self.viewport.escaped.connect(self._on_escape)
        window.scene_shown.connect(self._on_scene)
        window.result_shown.connect(self._on_result)
        window.approximation_shown.connect(lambda _: self.card.set_stale())
        window.theme_changed.connect(lambda _: self.card.show_again())

    def clear(self) -> None:
        """Forget the voxel."""
        if self.voxel is not None:
            self.voxel = None
            self.viewport.set_marker(None)
            self.card.show_voxel(None)
            self.window.settings_changed.emit()

    def _set_tool(self) -> None:
        self.viewport.set_picking(self.window.actions_["pick"].isChecked())

    def _on_escape(self) -> None:
        """The first Escape forgets the voxel, the second puts the tool away."""
        if self.voxel is not None:
            self.clear()
        elif self.window.actions_["pick"].isChecked():
            self.window.actions_["pick"].setChecked(False)
            self._set_tool()

    def _on_picked(self, cell: PickedCell | None) -> None:
        if self._scene is None or cell is None:
            self.clear()
            return
        from riglens.core.scene.voxel import (
            voxel_in_cell,  # is there with the scene; the first picture needs it not
        )

        pog = self._scene.heatmaps.display.pog
        cls = CLASSES.index(self.window.feature(Heat).class_name)
        ray = (cell.ray.origin_m, cell.ray.direction)
        self.voxel = voxel_in_cell(pog, cls, cell.centre_m, cell.cell_m, ray)
        x, y, z = (float(pog.grid.centres_m(axis)[place]) for axis, place in enumerate(self.voxel))
        self.viewport.set_marker(Marker((x, y, z), pog.grid.voxel_m))
        self.window.settings_changed.emit()

    def _on_scene(self, scene: LoadedScene) -> None:
        """A voxel of another grid means nothing here."""
        if self._scene is not None and scene.field.grid != self._scene.field.grid:
            self.clear()
        self._scene = scene

    def _on_result(self, result: Result) -> None:
        if result.request.voxel == self.voxel:
            self.card.show_voxel(voxel_text(result.picked) if result.picked is not None else None)


def voxel_text(picked: PickedVoxel) -> VoxelText:
    """What the card says of a voxel."""
    x, y, z = picked.facts.centre_m
    classes = tuple(
        (name, f"{p:.4g}", f"{h:.4g}")
        for name, p, h in zip(CLASSES, picked.facts.p, picked.facts.h_nat, strict=True)
    )
    lines = tuple(
        SensorLine(found.sensor, found.verdict == "sees", sight_text(found)) for found in picked.sights
    )
    summary = f"Seen by {len(picked.seen_by)} of {len(lines)} sensors"
    if not picked.facts.is_informative:
        summary = "No uncertainty here: whoever sees it, no score changes."
    place = f"x {x:.2f} · y {y:.2f} · z {z:.2f} m".replace("-", MINUS)
    return VoxelText(place, classes, summary, lines)
