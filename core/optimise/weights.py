"""Weigh objects: of their class in the mean over classes, and of their distance within a class."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from riglens.core.errors import InputError
from riglens.core.scene.boxes import CLASSES

Doubles = NDArray[np.float64]


@dataclass(frozen=True)
class Weights:
    """Weights by class and by ring [from, to) in metres around the car, 1 where nothing is said."""

    classes: Mapping[str, float] = field(default_factory=dict)
    rings: Mapping[tuple[float, float], float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name, weight in self.classes.items():
            if name not in CLASSES:
                raise InputError(f"must name one of {', '.join(CLASSES)}, or a ring (got '{name}')", "weight")
            if not 0.0 <= weight < math.inf:
                raise InputError(f"{name} must be at least 0 (got {weight:g})", "weight")
        if not any(self.by_class):
            raise InputError("must leave a class that counts", "weight")
        for (low, high), weight in self.rings.items():
            if not (0.0 <= low < high and 0.0 <= weight < math.inf):
                raise InputError(f"{low:g}-{high:g} must be a ring in m, and its weight at least 0", "weight")
        for (_, end), (start, _) in pairwise(sorted(self.rings)):
            if start < end:
                raise InputError(f"rings must not overlap (one ends at {end:g} m)", "weight")

    @property
    def by_class(self) -> Doubles:
        """Weights in the order of CLASSES."""
        return np.array([self.classes.get(name, 1.0) for name in CLASSES])

    def at(self, distance_m: Doubles) -> Doubles:
        """Return the weights of objects by their distance, (k,)."""
        found = np.ones(len(distance_m))
        for (low, high), weight in self.rings.items():
            found[(distance_m >= low) & (distance_m < high)] = weight
        return found


EVEN = Weights()
