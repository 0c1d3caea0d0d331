"""A LiDAR's range image of one frame: beams by azimuths, as the sensor fires them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from riglens.core.rig.model import Lidar
from riglens.core.sensing.rays import sensor_rays
from riglens.core.vehicle.solid import Solid
from riglens.core.view.frames import FrameBoxes
from riglens.core.view.hits import cast

MAX_RAYS = 1_000_000


@dataclass(frozen=True)
class RangeImage:
    """Range image: rows from the highest beam down, columns from the left of the sensor to its right.

    beams (rows,): place in the sensor's list; elevations_deg (rows,); azimuths_deg (columns,) within
    (-180, 180], before the offsets that beams may have; range_m (rows, columns), inf without a return; what (rows,
    columns) as in `riglens.core.view.hits`; box_classes: class of each box of the frame.
    thinned: one in this many beams and azimuths is cast, 1 for all.
    """

    lidar: Lidar
    beams: NDArray[np.int64]
    elevations_deg: NDArray[np.float64]
    azimuths_deg: NDArray[np.float64]
    range_m: NDArray[np.float64]
    what: NDArray[np.int32]
    box_classes: NDArray[np.uint8]
    thinned: tuple[int, int] = (1, 1)

    def azimuth_deg(self, row: int, column: int) -> float:
        """Azimuth of one ray, with the offset of its beam."""
        offsets = self.lidar.azimuth_offsets_deg
        offset = 0.0 if offsets is None else offsets[int(self.beams[row])]
        return float(self.azimuths_deg[column]) + offset

    @property
    def returns(self) -> int:
        """Number of rays that come back."""
        return int(np.count_nonzero(np.isfinite(self.range_m)))


def range_image(lidar: Lidar, boxes: FrameBoxes, body: Solid, max_rays: int = MAX_RAYS) -> RangeImage:
    """Return the hits of a LiDAR's beams in one frame; only some of very many rays are cast."""
    from riglens.core.sensing.body_ends import barrier_of  # loads the compiler: not while a window opens

    elevations, azimuths = lidar.elevations(), wrapped_deg(lidar.azimuths())
    step_beam, step_azimuth = _steps(len(elevations), len(azimuths), max_rays)
    beams = np.argsort(-elevations, kind="stable")[::step_beam]
    turns = np.argsort(-azimuths, kind="stable")[::step_azimuth]
    rays = sensor_rays(lidar, (beams[:, None] * len(azimuths) + turns).ravel())
    hits = cast(lidar.position, rays.directions, boxes, barrier_of(lidar, body), lidar.range_m)
    shape = len(beams), len(turns)
    return RangeImage(
        lidar,
        beams,
        elevations[beams],
        azimuths[turns],
        hits.range_m.reshape(shape),
        hits.what.reshape(shape),
        boxes.cls,
        (step_beam, step_azimuth),
    )


def wrapped_deg(angles_deg: NDArray[np.float64]) -> NDArray[np.float64]:
    """Angles within (-180, 180] degrees."""
    return 180.0 - np.mod(180.0 - angles_deg, 360.0)


def _steps(beams: int, azimuths: int, max_rays: int) -> tuple[int, int]:
    """Return n such that one in n beams and azimuths makes at most `max_rays` rays."""
    step_azimuth = max(1, -(-beams * azimuths // max_rays))
    step_azimuth = min(step_azimuth, azimuths)
    columns = -(-azimuths // step_azimuth)
    return max(1, -(-beams * columns // max_rays)), step_azimuth
