"""Define the figures of voxels, the paper's score among them, and of the ground around the car."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from typing import TYPE_CHECKING

from riglens.core.figures.figure import ALL, Better, Estimate, Figure, Unit
from riglens.core.metric.scores import ClassScores, Scores
from riglens.core.sensors.registry import AnyKind

if TYPE_CHECKING:  # loads the compiler
    from riglens.core.figures.evaluated import Evaluated, Need


@dataclass(frozen=True, kw_only=True)
class VoxelFigure(Figure):
    """A figure of the voxels that sensors cover: `value` of the scores of a class. Shares of all classes together are
    weighted by their entropy, entropies are added up. covered_by: where it is the share of entropy that sensors cover,
    their kinds, empty for any; such a figure can be the objective of a search."""

    value: Callable[[ClassScores], float]
    covered_by: tuple[str, ...] | None = None

    @property
    def needs(self) -> Need:
        return "voxels"

    def of(self, rig: Evaluated, who: str) -> Estimate:
        if rig.voxels is None:
            return Estimate.none("no voxels were evaluated")
        return self.of_scores(rig.voxels.scores, who)

    def of_scores(self, scores: Scores, who: str) -> Estimate:
        """Return the figure of scores for a class, or for `ALL`."""
        classes = list(scores.classes.values()) if who == ALL else [scores.classes[who]]
        total = sum(one.h_total for one in classes)
        if total == 0.0:
            return Estimate.none("there are no boxes" if who == ALL else f"there is no {who} in the boxes")
        if len(classes) == 1:
            return Estimate(self.value(classes[0]))
        weights = [one.h_total / total if self.unit == "share" else 1.0 for one in classes]
        return Estimate(sum(w * self.value(one) for w, one in zip(weights, classes, strict=True)))

    def in_reading(self, reading: str) -> VoxelFigure:
        """Return the figure with the direction that it has in a reading of S-MIG."""
        return replace(self, better="more") if self.of_paper and reading == "residual" else self


SEEN = VoxelFigure(
    key="seen",
    title="Entropy seen",
    short="Seen",
    question="Share of the class's entropy H(Ω) that any enabled sensor covers, without occlusion by traffic.",
    is_spread=True,
    of_paper=True,
    place="any.seen",
    value=lambda scores: scores.any_seen,
    covered_by=(),
)
S_MS = VoxelFigure(
    key="s_ms",
    title="S-MS",
    unit="nat",
    better="neither",
    question="The paper's score; decreases as coverage grows: do not read it as a grade.",
    leads=True,
    of_paper=True,
    value=lambda scores: scores.s_ms,
)


@cache
def seen_by(kind: AnyKind) -> VoxelFigure:
    """Return the share of entropy that sensors of a kind cover."""
    return VoxelFigure(
        key=f"seen_{kind.name}",
        title=f"Entropy seen by {kind.plural}",
        question=f"Share of the class's entropy H(Ω) that enabled {kind.plural} cover.",
        place=f"{kind.name}.seen",
        value=lambda scores: scores.kinds[kind.name].seen,
        covered_by=(kind.name,),
    )


@cache
def s_mig(kind: AnyKind) -> VoxelFigure:
    """Return S-MIG of all sensors of a kind."""
    return VoxelFigure(
        key=f"s_mig_{kind.name}",
        title=f"{kind.heading} S-MIG",
        short=f"S-MIG {kind.title[:3]}.",
        unit="nat",
        better="neither",
        question=f"S-MIG of all enabled {kind.plural} together.",
        of_paper=True,
        place=f"{kind.name}.s_mig",
        value=lambda scores: scores.kinds[kind.name].s_mig,
    )


@dataclass(frozen=True, kw_only=True)
class BlindGround(Figure):
    """The ground around the car on which an object of a height is unseen by any sensor."""

    key: str = "blind_m2"
    title: str = "Blind ground"
    question: str = "Ground around the car on which no sensor sees a low object."
    unit: Unit = "m²"
    better: Better = "less"
    per_class: bool = False

    @property
    def needs(self) -> Need:
        return "ground"

    def of(self, rig: Evaluated, who: str) -> Estimate:
        if rig.ground is None:
            return Estimate.none("blind zones were not computed")
        return Estimate(float(rig.ground.unseen(rig.settings.blind_m).sum() * rig.ground.column_m2))


BLIND_GROUND = BlindGround()
