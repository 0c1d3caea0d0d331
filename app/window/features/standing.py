"""Sensors off the body, inside it or in the ground are marked, and rays of the selected one that the car stops."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from riglens.app.background.standing import MountStatusAnswer, MountStatuses, MountStatusRequest
from riglens.app.background.worker import BackgroundWorker
from riglens.app.window.feature import Feature
from riglens.app.window.workbench import Workbench
from riglens.core.rig.model import Sensor, Vehicle
from riglens.core.vehicle.standing import MountStatus
from riglens.widgets.viewport.masts import Stubs, masts_of

SAME_PLACE_M = 0.02
"""Distance below which the origins of two sensors count as one place."""


class Standing(Feature):
    """Request the mounts after every move, once there are scores: both would compile at once. No result for a body that
    was not read."""

    def __init__(
        self, bench: Workbench, worker: BackgroundWorker[MountStatusRequest, MountStatusAnswer] | None = None
    ) -> None:
        super().__init__(bench)
        self.worker = worker or BackgroundWorker("places of sensors", MountStatuses(), self)
        self._asked: MountStatusRequest | None = None
        self._answered: Vehicle | None = None
        self.serve(self.worker, self._take)
        self.session.request_changed.connect(self._ask)
        bench.answers.answered.connect(lambda _: self._ask())
        self.document.selection_changed.connect(self._ask)
        self.document.rig_settled.connect(self._ask)
        self.document.opened.connect(self._forget)

    def _ask(self) -> None:
        """Request the mounts of the current sensors, unless that was done already."""
        rig = self.session.rig
        if self.bench.answers.result is None:
            return
        if rig.vehicle.lacks_mesh:
            self._asked = None
            self._show({})
            self._end_rays(None)
            return
        places_m = tuple((sensor.name, sensor.position) for sensor in rig.sensors)
        request = MountStatusRequest(rig.vehicle, places_m, self._stopped_of(), rig.obstacles)
        if self._answered is not None:
            self._end_rays(self._answered)
        if request != self._asked:
            self._asked = request
            self.worker.ask(request)

    def _forget(self) -> None:
        """Show no mounts of the rig that was open before."""
        self._asked = None
        self._show({})

    def _stopped_of(self) -> Sensor | None:
        """Return the sensor whose stopped rays are shown: the selected one, at rest, while the car is solid."""
        if self.session.body != "blocks" or self.document.is_dragging:
            return None
        found = self.document.selected_sensor()
        works = found is not None and found.enabled and found.name not in self.document.failed
        return found if works else None

    def _take(self, request: MountStatusRequest, answer: MountStatusAnswer) -> None:
        """Show a result; also one for an earlier pose, until the next arrives."""
        if self._asked is not None and request.vehicle == self._asked.vehicle:
            stands, ends_m = answer
            self._show(stands)
            self._show_stopped(request.stopped_of, ends_m)
            self._answered = request.vehicle
            self._end_rays(self._answered)

    def _end_rays(self, body: Vehicle | None) -> None:
        """Draw rays up to the body while the car is solid; with None, through it.

        The first answer says that what is needed for it has been compiled.
        """
        body = body if self.session.body == "blocks" else None
        if body != self.viewport.state.solid_body:
            self.viewport.show_state(replace(self.viewport.state, solid_body=body))

    def _show(self, stands: Mapping[str, MountStatus]) -> None:
        shared = shared_places(self.document.rig.sensors) if stands else {}
        problems = {
            name: "; ".join(filter(None, (shared.get(name), found.problem))) for name, found in stands.items()
        }
        problems = {name: problem for name, problem in problems.items() if problem}
        self.bench.panels.tree.show_problems(problems)
        self.bench.panels.inspector.show_mount_statuses(stands, problems)
        masts = masts_of(stands)
        if not stands:
            self._show_stubs(None)
        if masts != self.viewport.state.masts:
            self.viewport.show_state(replace(self.viewport.state, masts=masts))

    def _show_stopped(self, sensor: Sensor | None, ends_m: NDArray[np.float32]) -> None:
        """Show the stopped rays of the selected sensor, and none while it moves."""
        is_wanted = sensor is not None and sensor == self._stopped_of() and len(ends_m)
        self._show_stubs(Stubs(sensor.name, sensor.position, ends_m) if sensor and is_wanted else None)

    def _show_stubs(self, stubs: Stubs | None) -> None:
        if stubs is not self.viewport.state.stubs:
            self.viewport.show_state(replace(self.viewport.state, stubs=stubs))


def shared_places(sensors: Sequence[Sensor]) -> dict[str, str]:
    """Return a warning for each sensor in the same place as another: two housings do not fit there."""
    found: dict[str, str] = {}
    for one, other in combinations(sensors, 2):
        if math.dist(one.position, other.position) < SAME_PLACE_M:
            found.setdefault(one.name, f"in the same place as {other.name}")
            found.setdefault(other.name, f"in the same place as {one.name}")
    return found
