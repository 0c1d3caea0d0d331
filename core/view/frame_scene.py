"""Compute one frame for a rig: the ends of its LiDAR rays, and the number on each object."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from riglens.core.rig.model import Lidar, Rig
from riglens.core.sensing.body_ends import barrier_of
from riglens.core.sensing.rays import sensor_rays
from riglens.core.vehicle.solid import Solid
from riglens.core.view.frames import FrameBoxes
from riglens.core.view.hits import BODY, cast

MOST_RAYS = 400_000
"""With more LiDAR rays in total, only some beams and azimuths are cast: the others would be invisible."""


Verdict = Literal["no LiDARs", "out of range", "between beams", "hidden", "few points"]


@dataclass(frozen=True)
class Missed:
    """Reason for a low point count on an object: the verdict over all LiDARs together.

    points, alone: rays that end on it, and that would without occlusion. by: number of the
    box that hides most of these, GROUND or BODY (see `riglens.core.view.hits`); None if nothing hides any.
    """

    verdict: Verdict
    points: int
    alone: int
    by: int | None = None


@dataclass(frozen=True, eq=False)
class FrameScene:
    """Boxes of a frame with the points on them, and all points of the LiDARs. Equal only to itself.

    points (n,): LiDAR points on each box; places_m (p, 3) float32: where rays end, in the vehicle frame; box (p,):
    number of the box that a ray ends on, GROUND where it ends on the ground. thinned: one ray in this many was cast.
    """

    frame: int
    boxes: FrameBoxes
    points: NDArray[np.int64]
    places_m: NDArray[np.float32]
    box: NDArray[np.int32]
    thinned: int = 1


def frame_scene(rig: Rig, frame: int, boxes: FrameBoxes, body: Solid, most: int = MOST_RAYS) -> FrameScene:
    """Cast all enabled LiDARs of a rig in a frame, their azimuths as listed, against boxes, ground and body."""
    lidars = rig.enabled_lidars()
    thinned = max(1, -(-sum(lidar.ray_count for lidar in lidars) // most))
    parts = [_returns(lidar, boxes, body, thinned) for lidar in lidars]
    places_m = np.concatenate([np.zeros((0, 3), np.float32), *(part[0] for part in parts)])
    box = np.concatenate([np.zeros(0, np.int32), *(part[1] for part in parts)])
    points = np.bincount(box[box >= 0], minlength=len(boxes.cls)).astype(np.int64) * thinned
    return FrameScene(frame, boxes, points, places_m, box, thinned)


def _returns(
    lidar: Lidar, boxes: FrameBoxes, body: Solid, thinned: int
) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
    """Return where the rays of a LiDAR end on boxes or the ground, (p, 3), and on what, (p,)."""
    rays = sensor_rays(lidar, np.arange(0, lidar.ray_count, thinned))
    hits = cast(lidar.position, rays.directions, boxes, barrier_of(lidar, body), lidar.range_m)
    returns = np.isfinite(hits.range_m) & (hits.what != BODY)
    ends_m = np.array(rays.origin_m) + hits.range_m[returns, None] * rays.directions[returns]
    return ends_m.astype(np.float32), hits.what[returns]


def why_missed(rig: Rig, boxes: FrameBoxes, number: int, body: Solid, enough: int) -> Missed:
    """Explain why box `number` of a frame has fewer than `enough` points of the enabled LiDARs."""
    lidars = rig.enabled_lidars()
    if not lidars:
        return Missed("no LiDARs", 0, 0)
    only = boxes.only(number)
    reached = [lidar for lidar in lidars if _nearest_m(lidar, only) <= lidar.range_m[1]]
    if not reached:
        return Missed("out of range", 0, 0)
    stopped = np.concatenate([_stopped_by(lidar, boxes, only, body) for lidar in reached])
    points, alone = int(np.count_nonzero(stopped == number)), len(stopped)
    others = stopped[stopped != number]
    by = None
    if len(others):
        names, counts = np.unique(others, return_counts=True)
        by = int(names[np.argmax(counts)])
    if points >= enough:
        return Missed("few points", points, alone, by)
    return Missed("hidden" if alone >= enough else "between beams", points, alone, by)


def _nearest_m(lidar: Lidar, only: FrameBoxes) -> float:
    """Return the distance from a LiDAR to the nearest point of a box."""
    local = only.rotation[0].T @ (np.array(lidar.position) - only.centre_m[0])
    return float(np.linalg.norm(np.maximum(np.abs(local) - only.size_m[0] / 2.0, 0.0)))


def _stopped_by(lidar: Lidar, boxes: FrameBoxes, only: FrameBoxes, body: Solid) -> NDArray[np.int32]:
    """Return what stops the rays of a LiDAR that would end on a box if it stood alone, (n,)."""
    rays = sensor_rays(lidar)
    nothing = barrier_of(lidar, Solid.of(np.zeros((0, 3, 3))))
    alone = cast(lidar.position, rays.directions, only, nothing, lidar.range_m, has_ground=False)
    chosen = np.ascontiguousarray(rays.directions[alone.what == 0])
    return cast(lidar.position, chosen, boxes, barrier_of(lidar, body), lidar.range_m).what
