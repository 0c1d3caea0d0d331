"""Test figures of rigs from outside: their ratios against those of published average precision.

A figure passes where its ratio, on boxes of the recording, differs from the published one by TOLERANCE at most: this
was fixed before the first run. All figures count the same objects, those of `Anchor.region`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from riglens.core.engine.engine import Engine
from riglens.core.figures.hits import ON_TARGET, SEEN_BY_CAMERAS, SHARE_5
from riglens.core.figures.objects import ObjectFigure
from riglens.core.figures.predicted import PREDICTED
from riglens.core.metric.scores import PAPER_SETTINGS
from riglens.core.rig.model import Rig
from riglens.core.scene.boxes import CLASSES
from riglens.core.study.anchors import WITHIN_M, Anchor, Mix, Recording, anchors
from riglens.core.study.perception_entropy import fused_precision
from riglens.core.targets.counts import Counted
from riglens.core.targets.engine import TargetEngine
from riglens.core.targets.groups import RUNS
from riglens.core.targets.settings import TargetSettings
from riglens.core.targets.traffic import Traffic

Doubles = NDArray[np.float64]

TOLERANCE = 0.05
REPLICAS = 400
"""Draws of runs of frames, with replacement, for the ± of the traffic."""
_OF_OBJECTS: tuple[ObjectFigure, ...] = (PREDICTED, ON_TARGET, SHARE_5, SEEN_BY_CAMERAS)
FIGURES = {
    "predicted": "predicted AP",
    "on_target": "on target",
    "share_5": "≥ 5 points",
    "seen_by_cameras": "seen by cameras",
    "seen": "seen",
}
"""Figures compared, by name; the last one is the paper's entropy."""
PERCEPTION = "perception"
"""Perception entropy of Ma et al. (2021), for comparison."""
INSIDE = "inside"
"""Seen by cameras without the edge of the picture: the visible share of what lies inside the picture."""
_LEAST = {PREDICTED.key: 0.0}


@dataclass(frozen=True)
class AnchorRatios:
    """The published ratio of an anchor, and the ratios of the figures by name, NaN where there is none; traffic_sd:
    standard deviation of the judged one over runs of frames drawn with replacement."""

    anchor: Anchor
    boxes: str
    ratios: Mapping[str, float]
    traffic_sd: float

    def error(self, figure: str) -> float:
        """Return by how much the ratio of a figure is above the published one."""
        return self.ratios[figure] - self.anchor.published

    def passes(self, figure: str) -> bool:
        """Return whether a figure's ratio is the published one within the tolerance."""
        return abs(self.error(figure)) <= TOLERANCE

    @property
    def judged(self) -> float:
        """The ratio of the figure that the anchor judges."""
        return self.ratios[self.anchor.figure]


@dataclass(frozen=True)
class _Sums:
    """Sums of figures of objects, (figures, classes, runs), and the numbers of objects, (classes, runs)."""

    values: Doubles
    objects: Doubles

    def means(self, weights: Doubles) -> Doubles:
        """Return means (figures, classes, replicas) of runs with weights (runs, replicas); NaN without objects."""
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.asarray(self.values @ weights / (self.objects @ weights))


