"""Approximate covered sets: voxels tested by their outline or by their centre, never ray by ray.

They are only compared with the exact set. A voxel that already has the bit of the sensor's kind is not tested again.
"""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np

from riglens.core.kernels.rays.lattice import rotated_back
from riglens.core.kernels.runtime.jit import inlined, kernel, parallel_kernel

SLACK = 1e-9
"""Tolerance for rounding, so that an outline never loses a ray that grazes it."""
HALF_DIAGONAL = 0.8660254037844387
LEAST_RADIUS = 1e-300
"""Replaces a distance of zero from an axis, also for a beam straight up, whose tangent is 1.6e16."""
TURN = 2.0 * np.pi

Point = tuple[float, float, float]


class Place(NamedTuple):
    """Pose and range of a sensor: origin g (3,) and range reach (2,) in grid units; rotation (3, 3) to the vehicle
    frame."""

    g: np.ndarray
    rotation: np.ndarray
    reach: np.ndarray


class Tested(NamedTuple):
    """Voxels int32 (n, 3) to test, and the bit that the kernels set in seen uint8 (n,) for those that are seen."""

    voxels: np.ndarray
    flag: int


@inlined
def _centre(g: np.ndarray, rotation: np.ndarray, voxel: np.ndarray) -> Point:
    """Return the centre of a voxel in the sensor frame, grid units."""
    return rotated_back(rotation, (voxel[0] + 0.5 - g[0], voxel[1] + 0.5 - g[1], voxel[2] + 0.5 - g[2]))


@inlined
def _within(p: Point, reach: np.ndarray, margin: float) -> bool:
    """Return whether a point lies in the range of the sensor, give or take a margin."""
    square = p[0] * p[0] + p[1] * p[1] + p[2] * p[2]
    near, far = max(reach[0] - margin, 0.0), reach[1] + margin
    return bool(near * near <= square <= far * far)


@kernel
def corners(rotation: np.ndarray) -> np.ndarray:
    """Return the eight corners of a voxel seen from its centre, in the sensor frame, (8, 3)."""
    offsets = np.empty((8, 3))
    for k in range(8):
        x, y, z = (k & 1) - 0.5, ((k >> 1) & 1) - 0.5, ((k >> 2) & 1) - 0.5
        for axis in range(3):
            offsets[k, axis] = rotation[0, axis] * x + rotation[1, axis] * y + rotation[2, axis] * z
    return offsets


@inlined
def _slope_bounds(low: float, high: float, farthest: float) -> tuple[float, float]:
    """Return the bounds of y / x for y in [low, high] and x in (0, farthest]."""
    return (low / farthest if low > 0.0 else -np.inf), (high / farthest if high < 0.0 else np.inf)


@inlined
def _holds_line(low: float, high: float, count: int) -> bool:
    """Return whether [low, high] holds one of the whole numbers 0..count-1."""
    return bool(max(np.ceil(low - SLACK), 0.0) <= min(np.floor(high + SLACK), count - 1.0))


@kernel
def frustum(lens: np.ndarray) -> np.ndarray:
    """Return the outward unit normals (4, 3) of the pyramid around the lattice in the sensor frame."""
    normals = np.zeros((4, 3))
    for axis in range(2):
        start, per_slope, count = lens[3 * axis], lens[3 * axis + 1], lens[3 * axis + 2]
        for side, sign in ((0, 1.0), (1, -1.0)):
            slope = (start - (0.0 if side == 0 else count - 1.0)) / per_slope
            length = np.sqrt(1.0 + slope * slope)
            normals[2 * axis + side, 0] = -sign * slope / length
            normals[2 * axis + side, 1 + axis] = sign / length
    return normals


@inlined
def _far_outside(p: Point, normals: np.ndarray) -> bool:
    """Return whether the ball around a voxel lies outside one side of the pyramid."""
    outside = False
    for n in normals:
        outside |= n[0] * p[0] + n[1] * p[1] + n[2] * p[2] > HALF_DIAGONAL + SLACK
    return outside


