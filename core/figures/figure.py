"""Define a figure: a number about a rig with its unit, direction, question and error, and how it is worked out."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from riglens.core.scene.boxes import CLASSES

if TYPE_CHECKING:
    from riglens.core.figures.evaluated import Evaluated, Need

Better = Literal["more", "less", "neither"]
State = Literal["exact", "sampled", "outside", "none"]
Unit = Literal["share", "nat", "m²", "points", "px", "m"]
ALL = "all"
CLASSES_AND_ALL = (ALL, *CLASSES)
"""Rows of a table: objects of all classes, then class by class."""
SE_FACTOR = 2.0
"""Standard errors behind ± everywhere: 95 % of samples are nearer to the exact value."""


def absence(who: str) -> str:
    """Say that there is nothing of a class, or of `ALL`, to measure."""
    return f"there is no {'object' if who == ALL else who} there"


@dataclass(frozen=True)
class Estimate:
    """A figure's value, with its standard error `se` where it comes from a sample or a calibration.

    state: "exact"; "sampled": of some frames; "outside" the figure's domain, and "none": there is nothing to measure,
    both with the reason. value: 0 where there is none. sample_se: the part of `se` that more frames would remove;
    objects: number of objects that it was measured on; parts: the value with sensors of one kind alone, by kind; runs:
    how far each run of frames moves the value, from which a change gets its error.
    """

    value: float = 0.0
    se: float = 0.0
    state: State = "exact"
    reason: str = ""
    sample_se: float = 0.0
    objects: int = 0
    parts: Mapping[str, float] = field(default_factory=dict, hash=False)
    runs: tuple[float, ...] = field(default=(), repr=False)

    @property
    def exists(self) -> bool:
        """Return whether there was anything to measure."""
        return self.state != "none"

    def minus(self, before: Estimate) -> Estimate:
        """Return the change from another estimate of the same objects, with its error in traffic like theirs; or the
        reason of the one that is missing."""
        lacking = next((one for one in (self, before) if not one.exists), None)
        many = max(len(self.runs), len(before.runs))
        mine, theirs = (np.array(one.runs or (0.0,) * many) for one in (self, before))
        se = float(error_of_runs(mine - theirs))
        change = self.value - before.value
        return lacking or Estimate(change, se, self.state, self.reason, objects=before.objects)

    @classmethod
    def none(cls, reason: str) -> Estimate:
        """Return the estimate of a figure that a rig or scene does not have."""
        return cls(state="none", reason=reason)


def error_of_runs(runs: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the standard error of a value (...) in other traffic of its kind, from how far each run of frames (runs,
    ...) moves it: 0 with fewer than two runs. A ratio of totals over runs, linearised (Cochran, Sampling Techniques,
    1977, chapter 6), without a correction for a finite number of runs."""
    many = len(runs)
    return np.asarray(np.sqrt((runs**2).sum(axis=0) * (many / (many - 1) if many > 1 else 0.0)))


@dataclass(frozen=True, kw_only=True)
class Figure(ABC):
    """A number about a rig, for each class of objects or for the whole rig.

    key: its name in JSON, requirements, sweeps, objectives and Python; title, and `short` where space is short;
    question: one sentence that says what it measures, for tooltips, help and docs; better: its direction; resolved:
    least difference that tells two rigs apart, in its unit; leads: whether it stands in the first tables; is_spread:
    whether tolerances spread it though it does not lead; of_paper: whether it is a detail of the paper's score;
    per_class: False for a figure of the whole rig; place: where its value stands in the JSON of a class and among the
    columns of sweeps, if not under its key, with dots between the names; needs: what has to be evaluated for it.
    """

    key: str
    title: str
    short: str = ""
    unit: Unit = "share"
    better: Better = "more"
    question: str
    resolved: float = 0.0
    leads: bool = False
    is_spread: bool = False
    of_paper: bool = False
    per_class: bool = True
    place: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "short", self.short or self.title)
        object.__setattr__(self, "place", self.place or self.key)

    @property
    @abstractmethod
    def needs(self) -> Need:
        """Part of an evaluation that this figure reads."""

    @abstractmethod
    def of(self, rig: Evaluated, who: str) -> Estimate:
        """Return the figure of an evaluated rig for a class, or for `ALL` of them."""

    def change(self, now: Evaluated, before: Evaluated, who: str) -> Estimate:
        """Return the change from one rig to another in the same scene, with its own error."""
        return self.of(now, who).minus(self.of(before, who))

    @property
    def tip(self) -> str:
        """The question and the direction, for tooltips and help."""
        directions = {"more": " More is better.", "less": " Less is better.", "neither": ""}
        return f"{self.question}{directions[self.better]}"

    def column(self, who: str) -> str:
        """Return the name of its column in the table of a sweep."""
        return f"{who}.{self.place}" if self.per_class else self.key

    def region(self, rig: Evaluated) -> str:
        """Return what counts, in words: the objects, voxels or ground that the figure is about."""
        parts = {"voxels": rig.voxels_region, "objects": rig.objects_region, "ground": rig.ground_region}
        return parts[self.needs]

    def is_gain(self, change: float) -> bool | None:
        """Return whether a change is for the better; None where it is too small to tell, or has no direction."""
        if self.better == "neither" or abs(change) < self.resolved or change == 0.0:
            return None
        return (change > 0.0) == (self.better == "more")
