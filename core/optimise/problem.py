"""Define the problem of a search for rigs: what may change, and what is to be better for it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from riglens.core.blind.zones import called
from riglens.core.errors import InputError
from riglens.core.figures.evaluated import BLIND_M
from riglens.core.metric.entropy import EntropyField
from riglens.core.optimise.additions import NO_ADDITIONS, Additions, Move
from riglens.core.optimise.objectives import Objective, objective_named
from riglens.core.optimise.weights import EVEN, Weights
from riglens.core.rig.library import default_library
from riglens.core.rig.model import Rig
from riglens.core.targets.calibration import Calibration
from riglens.core.targets.settings import TargetSettings
from riglens.core.targets.traffic import Traffic


@dataclass(frozen=True)
class Problem:
    """Problem of a search: a rig, the sensors that may be added, traffic, and the frames to choose by and to check in.

    Every sensor of the rig stays as it is unless it is among the moves. reference: the rig that gains refer to; without
    it the best of some mounts that a person would choose, or the rig itself where nothing is added. blind_m: height of
    the object whose blind area is the second goal of the front; without it there is none. voxels: of the objectives of
    them; calibration: of predicted detection, by default the one that ships; checks: other traffic for the guard, by
    the name of the case; unmet: returns the requirements that a rig does not meet.
    """

    rig: Rig
    traffic: Traffic
    additions: Additions = NO_ADDITIONS
    objective: str = "on_target"
    frames: int = 100
    held_out: int = 1000
    seed: int = 0
    reference: Rig | None = None
    blind_m: float | None = None
    moves: tuple[Move, ...] = ()
    weights: Weights = EVEN
    voxels: EntropyField | None = None
    calibration: Calibration | None = None
    checks: Mapping[str, Traffic] = field(default_factory=dict)
    unmet: Callable[[Rig], tuple[str, ...]] | None = None

    def __post_init__(self) -> None:
        self._check_sensors()
        if self.goal.figure.needs == "voxels" and self.voxels is None:
            raise InputError(f"needs a scene of voxels for {self.objective}", "objective")
        if not 2 <= self.frames <= 1000:
            raise InputError(f"must be between 2 and 1000 (got {self.frames})", "frames")
        if self.held_out < 2:
            raise InputError(f"must be at least 2 (got {self.held_out})", "held_out")
        if not 0 <= self.seed < 1 << 62:
            raise InputError(f"must be between 0 and 2^62 - 1 (got {self.seed})", "seed")
        if self.frames + 2 > self.traffic.frames:
            most = self.traffic.frames - 2
            raise InputError(
                f"must be at most {most}, to leave frames for checking (got {self.frames})", "frames"
            )
        if self.blind_m is not None and not 0.05 <= self.blind_m <= 2.0:
            raise InputError(f"must be between 0.05 and 2 m (got {self.blind_m:g})", "blind_m")

    def _check_sensors(self) -> None:
        """Raise InputError unless the search adds or moves sensors that the objective measures, each once."""
        models = self.additions.models
        if not models and not self.moves:
            raise InputError("must name at least one sensor model, or a sensor to move", "add")
        exchanged = [model for move in self.moves for model in move.models]
        wanted = " or ".join(map(called, self.goal.kinds)) or "sensor"
        for model in (*models, *exchanged):
            entry = default_library().entry(model)
            if self.goal.kinds and entry.kind not in self.goal.kinds:
                raise InputError(f"{model} must be a {wanted} (got a {entry.kind})", "add")
        for model in self.additions.costs:
            if model not in (*models, *exchanged):
                known = ", ".join((*models, *exchanged))
                raise InputError(f"{model} must be one of the models to add: {known}", "cost")
        moved = set[str]()
        there = [sensor.name for sensor in self.goal.sensors_of(self.rig)]
        for move in self.moves:
            if move.sensor not in there:
                known = ", ".join(there) or "none"
                raise InputError(
                    f"must name an enabled {wanted} of the rig: {known} (got '{move.sensor}')", "move"
                )
            names = {sensor.name for sensor in move.sensors_of(self.rig)}
            if names & moved:
                raise InputError(f"must name each sensor or mirror pair once (got '{move.sensor}')", "move")
            moved |= names

    @property
    def goal(self) -> Objective:
        """Return the objective."""
        return objective_named(self.objective)

    @property
    def count(self) -> int:
        """Return how many candidates may be added, at most."""
        return self.additions.shared

    @property
    def ground_m(self) -> float:
        """Return the height of the object whose blind ground is the objective."""
        return self.blind_m or BLIND_M

    @property
    def last(self) -> int:
        """Return the end of the held-out frames."""
        return min(self.frames + self.held_out, self.traffic.frames)

    @property
    def settings(self) -> TargetSettings:
        """Settings of the counting, in which a candidate keeps its draws."""
        return TargetSettings(seed=self.seed, body=self.rig.body, calibration=self.calibration)
