"""A LiDAR's range image of one frame: beams by azimuths, as the sensor fires them, or a scan pattern on a raster."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from riglens.core.rig.model import Lidar
from riglens.core.sensing.rays import sensor_rays
from riglens.core.sensors.scan import RayRows
from riglens.core.vehicle.solid import Barrier, Solid
from riglens.core.view.frames import FrameBoxes
from riglens.core.view.hits import NOTHING, Hits, cast

MAX_RAYS = 1_000_000


@dataclass(frozen=True)
class RangeImage:
    """Range image: rows from the highest beam down, columns from the left of the sensor to its right.

    beams (rows,): place in the sensor's list; elevations_deg (rows,); azimuths_deg (columns,) within
    (-180, 180], before the offsets that beams may have; range_m (rows, columns), inf without a return; what (rows,
    columns) as in `riglens.core.view.hits`; box_classes: class of each box of the frame; returns, on_boxes: rays that
    come back, and those of them from boxes. thinned: one in this many beams and azimuths is cast, 1 for all.

    The rays of a scan pattern are shown in the nearest cell of a raster, of several in one cell the nearest return;
    cells without a ray hold nothing.
    """

    lidar: Lidar
    beams: NDArray[np.int64]
    elevations_deg: NDArray[np.float64]
    azimuths_deg: NDArray[np.float64]
    range_m: NDArray[np.float64]
    what: NDArray[np.int32]
    box_classes: NDArray[np.uint8]
    returns: int
    on_boxes: int
    thinned: tuple[int, int] = (1, 1)

    def azimuth_deg(self, row: int, column: int) -> float:
        """Return the azimuth of one ray, with the offset of its beam."""
        offsets = self.lidar.azimuth_offsets_deg
        offset = 0.0 if offsets is None else offsets[int(self.beams[row])]
        return float(self.azimuths_deg[column]) + offset


def range_image(lidar: Lidar, boxes: FrameBoxes, body: Solid, max_rays: int = MAX_RAYS) -> RangeImage:
    """Return the hits of a LiDAR's beams in one frame; only some of very many rays are cast."""
    from riglens.core.sensing.body_ends import barrier_of  # loads the compiler: not while a window opens

    if lidar.rays is not None:
        return _of_pattern(lidar, lidar.rays.ray_rows(), boxes, barrier_of(lidar, body), max_rays)
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
        *_counts(hits),
        (step_beam, step_azimuth),
    )


def _counts(hits: Hits) -> tuple[int, int]:
    return int(np.count_nonzero(np.isfinite(hits.range_m))), int(np.count_nonzero(hits.what >= 0))


def _of_pattern(lidar: Lidar, listed: RayRows, boxes: FrameBoxes, body: Barrier, max_rays: int) -> RangeImage:
    """Return the hits of a scan pattern on a raster with about as many cells as rays."""
    step = -(-lidar.ray_count // max_rays)
    rays = np.arange(0, lidar.ray_count, step)
    hits = cast(lidar.position, sensor_rays(lidar, rays).directions, boxes, body, lidar.range_m)
    elevations, azimuths = lidar.elevations()[::-1], wrapped_deg(lidar.azimuths()[::-1])
    azimuths = azimuths[np.argsort(-azimuths, kind="stable")]
    row = _nearest(elevations, listed.elevation_deg[rays])
    cell = row * azimuths.size + _nearest(azimuths, wrapped_deg(listed.azimuth_deg[rays]))
    farthest_first = np.lexsort((-hits.range_m, cell))  # of the rays of a cell the last one stays
    range_m, what = (
        np.full(elevations.size * azimuths.size, np.inf),
        np.full(elevations.size * azimuths.size, NOTHING),
    )
    range_m[cell[farthest_first]], what[cell[farthest_first]] = (
        hits.range_m[farthest_first],
        hits.what[farthest_first],
    )
    shape = elevations.size, azimuths.size
    return RangeImage(
        lidar,
        np.zeros(elevations.size, np.int64),
        elevations,
        azimuths,
        range_m.reshape(shape),
        what.astype(np.int32).reshape(shape),
        boxes.cls,
        *_counts(hits),
        (1, step),
    )


def _nearest(falling: NDArray[np.float64], angles_deg: NDArray[np.float64]) -> NDArray[np.int64]:
    """Return the place of the nearest of some falling angles for each angle."""
    middles = (falling[1:] + falling[:-1]) / 2.0
    return np.searchsorted(-middles, -angles_deg)


def wrapped_deg(angles_deg: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return angles within (-180, 180] degrees."""
    return 180.0 - np.mod(180.0 - angles_deg, 360.0)


def _steps(beams: int, azimuths: int, max_rays: int) -> tuple[int, int]:
    """Return n such that one in n beams and azimuths makes at most `max_rays` rays."""
    step_azimuth = max(1, -(-beams * azimuths // max_rays))
    step_azimuth = min(step_azimuth, azimuths)
    columns = -(-azimuths // step_azimuth)
    return max(1, -(-beams * columns // max_rays)), step_azimuth
