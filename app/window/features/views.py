"""Where the 3D view is looked at from, and which handles the selected sensor has."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from app.actions import Spec
from app.window.feature import Feature

if TYPE_CHECKING:
    from app.window.main_window import MainWindow

VIEWS = ("iso", "top", "front", "left", "rear")
GIZMOS = ("move", "rotate", "both")


def _view(key: str, text: str, tip: str, shortcut: str, icon: str = "") -> Spec:
    return Spec(key, text, tip, shortcut, icon, "view/looks", "views")


def _gizmo(key: str, text: str, tip: str, shortcut: str, icon: str) -> Spec:
    return Spec(key, text, tip, shortcut, icon, "view/gizmo", "gizmo", group="gizmo")


class Views(Feature):
    """Named views, framing of the selection, and the gizmo."""

    specs = (
        _view("iso", "Corner", "View from a corner", "1"),
        _view("top", "Top", "View from above", "2"),
        _view("front", "Front", "View of the front", "3"),
        _view("left", "Left", "View of the left side", "4"),
        _view("rear", "Rear", "View of the rear", "5"),
        _view("frame", "Frame selection", "Bring the selected sensor into the middle of the view", "F", "frame"),
        _gizmo("move", "Move", "Arrows on the selected sensor", "W", "move"),
        _gizmo("rotate", "Rotate", "Rings on the selected sensor", "E", "rotate"),
        _gizmo("both", "Move and rotate", "Arrows and rings on the selected sensor", "Q", "both"),
        Spec(
            "local", "Local axes", "Along the sensor's own axes; off: along those of the car", "L", "axes",
            "view/gizmo", "gizmo", is_checkable=True,
        ),
    )  # fmt: skip

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        self.bind(
            frame=self.frame,
            **dict.fromkeys((*GIZMOS, "local"), self.set_gizmo),
            **{view: partial(self.viewport.set_view, view) for view in VIEWS},
        )
        window.actions_["both"].setChecked(True)
        window.rig_shown.connect(self._update)

    def set_gizmo(self) -> None:
        """Give the viewport the handles that are ticked."""
        actions = self.window.actions_
        mode = next(key for key in GIZMOS if actions[key].isChecked())
        self.viewport.set_gizmo(mode, "local" if actions["local"].isChecked() else "world")

    def frame(self) -> None:
        """Look at the selected sensor from near by."""
        if self.document.selected is not None:
            self.viewport.frame_sensor(self.document.selected)

    def _update(self) -> None:
        self.window.actions_["frame"].setEnabled(self.document.selected is not None)
