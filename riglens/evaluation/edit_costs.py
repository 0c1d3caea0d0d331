"""Estimate the duration of exact evaluations from the engine's own times: a running median for every sensor."""

from __future__ import annotations

import statistics
from collections import deque

from riglens.core.rig.model import Rig, Sensor, rays_of

REMEMBERED = 9


class EditCosts:
    """Cost of bringing an engine from the rig it holds to another one; a sensor is known by its name.

    A sensor that was never changed alone is guessed from the last evaluation that cast several.
    """

    def __init__(self) -> None:
        self._held: list[Sensor] = []
        self._times: dict[str, deque[float]] = {}
        self._guess_ms = 0.0

    def expected_ms(self, rig: Rig) -> float:
        """Return the time to cast the sensors in this rig that are not held; 0 when there are none."""
        return sum(self._cost(name) for name in self._to_cast(rig))

    def is_guess(self, rig: Rig) -> bool:
        """Return whether a sensor that has to be cast was never measured."""
        return any(name not in self._times for name in self._to_cast(rig))

    def slowest_ms(self, rig: Rig) -> float:
        """Return the highest cost in ms of an enabled sensor of this rig."""
        return max((self._cost(sensor.name) for sensor in rig.sensors if sensor.enabled), default=0.0)

    def note(self, rig: Rig, elapsed_ms: float) -> None:
        """Record the time that the engine took to evaluate this rig, which it now holds."""
        cast = self._to_cast(rig)
        if len(cast) == 1:
            self._times.setdefault(cast[0], deque(maxlen=REMEMBERED)).append(elapsed_ms)
        elif cast:
            self._guess_ms = elapsed_ms / len(cast)
        self._held = [rays_of(sensor) for sensor in rig.sensors if sensor.enabled]

    def _cost(self, name: str) -> float:
        return statistics.median(self._times[name]) if name in self._times else self._guess_ms

    def _to_cast(self, rig: Rig) -> list[str]:
        held = list(self._held)
        names = []
        for sensor in rig.sensors:
            if not sensor.enabled:
                continue
            if (rays := rays_of(sensor)) in held:
                held.remove(rays)
            else:
                names.append(sensor.name)
        return names