@inlined
def _rectangle_holds_ray(p: Point, offsets: np.ndarray, half: np.ndarray, lens: np.ndarray) -> bool:
    """Return whether the bounding rectangle of a voxel in the image holds a point of the lattice."""
    if p[0] + half[0] <= 0.0:
        return False
    a_low, a_high, b_low, b_high = np.inf, -np.inf, np.inf, -np.inf
    if p[0] - half[0] > SLACK:
        for k in range(8):
            scale = 1.0 / (p[0] + offsets[k, 0])
            a, b = (p[1] + offsets[k, 1]) * scale, (p[2] + offsets[k, 2]) * scale
            a_low, a_high, b_low, b_high = min(a_low, a), max(a_high, a), min(b_low, b), max(b_high, b)
    else:
        a_low, a_high = _slope_bounds(p[1] - half[1], p[1] + half[1], p[0] + half[0])
        b_low, b_high = _slope_bounds(p[2] - half[2], p[2] + half[2], p[0] + half[0])
    columns = _holds_line(lens[0] - lens[1] * a_high, lens[0] - lens[1] * a_low, lens[2])
    return columns and _holds_line(lens[3] - lens[4] * b_high, lens[3] - lens[4] * b_low, lens[5])


@parallel_kernel
def camera_rectangles(place: Place, lens: np.ndarray, tested: Tested, workers: int, seen: np.ndarray) -> None:
    """Mark voxels whose bounding rectangle in the image holds a lattice point.

    lens (6,): column = lens[0] - lens[1] y / x out of lens[2], row = lens[3] - lens[4] z / x out of lens[5].
    """
    offsets = corners(place.rotation)
    half = np.array([offsets[:, 0].max(), offsets[:, 1].max(), offsets[:, 2].max()])
    normals = frustum(lens)
    voxels, flag = tested.voxels, tested.flag
    n = voxels.shape[0]
    for worker in numba.prange(workers):
        for i in range(n * worker // workers, n * (worker + 1) // workers):
            if seen[i] & flag:
                continue
            p = _centre(place.g, place.rotation, voxels[i])
            if _far_outside(p, normals) or not _within(p, place.reach, HALF_DIAGONAL):
                continue
            if _rectangle_holds_ray(p, offsets, half, lens):
                seen[i] |= np.uint8(flag)


@inlined
def _first_at_least(table: np.ndarray, value: float) -> int:
    """Return the index of the first entry of a rising table that is not below a value; its length when there is
    none."""
    low, high = 0, table.size
    while low < high:
        middle = (low + high) >> 1
        if table[middle] < value:
            low = middle + 1
        else:
            high = middle
    return low


@inlined
def _holds_azimuth(start: float, width: float, azimuths: np.ndarray) -> bool:
    """Return whether an arc from `start` over `width` radians holds an entry of a table over [0, 2 pi)."""
    start -= TURN * np.floor(start / TURN)
    k = _first_at_least(azimuths, start)
    following = azimuths[k] if k < azimuths.size else azimuths[0] + TURN
    return bool(following - start <= width)


@inlined
def _holds_beam(low_z: float, high_z: float, nearest: float, farthest: float, tangents: np.ndarray) -> bool:
    """Return whether a beam passes heights [low_z, high_z] somewhere between two distances from the axis."""
    low = low_z / (farthest if low_z >= 0.0 else nearest)
    high = high_z / (nearest if high_z >= 0.0 else farthest)
    beam = _first_at_least(tangents, low - SLACK * (1.0 + abs(low)))
    return beam < tangents.size and tangents[beam] <= high + SLACK * (1.0 + abs(high))


@inlined
def _angles_hold_ray(
    p: Point, offsets: np.ndarray, half_z: float, tangents: np.ndarray, azimuths: np.ndarray
) -> bool:
    """Return whether the bounding angles of a voxel hold a beam and an azimuth."""
    radius = np.sqrt(p[0] * p[0] + p[1] * p[1])
    low_z, high_z = p[2] - half_z, p[2] + half_z
    around_it = max(radius - HALF_DIAGONAL - SLACK, LEAST_RADIUS)
    if not _holds_beam(low_z, high_z, around_it, radius + HALF_DIAGONAL, tangents):
        return False
    ahead, farthest, turn_low, turn_high = np.inf, 0.0, np.inf, -np.inf
    for k in range(8):
        x, y = p[0] + offsets[k, 0], p[1] + offsets[k, 1]
        along = p[0] * x + p[1] * y
        turn = (p[0] * y - p[1] * x) / along
        ahead, farthest = min(ahead, along), max(farthest, x * x + y * y)
        turn_low, turn_high = min(turn_low, turn), max(turn_high, turn)
    around = not ahead > SLACK * max(radius * radius, 1.0)
    nearest = LEAST_RADIUS if around else ahead / radius
    if not _holds_beam(low_z, high_z, nearest, max(np.sqrt(farthest), LEAST_RADIUS), tangents):
        return False
    if around:
        return True
    start = np.arctan2(p[1], p[0]) + np.arctan(turn_low) - SLACK
    return _holds_azimuth(start, np.arctan(turn_high) - np.arctan(turn_low) + 2.0 * SLACK, azimuths)


@parallel_kernel
def lidar_angles(
    place: Place, tangents: np.ndarray, azimuths: np.ndarray, tested: Tested, workers: int, seen: np.ndarray
) -> None:
    """Mark voxels whose bounding angles hold a beam and an azimuth.

    tangents: of the beam elevations, rising; azimuths: radians in [0, 2 pi), rising.
    """
    offsets = corners(place.rotation)
    half_z = offsets[:, 2].max()
    voxels, flag = tested.voxels, tested.flag
    n = voxels.shape[0]
    for worker in numba.prange(workers):
        for i in range(n * worker // workers, n * (worker + 1) // workers):
            if seen[i] & flag:
                continue
            p = _centre(place.g, place.rotation, voxels[i])
            if _within(p, place.reach, HALF_DIAGONAL) and _angles_hold_ray(
                p, offsets, half_z, tangents, azimuths
            ):
                seen[i] |= np.uint8(flag)


@parallel_kernel
def camera_centres(place: Place, slopes: np.ndarray, tested: Tested, workers: int, seen: np.ndarray) -> None:
    """Mark voxels whose centre is in the image; slopes (4,): y / x from, to, z / x from, to at its edges."""
    voxels, flag = tested.voxels, tested.flag
    n = voxels.shape[0]
    for worker in numba.prange(workers):
        for i in range(n * worker // workers, n * (worker + 1) // workers):
            if seen[i] & flag:
                continue
            x, y, z = _centre(place.g, place.rotation, voxels[i])
            inside = x > 0.0 and slopes[0] * x <= y <= slopes[1] * x and slopes[2] * x <= z <= slopes[3] * x
            if inside and _within((x, y, z), place.reach, 0.0):
                seen[i] |= np.uint8(flag)


@parallel_kernel
def lidar_centres(
    place: Place, tangents: np.ndarray, sector: np.ndarray, tested: Tested, workers: int, seen: np.ndarray
) -> None:
    """Mark voxels whose centre is between the lowest and the highest beam and in the sector of azimuths.

    tangents (2,): of the outer elevations; sector (2,): first azimuth and width, radians (2 pi: a full turn).
    """
    voxels, flag = tested.voxels, tested.flag
    n = voxels.shape[0]
    full = sector[1] >= TURN - SLACK
    for worker in numba.prange(workers):
        for i in range(n * worker // workers, n * (worker + 1) // workers):
            if seen[i] & flag:
                continue
            x, y, z = _centre(place.g, place.rotation, voxels[i])
            radius = np.sqrt(x * x + y * y)
            if tangents[0] * radius <= z <= tangents[1] * radius and _within((x, y, z), place.reach, 0.0):
                angle = 0.0 if full else np.arctan2(y, x) - sector[0]
                if full or angle - TURN * np.floor(angle / TURN) <= sector[1]:
                    seen[i] |= np.uint8(flag)


@parallel_kernel
def sum_flagged(seen: np.ndarray, codes: np.ndarray, entropies_q: np.ndarray, workers: int) -> np.ndarray:
    """Return the fixed-point entropies of the voxels with bit 1 (camera) and bit 2 (LiDAR), int64 (2, 3)."""
    n = seen.size
    partial = np.zeros((workers, 16), np.int64)  # cache lines of its own for every worker
    for worker in numba.prange(workers):
        sums = np.zeros((2, 3), np.int64)
        for i in range(n * worker // workers, n * (worker + 1) // workers):
            for c in range(3):
                if seen[i] & 1:
                    sums[0, c] += np.int64(entropies_q[codes[i], c])
                if seen[i] & 2:
                    sums[1, c] += np.int64(entropies_q[codes[i], c])
        for column in range(6):
            partial[worker, column] = sums[column // 3, column % 3]
    total: np.ndarray = partial.sum(axis=0)[:6].reshape(2, 3)
    return total
