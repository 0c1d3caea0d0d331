"""Compare predicted with true points on objects: rank correlation, and ratio."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.stats import spearmanr

from riglens.core.rig.model import Rig
from riglens.core.scene.boxes import CLASSES
from riglens.core.targets.engine import TargetEngine
from riglens.core.targets.settings import TargetSettings
from riglens.core.targets.traffic import Traffic

RINGS_M = ((0.0, 10.0), (10.0, 20.0), (20.0, 30.0), (30.0, 40.0))
FAR_RINGS_M = (*RINGS_M, (40.0, 50.0), (50.0, 60.0))
"""Of objects of all classes together, which are enough there."""
SHARES = (1, 5)
"""Points that shares of objects are counted with: what a rig is judged by."""
ONE_DRAW = "class shapes, range law"
"""The prediction used to compare rigs."""
GOOD_RATIO, GOOD_RANK = (0.8, 1.25), 0.9
FEWEST = 20
"""Fewer objects than this make an unreliable median."""
DRAWS = 16
EXPECTED = f"class shapes, range law, mean of {DRAWS} draws"
VARIANTS = {
    "plain boxes": TargetSettings(shape="box", range_law=False),
    "class shapes": TargetSettings(shape="class", range_law=False),
    ONE_DRAW: TargetSettings(shape="class", range_law=True),
    EXPECTED: TargetSettings(shape="class", range_law=True),
}
"""Methods of prediction. The last but one is that of `targets.engine`: one draw of each spin phase and of each return.
The last one is its average, without the luck of a draw, which is unrelated to other sweeps."""


@dataclass(frozen=True)
class Pairs:
    """k objects: sequence index, frame number in it, class, distance in metres, true points, and predicted ones by
    variant (k,); those of EXPECTED are means."""

    sequences: tuple[str, ...]
    sequence: NDArray[np.int64]
    frame: NDArray[np.int64]
    cls: NDArray[np.uint8]
    distance_m: NDArray[np.float64]
    true: NDArray[np.int64]
    predicted: Mapping[str, NDArray[np.float64]]

    def rank(self, variant: str, chosen: NDArray[np.bool_]) -> float | None:
        """Return Spearman's rank correlation over some objects; None if it is undefined."""
        true, predicted = self.true[chosen], self.predicted[variant][chosen]
        if len(np.unique(true)) < 2 or len(np.unique(predicted)) < 2:
            return None
        return float(spearmanr(predicted, true).statistic)

    def ratio(self, variant: str, chosen: NDArray[np.bool_]) -> tuple[float | None, int]:
        """Return the median of predicted over true points where both are above 0 (0.5 where means are predicted), and
        the number of objects."""
        true, predicted = self.true[chosen], self.predicted[variant][chosen]
        both = (true > 0) & (predicted >= 0.5)
        ratios = predicted[both] / true[both]
        return (float(np.median(ratios)) if ratios.size else None), int(ratios.size)

    def sums(self, variant: str, chosen: NDArray[np.bool_]) -> float | None:
        """Return predicted over true points of some objects, all added up; None if there are no true ones."""
        true = int(self.true[chosen].sum())
        return float(self.predicted[variant][chosen].sum()) / true if true else None

    def shares(self, variant: str, chosen: NDArray[np.bool_], least: int) -> tuple[float, float] | None:
        """Return the share of some objects with `least` points or more, predicted and true; None without objects."""
        if not chosen.any():
            return None
        predicted, true = self.predicted[variant][chosen] >= least, self.true[chosen] >= least
        return float(predicted.mean()), float(true.mean())

    def ring(self, cls: int | None, ring_m: tuple[float, float]) -> NDArray[np.bool_]:
        """Return which objects are of a class, or of any, and in a ring, (k,)."""
        low, high = ring_m
        mine = np.ones(len(self.cls), np.bool_) if cls is None else self.cls == cls
        return np.asarray(mine & (self.distance_m >= low) & (self.distance_m < high))

    def of_sequence(self, number: int | None) -> NDArray[np.bool_]:
        """Return which objects are of a sequence, (k,); all of them for None."""
        return np.asarray(self.sequence == number) if number is not None else np.ones(len(self.cls), np.bool_)


def predict(
    traffic: Traffic, true: NDArray[np.int64], rigs: Mapping[str, Rig] | Rig, threads: int | None = None
) -> Pairs:
    """Predict the points on all objects that count, each sequence with its own rig where they differ.

    true (n,) in the order of the data. Raise KeyError for a sequence without a rig.
    """
    labels = traffic.data.labels
    box = np.flatnonzero(traffic.counts)
    frame = traffic.frame[traffic.frame_of_box[box]]
    names: tuple[str, ...] = ("all",)
    sequence = np.zeros(len(box), np.int64)
    if labels is not None:
        names, sequence, frame = labels.names, labels.sequence[frame], labels.frame[frame]
    engine = TargetEngine(traffic, threads)
    predicted = {}
    for variant, settings in VARIANTS.items():
        seeds = range(DRAWS if variant == EXPECTED else 1)
        points = np.zeros(len(box))
        for number in np.unique(sequence):
            rig = rigs if isinstance(rigs, Rig) else rigs[names[number]]
            mine = sequence == number
            for seed in seeds:
                drawn = engine.evaluate(rig, replace(settings, seed=seed))
                points[mine] += drawn.objects.all_points[mine]
        predicted[variant] = points / len(seeds)
    row = traffic.row[box]
    return Pairs(names, sequence, frame, traffic.cls[box], traffic.distance_m[box], true[row], predicted)


def class_masks(pairs: Pairs) -> dict[str, NDArray[np.bool_]]:
    """Return masks of all objects, then of each class."""
    everything = {"all": np.ones(len(pairs.cls), np.bool_)}
    return everything | {name: np.asarray(pairs.cls == number) for number, name in enumerate(CLASSES)}
