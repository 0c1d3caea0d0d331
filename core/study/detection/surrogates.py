"""Figures of a rig without training that may predict its detection."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from riglens.core.engine.engine import Engine
from riglens.core.figures.hits import ON_TARGET, SEEN_BY_CAMERAS, SHARE_1, SHARE_5
from riglens.core.figures.objects import parts_by_class
from riglens.core.figures.predicted import PREDICTED
from riglens.core.metric.scores import PAPER_SETTINGS, Reading
from riglens.core.scene.boxes import CLASSES
from riglens.core.study.detection.protocol import Entrant
from riglens.core.study.detection.statistics import COLUMNS
from riglens.core.study.perception_entropy import fused_precision
from riglens.core.targets.counts import Counted
from riglens.core.targets.engine import TargetEngine
from riglens.core.targets.settings import TargetSettings
from riglens.core.targets.traffic import NO_CLASS

Doubles = NDArray[np.float64]

SURROGATES = {
    "s_ms": "S-MS as the paper has it, nats: lower where more is seen",
    "residual": "S-MS, reading residual, nats: higher where more is seen",
    "hits": "S-MS, reading hits, nats: lower where more rays meet entropy",
    "seen": "share of the entropy seen, 0 to 1",
    "predicted": "AP that the bundled calibration predicts from one sweep, 0 to 1",
    "on_target": "mean over objects of 1 - exp(-cells/5), 0 to 1",
    "share_5": "share of objects with 5 LiDAR points or more, 0 to 1",
    "share_1": "share of objects with a LiDAR point, 0 to 1",
    "seen_by_cameras": "mean share of an object's silhouette that cameras show, 0 to 1",
    "perception": "perception entropy read as AP, 0 to 1 (riglens.core.study.perception_entropy)",
    "rays": "LiDAR rays of a frame",
}
"""Figures compared with average precision, by name, of the sensors that take part; share_1 and rays are baselines to
beat. S-MS and seen are of the whole region of the scores, figures of objects of those that average precision is
over."""
_READINGS: dict[str, Reading] = {"s_ms": "covered", "residual": "residual", "hits": "hits"}
LOWER_IS_MORE = ("s_ms", "hits")
"""Figures whose lower values mean more coverage."""


@dataclass(frozen=True)
class Surrogates:
    """values: by name (rigs, COLUMNS); the last column is the mean over classes."""

    values: Mapping[str, Doubles]

    def of(self, name: str, column: str) -> Doubles:
        """Return one figure of all rigs, (rigs,)."""
        return self.values[name][:, COLUMNS.index(column)]


def surrogates(
    rigs: Sequence[Entrant],
    engine: Engine,
    targets: TargetEngine,
    settings: TargetSettings,
    tell: Callable[[float], None],
    judged: NDArray[np.bool_] | None = None,
) -> Surrogates:
    """Score the rigs in all ways; the car's body as `settings` says.

    judged (n,): which boxes of the traffic the detector is judged on; None: all objects that count.
    """
    values = {name: np.zeros((len(rigs), len(COLUMNS))) for name in SURROGATES}
    for place, entrant in enumerate(rigs):
        for name, by_class in _of(entrant, engine, targets, settings, judged).items():
            values[name][place] = np.array([*by_class, np.mean(by_class)])
        tell((place + 1) / len(rigs))
    return Surrogates(values)


def _of(
    entrant: Entrant,
    engine: Engine,
    targets: TargetEngine,
    settings: TargetSettings,
    judged: NDArray[np.bool_] | None,
) -> dict[str, list[float]]:
    found: dict[str, list[float]] = {}
    for name, reading in _READINGS.items():
        metric = replace(PAPER_SETTINGS, reading=reading, body=settings.body)
        classes = engine.evaluate(entrant.rig, metric).scores.classes
        found[name] = [classes[cls].s_ms for cls in CLASSES]
        if name == "s_ms":
            found["seen"] = [classes[cls].any_seen for cls in CLASSES]
    counted = targets.evaluate(entrant.rig, settings)
    return found | _of_objects(counted, judged) | {"rays": [float(entrant.rays)] * len(CLASSES)}


def _of_objects(counted: Counted, judged: NDArray[np.bool_] | None) -> dict[str, list[float]]:
    cls = counted.groups.cls
    values = {one.key: one.values(counted) for one in (PREDICTED, ON_TARGET, SHARE_5, SHARE_1)}
    values[SEEN_BY_CAMERAS.key] = SEEN_BY_CAMERAS.values(counted)
    values["perception"] = fused_precision(counted.objects)
    inside = counted.groups.inside(counted.calibration.domain)  # where the detector was judged
    values[PREDICTED.key] = np.where(inside, values[PREDICTED.key], np.nan)

    def by_class(values: NDArray[Any]) -> list[float]:
        return [_mean(values[cls == number]) for number in range(len(CLASSES))]

    if judged is not None:
        cls = np.where(judged[counted.objects.box], cls, NO_CLASS)
        return {key: by_class(one) for key, one in values.items()}
    figures = (ON_TARGET, SHARE_5, SHARE_1)
    rows = [one.total for one in parts_by_class(counted, figures).values()]
    own = {one.key: [row[one.key].value for row in rows] for one in figures}
    return {key: by_class(values[key]) for key in (PREDICTED.key, SEEN_BY_CAMERAS.key, "perception")} | own


def _mean(values: NDArray[Any]) -> float:
    """Return the mean of those values that are known; 0 without any."""
    known = values[~np.isnan(values)]
    return max(float(known.mean()), 0.0) if known.size else 0.0
