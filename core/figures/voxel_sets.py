"""Define the sets of voxels that sensors of a rig cover: seen by any, by a kind, by several."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from riglens.core.sensors.registry import AnyKind, kind_named

if TYPE_CHECKING:  # loads the compiler
    from riglens.core.engine.engine import Engine, Evaluation
    from riglens.core.figures.evaluated import Need
    from riglens.core.scene.columns import Words

SetOf = Callable[["Engine", "Evaluation"], "Words"]
"""Returns a set of voxels of the evaluation, which holds what is seen, that an engine has just made."""


@dataclass(frozen=True, kw_only=True)
class VoxelSet:
    """Voxels that the sensors of a rig cover: those that a heatmap or a map from above shows.

    seen_by: who sees them ("any sensor"); of: called on the engine's thread. Without `least` enabled sensors,
    `least_kinds` kinds of them, or one of `kind`, the set is empty.
    """

    key: str
    seen_by: str
    of: SetOf
    least: int = 1
    least_kinds: int = 1
    kind: str = ""

    @property
    def needs(self) -> Need:
        """Return the parts of an evaluation that it reads."""
        return "voxels"

    @property
    def on_map(self) -> str:
        """Return the title of the map from above that shows the share of the entropy in this set."""
        return f"entropy seen by {self.seen_by}"

    @property
    def is_of_several(self) -> bool:
        """Return whether it takes more than one sensor."""
        return self.least > 1 or self.least_kinds > 1

    def lacks(self, kinds: Sequence[str]) -> str:
        """Return why the set is empty for a rig with enabled sensors of these kinds; "" where it may not be."""
        kind = kind_named(self.kind)
        if kind is not None:
            return "" if kind.name in kinds else f"No {kind.title} is enabled"
        if len(kinds) < self.least:
            return (
                "No sensor is enabled" if self.least == 1 else f"Fewer than {self.least} sensors are enabled"
            )
        if len(set(kinds)) < self.least_kinds:
            return f"Fewer than {self.least_kinds} kinds of sensors are enabled"
        return ""


def by_kind(kind: AnyKind) -> VoxelSet:
    """Return the voxels that sensors of a kind cover."""
    return VoxelSet(
        key=kind.name, seen_by=kind.plural, of=lambda _, found: found.seen[kind.name], kind=kind.name
    )


def at_least(key: str, sensors: int) -> VoxelSet:
    """Return the voxels that at least 2 or 3 sensors cover."""

    def of(engine: Engine, found: Evaluation) -> Words:
        from riglens.core.engine.inspect import covered_at_least  # loads the compiler

        words: Words = covered_at_least(engine, found.rig, found.settings.method)[sensors - 1]
        return words

    return VoxelSet(key=key, seen_by=f"at least {sensors}", of=of, least=sensors)


ANY = VoxelSet(key="any", seen_by="any sensor", of=lambda _, found: found.seen_by_any())
TWICE, THRICE = at_least("twice", 2), at_least("thrice", 3)
TWO_KINDS = VoxelSet(
    key="kinds", seen_by="two kinds", of=lambda _, found: found.seen_by_two_kinds(), least_kinds=2
)
