"""Figures of a rig by key and class, with their changes from a baseline: light enough to be kept and shown."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Self

from riglens.core.figures.coverage import VoxelFigure
from riglens.core.figures.figure import CLASSES_AND_ALL, Estimate, Figure, State, absence
from riglens.core.figures.objects import Cells, ObjectFigure
from riglens.core.figures.registry import figures, object_figures
from riglens.core.figures.weakest import Weakest, weakest_by_class
from riglens.core.metric.scores import Scores

if TYPE_CHECKING:  # loads the compiler
    from riglens.core.targets.counts import Counted
    from riglens.core.targets.groups import By

Values = Mapping[str, Mapping[str, Estimate]]
"""Estimates by key of a figure, and by class or `ALL`."""


@dataclass(frozen=True)
class Compared:
    """A figure of a rig and its change from a baseline, each by class or `ALL`; about: what it is of, in words;
    weakest: where it is worst, if that is known."""

    value: Mapping[str, Estimate]
    change: Mapping[str, Estimate]
    about: str = ""
    weakest: Mapping[str, Weakest] = field(default_factory=dict, hash=False)


def class_figures(present: Iterable[str] | None = None) -> tuple[VoxelFigure | ObjectFigure, ...]:
    """Return the figures of classes, of voxels and of objects, of rigs with sensors of some kinds."""
    return tuple(one for one in figures(present) if isinstance(one, VoxelFigure | ObjectFigure))


def values_of_scores(scores: Scores) -> Values:
    """Return every figure of voxels, of the kinds of sensor that were scored."""
    present = next(iter(scores.classes.values())).kinds
    return {
        one.key: {who: one.of_scores(scores, who) for who in CLASSES_AND_ALL}
        for one in class_figures(present)
        if isinstance(one, VoxelFigure)
    }


def values_of_objects(counted: Counted) -> Values:
    """Return every figure of objects."""
    return {
        one.key: {who: found for who, (found,) in one.estimates(counted, "all").items()}
        for one in object_figures()
    }


def compared_scores(now: Scores, before: Scores) -> dict[str, Compared]:
    """Return every figure of voxels, with its change from those of a baseline."""
    mine, theirs = values_of_scores(now), values_of_scores(before)
    return {
        key: Compared(found, {who: found[who].minus(theirs[key][who]) for who in found})
        for key, found in mine.items()
    }


@dataclass(frozen=True)
class FigureCells:
    """Cells of a figure of a rig, row by row of CLASSES_AND_ALL.

    lack: why the rig has no such figure, outside: why it is outside the figure's domain; empty otherwise. region: of
    the objects that count, in words; detector: of the calibration that it rests on. weakest: where the figure is worst,
    if all frames were used and the cells are those of whole classes.
    """

    figure: ObjectFigure
    cells: Cells
    lack: str
    outside: str
    region: str
    detector: str = ""
    weakest: Mapping[str, Weakest] = field(default_factory=dict, hash=False)

    @classmethod
    def of(
        cls,
        figure: ObjectFigure,
        now: Counted,
        before: Counted,
        by: By = "all",
    ) -> Self:
        """Return the cells of a rig by part, with changes from a baseline."""
        lack, calibration = figure.lacks(now), figure.calibrated(now)
        cells = figure.cells(now, before, by)
        where = f"within {now.within_m:g} m"
        weakest = weakest_by_class(figure, now) if by == "all" and now.is_whole else {}
        if calibration is None:
            return cls(figure, cells, lack, "", where, weakest=weakest)
        about = f"{calibration.predicts} of this detector: {calibration.detector}"
        where = calibration.domain.region if figure.in_domain else where
        return cls(figure, cells, lack, now.outside(calibration), where, about, weakest)

    def anchored(self, exact: FigureCells) -> FigureCells:
        """Return exact values of the same baseline plus the changes of this sample."""
        return replace(self, cells=self.cells.anchored(exact.cells))

    def at(self, who: str, part: int = 0) -> tuple[Estimate, Estimate]:
        """Return the figure of a class or of `ALL` in a part, and its change."""
        row, cells = CLASSES_AND_ALL.index(who), self.cells
        objects, value, change = (
            int(cells.objects[row, part]),
            *(float(one[row, part]) for one in (cells.value, cells.change)),
        )
        if self.lack or math.isnan(value):
            none = Estimate.none(self.lack or absence(who))
            return none, none
        se, change_se = float(cells.se[row, part]), float(cells.traffic_se[row, part])
        state: State = "outside" if self.outside else "sampled" if se else "exact"
        parts = {kind: float(one.value[row, part]) for kind, one in cells.parts.items()}
        found = Estimate(value, se, state, self.outside, objects=objects, parts=parts)
        return found, replace(found, value=change, se=change_se, parts={})

    def compared(self) -> Compared:
        """Return the figure of each row in the first part."""
        pairs = {who: self.at(who) for who in CLASSES_AND_ALL}
        value, change = ({who: pair[place] for who, pair in pairs.items()} for place in (0, 1))
        return Compared(value, change, self.about, self.weakest)

    @property
    def about(self) -> str:
        """Region and detector of the figure, in words."""
        return "\n".join(filter(None, (f"Objects {self.region}", self.detector)))


def in_reading(figure: Figure, reading: str) -> Figure:
    """Return a figure with the direction that it has in a reading of S-MIG."""
    return figure.in_reading(reading) if isinstance(figure, VoxelFigure) else figure
