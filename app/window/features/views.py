"""Choose the direction of the 3D view, named views, and the handles of the selected sensor."""

from __future__ import annotations

import math
from dataclasses import asdict, replace
from functools import partial
from typing import Any

from PySide6.QtWidgets import QMenu

from riglens.app.window.actions import Spec, menu_button
from riglens.app.window.feature import Feature
from riglens.app.window.settings import Settings
from riglens.app.window.status import TOLD_MS
from riglens.app.window.workbench import Workbench
from riglens.core.shown_text import visible
from riglens.widgets.drawing.camera import OrbitCamera
from riglens.widgets.gizmo.drag import GizmoMode, Space
from riglens.widgets.panels.controls.menus import add_entry

VIEWS = ("iso", "top", "front", "left", "rear", "right")
GIZMOS: tuple[GizmoMode, ...] = ("move", "rotate", "both")
FAR_M = 2000.0
FAR_AWAY = "Not in this view: {names}, {away_m:,.0f} m away. Select it and press F to go there."


def _view(key: str, text: str, tip: str, shortcut: str) -> Spec:
    return Spec(key, text, tip, shortcut, menu="view")


def _gizmo(key: str, text: str, tip: str, shortcut: str, icon: str) -> Spec:
    return Spec(key, text, tip, shortcut, icon, "view", "gizmo", group="gizmo")


class Views(Feature):
    """Named views, framing of the selection, and the gizmo."""

    specs = (
        _view("iso", "Corner", "View from a corner.", "1"),
        _view("top", "Top", "View from above.", "2"),
        _view("front", "Front", "View the front.", "3"),
        _view("left", "Left", "View the left side.", "4"),
        _view("rear", "Rear", "View the rear.", "5"),
        _view("right", "Right", "View the right side.", "6"),
        Spec(
            "frame", "Frame selection", "Centre the view on the selected sensors, or on everything.",
            "F", "frame", "view/looks",
        ),
        Spec("frame_all", "Frame all", "Fit the car with all its sensors into the view.", "Home", menu="view/looks"),
        Spec(
            "ortho", "Orthographic", "Use a parallel projection, so that lengths can be compared.",
            "O", menu="view/looks", is_checkable=True,
        ),
        Spec(
            "camera_inset", "Camera picture", "Show the picture of the selected camera in a corner of the view.",
            "Shift+C", menu="view/shown", is_checkable=True,
        ),
        _gizmo("move", "Move", "Show arrows on the selected sensor.", "W", "move"),
        _gizmo("rotate", "Rotate", "Show rings on the selected sensor.", "E", "rotate"),
        _gizmo("both", "Move and rotate", "Show arrows and rings on the selected sensor.", "Q", "both"),
        Spec(
            "local", "Local axes", "Move along the sensor's own axes; off: along those of the car.", "L", "axes",
            "view", "gizmo", is_checkable=True,
        ),
        Spec(
            "snap", "Snap", "Snap drags to multiples of 0.05 m and 5°; hold Ctrl for the opposite.",
            "S", "snap", "view", "gizmo", is_checkable=True,
        ),
    )  # fmt: skip

    mouse = (
        ("Left button on a sensor", "selects only this sensor"),
        ("Ctrl or Shift and left button on a sensor", "adds it to the selection, or removes it"),
        (
            "Shift and left button, dragged",
            "adds sensors in the box to the selection; with Ctrl removes them",
        ),
        ("Left button on an arrow, square or ring", "drags the selection; one drag is one undo step"),
        ("Ctrl during a drag", "snaps to 0.05 m and 5°, or does not if snapping is on"),
        (
            "Digits while an arrow or a ring is dragged",
            "set the distance in metres or the angle in degrees; Enter ends the drag",
        ),
        ("Arrow keys, Page up, Page down in the view", "move the selection by 1 cm, with Shift by 10 cm"),
        ("The same keys with Ctrl or Alt", "turn it by 1°, with Shift by 10°"),
        ("Left button elsewhere", "orbits the view"),
        ("Middle button", "pans the view"),
        ("Wheel", "zooms at the mouse position"),
        ("Double-click on a sensor", "centres the view on it"),
        ("Esc during a drag", "cancels the drag"),
    )

    def __init__(self, bench: Workbench) -> None:
        super().__init__(bench)
        self.bind(
            frame=self.frame,
            frame_all=self.frame_all,
            ortho=self.set_ortho,
            camera_inset=self._show_inset,
            **dict.fromkeys((*GIZMOS, "local", "snap"), self.set_gizmo),
            **{view: partial(self.viewport.set_view, view) for view in VIEWS},
        )
        views = bench.places.add_submenu("view/looks", "View from", [self.actions[key] for key in VIEWS])
        handles = [self.actions[key] for key in (*GIZMOS, "local", "snap")]
        bench.places.add_submenu("view/gizmo", "Handles", handles)
        menu = QMenu(bench.window)
        menu.addActions(
            [*views.actions(), menu.addSeparator(), self.actions["frame"], self.actions["frame_all"]]
        )
        tip = "Choose from where the car is seen (keys 1 to 6), or frame what is selected (F)."
        bench.places.add_to_toolbar("views", menu_button("view_from", "frame", tip, menu))

    def _show_inset(self) -> None:
        self.viewport.show_inset(self.actions["camera_inset"].isChecked())

    def set_gizmo(self) -> None:
        """Show the ticked handles in the view, and have drags snap or not."""
        actions = self.actions
        mode = next(key for key in GIZMOS if actions[key].isChecked())
        space: Space = "local" if actions["local"].isChecked() else "world"
        snap, state = actions["snap"].isChecked(), self.viewport.state
        self.viewport.show_state(replace(state, gizmo_mode=mode, gizmo_space=space, snap=snap))

    def frame(self) -> None:
        """Frame the selected sensors, or the car with all its sensors."""
        if not self.document.selection:
            self.frame_all()
        else:
            self.viewport.frame_sensors(self.document.selection)

    def frame_all(self) -> None:
        """Fit the car with all its sensors into the view; show how to reach one that is too far away."""
        self.viewport.frame_sensors(())
        far = self.viewport.state.far_away
        if far:
            away_m = math.hypot(*self.document.rig.sensor(far[0]).position)
            others = f" and {len(far) - 1} more" if len(far) > 1 else ""
            self.bench.status.showMessage(
                FAR_AWAY.format(names=visible(far[0]) + others, away_m=away_m), TOLD_MS
            )

    def set_ortho(self) -> None:
        """Draw with parallel rays, or with perspective."""
        self.look(self.viewport.state.camera.projected(self.actions["ortho"].isChecked()))

    def look(self, camera: OrbitCamera) -> None:
        """Look through a camera."""
        self.actions["ortho"].setChecked(camera.orthographic)
        self.viewport.show_state(replace(self.viewport.state, camera=camera))

    def restore(self, settings: Settings) -> None:
        key = settings.read("gizmo/mode", "both")
        self.actions[key if key in GIZMOS else "both"].setChecked(True)
        self.actions["local"].setChecked(settings.read("gizmo/local", False))
        self.actions["snap"].setChecked(settings.read("gizmo/snap", False))
        self.set_gizmo()
        self.actions["camera_inset"].setChecked(settings.read("view/inset", True))
        self._show_inset()
        camera = camera_of(settings.read("view/camera", {}))
        if camera is not None:
            self.look(camera)

    def keep(self, settings: Settings) -> None:
        settings.write("gizmo/mode", next(key for key in GIZMOS if self.actions[key].isChecked()))
        settings.write("gizmo/local", self.actions["local"].isChecked())
        settings.write("gizmo/snap", self.actions["snap"].isChecked())
        settings.write("view/inset", self.actions["camera_inset"].isChecked())
        camera = self.viewport.chosen_camera()
        settings.write("view/camera", {} if camera is None else asdict(camera))


