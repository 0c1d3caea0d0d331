"""What is known about the voxel that the user picked: p and h, which sensors see it, and why others do not."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # made by the background thread, which loads what computes them
    from riglens.core.engine.sight import Sight
    from riglens.core.scene.voxel import VoxelFacts


@dataclass(frozen=True)
class PickedVoxel:
    """A voxel with what each sensor of the rig makes of it; no sensor counts where it is not informative."""

    facts: VoxelFacts
    sights: tuple[Sight, ...]

    @property
    def seen_by(self) -> tuple[str, ...]:
        """Names of the sensors that see it."""
        return tuple(found.sensor for found in self.sights if found.verdict == "sees")


def sight_text(found: Sight) -> str:
    """What a sensor makes of a voxel, in a few words."""
    if found.verdict == "outside" and found.miss_deg is not None:
        place = {"above": "above", "below": "below"}.get(found.side, "outside")
        return f"{place} field of view by {found.miss_deg:.1f}°"
    if found.verdict == "between" and found.miss_m is not None:
        return f"between rays, missed by {length_text(found.miss_m)}"
    texts = {"sees": "sees it", "off": "switched off", "range": "out of range"}
    return texts.get(found.verdict, "not seen")


def length_text(length_m: float) -> str:
    """A short length in millimetres, centimetres or metres."""
    if length_m < 0.01:
        return f"{1e3 * length_m:.1f} mm"
    return f"{100 * length_m:.1f} cm" if length_m < 1.0 else f"{length_m:.2f} m"
