"""Define the figures of a calibration: the average precision, and the recall, that a detector would reach."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from riglens.core.figures.figure import Estimate
from riglens.core.figures.hits import LIDARS, RESOLVED
from riglens.core.figures.objects import ObjectFigure, parts_by_class

if TYPE_CHECKING:  # loads the compiler
    from riglens.core.targets.counts import Counted

PREDICTED = ObjectFigure(
    key="predicted",
    title="Predicted AP",
    short="Pred. AP",
    question="Average precision that a detector would reach on these objects with these LiDAR hits, by a calibration.",
    resolved=RESOLVED,
    leads=True,
    kinds=LIDARS,
    values=lambda counted: counted.curve(counted.calibration),
    calibration=lambda counted: counted.calibration,
)
FOUND = ObjectFigure(
    key="found",
    title="Found",
    question="Share of these objects that a detector would find with these LiDAR points, by a calibration.",
    resolved=RESOLVED,
    kinds=LIDARS,
    values=lambda counted: counted.curve(counted.settings.recall),
    calibration=lambda counted: counted.settings.recall,
)


def predicted_mean(counted: Counted) -> Estimate:
    """Return the mean of predicted detection over classes, or why it is missing: a class has no prediction."""
    found = [one.total["predicted"] for one in parts_by_class(counted, [PREDICTED]).values()]
    lacking = next((one for one in found if not one.exists), None)
    if lacking is not None:
        return lacking
    sample_se = float(np.linalg.norm([one.sample_se for one in found])) / len(found)
    return Estimate(
        sum(one.value for one in found) / len(found),
        math.hypot(sample_se, counted.calibration.mean_error),
        found[0].state,
        found[0].reason,
        sample_se,
        sum(one.objects for one in found),
    )


def found_text(counted: Counted, factor: float) -> str:
    """Say how many of 100 objects of each class are found, ± that many standard errors; empty where no calibration
    says so."""
    if counted.settings.recall is None:
        return ""
    classes = parts_by_class(counted, [FOUND])
    known = {name: one.total["found"] for name, one in classes.items() if one.total["found"].exists}
    shares = {name: (one.value, factor * one.se) for name, one in known.items()}
    return of_100(shares, counted.settings.recall.domain.region)


def of_100(found: Mapping[str, tuple[float, float]], region: str) -> str:
    """Say how many of 100 objects of each class in a region are found, ±, both as shares; empty without a class."""
    text = ", ".join(
        f"{name} {100.0 * value:.0f} ± {max(100.0 * error, 1.0):.0f}"
        for name, (value, error) in found.items()
    )
    return text and f"Found of 100 objects {region}: {text}"
