"""Footprints are found in a thread, once the first figures are exact: the view shows coarse ones until then."""

from __future__ import annotations

from PySide6.QtCore import Qt

from riglens.app.background.counting import CountAnswer
from riglens.app.background.footprints import FootprintsRequest, find_footprints
from riglens.app.background.worker import BackgroundWorker
from riglens.app.window.feature import Feature
from riglens.app.window.workbench import Workbench


class Footprints(Feature):
    """Request the footprints that the view shows, except while sensors are dragged and until the objects of the first
    rig are counted, or cannot be: those of a whole car take a second of a processor."""

    def __init__(
        self, bench: Workbench, worker: BackgroundWorker[FootprintsRequest, None] | None = None
    ) -> None:
        super().__init__(bench)
        self.worker = worker or BackgroundWorker("footprints", find_footprints, self)
        self._asked: FootprintsRequest | None = None
        self._waits = True
        queued = Qt.ConnectionType.QueuedConnection
        bench.counter.answered.connect(self._take_count, queued)
        bench.counter.failed.connect(self.begin, queued)
        bench.recompute.load_ended.connect(self._end_load, queued)
        self.serve(self.worker, self._take)
        self.document.rig_settled.connect(self.begin)
        self.viewport.footprints_lacking.connect(self._ask)

    def begin(self) -> None:
        """Request what is shown, now and from now on."""
        self._waits = False
        self._ask()

    def _take_count(self, _: object, answer: CountAnswer) -> None:
        if self._waits and answer.is_whole:
            self.begin()

    def _end_load(self, problem: str, _: object) -> None:
        if problem:
            self.begin()

    def _ask(self) -> None:
        """Request the footprints of the state that is shown, unless that was done already."""
        if self._waits:
            return
        state = self.viewport.state
        sensors = () if self.document.is_dragging else state.footprints_of
        request = FootprintsRequest(sensors, state.ray_look.px_per_m, state.solid_body, state.rig.obstacles)
        if sensors and request != self._asked:
            self._asked = request
            self.worker.ask(request)

    def _take(self, request: FootprintsRequest, answer: None) -> None:
        self.viewport.update_footprints()
