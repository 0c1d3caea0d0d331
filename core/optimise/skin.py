"""Gains of mounts on the car's skin for any rig: kept tables of candidates, and the sensors of a rig cast when new."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from riglens.core.errors import IsStale, never_stale
from riglens.core.optimise.makers import Maker
from riglens.core.optimise.objectives import Objective
from riglens.core.optimise.placing import Candidate
from riglens.core.rig.model import Rig, Sensor

Doubles = NDArray[np.float64]


class SkinGains:
    """Gains of candidates for any rig: only sensors that changed since the last rig are cast.

    points_m, normals (m, 3): the spots of the candidates, those on the left first, then their images where candidates
    are pairs.
    """

    def __init__(
        self, goal: Objective, maker: Maker[Any], listed: Sequence[Candidate], cells: Sequence[Any]
    ) -> None:
        self.candidates, self._goal = tuple(listed), goal
        self._maker, self._table = maker, maker.table(maker.joined([]), cells)
        self._held: dict[Sensor, Any] = {}
        spots = {one.spot: one.on for one in listed if one.on is not None}
        self._numbers = sorted(spots)
        points = np.array([spots[one].point_m for one in self._numbers]).reshape(-1, 3)
        normals = np.array([spots[one].normal for one in self._numbers]).reshape(-1, 3)
        self._is_paired = any(len(one.sensors) > 1 for one in listed)
        flip = np.array([1.0, -1.0, 1.0])
        both = [1.0, flip] if self._is_paired else [1.0]
        self.points_m = np.concatenate([points * side for side in both])
        self.normals = np.concatenate([normals * side for side in both])

    def gains(self, rig: Rig, is_stale: IsStale = never_stale) -> Doubles:
        """Return by how much each candidate would improve the rig, (n,), in the unit of the figure."""
        own = self._goal.sensors_of(rig)
        self._held = {
            one: self._held[one] if one in self._held else self._maker.cells_of([one], is_stale)
            for one in own
        }
        base = self._maker.joined(list(self._held.values()))
        return self._maker.shown_gains(self._maker.gains_next_to(self._table, base))

    def by_spot(self, gains: Doubles) -> Doubles:
        """Return the best gain at each spot, (m,)."""
        best = dict.fromkeys(self._numbers, -np.inf)
        for one, gain in zip(self.candidates, gains.tolist(), strict=True):
            if one.on is not None:
                best[one.spot] = max(best[one.spot], gain)
        found = np.array([best[one] for one in self._numbers])
        return np.concatenate([found, found]) if self._is_paired else found
