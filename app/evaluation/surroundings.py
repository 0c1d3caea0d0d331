"""Blind zones around the car of the window: one engine that follows edits, a new one for another car."""

from __future__ import annotations

from riglens.app.evaluation.known_body import known_body
from riglens.app.evaluation.requests import EvaluationRequest
from riglens.core.review.blind import BlindEngine, BlindMap, BlindSettings
from riglens.core.rig.model import Vehicle


class Surroundings:
    """Blind zones with the usual settings of `riglens blind`. For the thread of the parallel kernels."""

    def __init__(self, threads: int | None) -> None:
        self._threads = threads
        self._car: Vehicle | None = None
        self._engine: BlindEngine | None = None

    def blind_map(self, request: EvaluationRequest) -> BlindMap:
        """Return the blind map of a request's rig around its car, whose body is solid once its mesh has been read."""
        vehicle = request.rig.vehicle
        if self._engine is None or self._car != vehicle:
            self._car = vehicle
            body = known_body(request.rig, "blocks")
            self._engine = BlindEngine(vehicle, BlindSettings(body=body), self._threads)
        return self._engine.evaluate(request.rig)
