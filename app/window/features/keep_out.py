"""View > Keep-out zones: shown on the car, and painted there with a brush."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

from riglens.app.window.actions import Spec
from riglens.app.window.feature import Feature
from riglens.app.window.features.mounts import Mounts
from riglens.app.window.settings import Settings
from riglens.app.window.workbench import Workbench
from riglens.core.geometry import Vec3
from riglens.core.rig.model import MAX_SPOTS, Spot
from riglens.widgets.car.keep_out import Box, KeepOut, Zone

if TYPE_CHECKING:  # loads the compiler
    from riglens.core.blind.outline import Outline
    from riglens.core.review.mounts import KeepOut as Required

RADII_M = {"brush_small": 0.05, "brush_medium": 0.10, "brush_large": 0.20}
"""Of the spots that a brush leaves: our choice."""
HINT = (
    "Paint keep-out zones on the car; start on a painted spot to erase. Drag off the car to "
    "turn the view; Esc ends painting."
)
FULL = f"The rig holds {MAX_SPOTS} spots already: erase some, or paint with a larger brush"
OTHER_TOOLS = ("pick", "measure")


class KeepOutZones(Feature):
    """Amber: zones of the usual limits on mounts, or of their file; red: spots of the rig itself, kept in its file.

    A stroke is one undo step. Nothing is done while the zones are out of sight.
    """

    specs = (
        Spec(
            "keep_out_shown", "Show on the car",
            "Colour the keep-out zones: amber by the mount limits (Checks > Mounts), red as painted.",
            menu="view", is_checkable=True,
        ),
        Spec(
            "keep_out_paint", "Paint on the car",
            "Paint keep-out zones with the left button; start on a painted spot to erase.",
            menu="view", is_checkable=True,
        ),
        *(
            Spec(key, f"Brush of {200 * radius_m:.0f} cm", "Diameter of the spots.", menu="view", group="brush")
            for key, radius_m in RADII_M.items()
        ),
        Spec("keep_out_clear", "Erase all painted zones", "Undo restores them.", menu="view"),
    )  # fmt: skip

    mouse = (
        ("Painting keep-out zones: left button on the car", "paints, or erases if started on a painted spot"),
    )

    def __init__(self, bench: Workbench, mounts: Mounts) -> None:
        super().__init__(bench)
        self._mounts = mounts
        self._brush = "brush_medium"
        self._stroke: tuple[Spot, ...] | None = None
        self._is_erasing = False
        self._zones: tuple[object, tuple[Zone, ...]] | None = None
        actions = [self.actions[spec.key] for spec in self.specs]
        bench.places.add_submenu("view/shown", "Keep-out zones", actions)
        self.actions[self._brush].setChecked(True)
        self.bind(
            keep_out_shown=self._show_or_hide,
            keep_out_paint=self._switch,
            keep_out_clear=lambda: self.document.apply(self.document.rig.replace(keep_out=())),
            **{key: partial(self._take_brush, key) for key in RADII_M},
        )
        self.viewport.brushed.connect(self._on_brushed)
        self.viewport.brush_ended.connect(self._on_ended)
        self.viewport.escaped.connect(self.end)
        self.document.opened.connect(self.end)
        for tool in OTHER_TOOLS:
            self.actions[tool].toggled.connect(lambda is_on: self.end() if is_on else None)

    # ------------------------------------------------------------------ what is shown
    def _show_or_hide(self) -> None:
        """Follow rig, car and limits while the zones are in sight, and not otherwise."""
        is_shown = self.actions["keep_out_shown"].isChecked()
        for changed in (self.document.rig_changed, self.session.asked_changed, self._mounts.limits_changed):
            if is_shown:
                changed.connect(self._show)
            else:
                changed.disconnect(self._show)
        if not is_shown:
            self.end()
        self._show()

    def _show(self) -> None:
        shown = None
        if self.actions["keep_out_shown"].isChecked():
            spots = self.document.rig.keep_out if self._stroke is None else self._stroke
            shown = KeepOut(self._zones_now(), spots)
        if shown != self.viewport.state.keep_out:
            self.viewport.show_state(replace(self.viewport.state, keep_out=shown))

    def _zones_now(self) -> tuple[Zone, ...]:
        """Return the zones of the mount limits, in metres of the current car; none while its mesh is missing."""
        vehicle, asked = self.session.rig.vehicle, self._mounts.keep_out
        if vehicle.lacks_mesh:
            return ()
        key = (vehicle, asked)
        if self._zones is None or self._zones[0] != key:
            from riglens.core.blind.outline import Outline

            outline = Outline.of(vehicle)
            self._zones = (key, tuple(zone_of(one, outline, vehicle.height) for one in asked))
        return self._zones[1]

    def restore(self, settings: Settings) -> None:
        if settings.read("keep_out/shown", False):
            self.actions["keep_out_shown"].trigger()

    def keep(self, settings: Settings) -> None:
        settings.write("keep_out/shown", self.actions["keep_out_shown"].isChecked())

    # ------------------------------------------------------------------ painting
    def _switch(self) -> None:
        if not self.actions["keep_out_paint"].isChecked():
            self._put_away()
            return
        for tool in OTHER_TOOLS:
            if self.actions[tool].isChecked():
                self.actions[tool].trigger()  # one tool takes the mouse
        if not self.actions["keep_out_shown"].isChecked():
            self.actions["keep_out_shown"].trigger()
        self.viewport.set_tool("paint", True)
        self.bench.status.showMessage(HINT)

    def end(self) -> None:
        """Stop painting."""
        if self.actions["keep_out_paint"].isChecked():
            self.actions["keep_out_paint"].setChecked(False)
            self._put_away()

    def _put_away(self) -> None:
        self.viewport.set_tool("paint", False)
        self.bench.status.clearMessage()

    def _take_brush(self, key: str) -> None:
        self._brush = key
        self.actions[key].setChecked(True)

    def _on_brushed(self, point_m: Vec3, begins: bool) -> None:
        """Paint or erase where the brush touches the car; the start of a stroke decides which."""
        if begins:
            self._stroke = self.document.rig.keep_out
            self._is_erasing = any(covers(spot, point_m) for spot in self._stroke)
        if self._stroke is None:
            return
        if self._is_erasing:
            self._stroke = tuple(spot for spot in self._stroke if not covers(spot, point_m))
        else:
            self._paint(point_m)
        self._show()

    def _paint(self, point_m: Vec3) -> None:
        """Leave a spot, unless there is one of the same size half a radius from here."""
        assert self._stroke is not None
        radius_m = RADII_M[self._brush]
        near = (s for s in self._stroke if s[3] >= radius_m and math.dist(s[:3], point_m) < radius_m / 2.0)
        if any(near):
            return
        if len(self._stroke) >= MAX_SPOTS:
            self.bench.status.showMessage(FULL)
            return
        x, y, z = (round(value, 3) for value in point_m)
        self._stroke = (*self._stroke, (x, y, z, radius_m))

    def _on_ended(self, kept: bool) -> None:
        """Commit the stroke as one undo step, if it changed anything."""
        stroke, self._stroke = self._stroke, None
        if stroke is not None and kept:
            self.document.apply(self.document.rig.replace(keep_out=stroke))
        self._show()


def covers(spot: Spot, point_m: Vec3) -> bool:
    """Return whether a place lies within a spot."""
    return math.dist(spot[:3], point_m) <= spot[3]


def zone_of(asked: Required, outline: Outline, height_m: float) -> Zone:
    """Return the zone with its boxes in metres instead of shares of the car."""

    def corner(end: int, box: tuple[tuple[float, float], ...]) -> Vec3:
        x, y, z = (span[end] for span in box)
        return (
            outline.rear_m + x * outline.length_m,
            outline.right_m + y * outline.width_m,
            z * height_m,
        )

    spans = [(box.x, box.y, box.z) for box in asked.boxes]
    boxes: tuple[Box, ...] = tuple((corner(0, span), corner(1, span)) for span in spans)
    return Zone(asked.material, boxes)
