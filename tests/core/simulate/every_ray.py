"""A sweep worked out ray by ray in plain numpy: every ray against every part of everything that stands in a frame."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from riglens.core.rig.model import Lidar, Rig
from riglens.core.sensing.rays import local_directions
from riglens.core.simulate.clutter import KINDS
from riglens.core.simulate.settings import SimulationSettings
from riglens.core.simulate.sweeps import GROUND, STATIC
from riglens.core.simulate.world import World, Worlds
from riglens.core.targets.contribution import phases_rad
from riglens.core.targets.draws import mixed, sensor_key, units
from riglens.core.targets.range_law import anchors_of, range_for
from riglens.core.targets.shapes import GLASS_PASSES, GLASS_RETURNS, REFLECTIVITY, SHAPES, WIDTH
from riglens.core.vehicle.solid import Solid
from tests.core.targets.brute_force import return_words
from tests.core.targets.parts import Parts, parts_by_kind
from tests.core.vehicle.solids import body_ends

Doubles = NDArray[np.float64]


class Expected(NamedTuple):
    """What the rays of a rig measure: points (n, 3), ring (n,), object (n,), in the order of a sweep."""

    points_m: Doubles
    ring: NDArray[np.int64]
    object: NDArray[np.int64]


def sweep(rig: Rig, worlds: Worlds, frame: int, solid: Solid | None = None) -> Expected:
    """All LiDARs in a frame."""
    parts = [_of(lidar, worlds, frame, solid) for lidar in rig.enabled_lidars()]
    return Expected(*(np.concatenate(columns) for columns in zip(*parts, strict=True)))


def _of(lidar: Lidar, worlds: Worlds, frame: int, solid: Solid | None) -> Expected:
    settings, world = worlds.settings, worlds.world(frame)
    origin, d = np.array(lidar.position), _directions(lidar, settings, frame)
    parts = parts_of_world(world)
    entry, cosine = entries(world, origin, d, lidar.range_m)
    words = return_words(lidar, settings.seed, frame)
    draws = units(mixed(words, np.array([0])))
    passes, returns_from = (GLASS_PASSES, 1.0 - GLASS_RETURNS) if settings.range_law else (0.0, 1.0)
    entry[np.ix_(draws < passes, parts.is_glass)] = np.inf
    part = entry.argmin(axis=1) if entry.shape[1] else np.zeros(len(d), int)
    t = entry[np.arange(len(d)), part] if entry.shape[1] else np.full(len(d), np.inf)
    met = np.isfinite(t)
    box = parts.box[part] if entry.shape[1] else part
    what = np.where(met, np.where(box < world.reflectivity.users, box, STATIC), GROUND)
    ground = ground_m(world, origin, d)
    t = np.where(
        met, t, np.where((ground >= lidar.range_m[0]) & (ground <= lidar.range_m[1]), ground, np.inf)
    )
    returns = np.isfinite(t)
    if entry.shape[1]:
        returns &= ~(met & parts.is_glass[part] & (draws < returns_from))
    returns &= t < (np.inf if solid is None else body_ends(lidar, solid))
    if settings.range_law and anchors_of(lidar):
        cls = world.boxes.cls[box] if entry.shape[1] else box
        square = cosine[np.arange(len(d)), part] if entry.shape[1] else np.ones(len(d))
        returns &= _lawful(
            lidar,
            settings,
            frame,
            t,
            np.where(met, cls, 4),
            np.where(met, square, np.maximum(-d[:, 2], 0.25)),
        )
    words = _words(lidar, settings, frame, "losses")
    returns &= (words >> np.uint64(32)) / 2.0**32 >= settings.dropout
    deep = np.where(met, world.reflectivity.soft[world.boxes.kind[box]], 0.0) if entry.shape[1] else 0.0
    t = t + deep * (words & np.uint64(0xFFFFFFFF)) / 2.0**32
    t = t + settings.noise_m * _bells(_words(lidar, settings, frame, "noise"))
    rays = _in_order(lidar)
    rays = rays[returns[rays]]
    points = origin + t[rays, None] * d[rays]
    return Expected(points, rays // lidar.azimuths().size, what[rays])


def ground_m(world: World, origin: Doubles, d: Doubles) -> Doubles:
    """Where rays meet the ground: the plane, then twice the plane at the height of the ground there."""
    above = origin[2] - world.surface.height
    if not world.surface.exists or above <= 0.0:
        return np.full(len(d), np.inf)
    down = np.where(d[:, 2] < 0.0, -d[:, 2], np.nan)
    t = above / down
    for _ in range(2):
        x, y = origin[0] + t * d[:, 0], origin[1] + t * d[:, 1]
        bump = sum(
            (a * np.sin(u * x + v * y + phase) for a, u, v, phase in world.surface.waves), np.zeros(len(d))
        )
        t = (above - bump) / down
    return np.where(t > 0.0, t, np.inf)


def _words(lidar: Lidar, settings: SimulationSettings, frame: int, name: str) -> NDArray[np.uint64]:
    """The random words of all rays for one purpose."""
    key = int(mixed(sensor_key(settings.seed, f"{name} of {lidar.name}"), np.array([frame]))[0])
    return mixed(key, np.arange(lidar.ray_count))


def _bells(words: NDArray[np.uint64]) -> Doubles:
    """Nearly normal numbers: the sum of four even ones of 16 bits each."""
    evens = np.array(
        [(words >> np.uint64(shift)) & np.uint64(0xFFFF) for shift in (0, 16, 32, 48)], np.float64
    )
    return np.asarray(((evens + 0.5) / 65536.0 - 0.5).sum(axis=0) * np.sqrt(3.0))


def _in_order(lidar: Lidar) -> NDArray[np.int64]:
    """Rays by rising elevation, then azimuth."""
    azimuths = np.radians(lidar.azimuths())
    rows = np.argsort(lidar.elevations(), kind="stable")
    columns = np.argsort(azimuths % (2 * np.pi), kind="stable")
    return np.asarray((rows[:, None] * len(azimuths) + columns).ravel())


def _directions(lidar: Lidar, settings: SimulationSettings, frame: int) -> Doubles:
    phase = float(phases_rad(lidar, settings.targets(), np.array([frame]))[0])
    cos, sin = np.cos(phase), np.sin(phase)
    turn = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
    return np.asarray(local_directions(lidar, np.arange(lidar.ray_count)) @ (lidar.pose.rotation() @ turn).T)


def parts_of_world(world: World) -> Parts:
    """The parts of all boxes of a frame."""
    kinds = [*SHAPES, *((kind.parts,) for kind in KINDS)]
    return parts_by_kind(kinds, world.boxes.kind, 2.0 * world.boxes.halves)


def entries(
    world: World, origin: Doubles, d: Doubles, range_m: tuple[float, float]
) -> tuple[Doubles, Doubles]:
    """Where each ray enters each part (rays, parts), inf: nowhere, and the cosine at the face."""
    boxes, parts = world.boxes, parts_of_world(world)
    entry, cosine = np.full((2, len(d), len(parts.box)), np.inf)
    for part, box in enumerate(parts.box):
        turn = boxes.rotations[box]
        start, along = turn.T @ (origin - boxes.centres[box]), d @ turn
        if (np.abs(start) <= boxes.halves[box]).all():
            continue
        start, half = start - parts.offset_m[part], parts.half_m[part]
        with np.errstate(divide="ignore", invalid="ignore"):
            a, b = (-half - start) / along, (half - start) / along
        first, last = np.minimum(a, b), np.maximum(a, b)
        t0, t1 = np.maximum(first.max(axis=1), range_m[0]), np.minimum(last.min(axis=1), range_m[1])
        entry[:, part] = np.where(t0 < t1, t0, np.inf)
        inside = (np.abs(start) <= half).all()
        cosine[:, part] = 1.0 if inside else np.abs(along)[np.arange(len(d)), first.argmax(axis=1)]
    return entry, cosine


def _lawful(
    lidar: Lidar,
    settings: SimulationSettings,
    frame: int,
    t: Doubles,
    cls: NDArray[np.int64],
    cosine: Doubles,
) -> NDArray[np.bool_]:
    """Which rays come back by the range law."""
    anchors = anchors_of(lidar)
    limit = np.array([range_for(rho, anchors) for rho in (*REFLECTIVITY, 0.2, 0.2)])[cls] * np.sqrt(cosine)
    chance = units(_words(lidar, settings, frame, "returns"))
    with np.errstate(over="ignore"):
        return np.asarray(chance < 1.0 / (1.0 + np.exp((t / limit - 1.0) / WIDTH)))
