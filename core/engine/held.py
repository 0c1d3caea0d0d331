"""The state of an engine: the sensors of the rig evaluated last and the voxels that they traverse."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from riglens.core.engine.caster import Window
from riglens.core.metric.scores import Method
from riglens.core.rig.model import Sensor
from riglens.core.sensing.body_ends import Obstacle
from riglens.core.vehicle.solid import Barrier

FEWEST_DIGITS = 4
"""Binary digits in which others are counted at first."""


class Shape(NamedTuple):
    """Everything that determines the rays of a sensor: the casting method, the sensor without name and switch, and what
    stops its rays, None if the body is ignored."""

    method: Method
    sensor: Sensor
    stop: Obstacle | None

    @property
    def barrier(self) -> Barrier | None:
        return None if self.stop is None else self.stop.barrier


@dataclass(frozen=True)
class Held:
    """Sensor whose contribution is in a slot; `kind`: the row of its kind."""

    shape: Shape
    kind: int
    slot: int
    window: Window


@dataclass
class Others:
    """Sensors of a kind that stay while others move: the window of each by its slot; the number of them that see each
    voxel, in binary digits (digits, words), lowest first; and the informative voxels that none of them sees, `free`
    (words,). An edit of the same sensors reuses it; when others move, it is updated."""

    windows: dict[int, Window]
    counts: NDArray[np.uint64]
    free: NDArray[np.uint64]

    def digits(self, sensors: int) -> NDArray[np.uint64]:
        """Return the digits needed to count `sensors` sensors; untouched pages cost no memory."""
        digits = sensors.bit_length()
        if digits > len(self.counts):
            more = np.zeros((max(digits, FEWEST_DIGITS), self.free.size), np.uint64)
            more[: len(self.counts)] = self.counts
            self.counts = more
        return self.counts[:digits]


@dataclass
class State:
    """Free rows of the stack are empty; the union holds informative voxels only, the stack maybe others too; `others`
    by kind, of those that ever had any."""

    stack: NDArray[np.uint64]
    union: NDArray[np.uint64]
    sums_q: NDArray[np.int64]
    others: dict[int, Others] = field(default_factory=dict)
    held: list[Held] = field(default_factory=list)
