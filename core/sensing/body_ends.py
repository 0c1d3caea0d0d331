"""Find where the rays of a sensor end at the car's own body."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import compress
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from riglens.core.in_threads import in_threads
from riglens.core.kernels.body.screen import Screen
from riglens.core.kernels.rays.cast import Cast
from riglens.core.kernels.runtime import codes
from riglens.core.rig.library import Cylinder, body_of
from riglens.core.rig.model import Sensor
from riglens.core.sensing.kept import SHADOWS, LatestAnswers
from riglens.core.sensing.ray_tiles import is_image, tiled
from riglens.core.sensing.rays import lattice
from riglens.core.sensing.screens import screen_of
from riglens.core.sensors.base import rays_of, unplaced
from riglens.core.sensors.lattice import Lattice
from riglens.core.sensors.registry import kind_of
from riglens.core.vehicle.solid import Barrier, Housing, Solid

View = tuple[float, float, float]
"""Angle from its axis, lowest and highest elevation within which a sensor's rays lie, radians."""
_VIEWS = LatestAnswers[Sensor, View](1024)
NO_EMPTY_BOX = np.array([1.0, 1.0, 1.0, -1.0, -1.0, -1.0])
"""No place in which it makes no difference where a ray ends."""


def housing_radius_m(sensor: Sensor) -> float:
    """Return the radius of a ball around a sensor that contains its housing: nearer surfaces stop none of its rays.

    Half the diagonal of the housing in the sensor library, or how near to a sensor of its kind the body lets rays pass.
    """
    known, occlusion = _known_radius_m(sensor.model) if sensor.model else None, kind_of(sensor).occlusion
    return max(occlusion.passes_within_m, occlusion.housing_radius_m if known is None else known)


@lru_cache(maxsize=256)
def _known_radius_m(model: str) -> float | None:
    body = body_of(model)
    if body is None:
        return None
    sides = (
        (body.diameter, body.height) if isinstance(body, Cylinder) else (body.length, body.width, body.height)
    )
    return float(np.linalg.norm(sides)) / 2


@dataclass(frozen=True)
class Obstacle:
    """The part of a car that stops the rays of a sensor; equal ones stop the same rays of it at the same places.

    fingerprint: of the body, with the housings that its rays may meet; start_m: the distance from the sensor at which
    all this begins to count; kind: of the sensor; solid: the car; met: those housings.
    """

    fingerprint: str
    start_m: float
    kind: str = field(compare=False, repr=False)
    solid: Solid = field(compare=False, repr=False)
    met: tuple[Housing, ...] = field(default=(), compare=False, repr=False)

    @property
    def barrier(self) -> Barrier:
        """The same for the kernels, made anew each time."""
        return self.solid.barrier(self.kind, self.start_m, self.met)


def obstacle_of(sensor: Sensor, solid: Solid) -> Obstacle:
    """Return what of a car stops the rays of a sensor: of housings those of others that lie in its view."""
    found = known_obstacle(sensor, solid, _view_rad)
    assert found is not None
    return found


def known_obstacle(
    sensor: Sensor, solid: Solid, view_of: Callable[[Sensor], View | None] = _VIEWS.known
) -> Obstacle | None:
    """Return what of a car stops the rays of a sensor; None if its view, which `view_of` returns, is needed and not yet
    known. By default nothing is computed for it."""
    start_m = housing_radius_m(sensor)
    if not solid.housings:
        return Obstacle(solid.fingerprint, start_m, sensor.kind, solid)
    others = tuple(one for one in solid.housings if one.name != sensor.name)
    may_meet = _may_meet(sensor, others, start_m, view_of)
    if may_meet is None:
        return None
    met = tuple(compress(others, may_meet))
    key = hashlib.sha256(repr((solid.body, met)).encode()).hexdigest() if met else solid.body
    return Obstacle(key, start_m, sensor.kind, solid, met)


def barrier_of(sensor: Sensor, solid: Solid) -> Barrier:
    """Return the part of the car that stops the rays of a sensor."""
    return obstacle_of(sensor, solid).barrier


def barrier_of_some(sensor: Sensor, solid: Solid) -> Barrier:
    """Return a barrier that stops the same rays of a sensor at the same places, for some of them: it holds the housings
    out of view, too, and needs no table of all rays."""
    others = frozenset(one for one in solid.housings if one.name != sensor.name)
    return solid.barrier(sensor.kind, housing_radius_m(sensor), others)


ROOM_RAD = 1e-5
"""Far more than all rounding of directions and of triangles."""


