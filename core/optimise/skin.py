"""Gains of mounts on the car's skin for any rig: kept tables of candidates, and the sensors of a rig cast when new."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from riglens.core.errors import IsStale, never_stale
from riglens.core.optimise.makers import TableMaker
from riglens.core.optimise.mounts import Candidate
from riglens.core.optimise.objectives import Objective
from riglens.core.optimise.tables import Cells
from riglens.core.rig.model import Rig, Sensor

Doubles = NDArray[np.float64]


class SkinGains:
    """Gains of candidates for any rig: only sensors that changed since the last rig are cast.

    points_m, normals (m, 3): the spots of the candidates, those on the left first, then their images where candidates
    are pairs.
    """

    def __init__(
        self, goal: Objective, maker: TableMaker, listed: Sequence[Candidate], cells: Sequence[Cells]
    ) -> None:
        self.candidates, self._goal = tuple(listed), goal
        self._maker, self._table = maker, maker.table(np.zeros(0, np.int32), cells)
        self._held: dict[Sensor, Cells] = {}
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
        self._held = {one: self._held.get(one, _UNKNOWN) for one in own}
        for one, cells in self._held.items():
            if cells is _UNKNOWN:
                self._held[one] = self._maker.cells_of([one], is_stale)
        base = np.unique(np.concatenate([np.zeros(0, np.int32), *self._held.values()]))
        state = self._table.given(base, self._maker.known(base))
        return self._maker.shown_gains(self._table.gains_in(state, np.arange(self._table.size)))

    def by_spot(self, gains: Doubles) -> Doubles:
        """Return the best gain at each spot, (m,)."""
        best = dict.fromkeys(self._numbers, -np.inf)
        for one, gain in zip(self.candidates, gains.tolist(), strict=True):
            if one.on is not None:
                best[one.spot] = max(best[one.spot], gain)
        found = np.array([best[one] for one in self._numbers])
        return np.concatenate([found, found]) if self._is_paired else found


_UNKNOWN: Cells = np.zeros(0, np.int32)
