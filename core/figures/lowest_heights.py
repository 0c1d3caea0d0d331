"""Define the maps of the ground around the car: the lowest visible height, and the overlap of fields of view."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from riglens.core.sensors.registry import kind_named, kinds

if TYPE_CHECKING:  # loads the compiler
    from riglens.core.blind.zones import By
    from riglens.core.figures.evaluated import Need


@dataclass(frozen=True)
class LowestHeight:
    """The lowest height L_k that k (1, 2) sensors of those that count see; with k = 0 the number of sensors that see an
    object."""

    by: By
    k: int

    @property
    def key(self) -> str:
        """Its name in settings."""
        return f"lowest_{self.k}_{self.by}" if self.k else "overlap"

    @property
    def needs(self) -> Need:
        """What has to be evaluated for it."""
        return "ground"

    @property
    def on_map(self) -> str:
        """Return the title of the map."""
        if not self.k:
            return "overlap of fields of view"
        kind = kind_named(self.by)
        one, several = ("sensor", "sensors") if kind is None else (kind.title, kind.plural)
        return f"L{'₁₂'[self.k - 1]}, lowest height seen by {self.k} {one if self.k == 1 else several}"


def lowest_heights() -> tuple[LowestHeight, ...]:
    """Return the maps of the ground around the car: for any sensor and for each kind, by one and by two."""
    whose = ("any", *(kind.name for kind in kinds()))
    return (*(LowestHeight(by, k) for k in (1, 2) for by in whose), LowestHeight("any", 0))