def _may_meet(
    sensor: Sensor, housings: Sequence[Housing], start_m: float, view_of: Callable[[Sensor], View | None]
) -> NDArray[np.bool_] | None:
    """Return whether rays of a sensor may meet the balls around housings (n,); False is certain. None without a view
    that is needed."""
    places_m = np.array([one.pose.position_m for one in housings]).reshape(-1, 3)
    away = (places_m - np.array(sensor.position)) @ sensor.pose.rotation()
    distance, radius = np.linalg.norm(away, axis=1), np.array([one.radius_m for one in housings]) + ROOM_RAD
    counts, is_around = np.asarray(distance + radius > start_m), distance <= radius
    if not (counts & ~is_around).any():
        return counts
    if (view := view_of(unplaced(sensor))) is None:
        return None
    widest, lowest, highest = view
    divisor = np.where(is_around, np.inf, distance)
    half = np.arcsin(radius / divisor) + ROOM_RAD
    aside = np.arccos(np.clip(away[:, 0] / divisor, -1.0, 1.0))
    up = np.arcsin(np.clip(away[:, 2] / divisor, -1.0, 1.0))
    in_view = (aside - half <= widest) & (lowest <= up + half) & (up - half <= highest)
    return np.asarray(counts & (is_around | in_view))


def _view_rad(sensor: Sensor) -> View:
    """Return the view of a sensor; kept, since tables of rays are not, and those of a bent lens take half a second."""
    return _VIEWS.found(sensor, lambda: _view_of(lattice(sensor)))


def _view_of(table: Lattice) -> View:
    """Return the view of a table of rays."""
    if not len(table.rows):
        return -math.inf, math.inf, -math.inf
    if table.kind == codes.LISTED:
        ahead, up = table.rows[:, 0], table.rows[:, 2]
    elif table.kind == codes.LIDAR:
        level, up = table.rows[:, 0], table.rows[:, 1]
        ahead = np.array([level.min(), level.max()]) * table.planes[:, 0].min()
    else:
        sides = np.abs(table.rows[:, 0]).max(), np.abs(table.planes[:, 0]).max()
        ahead, up = 1.0 / np.sqrt(1.0 + np.square(sides).sum(keepdims=True)), np.array([-1.0, 1.0])
    low, high = np.arcsin(np.clip([up.min(), up.max()], -1.0, 1.0))
    return math.acos(np.clip(ahead.min(), -1.0, 1.0)), float(low), float(high)


def rays_in_metres(sensor: Sensor, table: Lattice | None = None) -> Cast:
    """Return the rays of a sensor, or those of a table, in the vehicle frame, for kernels that use no grid."""
    table = lattice(sensor) if table is None else table
    return Cast(
        table.kind,
        table.rows,
        table.planes,
        np.array(sensor.position, np.float64),
        sensor.pose.rotation(),
        np.array(sensor.range_m),
        np.zeros(6, np.int64),
        np.zeros(3, np.int64),
        False,
        np.zeros(0),
    )


class Shadow(NamedTuple):
    """Rays of a sensor that end at the car, by number: which of them (rays,), as row and plane of the lattice say; of
    some, `cut` (k,), in rising order, at which distance in metres (k,). All others are over before anything that
    counts."""

    is_stopped: NDArray[np.bool_]
    cut: NDArray[np.int64]
    cut_m: NDArray[np.float64]


def listed_ends(sensor: Sensor, directions: NDArray[np.float64], barrier: Barrier) -> NDArray[np.float64]:
    """Return the distance in metres (n,) at which some rays of a sensor first meet its barrier, inf if free.

    directions (n, 3): unit vectors in the vehicle frame. One by one through the tree, by any thread; a ray that ends
    with the sensor's range before the barrier is free.
    """
    from riglens.core.kernels.body.solid import meet_listed  # the compiler

    place = np.array(sensor.position, np.float64)
    most = np.full(len(directions), sensor.range_m[1])
    rays = np.ascontiguousarray(directions)
    return meet_listed(place, rays, barrier.tree, barrier.stops, most, barrier.start_m)[0]


def barrier_ends(sensor: Sensor, barrier: Barrier, workers: int = 1) -> NDArray[np.float64]:
    """Return the distance in metres (rays,) at which each ray first meets the barrier, inf if free.

    Rays as in `lattice(sensor).directions()`: row by row, of a listed sensor those that exist. Range limits play no
    part.
    """
    shadow = barrier_shadow(sensor, barrier, NO_EMPTY_BOX, workers)
    ends = np.full(shadow.is_stopped.size, np.inf)
    ends[shadow.cut] = shadow.cut_m
    return ends


