"""What is known about the voxel that the user picked: p and h, which sensors see it, and why others do not."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from core.engine.engine import Engine
from core.engine.inspect import sees_voxel
from core.engine.sight import Sensor, Sight, sight
from core.metric.scores import Method
from core.rig.model import Rig
from core.scene.pog import Pog
from core.scene.voxel import Voxel, VoxelFacts, voxel_facts


@dataclass(frozen=True)
class PickedVoxel:
    """A voxel with what each sensor of the rig makes of it; no sensor counts where it is not informative."""

    facts: VoxelFacts
    sights: tuple[Sight, ...]

    @property
    def seen_by(self) -> tuple[str, ...]:
        """Names of the sensors that see it."""
        return tuple(found.sensor for found in self.sights if found.verdict == "sees")


class VoxelReporter:
    """Looks at one voxel again and again while the rig changes; reasons are kept for sensors that stay."""

    def __init__(self, pog: Pog) -> None:
        self._pog = pog
        self._kept: dict[tuple[Sensor, Voxel], Sight] = {}

    def report(self, engine: Engine, rig: Rig, method: Method, voxel: Voxel, in_haste: bool) -> PickedVoxel:
        """The voxel as the engine's last evaluation, of this rig, sees it; `in_haste` leaves out new reasons."""
        facts = voxel_facts(self._pog, voxel)
        if not facts.is_informative:
            return PickedVoxel(facts, ())
        kept, self._kept = self._kept, {}
        sights = []
        for sensor in rig.sensors:
            sees = sensor.enabled and bool(sees_voxel(engine, sensor, method, voxel))
            found = kept.get((sensor, voxel))
            if found is None or (found.verdict == "sees") != sees:
                found = self._look(sensor, facts, sees, in_haste)
            if found.verdict != "missed":
                self._kept[sensor, voxel] = found
            sights.append(found)
        return PickedVoxel(facts, tuple(sights))

    def _look(self, sensor: Sensor, facts: VoxelFacts, sees: bool, in_haste: bool) -> Sight:
        if in_haste and sensor.enabled and not sees:
            away = np.array(facts.centre_m) - np.array(sensor.position)
            return Sight(sensor.name, "missed", float(np.linalg.norm(away)))
        return sight(sensor, self._pog.grid, facts.voxel, sees)


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
