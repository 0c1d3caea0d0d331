"""Define what a search may change: sensors that may be added, and those of the rig that may go elsewhere."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from riglens.core.errors import InputError
from riglens.core.review.mounts import MountLimits
from riglens.core.rig.edits import partner_of
from riglens.core.rig.model import Rig, Sensor

LEVELS_DEG = (0.0, 8.0, 15.0)
"""Outward tilts of added sensors."""
TURNS_DEG = (-8.0, 0.0, 8.0, 15.0)
"""Further outward lean of moved sensors."""
SPACING_M = 0.14
"""Usual distance between mounts: two pairs of 16 beams on a sedan gain 1 % over 0.2 m, and at 0.1 m 0.7 % more in
twice the time."""
OR = "/"
"""Between models to choose among."""
USUAL_RULES = MountLimits(height_m=(0.4, 100.0), spacing_m=0.25)
"""Our choice: dirt and kerbs below, housings side by side."""


@dataclass(frozen=True)
class Move:
    """A sensor that may go elsewhere on the skin, with its mirror partner, or be exchanged for models of the library.

    radius_m: how far from where it is; 0: it stays in its place.
    """

    sensor: str
    radius_m: float = math.inf
    models: tuple[str, ...] = ()
    tilts_deg: tuple[float, ...] = TURNS_DEG

    def __post_init__(self) -> None:
        if not self.radius_m >= 0.0:
            raise InputError(f"{self.sensor} must move by at least 0 m (got {self.radius_m:g})", "move")

    def sensors_of(self, rig: Rig) -> tuple[Sensor, ...]:
        """Return the sensor, or its mirror pair with the left one first."""
        names = (self.sensor, partner_of(rig, self.sensor))
        return tuple(sorted((s for s in rig.sensors if s.name in names), key=lambda one: -one.position[1]))


def moves_of(
    radius_m: Mapping[str, float],
    models: Mapping[str, Sequence[str]],
    tilts_deg: tuple[float, ...] = TURNS_DEG,
) -> tuple[Move, ...]:
    """Return the moves of sensors by how far they may go, and by what they may be exchanged for."""
    found = [Move(name, far, tuple(models.get(name, ())), tilts_deg) for name, far in radius_m.items()]
    return (*found, *(Move(n, 0.0, tuple(m), (0.0,)) for n, m in models.items() if n not in radius_m))


@dataclass(frozen=True)
class Additions:
    """Sensors that may be added: models of the library, in mirror pairs or single, `count` of them, within a budget.

    counts: from how many to how many sensors of a model, or of models to choose among ("one/other"), which do not
    count in `count`; of mirror pairs an odd one stands on the middle plane. yaw_deg: turns of sensors that look one
    way, from straight out. costs: of one sensor by model, 1 where nothing is said. rules: limits of each mount; without
    zones of their own the usual ones keep sensors out. spots_m: distance between neighbouring spots. box_m: from and to
    along each axis, where sensors stand in the air on brackets, instead of the skin.
    """

    models: tuple[str, ...]
    count: int = 1
    mirrored: bool = True
    costs: Mapping[str, float] = field(default_factory=dict)
    budget: float = math.inf
    rules: MountLimits = USUAL_RULES
    spots_m: float = SPACING_M
    tilts_deg: tuple[float, ...] = LEVELS_DEG
    box_m: tuple[tuple[float, float], ...] | None = None
    counts: Mapping[str, tuple[int, int]] = field(default_factory=dict)
    yaw_deg: tuple[float, ...] = (0.0,)

    def __post_init__(self) -> None:
        if self.box_m is not None and not all(-50.0 <= low <= high <= 50.0 for low, high in self.box_m):
            raise InputError("must rise from X0 to X1, Y0 to Y1 and Z0 to Z1, within 50 m", "box_m")
        if not 1 <= self.count <= 20:
            raise InputError(f"must be between 1 and 20 (got {self.count})", "count")
        if not self.budget > 0.0:
            raise InputError(f"must be above 0 (got {self.budget:g})", "budget")
        if not 0.05 <= self.spots_m <= 2.0:
            raise InputError(f"must be between 0.05 and 2 m (got {self.spots_m:g})", "spots_m")
        for model, (least, most) in self.counts.items():
            if not 0 <= least <= most <= 20 or not most:
                raise InputError(
                    f"{model} must be from 0 to 20 sensors, from the lower number (got {least}-{most})", "add"
                )
        if not self.yaw_deg or not all(-180.0 <= yaw <= 180.0 for yaw in self.yaw_deg):
            raise InputError("must be between -180 and 180 degrees", "yaw_deg")
        for model, cost in self.costs.items():
            if not 0.0 < cost < math.inf:
                raise InputError(f"{model} must be above 0 (got {cost:g})", "cost")

    def sizes_of(self, model: str) -> tuple[int, ...]:
        """Return how many sensors a candidate of a model may have: 2 of a mirror pair, 1 of a single sensor."""
        least, most = self.counts.get(self.group_of(model), (0, 2))
        if not self.mirrored:
            return (1,)
        return (*((2,) if most > 1 else ()), *((1,) if least % 2 or most % 2 else ()))

    def group_of(self, model: str) -> str:
        """Return the key of the counts that a model is part of, empty without any."""
        return next((key for key in self.counts if model in key.split(OR)), "")

    def cost_of(self, model: str) -> float:
        """Return the cost of the cheapest candidate of a model: a pair costs twice as much as a sensor."""
        return self.costs.get(model, 1.0) * min(self.sizes_of(model))

    @property
    def shared(self) -> int:
        """Return how many candidates may be added, at most, of the models without counts of their own."""
        return 0 if all(map(self.group_of, self.models)) else self.count


NO_ADDITIONS = Additions(())


def counts_of(words: Sequence[str]) -> tuple[tuple[str, ...], dict[str, tuple[int, int]]]:
    """Return models, and from how many to how many of them, from words such as hesai-xt32, hesai-xt32:2,
    hesai-xt32:0-4, or one/other:1 for one of two models."""
    models, counts = list[str](), dict[str, tuple[int, int]]()
    for word in words:
        group, colon, said = word.partition(":")
        for model in group.split(OR):
            if model in models:
                raise InputError(f"must name each model once (got '{word}')", "add")
            models.append(model)
        if colon:
            try:
                low, _, high = said.partition("-")
                counts[group] = int(low), int(high or low)
            except ValueError:
                raise InputError(f"must be MODEL, MODEL:N or MODEL:FROM-TO (got '{word}')", "add") from None
    return tuple(models), counts
