"""Collect the assumptions of simulated sweeps."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Annotated, Literal

from riglens.core.errors import InputError
from riglens.core.metric.scores import Body
from riglens.core.option_help import PHASE, RANGE_LAW, SHAPE, OptionHelp
from riglens.core.targets.settings import Phase, TargetSettings
from riglens.core.targets.shapes import Shape

GroundKind = Literal["uneven", "flat", "none"]
MOST_CLUTTER = 2000
MOST_NOISE_M = 10.0


@dataclass(frozen=True)
class SimulationSettings:
    """Settings of simulated sweeps; all numbers are our choice.

    seed, shape, range_law, phase, body: as in `riglens.core.targets.settings.TargetSettings`, with the same draws.
    noise_m: metres. dropout: of returns, whatever they are on. clutter: within 60 m, on average before what would stand
    in an object is left out.
    """

    seed: Annotated[int, OptionHelp("N", "Seed of all random draws.")] = 0
    shape: Annotated[Shape, SHAPE] = "class"
    range_law: Annotated[bool, RANGE_LAW] = True
    phase: Annotated[Phase, PHASE] = "random"
    noise_m: Annotated[float, OptionHelp("M", "Standard deviation of a range, in metres.")] = 0.02
    dropout: Annotated[float, OptionHelp("SHARE", "Share of returns lost at random.")] = 0.05
    clutter: Annotated[
        int,
        OptionHelp(
            "N",
            "Number of bushes, bins, poles and walls around the car in each frame, the same for every rig.",
        ),
    ] = 60
    ground: Annotated[
        GroundKind,
        OptionHelp("", "uneven: with waves of a few centimetres; flat; or none.", option="road"),
    ] = "uneven"
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