def barrier_shadow(
    sensor: Sensor,
    barrier: Barrier,
    empty_box: NDArray[np.float64],
    workers: int = 1,
    table: Lattice | None = None,
) -> Shadow:
    """Return which rays of a sensor end at a barrier, and where those end that meet it only outside the empty box.

    empty_box (6,): low and high corner of a box in metres that holds the sensor, or `NO_EMPTY_BOX`; table: the sensor's
    lattice, where it has been made before.
    """
    rays = rays_in_metres(sensor, table)
    if not len(barrier.stops):
        return _no_shadow(len(rays.rows) * len(rays.planes))
    screen = screen_of(sensor)
    if screen is not None:
        return _by_triangle(rays, screen, barrier, empty_box, workers)
    stops = barrier.stops.tobytes()
    cut, cut_m = _ends(
        _AtBody(rays_of(sensor), id(barrier.tree.corners), stops, barrier.start_m, barrier, workers)
    )
    from riglens.core.kernels.body.empty_box import stop_rays  # the compiler

    is_stopped = np.zeros(len(rays.rows), np.bool_)
    return Shadow(is_stopped, *stop_rays(rays, cut, cut_m, empty_box, is_stopped))


def _no_shadow(rays: int) -> Shadow:
    return Shadow(np.zeros(rays, np.bool_), np.zeros(0, np.int64), np.zeros(0))


def _by_triangle(
    rays: Cast, screen: Screen, barrier: Barrier, empty_box: NDArray[np.float64], workers: int
) -> Shadow:
    """Compute the shadow triangle by triangle, testing each against the rays that can meet it."""
    from riglens.core.kernels.body import shadow as kernel  # the compiler

    rows, columns = len(screen.row_of), len(screen.column_of)
    at = np.empty((rows, columns))
    has_end, is_over = np.zeros((2, rows, (columns + 63) // 64), np.uint64)
    how = rays, screen, *barrier, empty_box
    in_threads(workers, lambda share: kernel.find_ends(*how, share, workers, at, has_end, is_over))
    stopped, cut = has_end | is_over, has_end & ~is_over
    some = np.flatnonzero(stopped.any(axis=1))
    if not some.size:
        return _no_shadow(rows * columns)
    is_stopped = np.zeros((rows, columns), np.bool_)
    if screen.is_camera:
        is_stopped[some] = _unpacked(stopped[some], columns)
    else:
        place_of = np.empty(columns, np.int64)
        place_of[screen.column_of] = np.arange(columns)
        is_stopped[screen.row_of[some]] = _unpacked(stopped[some], columns)[:, place_of]
    row, column = np.nonzero(_unpacked(cut, columns)) if cut.any() else np.zeros((2, 0), np.int64)
    number = screen.row_of[row] * columns + screen.column_of[column]
    order = np.argsort(number)
    return Shadow(is_stopped.ravel(), number[order], at[row, column][order])


def _unpacked(words: NDArray[np.uint64], columns: int) -> NDArray[np.bool_]:
    """Return the bits (rows, columns) of words (rows, n)."""
    bits = np.unpackbits(words.view(np.uint8), axis=1, count=columns, bitorder="little")
    return bits.view(np.bool_)


@dataclass(frozen=True)
class _AtBody:
    """Key of what stops the rays of a sensor without straight rows: the sensor, and the tree, by its identity while it
    is kept, with the triangles in it that stop them; the empty box of a picture."""

    sensor: Sensor
    tree: int
    stops: bytes = field(repr=False)
    start_m: float
    barrier: Barrier = field(compare=False, repr=False)
    workers: int = field(compare=False)


@SHADOWS.of
def _ends(at: _AtBody) -> tuple[NDArray[np.int32], NDArray[np.float64]]:
    """Return which rays a body stops, in rising order, and at which distances in metres: each triangle is offered to
    the rays of a picture that can meet it, other rays search the tree one by one."""
    from riglens.core.kernels.body import empty_box, lens_shadow, solid  # the compiler

    rays = rays_in_metres(at.sensor)
    ends = np.full(len(rays.rows) * len(rays.planes), np.inf)
    if is_image(at.sensor):
        how = rays, tiled(at.sensor), *at.barrier
        in_threads(at.workers, lambda share: lens_shadow.find_lens_ends(*how, share, at.workers, ends))
    else:
        in_threads(at.workers, lambda share: solid.ends_by_tree(rays, *at.barrier, share, at.workers, ends))
    found: tuple[NDArray[np.int32], NDArray[np.float64]] = empty_box.finite_ends(ends)
    return found
