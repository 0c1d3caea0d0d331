"""Measure the figures of a rig that tolerances spread."""

from __future__ import annotations

import math
import operator
from collections.abc import Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from riglens.core.errors import IsStale, never_stale
from riglens.core.figures.evaluated import Evaluated, Evaluator, Need
from riglens.core.figures.figure import Estimate, Figure
from riglens.core.figures.objects import ObjectFigure
from riglens.core.figures.registry import tolerated_figures
from riglens.core.geometry import Pose
from riglens.core.review.tolerance import standing
from riglens.core.rig.model import Rig
from riglens.core.scene.boxes import CLASSES
from riglens.core.targets.counts import Counted

FEW_CHANGED = 10
"""Objects of a sample below which their changes do not tell how much those of others differ. Our choice."""


def measured_name(figure: Figure, cls: str) -> str:
    """Return the name of a figure of a class among those measured."""
    return f"{figure.key} {cls}"


class _Designed(NamedTuple):
    """The figures of the rig as designed in all frames, by key and class, and its counts in the sample."""

    whole: Mapping[str, Mapping[str, Estimate]]
    sample: Counted


class Measures:
    """Measurement of rigs one after another: `KEY CLASS` of the leading figures, those of objects where there is
    traffic.

    Objects are counted in the first `frames` frames, 0 for none; what `evaluate` holds of a sensor is not cast again.
    With `designed`, they are counted in all frames for that rig alone: a figure of objects is then its own plus the
    change that the sample shows, object by object, with the standard error of that change, so that the rig as
    designed has one figure everywhere. For the thread of the parallel kernels.
    """

    def __init__(self, evaluate: Evaluator, frames: int | None = None, designed: Rig | None = None) -> None:
        self._evaluate, self._frames, self._designed = evaluate, frames, designed
        self._of_design: _Designed | None = None
        self._last: Rig | None = None
        wanted = tolerated_figures()
        self._of_voxels = tuple(one for one in wanted if one.needs == "voxels")
        self._of_objects = tuple(one for one in wanted if isinstance(one, ObjectFigure))

    @cached_property
    def _moved(self) -> Evaluator:
        """Evaluates the rigs that are measured."""
        return self._evaluate.beside()

    @property
    def frames(self) -> tuple[int, int]:
        """Return the number of frames in which objects are counted, and the total."""
        traffic = self._evaluate.traffic
        most = 0 if traffic is None or self._frames == 0 else traffic.frames
        return (most if self._frames is None else min(self._frames, most)), most

    def __call__(self, rig: Rig, stance: Pose, cancel: IsStale = never_stale) -> dict[str, Estimate]:
        """Return the figures of a rig with a stance of its car, with the standard errors that the sample adds;
        Cancelled as soon as `cancel` returns True."""
        used, most = self.frames
        designed = self._as_designed(cancel) if self._designed is not None and used < most else None
        found = self._found(standing(rig, stance), stance, cancel)
        figures = {measured_name(one, cls): one.of(found, cls) for one in self._of_voxels for cls in CLASSES}
        if found.objects is not None:
            for one in self._of_objects:
                names = (measured_name(one, cls) for cls in CLASSES)
                figures |= zip(names, _estimates(one, found.objects, designed), strict=True)
        return figures

    def _found(self, rig: Rig, stance: Pose, cancel: IsStale) -> Evaluated:
        """Evaluate a rig: its objects are counted while its voxels are evaluated, where there are threads for both."""
        (used, most), last, self._last = self.frames, self._last, rig
        anew = last is not None and not any(map(operator.eq, rig.sensors, last.sensors))
        if not most or self._evaluate.threads == 1:
            needs: tuple[Need, ...] = ("voxels", "objects") if most else ("voxels",)
            return self._moved(rig, needs, used, stance, cancel, anew=anew)
        with ThreadPoolExecutor(1) as other:
            counting = other.submit(self._moved, rig, ("objects",), used, stance, cancel)
            voxels = self._moved(rig, ("voxels",), None, stance, cancel, anew=anew)
            return replace(voxels, objects=counting.result().objects)

    def _as_designed(self, cancel: IsStale) -> _Designed:
        """Return the counts of the rig as designed."""
        assert self._designed is not None
        if self._of_design is None:
            whole = self._evaluate(self._designed, ("objects",), cancel=cancel).objects
            sample = self._moved(self._designed, ("objects",), self._frames, cancel=cancel).objects
            assert whole is not None and sample is not None
            self._of_design = _Designed({one.key: _by_class(one, whole) for one in self._of_objects}, sample)
        return self._of_design


def _estimates(figure: ObjectFigure, counted: Counted, designed: _Designed | None) -> Iterator[Estimate]:
    """Yield a figure for each class; of all frames and changed as the sample shows, where there is a rig as designed.

    A change that hardly any object of the sample shows may be there in others: its error is at least what one makes."""
    if designed is None:
        for one in _by_class(figure, counted).values():
            yield Estimate(one.value, one.sample_se)
        return
    cells = figure.cells(counted, designed.sample, in_detail=False)
    left = math.sqrt(1.0 - counted.frames_used / counted.frames)
    has_changed = np.nan_to_num(figure.values(counted) - figure.values(designed.sample)) != 0.0
    changed = np.bincount(counted.groups.cls[has_changed], minlength=len(CLASSES))
    for row, own in enumerate(designed.whole[figure.key].values(), 1):
        objects = int(cells.objects[row, 0]) if own.exists else 0
        change, se = (float(one[row, 0]) if objects else 0.0 for one in (cells.change, cells.change_se))
        least = left / max(objects, 1) if own.exists and changed[row - 1] < FEW_CHANGED else 0.0
        yield Estimate(min(1.0, max(0.0, own.value + change)), max(se, least))


def _by_class(figure: ObjectFigure, counted: Counted) -> dict[str, Estimate]:
    return {
        cls: cells[0] for cls, cells in figure.estimates(counted, "all", CLASSES, in_detail=False).items()
    }
