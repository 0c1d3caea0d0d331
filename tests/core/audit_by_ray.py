"""What becomes of each ray of a sensor, in Python, ray by ray: the oracle of the compiled audit."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from riglens.core.engine.caster import Caster
from riglens.core.kernels.body.ray_outcomes import CAR, GROUND, NEW, NOTHING, OUTSIDE, SHARED
from riglens.core.kernels.rays.cast import Cast
from riglens.core.kernels.rays.walk import IRREGULAR, Ray, walk_exact
from riglens.core.rig.model import Sensor
from riglens.core.scene.columns import Words, words_per_column
from riglens.core.sensing.body_ends import barrier_ends
from riglens.core.sensing.rays import rotate
from riglens.core.sensors.lattice import Lattice
from riglens.core.vehicle.solid import Barrier

FULL = np.uint64(0xFFFFFFFFFFFFFFFF)


def fates_by_ray(caster: Caster, sensor: Sensor, barrier: Barrier | None, others: Words) -> NDArray[np.int64]:
    """What becomes of each ray of a sensor, when `others` is what the other sensors see."""
    field = caster.field
    nx, ny, nz = field.grid.shape
    rays = caster.rays(sensor, "exact")._replace(box=np.array([0, nx, 0, ny, 0, nz], np.int64))
    directions = rotate(rays.rotation, Lattice(rays.kind, rays.rows, rays.planes).directions())
    stopped = np.zeros(len(directions), np.bool_)
    if barrier is not None:
        stopped = barrier_ends(sensor, barrier) / field.grid.voxel_m < rays.reach[1]
    fates, runs = np.full(len(directions), OUTSIDE), np.empty((nx + ny + nz + 3, 3), np.int32)
    for number, d in enumerate(directions):
        if stopped[number]:
            fates[number] = CAR
            continue
        words, masks = _met(caster, rays, number, d, runs)
        if len(words):
            fates[number] = _meets(masks & field.index.words[words], others[words])
            if fates[number] == NOTHING and _ends_at_ground(rays, d):
                fates[number] = GROUND
    return fates


def _met(
    caster: Caster, rays: Cast, number: int, d: NDArray[np.float64], runs: NDArray[np.int32]
) -> tuple[NDArray[np.int64], Words]:
    """Words that a ray meets, and the levels that it meets in each."""
    g = (float(rays.origin[0]), float(rays.origin[1]), float(rays.origin[2]))
    ray = Ray(g, (float(d[0]), float(d[1]), float(d[2])), float(rays.reach[0]), float(rays.reach[1]))
    count = walk_exact(ray, rays.box, int(rays.shape[1]), runs)
    if count == IRREGULAR:
        pairs = list(caster.walk_irregular(rays, np.array([number])))
        return np.array([word for word, _ in pairs], np.int64), np.array([bit for _, bit in pairs], np.uint64)
    depth = words_per_column(caster.field.grid)
    column, low, high = runs[:count].astype(np.int64).T
    words, masks = [], []
    for part in range(depth):
        first, last = np.maximum(low - 64 * part, 0), np.minimum(high - 64 * part, 63)
        here = first <= last
        words.append(column[here] * depth + part)
        masks.append((FULL << first[here].astype(np.uint64)) & (FULL >> (63 - last[here]).astype(np.uint64)))
    return np.concatenate(words), np.concatenate(masks)


def _meets(informative: Words, others: Words) -> int:
    """What a ray meets, by the informative voxels it meets and those that others see, word by word."""
    if not informative.any():
        return NOTHING
    return NEW if (informative & ~others).any() else SHARED


def _ends_at_ground(rays: Cast, d: NDArray[np.float64]) -> bool:
    """Whether a ray passes the floor of the region, within its sides and its range."""
    if d[2] >= 0.0 or rays.origin[2] < 0.0:
        return False
    t = rays.origin[2] / -d[2]
    x, y = rays.origin[0] + t * d[0], rays.origin[1] + t * d[1]
    return bool(0.0 <= x < rays.shape[0] and 0.0 <= y < rays.shape[1] and t <= rays.reach[1])
