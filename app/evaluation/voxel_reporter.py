"""Looks at the voxel that the user picked, on the background thread."""

from __future__ import annotations

import numpy as np

from riglens.app.evaluation.picked import PickedVoxel
from riglens.core.engine.engine import Engine
from riglens.core.engine.inspect import sees_voxel
from riglens.core.engine.sight import Sensor, Sight, sight
from riglens.core.metric.scores import Method
from riglens.core.rig.model import Rig
from riglens.core.scene.pog import Pog
from riglens.core.scene.voxel import Voxel, VoxelFacts, voxel_facts


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
