"""Sensors onto the car's body: placed by a click, dropped from the library, nudged by keys."""

from __future__ import annotations

from typing import TYPE_CHECKING

from riglens.app.window.actions import Spec
from riglens.app.window.feature import Feature
from riglens.core.geometry import Pose
from riglens.core.rig.library import default_library, sensor_from_model

if TYPE_CHECKING:
    from riglens.app.window.main_window import MainWindow

HINT = "Click on the car to put {name} there; Esc leaves it where it was."


class Placing(Feature):
    """Place on body, drops of library models, and arrow keys in the view."""

    specs = (
        Spec(
            "place", "Place on body", "Have the selected sensor follow the mouse over the car until a click",
            "P", "place", "sensor/place", "place", is_checkable=True,
        ),
    )  # fmt: skip

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        self.bind(place=self.place)
        self.viewport.placing_changed.connect(self._show)
        self.viewport.model_dropped.connect(window.guarded(self.add))
        self.viewport.nudged.connect(window.guarded(self._nudge))
        window.rig_shown.connect(self._update)

    def place(self) -> None:
        """Begin to place the selected sensor, or leave off."""
        action = self.window.actions_["place"]
        if not action.isChecked():
            self.viewport.cancel_drag()
        elif self.document.selected is None or not self.viewport.begin_placing():
            action.setChecked(False)

    def add(self, model: str, pose: Pose) -> None:
        """Add a sensor of a library model at a pose and select it."""
        name = f"{default_library().entry(model).kind}_1"
        self.document.add(sensor_from_model(model, name, pose))

    def _nudge(self, name: str, pose: Pose) -> None:
        self.document.replace_sensor(name, self.document.rig.sensor(name).with_pose(pose))

    def _show(self, active: bool) -> None:
        self.window.actions_["place"].setChecked(active)
        if active:
            self.window.status.showMessage(HINT.format(name=self.document.selected))
        else:
            self.window.status.clearMessage()

    def _update(self) -> None:
        hidden = self.document.selected in self.document.hidden
        self.window.actions_["place"].setEnabled(self.document.selected is not None and not hidden)
