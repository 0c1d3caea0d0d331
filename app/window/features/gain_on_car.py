"""Colour the car by the gain of one more sensor at each place, live while the rig is edited."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from PySide6.QtCore import Qt

from riglens.app.background.proposing import Answer, Gains, GainsRequest, Spots
from riglens.app.window.feature import Feature
from riglens.app.window.features.propose import Propose
from riglens.app.window.workbench import Workbench
from riglens.core.rig.model import Rig, Vehicle
from riglens.core.view.heatmap_data import HeatmapData, Values

NOTE = "at each place on the car, given the rig"


class GainOnCar(Feature):
    """Display of the gains of the search that cast its candidates last; one request is under way at a time."""

    def __init__(self, bench: Workbench, propose: Propose) -> None:
        super().__init__(bench)
        self._propose, self._is_on = propose, False
        self._spots_m: Values | None = None
        self._vehicle: Vehicle | None = None
        self._gains: Gains | None = None
        self._top, self._title = 0.0, ""
        self._asked: Rig | None = None
        """The rig of the request under way, None without one."""
        propose.panel.skin_wanted.connect(bench.guarded(self.turn))
        propose.begun.connect(self._forget)
        propose.proposer.answered.connect(self._take, Qt.ConnectionType.QueuedConnection)
        propose.in_sight.changed.connect(lambda _: self._show())

    def turn(self, is_on: bool) -> None:
        """Colour the car, or leave it in its paint."""
        if is_on == self._is_on:
            return
        self._is_on = is_on
        for changed in (self.document.rig_changed, self.document.failed_changed):
            (changed.connect if is_on else changed.disconnect)(self._ask)
        if is_on and self._spots_m is None:
            self._propose.find_gains()
        self._ask()
        self._show()

    def _ask(self) -> None:
        """Request the gains for the current rig, without the mesh, which the process has; none while a request is
        under way or for another car."""
        rig = self.document.working_rig
        if rig.vehicle != self._vehicle:
            self._show()
        elif self._asked is None and self._gains is not None and rig.sensors != self._gains.rig.sensors:
            self._asked = rig
            self._propose.proposer.send(GainsRequest(rig))

    def _forget(self) -> None:
        self._spots_m = self._vehicle = self._gains = self._asked = None
        self._top = 0.0
        self._show()

    def _take(self, answer: Answer) -> None:
        if isinstance(answer, Spots):
            self._forget()
            self._spots_m = answer.points_m.astype(np.float32)
            self._title = f"Gain: {self._propose.objective.lower()}"
        elif isinstance(answer, Gains) and self._spots_m is not None:
            self._gains, self._asked, self._vehicle = answer, None, answer.rig.vehicle
            self._top = max(self._top, float(answer.gains.max(initial=0.0)))
            self._show()
            if self._is_on:
                self._ask()  # the rig may have moved on

    def _show(self) -> None:
        """Show the gains while they are wanted and belong to the car."""
        gains, shown = self._gains, None
        is_known = gains is not None and self.document.working_rig.vehicle == self._vehicle
        if self._is_on and self._propose.in_sight and is_known and self._spots_m is not None:
            assert gains is not None
            shown = HeatmapData(
                self._spots_m, 0.0, gains.gains.astype(np.float32), self._title, "", 0.0,
                self._top or 1.0, NOTE, "level",
            )  # fmt: skip
        before = self.viewport.state.skin_gain
        if shown is not None or before is not None:
            self.viewport.show_state(replace(self.viewport.state, skin_gain=shown))