class _Recorded:
    """Figures of rigs on the objects of a recording, each rig counted once."""

    def __init__(self, targets: TargetEngine, engine: Engine, frames: int) -> None:
        self._targets, self._engine, self._frames = targets, engine, frames
        self._sums = dict[Rig, _Sums]()
        self._seen = dict[Rig, Doubles]()
        rng = np.random.default_rng(0)
        drawn = rng.multinomial(RUNS, np.full(RUNS, 1.0 / RUNS), REPLICAS).T.astype(np.float64)
        self._weights = np.concatenate([np.ones((RUNS, 1)), drawn], axis=1)

    def ratios(self, anchor: Anchor) -> tuple[dict[str, float], float]:
        """Return the ratios of all figures, and the deviation of the judged one."""
        rows = [CLASSES.index(cls) for cls in anchor.classes]
        before, after = (self._figures(mix, rows) for mix in (anchor.before, anchor.after))
        found = {
            name: np.divide(after[name], of, out=np.full(of.shape, np.nan), where=of > 0.0)
            for name, of in before.items()
        }
        ratios = {name: float(of[0]) for name, of in found.items()}
        judged = found[anchor.figure][1:]
        known = judged[~np.isnan(judged)]
        return ratios, float(known.std()) if known.size else math.nan

    def _figures(self, mix: Mix, rows: Sequence[int]) -> dict[str, Doubles]:
        """Return each figure, mean over classes, on all objects and on replicas of them, (1 + REPLICAS,)."""
        parts = [(share, self._sums_of(rig)) for share, rig in mix]
        means = np.sum([share * sums.means(self._weights) for share, sums in parts], axis=0)
        names = [*(one.key for one in _OF_OBJECTS), PERCEPTION, INSIDE]
        least = np.array([_LEAST.get(name, -math.inf) for name in names])[:, None, None]
        of_classes = _mean_known(np.maximum(means, least)[:, rows])
        seen = np.nan
        if len(mix) == 1:  # where sensors are lost at random, it would take a scene for each set
            seen = float(self._seen_of(mix[0][1])[list(rows)].mean())
        return dict(zip(names, of_classes, strict=True)) | {"seen": np.full(1 + REPLICAS, seen)}

    def _sums_of(self, rig: Rig) -> _Sums:
        if rig not in self._sums:
            settings = TargetSettings(body=None)
            counted = self._targets.evaluate(rig, settings, self._frames, with_losses=True)
            values = [*(one.values(counted) for one in _OF_OBJECTS), fused_precision(counted.objects)]
            values.append(_shown_inside(counted))
            self._sums[rig] = _sums(counted, np.stack(values))
        return self._sums[rig]

    def _seen_of(self, rig: Rig) -> Doubles:
        if rig not in self._seen:
            classes = self._engine.evaluate(rig, replace(PAPER_SETTINGS, body=rig.body)).scores.classes
            self._seen[rig] = np.array([classes[cls].any_seen for cls in CLASSES])
        return self._seen[rig]


def _shown_inside(counted: Counted) -> Doubles:
    """Return the visible share of what lies inside the picture that shows most of an object, (k,); 0 outside every
    picture."""
    assert counted.losses is not None
    shown, inside = counted.objects.visible, 1.0 - np.nan_to_num(counted.losses.outside, nan=1.0)
    return np.divide(shown, inside, out=np.zeros(len(shown)), where=shown > 0.0)


def _mean_known(values: Doubles) -> Doubles:
    """Return the mean over classes (figures, classes, replicas) of those that have objects; NaN where none has."""
    known = ~np.isnan(values)
    count = known.sum(axis=1)
    total = np.where(known, values, 0.0).sum(axis=1)
    return np.asarray(np.divide(total, count, out=np.full(total.shape, np.nan), where=count > 0))


def _sums(counted: Counted, values: Doubles) -> _Sums:
    """Add up values (figures, k) of objects by class and run of frames; objects without a value do not count."""
    group = counted.groups.cls.astype(np.int64) * RUNS + counted.groups.run
    size = len(CLASSES) * RUNS
    sums = [np.bincount(group, np.nan_to_num(one), size) for one in values]
    objects = np.bincount(group, ~np.isnan(values).any(axis=0), size).astype(np.float64)
    shape = len(CLASSES), RUNS
    return _Sums(np.reshape(sums, (len(values), *shape)), objects.reshape(shape))


def outcomes(
    recording: Recording,
    traffic: Traffic,
    engine: Engine,
    frames: int,
    tell: Callable[[float], None] = lambda share: None,
) -> list[AnchorRatios]:
    """Compute the figures of the anchors on a recording, on the objects of `frames` frames of some boxes."""
    recorded = _Recorded(TargetEngine(traffic.within(WITHIN_M[recording])), engine, frames)
    found = []
    for number, one in enumerate(anchors(recording), 1):
        found.append(AnchorRatios(one, traffic.data.source, *recorded.ratios(one)))
        tell(number / len(anchors(recording)))
    return found


def mean_error(found: Sequence[AnchorRatios], figure: str) -> float:
    """Return the mean of the absolute errors of a figure, NaN without any."""
    errors = [abs(one.error(figure)) for one in found if not math.isnan(one.ratios[figure])]
    return float(np.mean(errors)) if errors else math.nan
