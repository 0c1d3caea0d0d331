"""Predicted against true points on road users: rank correlation, and how many times too many."""

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
GOOD_RATIO, GOOD_RANK = (0.8, 1.25), 0.9
FEWEST = 20
"""Fewer objects than this make a median that says little."""
DRAWS = 16
EXPECTED = f"class shapes, range law, mean of {DRAWS} draws"
VARIANTS = {
    "plain boxes": TargetSettings(shape="box", range_law=False),
    "class shapes": TargetSettings(shape="class", range_law=False),
    "class shapes, range law": TargetSettings(shape="class", range_law=True),
    EXPECTED: TargetSettings(shape="class", range_law=True),
}
"""The ways to predict. The last but one is what `targets.engine` does: one draw of each spin phase and of each return.
The last one is what it counts on average, without the luck of a draw, which tells about no other sweep."""


@dataclass(frozen=True)
class Pairs:
    """Of k road users: sequence index, class, distance in metres, true points, and predicted ones by variant (k,);
    those of EXPECTED are means."""

    sequences: tuple[str, ...]
    sequence: NDArray[np.int64]
    cls: NDArray[np.uint8]
    distance_m: NDArray[np.float64]
    true: NDArray[np.int64]
    predicted: Mapping[str, NDArray[np.float64]]

    def rank(self, variant: str, chosen: NDArray[np.bool_]) -> float | None:
        """Spearman's rank correlation over some road users; None where it is not defined."""
        true, predicted = self.true[chosen], self.predicted[variant][chosen]
        if len(np.unique(true)) < 2 or len(np.unique(predicted)) < 2:
            return None
        return float(spearmanr(predicted, true).statistic)

    def ratio(self, variant: str, chosen: NDArray[np.bool_]) -> tuple[float | None, int]:
        """Median of predicted over true points where both are above 0 (0.5 where means are predicted), and of how many
        road users."""
        true, predicted = self.true[chosen], self.predicted[variant][chosen]
        both = (true > 0) & (predicted >= 0.5)
        ratios = predicted[both] / true[both]
        return (float(np.median(ratios)) if ratios.size else None), int(ratios.size)

    def ring(self, cls: int, ring_m: tuple[float, float]) -> NDArray[np.bool_]:
        """Which road users are of a class and in a ring, (k,)."""
        low, high = ring_m
        return np.asarray((self.cls == cls) & (self.distance_m >= low) & (self.distance_m < high))

    def of_sequence(self, number: int | None) -> NDArray[np.bool_]:
        """Which road users are of a sequence, (k,); all of them for None."""
        return np.asarray(self.sequence == number) if number is not None else np.ones(len(self.cls), np.bool_)


def predict(
    traffic: Traffic, true: NDArray[np.int64], rigs: Mapping[str, Rig] | Rig, threads: int | None = None
) -> Pairs:
    """Predict the points on all road users that count, each sequence with its own rig where they differ.

    true (n,) in the order of the data. Raise KeyError for a sequence without a rig.
    """
    labels = traffic.data.labels
    box = np.flatnonzero(traffic.counts)
    frame = traffic.frame[traffic.frame_of_box[box]]
    names: tuple[str, ...] = ("all",)
    sequence = np.zeros(len(box), np.int64)
    if labels is not None:
        names, sequence = labels.names, labels.sequence[frame]
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
    return Pairs(names, sequence, traffic.cls[box], traffic.distance_m[box], true[row], predicted)


def class_masks(pairs: Pairs) -> dict[str, NDArray[np.bool_]]:
    """All road users, then those of each class."""
    everything = {"all": np.ones(len(pairs.cls), np.bool_)}
    return everything | {name: np.asarray(pairs.cls == number) for number, name in enumerate(CLASSES)}