def camera_of(kept: dict[str, Any]) -> OrbitCamera | None:
    """Return the camera of an earlier session; None if none was kept."""
    try:
        x, y, z = (float(value) for value in kept["focal_m"])
        distance, azimuth, elevation = (
            float(kept[key]) for key in ("distance_m", "azimuth_deg", "elevation_deg")
        )
    except (KeyError, TypeError, ValueError):
        return None
    is_sane = max(map(abs, (x, y, z))) <= FAR_M and 0.0 < distance <= FAR_M and abs(elevation) <= 90.0
    if not (is_sane and abs(azimuth) <= 360.0):  # false for NaN too
        return None
    is_flat = kept.get("orthographic") is True
    is_parallel = is_flat or kept.get("parallel") is True
    return OrbitCamera((x, y, z), distance, azimuth, elevation, is_parallel, orthographic=is_flat)


SAVED_KEY, MOST_SAVED, LONGEST_NAME = "view/saved", 50, 60


class SavedViews(Feature):
    """Views with names, for every rig: saved, recalled and deleted in a menu, kept in the settings."""

    specs = (
        Spec("save_view", "Save view…", "Save this view of the car under a name.", "Ctrl+Alt+V", menu="view"),
    )  # fmt: skip

    def __init__(self, bench: Workbench, views: Views) -> None:
        super().__init__(bench)
        self._views = views
        self.menu = bench.places.add_submenu("view/looks", "Saved views")
        self.menu.aboutToShow.connect(self.fill)
        self.bind(save_view=self.save)
        self.fill()

    @property
    def cameras(self) -> dict[str, OrbitCamera]:
        """The saved cameras by name, in alphabetical order."""
        kept = self.bench.kept.read(SAVED_KEY, {})
        found = {name: camera_of(value) for name, value in kept.items() if isinstance(value, dict)}
        known = {name: camera for name, camera in found.items() if camera is not None}
        return dict(sorted(known.items(), key=lambda item: item[0].casefold()))

    def save(self) -> None:
        """Ask for a name and save the view under it; an existing name gets the new view."""
        name = self.bench.dialogs.view_name(self.bench.window, list(self.cameras))
        name = (name or "").strip()[:LONGEST_NAME]
        if not name:
            return
        cameras = self.cameras | {name: self.viewport.state.camera}
        if len(cameras) > MOST_SAVED:
            self.bench.report_error(f"Saved views: at most {MOST_SAVED} are kept; delete one first.")
            return
        self._keep(cameras)
        self.bench.status.showMessage(f"Saved as '{name}' in View > Saved views.", TOLD_MS)

    def recall(self, name: str) -> None:
        """Look from where a view was saved."""
        self._views.look(self.cameras[name])

    def forget(self, name: str) -> None:
        """Delete a saved view."""
        self._keep({other: camera for other, camera in self.cameras.items() if other != name})

    def fill(self) -> None:
        """List the saved views in the menu."""
        self.menu.clear()
        self.menu.addAction(self.actions["save_view"])
        self.menu.addSeparator()
        cameras = self.cameras
        for name in cameras:
            add_entry(self.menu, name.replace("&", "&&"), partial(self.recall, name))
        if cameras:
            self.menu.addSeparator()
            gone = QMenu("Delete", self.menu)
            for name in cameras:
                add_entry(gone, name.replace("&", "&&"), partial(self.forget, name))
            self.menu.addMenu(gone)

    def _keep(self, cameras: dict[str, OrbitCamera]) -> None:
        self.bench.kept.write(SAVED_KEY, {name: asdict(camera) for name, camera in cameras.items()})
        self.bench.kept.sync()
        self.fill()
