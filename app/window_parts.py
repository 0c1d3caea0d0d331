"""Small parts of the window: what it asks of a viewport, help texts, and where new things go."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any, Protocol

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QMenu, QToolButton

from app.actions import Actions, shortcut_rows
from app.options import AutoVoxel, SceneOptions
from core.geometry import Vec3
from core.rig.model import Rig, Vehicle
from core.scene.grid import DEFAULT_ROI_M, DEFAULT_VOXEL_M, VoxelGrid
from widgets.panels.icons import icon
from widgets.panels.scene_panel import SceneChoice
from widgets.panels.scores_panel import SIGN_NOTE

GAP_M = 0.15
MOUSE = (
    ("Left button on a sensor", "selects it"),
    ("Left button on an arrow or ring", "drags the sensor; one drag is one undo step"),
    ("Left button elsewhere", "turns the view"),
    ("Middle button, or Shift and left button", "shifts the view"),
    ("Wheel", "comes nearer to what is under the mouse, or goes away"),
    ("Double click on a sensor", "brings it into the middle of the view"),
    ("Esc during a drag", "puts the sensor back"),
)
ABOUT = (
    "<p><b>RigLens</b> shows how well LiDARs and cameras on a car look at the traffic around it, "
    "after “Influence of Camera-LiDAR Configuration on 3D Object Detection” (ICRA 2024).</p>"
    f"<p>{SIGN_NOTE}</p>"
)


class ViewportWidget(Protocol):
    """What the window asks of a viewport, on the screen or offscreen."""

    sensor_picked: Any
    drag_started: Any
    drag_moved: Any
    drag_finished: Any
    drag_cancelled: Any

    def set_rig(self, rig: Rig, hidden: frozenset[str], selected: str | None) -> None:
        """Show a rig."""

    def set_heatmap(self, data: Any) -> None:
        """Show a heatmap, None for none."""

    def set_grid(self, grid: Any) -> None:
        """Show another region of interest."""

    def set_gizmo(self, mode: Any, space: Any) -> None:
        """Choose the handles and whose axes they follow."""

    def set_view(self, name: str) -> None:
        """Look from a named side."""

    def frame_sensor(self, name: str) -> None:
        """Look at one sensor from near by."""

    def set_vehicle(self, vehicle: Vehicle) -> None:
        """Draw another car; InputError for an unknown body."""

    def cancel_drag(self) -> bool:
        """Give up the drag in progress; False when there is none."""

    def screenshot(self, path: Path) -> object:
        """Write the view as a PNG."""

    def close_viewport(self) -> None:
        """Give back what Qt does not: VTK's window and observers."""


def help_html(actions: Actions) -> str:
    """What keys and mouse buttons do, as a table."""
    rows = [*shortcut_rows(actions), *MOUSE]
    cells = "".join(f"<tr><td><b>{key}</b>&nbsp;&nbsp;&nbsp;</td><td>{what}</td></tr>" for key, what in rows)
    return f"<table>{cells}</table>"


def menu_button(kind: str, menu: QMenu) -> QToolButton:
    """A toolbar button that opens the menu of sensor models of a kind."""
    button = QToolButton()
    button.setObjectName(f"add_{kind}")
    button.setIcon(icon(kind))
    button.setText("+ ▾")
    button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
    button.setToolTip(menu.title())
    button.setMenu(menu)
    button.setPopupMode(QToolButton.ToolButtonPopupMode.InstantPopup)
    return button


def choice_of(options: SceneOptions, grid: VoxelGrid | None = None) -> SceneChoice:
    """What the scene panel shows for these options; the grid of a stored POG is known once it is loaded."""
    voxel_m, roi_m = options.voxel_m or DEFAULT_VOXEL_M, options.roi_m or DEFAULT_ROI_M
    if options.pog is not None and grid is not None:
        voxel_m, roi_m = grid.voxel_m, grid.roi_m
    return SceneChoice(
        options.boxes,
        options.origin_m or (0.0, 0.0, 0.0),
        options.frames,
        voxel_m if options.auto is None else None,
        roi_m,
        options.pog,
    )


def options_of(choice: SceneChoice, before: SceneOptions) -> SceneOptions:
    """Options for what the scene panel says; class names stay mapped as long as the data set is the same."""
    if choice.pog is not None:
        return SceneOptions(pog=choice.pog)
    auto = (before.auto or AutoVoxel()) if choice.voxel_m is None else None
    return SceneOptions(
        boxes=choice.boxes,
        origin_m=choice.origin_m if choice.boxes is not None else None,
        frames=choice.frames,
        classes=before.classes if choice.boxes == before.boxes else (),
        voxel_m=choice.voxel_m,
        roi_m=choice.roi_m,
        auto=auto,
    )


def free_place(rig: Rig, kind: str) -> Vec3:
    """A place above the middle of the roof where no sensor is yet."""
    z = rig.vehicle.height + (0.35 if kind == "lidar" else 0.15)
    x = 0.0
    while any(math.dist(sensor.position, (x, 0.0, z)) < GAP_M for sensor in rig.sensors):
        x -= 2 * GAP_M
    return round(x, 3), 0.0, round(z, 3)


def file_name(rig_name: str, suffix: str) -> str:
    """A rig's name as a file name: letters, digits and -_+. stay."""
    kept = "".join(c if c.isalnum() or c in "-_+." else "-" for c in rig_name).strip("-.")
    return (kept or "rig") + suffix
