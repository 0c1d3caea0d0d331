"""Data that look one way only, such as labels of a front camera: where they hold nothing, and who looks there."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from riglens.core.rig.model import Sensor
from riglens.core.scene.boxes import CLASSES
from riglens.core.sensing.rays import sensor_rays

if TYPE_CHECKING:  # it loads the compiler, and the window asks `looks_into` without one
    from riglens.core.view.display import DisplayGrid

EMPTY_SHARE, LEAST_GAP_DEG, LEAST_BOXES = 0.02, 90, 30
"""A gap holds at most this share of the traffic over at least this angle, and there are at least this many boxes. Our
choice: KITTI's labels leave 190° with 1 % of it, nuScenes and the bundled town never more than 20°."""
_NEAR_M = 3.0
_RAYS, _MOST_RAYS = 0.95, 400


@dataclass(frozen=True)
class Gap:
    """A sector around the vehicle without boxes: azimuths in degrees, 0 ahead and positive to the left, to > from.

    `from_deg` lies in [-180, 180); `to_deg` may lie beyond 180.
    """

    from_deg: float
    to_deg: float

    def holds(self, azimuths_deg: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return whether directions lie in the sector, in their shape."""
        return np.asarray((azimuths_deg - self.from_deg) % 360.0 <= self.to_deg - self.from_deg)

    @property
    def boxes_deg(self) -> tuple[float, float]:
        """The sector in which there are boxes, from and to; from lies in [-180, 180)."""
        start = (self.to_deg + 180.0) % 360.0 - 180.0
        return start, start + 360.0 - (self.to_deg - self.from_deg)

    @property
    def words(self) -> str:
        """Return the directions of the boxes in words, such as "boxes only ahead (-45° to 45°)"."""
        start, end = self.boxes_deg
        middle = ((start + end) / 2 + 180.0) % 360.0 - 180.0
        across = "left" if middle > 0 else "right"
        side = "ahead" if abs(middle) <= 45 else "behind" if abs(middle) >= 135 else across
        return f"boxes only {side} ({start:.0f}° to {end:.0f}°)".replace("-", "\u2212")


def widest_gap(display: DisplayGrid) -> Gap | None:
    """Return the widest sector with almost no traffic of any class; None if the data cover all directions."""
    if sum(display.pog.data.boxes.values()) < LEAST_BOXES:
        return None
    x, y = display.centres_m[:, 0].astype(np.float64), display.centres_m[:, 1].astype(np.float64)
    per_class = np.stack([display.probability(cls) for cls in range(len(CLASSES))])
    traffic: NDArray[np.float64] = per_class.sum(axis=0, dtype=np.float64)
    far = np.hypot(x, y) > _NEAR_M
    degrees = np.floor(np.degrees(np.arctan2(y[far], x[far])) + 180.0).astype(np.int64) % 360
    by_degree = np.bincount(degrees, traffic[far], 360).astype(np.float64)
    total = float(by_degree.sum())
    start, width = _widest_run(by_degree, EMPTY_SHARE * total)
    return Gap(start - 180.0, start - 180.0 + width) if total > 0.0 and width >= LEAST_GAP_DEG else None


def _widest_run(weights: NDArray[np.float64], most: float) -> tuple[int, int]:
    """Return start and length of the longest run of a circle (n,) with a sum up to `most`; of several the lightest."""
    count = len(weights)
    sums = np.concatenate([[0.0], np.cumsum(np.tile(weights, 2))])
    ends = np.searchsorted(sums, sums[:count] + most, side="right") - 1
    widths = np.minimum(ends - np.arange(count), count)
    weight = sums[np.arange(count) + widths] - sums[:count]
    start = int(np.lexsort((weight, -widths))[0])
    return start, int(widths[start])


def looks_into(sensor: Sensor, gap: Gap) -> bool:
    """Return whether nearly all rays of a sensor run within a gap, where the data hold nothing to see."""
    step = max(1, sensor.ray_count // _MOST_RAYS) | 1  # odd: columns are mostly even in number
    directions = sensor_rays(sensor, np.arange(0, sensor.ray_count, step)).directions
    azimuths_deg = np.degrees(np.arctan2(directions[:, 1], directions[:, 0]))
    cast = azimuths_deg[~np.isnan(azimuths_deg)]
    return bool(gap.holds(cast).mean() >= _RAYS) if len(cast) else False
