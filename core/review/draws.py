"""Measure as many draws of a tolerance profile as a verdict needs, and bound the chance that they show."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Generic, TypeVar

from riglens.core.geometry import Pose
from riglens.core.review.tolerance import ToleranceProfile, disturbed, errors_count, unit_draws
from riglens.core.rig.model import Rig

T = TypeVar("T")
CONFIDENCE = 0.95


class Draws(Generic[T]):
    """Measurements of a rig under errors of a profile, draw by draw. More draws begin with those of fewer."""

    def __init__(
        self, rig: Rig, profile: ToleranceProfile, seed: int, measure: Callable[[Rig, Pose], T]
    ) -> None:
        self._rig, self._profile, self._seed, self._measure = rig, profile, seed, measure
        self._found: list[T] = []

    def first(self, count: int) -> Sequence[T]:
        """Return the measurements of the first draws."""
        if count > len(self._found):
            units = unit_draws(count, errors_count(self._rig), self._seed)
            for errors in units[len(self._found) :]:
                self._found.append(self._measure(*disturbed(self._rig, self._profile, errors)))
        return self._found[:count]


def chance_bounds(count: int, draws: int) -> tuple[float, float]:
    """Return the lower and the upper bound of a chance that occurred `count` times in `draws` draws, each with 95 %
    confidence (Clopper and Pearson, Biometrika 26, 1934, exact for independent draws)."""
    from scipy.stats import beta  # slow to load

    low = float(beta.ppf(1.0 - CONFIDENCE, count, draws - count + 1)) if count else 0.0
    high = float(beta.ppf(CONFIDENCE, count + 1, draws - count)) if count < draws else 1.0
    return low, high
