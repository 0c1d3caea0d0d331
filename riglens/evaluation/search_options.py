"""Define the options of a search for rigs: plain data, cheap to import."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated, Any

from riglens.core.errors import InputError
from riglens.core.optimise.objectives import objective_named, objectives
from riglens.core.optimise.weights import Weights
from riglens.core.option_help import OptionHelp

if TYPE_CHECKING:  # loads the compiler
    from riglens.core.optimise.additions import Additions
    from riglens.core.optimise.problem import Problem
    from riglens.core.review.mounts import MountLimits
    from riglens.core.rig.model import Rig
    from riglens.core.targets.traffic import Traffic

HIGHEST_M = 100.0
_FIELDS = {"height_m": "lowest_m", "spacing_m": "spacing_m", "beyond_m": "beyond_m"}
"""Options of the rules of mounts."""
_METAVARS = {"cost": "MODEL=COST", "weight": "WHAT=W", "move": "NAME or NAME=M"}


@dataclass(frozen=True)
class SearchOptions:
    """Options of a search for more sensors: what may be added, where, and for which figure.

    The one form of these options: `riglens optimise` reads it from its words, the window makes a form of its fields.
    """

    add: Annotated[
        tuple[str, ...],
        OptionHelp(
            "MODEL[:FROM-TO]",
            "Library model to add, or several with / between them, from how many to how many sensors; repeated: the "
            "search chooses among them.",
        ),
    ] = ()
    count: Annotated[
        int, OptionHelp("K", "Number of mirror pairs, or of single sensors, to add at most.")
    ] = 1
    singles: Annotated[bool, OptionHelp("", "Add single sensors instead of mirror pairs.")] = False
    cost: Annotated[
        tuple[str, ...],
        OptionHelp("MODEL=COST", "Cost of one sensor of a model, such as hesai-qt64=2.5 (1)."),
    ] = ()
    budget: Annotated[float | None, OptionHelp("COST", "Limit of the cost of all added sensors.")] = None
    yaw_deg: Annotated[
        tuple[float, ...],
        OptionHelp("DEG", "Turn of a sensor that looks one way, from straight out; may be repeated (0)."),
    ] = ()
    tilt_deg: Annotated[
        tuple[float, ...],
        OptionHelp(
            "DEG",
            "Lean of added sensors outwards, by which cameras look down; may be repeated (0, 8 and 15).",
        ),
    ] = ()
    spots_m: Annotated[float, OptionHelp("M", "Distance between neighbouring mounts on the skin.")] = 0.14
    lowest_m: Annotated[float, OptionHelp("M", "Least height of a sensor over the ground.")] = 0.4
    spacing_m: Annotated[float, OptionHelp("M", "Least distance between two sensors.")] = 0.25
    beyond_m: Annotated[
        float | None,
        OptionHelp("M", "Largest overhang of housings over the car's outline at front, rear and sides."),
    ] = None
    objective: Annotated[
        str,
        OptionHelp(
            "FIGURE",
            f"Figure to improve: {', '.join(objectives())}; see docs/figures.md.",
        ),
    ] = "on_target"
    weight: Annotated[
        tuple[str, ...],
        OptionHelp(
            "WHAT=W",
            "Weight of a class (pedestrian=2) or of a ring in metres (0-20=3); may be repeated (1).",
        ),
    ] = ()
    blind_m: Annotated[
        float | None,
        OptionHelp(
            "M",
            "Also list rigs that leave less ground where an object of this height is in no sensor's view.",
        ),
    ] = None
    frames: Annotated[
        int, OptionHelp("N", "Number of frames to choose by; the gain is checked in others.")
    ] = 100
    box_m: Annotated[
        str | None,
        OptionHelp(
            "X0,X1,Y0,Y1,Z0,Z1", "Mount sensors in the air in this box, in metres, instead of on the skin."
        ),
    ] = None
    move: Annotated[
        tuple[str, ...],
        OptionHelp(
            "NAME[=M]",
            "Let a sensor of the rig and its mirror partner go anywhere on the skin, or M metres far; may be repeated.",
        ),
    ] = ()
    exchange: Annotated[
        tuple[str, ...],
        OptionHelp(
            "NAME=MODEL",
            "Let a sensor of the rig be exchanged for a model, in its place unless it may move; may be repeated.",
        ),
    ] = ()
    held_out: Annotated[int, OptionHelp("N", "Number of other frames to check the gain in.")] = 1000
    seed: Annotated[int, OptionHelp("N", "Seed of mounts, LiDAR phases and lost rays.")] = 0

    def __post_init__(self) -> None:
        objective_named(self.objective)
        numbers_of("cost", self.cost)
        self.weights()
        self.box()
        self.moves()

    def replace(self, **changes: Any) -> SearchOptions:
        """Return the options with some fields changed; raise InputError for words that do not fit."""
        return replace(self, **changes)

    def weights(self) -> Weights:
        """Return weights by class and by ring."""
        classes, rings = dict[str, float](), dict[tuple[float, float], float]()
        for name, weight in numbers_of("weight", self.weight).items():
            low, _, high = name.partition("-")
            try:
                rings[float(low), float(high)] = weight
            except ValueError:
                classes[name] = weight
        return Weights(classes, rings)

    def rules(self) -> MountLimits:
        """Return the rules of mounts; raise InputError for a number outside its limits."""
        from pydantic import ValidationError

        from riglens.core.review.mounts import MountLimits
        from riglens.core.rig.yaml.problems import problems

        out = dict.fromkeys(("front", "rear", "left", "right"), self.beyond_m)
        rules = {"height_m": (self.lowest_m, HIGHEST_M), "spacing_m": self.spacing_m, "beyond_m": out}
        try:
            return MountLimits.model_validate(rules)
        except ValidationError as error:
            problem = problems(error, rules)[0]
            raise InputError(problem.complaint.strip(), _FIELDS[str(problem.path[0])]) from error

    def box(self) -> tuple[tuple[float, float], ...] | None:
        """Return the box in the air along x, y and z."""
        if self.box_m is None:
            return None
        try:
            x0, x1, y0, y1, z0, z1 = map(float, self.box_m.split(","))
        except ValueError:
            raise InputError(f"must be X0,X1,Y0,Y1,Z0,Z1 (got '{self.box_m}')", "box_m") from None
        return (x0, x1), (y0, y1), (z0, z1)

    def moves(self) -> tuple[Mapping[str, float], Mapping[str, Sequence[str]]]:
        """Return how far sensors may go, metres, and the models that they may be exchanged for."""
        radius_m, models = dict[str, float](), dict[str, list[str]]()
        for word in self.move:
            radius_m |= numbers_of("move", (word,)) if "=" in word else {word: math.inf}
        for word in self.exchange:
            name, _, model = word.rpartition("=")
            if not name:
                raise InputError(f"must be NAME=MODEL (got '{word}')", "exchange")
            models.setdefault(name, []).append(model)
        return radius_m, models

    def additions(self, rules: MountLimits | None = None) -> Additions:
        """Return what may be added, by these rules instead of those of the options."""
        from riglens.core.optimise.additions import LEVELS_DEG, Additions, counts_of

        models, counts = counts_of(self.add)
        return Additions(
            models,
            self.count,
            not self.singles,
            numbers_of("cost", self.cost),
            math.inf if self.budget is None else self.budget,
            rules or self.rules(),
            self.spots_m,
            box_m=self.box(),
            counts=counts,
            yaw_deg=self.yaw_deg or (0.0,),
            tilts_deg=self.tilt_deg or LEVELS_DEG,
        )

    def problem(self, rig: Rig, traffic: Traffic, additions: Additions | None = None, **more: Any) -> Problem:
        """Return the problem of a rig in traffic; `more`: its further fields."""
        from riglens.core.optimise.additions import moves_of
        from riglens.core.optimise.problem import Problem

        return Problem(
            rig,
            traffic,
            additions or self.additions(),
            self.objective,
            self.frames,
            self.held_out,
            self.seed,
            blind_m=self.blind_m,
            moves=moves_of(*self.moves()),
            weights=self.weights(),
            **more,
        )


def numbers_of(option: str, words: tuple[str, ...]) -> Mapping[str, float]:
    """Return numbers by name, from words such as pedestrian=2."""
    found = {}
    for word in words:
        name, _, number_said = word.rpartition("=")
        try:
            found[name] = float(number_said)
        except ValueError:
            name = ""
        if not name:
            raise InputError(f"must be {_METAVARS[option]} (got '{word}')", option)
    return found
