"""Collect the assumptions of simulated sweeps."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Literal

from riglens.core.errors import InputError
from riglens.core.metric.scores import Body
from riglens.core.targets.settings import Phase, TargetSettings
from riglens.core.targets.shapes import Shape

GroundKind = Literal["uneven", "flat", "none"]
MOST_CLUTTER = 2000
MOST_NOISE_M = 10.0


@dataclass(frozen=True)
class SimulationSettings:
    """Settings of simulated sweeps; all numbers are our choice.

    seed, shape, range_law, phase, body: as in `riglens.core.targets.settings.TargetSettings`, with the same draws.
    noise_m: standard deviation of a range, metres. dropout: share of returns that get lost, whatever they are on.
    clutter: bushes, bins, poles, walls... that stand in a frame within 60 m, on average before those that would stand
    in an object are left out; the same for every rig. ground: with waves of a few centimetres, flat, or none.
    """

    seed: int = 0
    shape: Shape = "class"
    range_law: bool = True
    phase: Phase = "random"
    noise_m: float = 0.02
    dropout: float = 0.05
    clutter: int = 60
    ground: GroundKind = "uneven"
    body: Body | None = "ignored"

    def __post_init__(self) -> None:
        if not 0 <= self.seed < 1 << 63:
            raise InputError(f"must be an integer from 0 to 2^63 - 1 (got {self.seed})", "seed")
        if not 0.0 <= self.noise_m <= MOST_NOISE_M:
            raise InputError(f"must be between 0 and {MOST_NOISE_M:g} m (got {self.noise_m:g})", "noise_m")
        if not 0.0 <= self.dropout < 1.0 or math.isnan(self.dropout):
            raise InputError(f"must be at least 0 and below 1 (got {self.dropout:g})", "dropout")
        if not 0 <= self.clutter <= MOST_CLUTTER:
            raise InputError(f"must be an integer from 0 to {MOST_CLUTTER} (got {self.clutter})", "clutter")

    def targets(self) -> TargetSettings:
        """Return the same settings for counting points on objects."""
        return TargetSettings(self.shape, self.range_law, self.phase, self.seed, body=self.body)

    def as_dict(self) -> dict[str, object]:
        """Return the settings as plain data."""
        return asdict(self)


USUAL_SIMULATION = SimulationSettings()
