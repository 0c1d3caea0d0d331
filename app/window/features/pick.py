"""Show the details of a voxel picked on the heatmap, while the rig changes."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from PySide6.QtCore import Qt
from PySide6.QtGui import QShortcut

from riglens.app.window.actions import Spec
from riglens.app.window.feature import Feature
from riglens.app.window.features.frame import FrameView, box_name
from riglens.app.window.workbench import Workbench
from riglens.core.figures.registry import voxel_heat_map
from riglens.core.figures.text import MINUS
from riglens.core.rig.model import Rig
from riglens.core.scene.boxes import CLASSES
from riglens.core.vehicle.solid import Solid
from riglens.evaluation.requests import PickedVoxel, Result, sight_text
from riglens.widgets.heatmap.pick import PickedCell
from riglens.widgets.panels.scene.voxel_card import SensorLine, VoxelCard, VoxelText
from riglens.widgets.traffic.frame import ShownFrame
from riglens.widgets.viewport.scene_state import Marker

if TYPE_CHECKING:
    from riglens.core.engine.sight import Sight
    from riglens.core.scene.columns import Words


FAILED = "failed"
NOBODY_BEFORE: Mapping[str, str] = {}


class Pick(Feature):
    """Alt+click, or the tool: the voxel that is clicked becomes the session's."""

    specs = (
        Spec(
            "pick", "Pick a voxel", "Click on the heatmap to see which sensors cover a place; Alt-click always works.",
            "I", "pick", "view/shown", "heat", is_checkable=True,
        ),
    )  # fmt: skip

    mouse = (
        ("Alt and left button on the heatmap", "shows which sensors cover that voxel, and why others do not"),
    )

    def __init__(self, bench: Workbench, frame: FrameView) -> None:
        super().__init__(bench)
        self.card = VoxelCard(self.viewport)
        self._drawn: Result | None = None
        self._escape = QShortcut(Qt.Key.Key_Escape, bench.window, self.clear)  # wherever the focus is
        self._escape.setEnabled(False)
        self.bind(pick=self._set_tool)
        self.card.closed.connect(self.clear)
        self.viewport.cell_picked.connect(self._on_picked)
        self.viewport.escaped.connect(self._on_escape)
        self.session.voxel_changed.connect(self._show_voxel)
        bench.answers.answered.connect(self._on_result)
        frame.drawn.connect(self._on_frame)
        bench.answers.approximated.connect(lambda _: self.card.set_stale())
        bench.theme_changed.connect(lambda _: self.card.show_again())

    def clear(self) -> None:
        """Forget the voxel."""
        self.session.pick(None)

    def _set_tool(self) -> None:
        self.viewport.set_tool("pick", self.actions["pick"].isChecked())

    def _on_escape(self) -> None:
        """Clear the voxel on the first Escape and put the tool away on the second."""
        if self.session.voxel is not None:
            self.clear()
        elif self.actions["pick"].isChecked():
            self.actions["pick"].setChecked(False)
            self._set_tool()

    def _on_picked(self, cell: PickedCell | None) -> None:
        scene = self.session.scene
        is_of_scene = self._drawn is None or self._drawn.scene is scene  # new data have come, cells have not
        if scene is None or cell is None or not is_of_scene:
            self.clear()
            return
        from riglens.core.metric.voxel import (
            voxel_in_cell,  # loaded with the scene: not while the window opens
        )

        cls = CLASSES.index(
            self.session.heat.class_name if self._drawn is None else self._drawn.request.heat_class
        )
        ray = (cell.ray.origin_m, cell.ray.direction)
        pog = scene.heatmaps.display.pog
        self.session.pick(voxel_in_cell(pog, cls, cell.centre_m, cell.cell_m, ray, self._meant(cell)))

    def _meant(self, cell: PickedCell) -> Words | None:
        """Return the voxels that a click on a drawn cell may mean; None when any may be meant."""
        drawn = self._drawn
        heat = None if drawn is None else voxel_heat_map(drawn.request.heat)
        if drawn is None or drawn.marks is None or heat is None:
            return None
        value = 0.0 if drawn.heatmap is None else float(drawn.heatmap.values[cell.row])
        return heat.meant(drawn.marks, value)

    def _show_voxel(self) -> None:
        """Mark the voxel; its details come with the next result."""
        voxel, marker = self.session.voxel, None
        self._escape.setEnabled(voxel is not None)
        if voxel is None:
            self.card.show_voxel(None)
        elif self.session.scene is not None:
            grid = self.session.scene.heatmaps.display.pog.grid
            x, y, z = (float(grid.centres_m(axis)[place]) for axis, place in enumerate(voxel))
            marker = Marker((x, y, z), grid.voxel_m)
        self.viewport.show_state(replace(self.viewport.state, marker=marker))

    def _on_result(self, result: Result) -> None:
        self._drawn = result
        if result.request.voxel == self.session.voxel:
            self._show_card(result.picked)

    def _on_frame(self) -> None:
        """Update the text of a shown voxel: other objects hide it in this frame."""
        drawn = self._drawn
        if self.card.text is not None and drawn is not None and drawn.request.voxel == self.session.voxel:
            self._show_card(drawn.picked)

    def _show_card(self, picked: PickedVoxel | None) -> None:
        traffic = self.viewport.state.traffic
        hidden = (
            {}
            if picked is None or traffic is None or traffic.is_plain
            else hidden_from(picked, self._rig(), traffic)
        )
        self.card.show_voxel(None if picked is None else voxel_text(picked, hidden, self.document.failed))

    def _rig(self) -> Rig:
        assert self._drawn is not None
        return self._drawn.request.rig


