"""Footprints are found in a thread: the view shows coarse ones until then."""

from __future__ import annotations

from riglens.app.background.footprints import FootprintsRequest, find_footprints
from riglens.app.background.worker import BackgroundWorker
from riglens.app.window.feature import Feature
from riglens.app.window.workbench import Workbench


class Footprints(Feature):
    """Request the footprints that the view shows, except while sensors are dragged."""

    def __init__(
        self, bench: Workbench, worker: BackgroundWorker[FootprintsRequest, None] | None = None
    ) -> None:
        super().__init__(bench)
        self.worker = worker or BackgroundWorker("footprints", find_footprints, self)
        self._asked: FootprintsRequest | None = None
        self.serve(self.worker, self._take)
        self.document.rig_settled.connect(self._ask)
        self.viewport.footprints_lacking.connect(self._ask)

    def _ask(self) -> None:
        """Request the footprints of the state that is shown, unless that was done already."""
        state = self.viewport.state
        sensors = () if self.document.is_dragging else state.footprints_of
        request = FootprintsRequest(sensors, state.ray_look.px_per_m, state.solid_body, state.rig.obstacles)
        if sensors and request != self._asked:
            self._asked = request
            self.worker.ask(request)

    def _take(self, request: FootprintsRequest, answer: None) -> None:
        self.viewport.update_footprints()
