"""The measuring tool: two clicks in the view, and the distance between the places."""

from __future__ import annotations

from dataclasses import replace

from riglens.app.window.actions import Spec
from riglens.app.window.feature import Feature
from riglens.app.window.workbench import Workbench
from riglens.widgets.viewport.measured import Measured, Place, measured_lines

HINT = "Click two points: sensors, the car's body or the ground. Drag to turn the view; Esc ends measuring."
NOWHERE = "Nothing to measure there: click a sensor, the car's body or the ground"


class Measure(Feature):
    """Clicks measure while the tool is on. A place on a sensor moves with it; Escape ends all of it."""

    specs = (
        Spec(
            "measure", "Measure a distance", "Click two points in the view to measure distance, x, y, z, and heights.",
            "Shift+M", "measure", "view/shown", "heat", is_checkable=True,
        ),
    )  # fmt: skip

    mouse = (("Measuring: two left clicks", "measure between sensors, body and ground; Esc ends measuring"),)

    def __init__(self, bench: Workbench) -> None:
        super().__init__(bench)
        self.bind(measure=self._switch)
        self.viewport.place_picked.connect(self._on_place)
        self.viewport.escaped.connect(self.end)
        self.document.opened.connect(self.end)
        self.actions["pick"].toggled.connect(lambda is_on: self.end() if is_on else None)

    def _switch(self) -> None:
        if self.actions["measure"].isChecked():
            if self.actions["pick"].isChecked():
                self.actions["pick"].trigger()  # one tool takes the clicks
            self.viewport.set_tool("measure", True)
            self.document.rig_changed.connect(self._follow)  # no drag wakes it otherwise
            self.bench.status.showMessage(HINT)
        else:
            self.end()

    def end(self) -> None:
        """End measuring and remove the line."""
        action = self.actions["measure"]
        if not action.isChecked() and self.viewport.state.measured is None:
            return
        action.setChecked(False)
        self.viewport.set_tool("measure", False)
        self.document.rig_changed.disconnect(self._follow)
        self.bench.status.clearMessage()
        self._show(None)

    def _on_place(self, place: Place | None) -> None:
        """Start, finish, or start again a measurement by a click."""
        if place is None:
            self.bench.status.showMessage(NOWHERE)
            return
        before = self.viewport.state.measured
        is_second = before is not None and before.second is None
        found = Measured(before.first, place) if before is not None and is_second else Measured(place)
        self._show(found)

    def _follow(self) -> None:
        """Update the measurement to the current sensors; points on removed sensors are dropped."""
        before = self.viewport.state.measured
        if before is None:
            return
        places = {sensor.name: sensor.position for sensor in self.document.rig.sensors}
        if any(place.sensor is not None and place.sensor not in places for place in before.places):
            self._show(None)
            return
        now = (
            place if place.sensor is None else replace(place, point_m=places[place.sensor])
            for place in before.places
        )
        self._show(Measured(*now))

    def _show(self, found: Measured | None) -> None:
        if found != self.viewport.state.measured:
            self.viewport.show_state(replace(self.viewport.state, measured=found))
        if found is not None:
            self.bench.status.showMessage(" · ".join(measured_lines(found)))