def hidden_from(picked: PickedVoxel, rig: Rig, frame: ShownFrame) -> dict[str, str]:
    """Return what hides the centre of a voxel from each sensor that covers it, in the frame shown, in words by name."""
    from riglens.core.view.frames import FrameBoxes
    from riglens.core.view.hits import cast

    boxes = FrameBoxes(frame.cls, frame.centre_m, frame.size_m, frame.rotation)
    nothing, found = Solid.of(np.zeros((0, 3, 3))), dict[str, str]()
    for name in picked.seen_by:
        sensor = rig.sensor(name)
        away = np.array(picked.facts.centre_m) - np.array(sensor.position)
        far_m = float(np.linalg.norm(away))
        barrier = nothing.barrier(sensor.kind, 0.0)
        what = int(
            cast(sensor.position, (away / far_m)[None], boxes, barrier, (0.0, far_m), has_ground=False).what[
                0
            ]
        )
        if what >= 0:
            found[name] = box_name(int(frame.cls[what]), frame.centre_m[what])
    return found


def voxel_text(
    picked: PickedVoxel,
    hidden: Mapping[str, str] = NOBODY_BEFORE,
    failed: Collection[str] = (),
) -> VoxelText:
    """Return the text of a voxel's card; `hidden` is what hides it in the frame shown, by sensor, `failed` are the
    sensors that are off because they are taken as failed."""
    x, y, z = picked.facts.centre_m
    classes = tuple(
        (name, f"{p:.4g}", f"{h:.4g}")
        for name, p, h in zip(CLASSES, picked.facts.p, picked.facts.h_nat, strict=True)
    )
    lines = tuple(
        SensorLine(found.sensor, found.verdict == "sees", _sight_text(found, hidden, failed))
        for found in picked.sights
    )
    summary = f"Seen by {len(picked.seen_by)} of {len(lines)} sensors"
    if not picked.facts.is_informative:
        summary = "No uncertainty here: coverage does not change any score."
    place = f"x {x:.2f} · y {y:.2f} · z {z:.2f} m".replace("-", MINUS)
    return VoxelText(place, classes, summary, lines)


def _sight_text(found: Sight, hidden: Mapping[str, str], failed: Collection[str]) -> str:
    if found.verdict == "off" and found.sensor in failed:
        return FAILED
    before = hidden.get(found.sensor)
    return sight_text(found) if before is None else f"sees it, in this frame behind {before}"
