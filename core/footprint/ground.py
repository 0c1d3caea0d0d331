"""The footprint of a sensor on flat ground, in bands: of pixels per metre, or of the classes that it reaches.

Of a camera without distortion the bands are exact polygons, since f / depth = limit is a straight line on the ground.
Everything else - a bent lens, a limited range, a blocked sector, the car's own body, a radar - is followed outwards
along bearings from the point below the sensor; where a band begins and ends there is found by bisection.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from riglens.core.errors import InputError
from riglens.core.footprint.detail import in_image, px_per_deg, px_per_m
from riglens.core.rig.model import MAX_SENSORS
from riglens.core.scene.boxes import CLASSES
from riglens.core.sensing.kept import LatestAnswers
from riglens.core.sensors.base import Sensor, rays_of
from riglens.core.sensors.camera import Camera, pixel_directions
from riglens.core.sensors.kind import Echo
from riglens.core.sensors.registry import kind_of
from riglens.core.sensors.sectors import Sectored
from riglens.core.targets.detection_range import SIZES_M
from riglens.core.vehicle.solid import Barrier, Solid

Points = NDArray[np.float64]
Levels = NDArray[np.int64]
EN_62676_4 = (250.0, 125.0, 63.0, 25.0)
"""Pixels per metre to identify, recognise, observe and detect a person (EN 62676-4:2015, 62.5 as 63)."""
MOST_BANDS, LEAST_LIMIT, MOST_LIMIT = 8, 0.1, 1e5
_NEAR_M = 0.05
_HALVINGS = 14
STEP_DEG = 2.0
"""Largest angle between the bearings along which bent outlines are followed."""
_MOST_KEPT = MAX_SENSORS + 1
"""Those of a whole rig that were asked for last are all kept."""
_ROOM_RAD = 1e-6
"""Far more than all rounding of directions."""
_HEIGHTS = 5
"""Places above each other on an object, of which a radar or ultrasonic sensor has to reach one."""


@dataclass(frozen=True, eq=False)
class Band:
    """Part of a footprint: ground of at least `limit` and less than the limit of the band before.

    title: "≥ 125 px/m", or the class that is reached as far as that; limit: pixels per metre, NaN for classes; patches:
    outlines (n, 2) in metres, vehicle frame. Corner k faces corner n - 1 - k across the patch.
    """

    title: str
    limit: float
    patches: tuple[Points, ...]

    @property
    def area_m2(self) -> float:
        """Area of the ground in the band."""
        return float(sum(_area_m2(patch) for patch in self.patches))


@dataclass(frozen=True, eq=False)
class Footprint:
    """Footprint of a sensor: bands from the finest, or from the class that is reached least far."""

    sensor: Sensor
    bands: tuple[Band, ...]

    @property
    def area_m2(self) -> float:
        """Area of the ground in all bands."""
        return float(sum(band.area_m2 for band in self.bands))

    @property
    def reach_m(self) -> tuple[float, float] | None:
        """Least and largest distance of the footprint from the point below the sensor; None if it is empty."""
        foot = np.array(self.sensor.position[:2])
        patches = [patch for band in self.bands for patch in band.patches]
        if not patches:
            return None
        least = min(_distance_m(patch, foot) for patch in patches)
        return least, max(float(np.hypot(*(patch - foot).T).max()) for patch in patches)

    def px_per_m(self, points_m: Points) -> Points:
        """Return a camera's pixels per metre at points (n, 3) of the vehicle frame; NaN: not in the picture."""
        return self._at(points_m, px_per_m)

    def px_per_deg(self, points_m: Points) -> Points:
        """Return a camera's pixels per degree at points (n, 3) of the vehicle frame; NaN: not in the picture."""
        return self._at(points_m, px_per_deg)

    def _at(self, points_m: Points, density: Callable[[Camera, Points], Points]) -> Points:
        camera = self.sensor
        if not isinstance(camera, Camera):
            raise InputError(f"{kind_of(camera).plural} have no pixels")
        offset = np.asarray(points_m, np.float64).reshape(-1, 3) - np.array(camera.position)
        local = offset @ camera.pose.rotation()
        return np.asarray(np.where(in_image(camera, local), density(camera, local), np.nan))


def has_footprint(sensor: Sensor) -> bool:
    """Return whether a sensor has a footprint: cameras, and kinds that reach objects of some class so far."""
    return isinstance(sensor, Camera) or kind_of(sensor).in_field is not None


def footprint(
    sensor: Sensor,
    limits: Sequence[float] = EN_62676_4,
    solid: Solid | None = None,
    step_deg: float = STEP_DEG,
) -> Footprint:
    """Return the footprint of a sensor on the ground, without what a solid body hides.

    Parameters
    ----------
    limits
        Of a camera: least pixels per metre of each band, falling.
    step_deg
        Largest angle between the bearings along which bent outlines are followed.

    Raises
    ------
    InputError
        For limits that do not fall, and for a sensor without a footprint.
    """
    if not has_footprint(sensor):
        raise InputError(f"{kind_of(sensor).plural} have no footprint: their beams are rings on the ground")
    barrier = None
    if solid is not None:
        from riglens.core.sensing.body_ends import barrier_of  # the compiler

        barrier = barrier_of(sensor, solid)
    if isinstance(sensor, Camera):
        limits = checked_limits(limits)
        titles = [f"≥ {limit:g} px/m" for limit in limits]
        patches = _of_camera(sensor, limits, barrier, step_deg)
        bands = zip(titles, limits, patches, strict=True)
        return Footprint(sensor, tuple(Band(*band) for band in bands))
    echoes = sorted(_echoes(sensor), key=lambda echo: _reach_m(sensor, echo))
    patches = _followed(sensor, len(echoes), _wave_levels(sensor, echoes, barrier), step_deg)
    names = [echo.cls for echo in echoes]
    bands = zip(names, [math.nan] * len(names), patches, strict=True)
    return Footprint(sensor, tuple(Band(*band) for band in bands))


class KeptFootprints:
    """Footprints by what decides them, the latest of them kept; for all threads.

    step_deg: largest angle between the bearings along which bent outlines are followed.
    """

    def __init__(self, step_deg: float = STEP_DEG) -> None:
        self._step_deg = step_deg
        self._kept = LatestAnswers[Hashable, Footprint](_MOST_KEPT)

    def known(self, sensor: Sensor, limits: tuple[float, ...], solid: Solid | None) -> Footprint | None:
        """Return a footprint that was found before, at once."""
        return self._kept.known(self._key(sensor, limits, solid, waits=False))

    def found(self, sensor: Sensor, limits: tuple[float, ...], solid: Solid | None) -> Footprint:
        """Return the footprint of a sensor with such limits of cameras, without what a solid body hides."""
        key = self._key(sensor, limits, solid, waits=True)
        return self._kept.found(key, lambda: footprint(sensor, limits, solid, self._step_deg))

    @staticmethod
    def _key(sensor: Sensor, limits: tuple[float, ...], solid: Solid | None, waits: bool) -> Hashable:
        """Return the rays, the limits, and of a body what may hide ground: without housings out of view.

        Without `waits` None, the key of nothing, where that needs a table of rays.
        """
        if solid is None or not solid.housings:
            return rays_of(sensor), limits, "" if solid is None else solid.fingerprint
        from riglens.core.sensing.body_ends import known_obstacle, obstacle_of  # the compiler

        obstacle = (obstacle_of if waits else known_obstacle)(sensor, solid)
        return None if obstacle is None else (rays_of(sensor), limits, obstacle.fingerprint)


FOOTPRINTS = KeptFootprints()
"""Footprints of this process: a thread finds those of a car before the window draws them."""


def checked_limits(limits: Sequence[float]) -> tuple[float, ...]:
    """Return limits of pixels per metre as they have to be; InputError otherwise."""
    found = tuple(float(limit) for limit in limits)
    falls = all(high > low for high, low in pairwise(found))
    inside = all(LEAST_LIMIT <= limit <= MOST_LIMIT for limit in found)
    if not (1 <= len(found) <= MOST_BANDS and falls and inside):
        raise InputError(
            f"must be 1 to {MOST_BANDS} falling numbers from {LEAST_LIMIT:g} to {MOST_LIMIT:g} px/m "
            f"(got {', '.join(f'{limit:g}' for limit in found)})",
            "px_per_m",
        )
    return found


# ---------------------------------------------------------------- cameras
def _of_camera(
    camera: Camera, limits: tuple[float, ...], barrier: Barrier | None, step_deg: float
) -> list[tuple[Points, ...]]:
    """Return the patches of each band."""
    whole = _polygons(camera, limits) if camera.distortion is None else None
    if whole is not None:
        corners = [polygon for polygon in whole if len(polygon)]
        if not corners:
            return [() for _ in limits]
        is_free = not camera.blocked and camera.range_m == (0.0, math.inf)
        if is_free and (barrier is None or not _is_any_hidden(camera, corners, barrier)):
            return [(polygon,) if len(polygon) else () for polygon in whole]
    levels = _camera_levels(camera, limits, barrier)
    return _followed(camera, len(limits), levels, step_deg, _most_m(camera, limits[-1]), whole)


def _polygons(camera: Camera, limits: tuple[float, ...]) -> list[Points]:
    """Return the convex polygon (n, 2) of each band of a pinhole, (0, 2) for an empty one.

    Inside are the places on the ground with a . (x, y, 0) + b >= 0 for the sides of the image and both depths.
    """
    rotation, origin = camera.pose.rotation(), np.array(camera.position)
    fx, fy, cx, cy = camera.intrinsics_px()
    width, height = camera.image
    sides = np.array(
        [[cx / fx, -1, 0], [(width - cx) / fx, 1, 0], [cy / fy, 0, -1], [(height - cy) / fy, 0, 1]]
    )
    if origin[2] <= 0.0:
        return [np.zeros((0, 2)) for _ in limits]
    planes = [(rotation @ side, -float(rotation @ side @ origin)) for side in sides]
    ahead = rotation[:, 0]
    at_origin = float(ahead @ origin)
    found = []
    for far, near in zip(limits, (math.inf, *limits), strict=False):
        depths = ((ahead, -at_origin - fx / near), (-ahead, at_origin + fx / far))
        reach_m = 4.0 * (fx / far) * (1.0 + np.abs(sides).sum()) + origin[2]
        square = origin[:2] + reach_m * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
        for normal, offset in (*planes, *depths):
            square = _cut(square, normal[:2], offset)
        found.append(square)
    return found


def _cut(polygon: Points, normal: Points, offset: float) -> Points:
    """Return the part of a convex polygon (n, 2) where normal . point + offset >= 0."""
    if not len(polygon):
        return polygon
    at = polygon @ normal + offset
    corners = []
    for here, there, at_here, at_there in zip(
        polygon, np.roll(polygon, -1, axis=0), at, np.roll(at, -1), strict=True
    ):
        if at_here >= 0.0:
            corners.append(here)
        if (at_here >= 0.0) != (at_there >= 0.0):
            corners.append(here + (there - here) * (at_here / (at_here - at_there)))
    return np.array(corners).reshape(-1, 2)


def _is_any_hidden(camera: Camera, polygons: Sequence[Points], barrier: Barrier) -> bool:
    """Return whether the body hides any place of some polygons, as seen by rays to a lattice of them."""
    rows = np.concatenate([_lattice_over(polygon) for polygon in polygons])
    return bool(_hidden(camera, rows, barrier).any())


def _lattice_over(polygon: Points) -> Points:
    """Return places over a convex polygon: along its edges and towards its middle."""
    share = np.linspace(0.0, 1.0, 12, endpoint=False)[:, None]
    edges = [a + share * (b - a) for a, b in zip(polygon, np.roll(polygon, -1, axis=0), strict=True)]
    edge, middle = np.concatenate(edges), polygon.mean(axis=0)
    return np.concatenate([middle + part * (edge - middle) for part in (1.0, 0.85, 0.6, 0.3)])


def _camera_levels(
    camera: Camera, limits: tuple[float, ...], barrier: Barrier | None
) -> Callable[[Points], Levels]:
    """Return a function from places (n, 2) to the number of limits that are met there, 0 out of view."""
    rotation, origin = camera.pose.rotation(), np.array(camera.position)

    def levels(places: Points) -> Levels:
        offset = np.column_stack([places, np.zeros(len(places))]) - origin
        local = offset @ rotation
        distance = np.linalg.norm(offset, axis=1)
        low, high = camera.range_m
        seen = np.flatnonzero(in_image(camera, local) & (distance >= low) & (distance <= high))
        found = np.zeros(len(places), np.int64)
        found[seen] = (px_per_m(camera, local[seen])[:, None] >= limits).sum(axis=1)
        seen = np.flatnonzero(found)
        if barrier is not None and len(seen):
            found[seen[_hidden(camera, places[seen], barrier)]] = 0
        return np.asarray(found)

    return levels


def _hidden(sensor: Sensor, places: Points, barrier: Barrier) -> NDArray[np.bool_]:
    """Return whether the body stops the rays to places (n, 2) on the ground, (n,)."""
    return _is_stopped(
        sensor, np.column_stack([places, np.zeros(len(places))]) - np.array(sensor.position), barrier
    )


def _is_stopped(sensor: Sensor, offset: Points, barrier: Barrier) -> NDArray[np.bool_]:
    """Return whether the body stops the rays to places (n, 3) as seen from the sensor, in vehicle axes, (n,)."""
    from riglens.core.sensing.body_ends import listed_ends  # the compiler

    distance = np.linalg.norm(offset, axis=1)
    return np.asarray(listed_ends(sensor, offset / distance[:, None], barrier) < distance)


def _most_m(camera: Camera, limit: float) -> float:
    """Return a distance beyond which no place has as many pixels per metre."""
    share = np.linspace(0.0, 1.0, 33)
    u, v = np.meshgrid(share * camera.image[0], share * camera.image[1])
    directions = pixel_directions(camera, np.stack([u.ravel(), v.ravel()], axis=1))
    known = directions[np.isfinite(directions[:, 0])]
    return 1.05 * float(np.nanmax(px_per_m(camera, known), initial=0.0)) / limit


# ---------------------------------------------------------------- radars and ultrasonic sensors
def _echoes(sensor: Sensor) -> tuple[Echo, ...]:
    return tuple(Echo(cls, min(SIZES_M[cls][:2])) for cls in CLASSES)


def _reach_m(sensor: Sensor, echo: Echo) -> float:
    """Return how far a sensor reaches an object."""
    limits = kind_of(sensor).limits_m(sensor, echo)
    most = math.inf if limits is None else float(np.max(limits))
    return min(most, sensor.range_m[1])


def _wave_levels(
    sensor: Sensor, echoes: Sequence[Echo], barrier: Barrier | None
) -> Callable[[Points], Levels]:
    """Return a function from places (n, 2) to the number of classes that are reached there."""
    in_field = kind_of(sensor).in_field
    assert in_field is not None
    rotation, origin = sensor.pose.rotation(), np.array(sensor.position)

    def reached(places: Points, echo: Echo) -> NDArray[np.bool_]:
        top_m = SIZES_M[echo.cls][2]
        found = reached_at(places, echo, np.array([min(origin[2], top_m)]))  # nearly all that are reached
        rest = np.flatnonzero(~found)
        found[rest] = reached_at(places[rest], echo, np.linspace(0.0, top_m, _HEIGHTS))
        return found

    def reached_at(places: Points, echo: Echo, heights_m: Points) -> NDArray[np.bool_]:
        """Return whether any of some heights is reached, (n,)."""
        each = np.empty((len(places), len(heights_m), 3))
        each[..., :2] = (places - origin[:2])[:, None]
        each[..., 2] = heights_m - origin[2]
        offset = each.reshape(-1, 3)
        local, distance = offset @ rotation, np.sqrt((offset * offset).sum(axis=1))
        inside = in_field(sensor, local, distance, echo) & ~sensor.blocked_rays(local)
        inside &= (distance >= sensor.range_m[0]) & (distance <= sensor.range_m[1])
        held = np.flatnonzero(inside)
        if barrier is not None and len(held):
            inside[held] = ~_is_stopped(sensor, offset[held], barrier)
        return np.asarray(inside.reshape(len(places), len(heights_m)).any(axis=1))

    def levels(places: Points) -> Levels:
        found, rest = np.zeros(len(places), np.int64), np.arange(len(places))
        for echo in reversed(echoes):  # what is reached less far lies within what is reached farther
            rest = rest[reached(places[rest], echo)]
            found[rest] += 1
        return found

    return levels


# ---------------------------------------------------------------- along bearings
def _followed(
    sensor: Sensor,
    count: int,
    levels: Callable[[Points], Levels],
    step_deg: float,
    most_m: float | None = None,
    polygons: Sequence[Points] | None = None,
) -> list[tuple[Points, ...]]:
    """Return the patches of each of `count` bands, the finest first: where `levels` is count, count - 1, ..."""
    foot = np.array(sensor.position[:2])
    if most_m is None:
        most_m = 1.01 * max(_reach_m(sensor, echo) for echo in _echoes(sensor))
    if sensor.position[2] < 0.0 or not 0.0 < most_m < math.inf:
        return [() for _ in range(count)]
    bearings = _bearings(sensor, step_deg, foot, polygons)
    steps = max(16, math.ceil(math.log(most_m / _NEAR_M) / (0.025 * step_deg)))
    radii = np.geomspace(_NEAR_M, most_m, steps)
    along = np.stack([np.cos(bearings), np.sin(bearings)], axis=1)

    def at(rows: NDArray[np.int64], radius_m: Points) -> Levels:
        return levels(foot + radius_m[:, None] * along[rows])

    faced = np.flatnonzero(_is_faced(sensor, along))
    field = np.zeros((len(bearings), steps), np.int64)
    field[faced] = at(np.repeat(faced, steps), np.tile(radii, len(faced))).reshape(len(faced), steps)
    runs = _runs(field, at, radii)
    return [_outlines(runs, level, along, foot) for level in range(count, 0, -1)]


def _bearings(sensor: Sensor, step_deg: float, foot: Points, polygons: Sequence[Points] | None) -> Points:
    """Return bearings once round, in radians: even ones, and one on either side of each corner of the field."""
    even: Points = np.radians(np.arange(-180.0, 180.0, step_deg))
    corners = [polygon - foot for polygon in polygons or () if len(polygon)]
    if isinstance(sensor, Sectored):
        ends = np.radians([azimuth for sector in sensor.sectors for azimuth in sector.azimuth_deg])
        level = np.stack([np.cos(ends), np.sin(ends), np.zeros(len(ends))], axis=1)
        corners.append((level @ sensor.pose.rotation().T)[:, :2])
    if not corners:
        return even
    special = np.concatenate([np.arctan2(corner[:, 1], corner[:, 0]) for corner in corners])
    beside = np.concatenate([special - 1e-7, special + 1e-7])
    turned = (beside + math.pi) % (2.0 * math.pi) - math.pi
    return np.asarray(np.unique(np.concatenate([even, turned])))


def _is_faced(sensor: Sensor, along: Points) -> NDArray[np.bool_]:
    """Return whether a sensor may look along bearings (n, 2), at any elevation, (n,); False is certain."""
    if not isinstance(sensor, Sectored):
        return np.ones(len(along), np.bool_)
    found, rotation = np.zeros(len(along), np.bool_), sensor.pose.rotation()
    for sector in sensor.sectors:
        (right, left), (low, high) = np.radians([sector.azimuth_deg, sector.elevation_deg])
        half, middle = (left - right) / 2.0, (low + high) / 2.0
        # a cone around the sector: up to a right angle aside, its corners are farthest from its middle
        corners = np.sin(middle) * np.sin([low, high]) + np.cos(middle) * np.cos([low, high]) * np.cos(half)
        widest = np.arccos(min(corners.min(), 1.0)) + _ROOM_RAD
        turn = (left + right) / 2.0
        x, y, z = rotation @ [np.cos(middle) * np.cos(turn), np.cos(middle) * np.sin(turn), np.sin(middle)]
        aside = np.arcsin(np.clip(np.abs(along @ [-y, x]), 0.0, 1.0))
        off = np.where(along @ [x, y] > 0.0, aside, np.arccos(min(abs(z), 1.0)))
        found |= (off <= widest) | (half > math.pi / 2.0)
    return found


class _Runs(NamedTuple):
    """Stretches of bearings that lie in one band: bearing, level, near and far radius of each, (n,)."""

    rows: NDArray[np.int64]
    levels: Levels
    near_m: Points
    far_m: Points


def _runs(field: Levels, at: Callable[[NDArray[np.int64], Points], Levels], radii: Points) -> _Runs:
    """Return the stretches in bands of samples (bearings, radii), with their ends found exactly."""
    padded = np.pad(field, ((0, 0), (1, 1)))
    inside, last = padded[:, 1:-1] > 0, len(radii) - 1
    rows, first = np.nonzero(inside & (padded[:, 1:-1] != padded[:, :-2]))
    _, final = np.nonzero(inside & (padded[:, 1:-1] != padded[:, 2:]))
    level = field[rows, first]
    both, wanted = np.concatenate([rows, rows]), np.concatenate([level, level])
    inner = radii[np.concatenate([first, final])]
    outer = radii[np.concatenate([np.maximum(first - 1, 0), np.minimum(final + 1, last)])]
    for _ in range(_HALVINGS):
        middle = (inner + outer) / 2.0
        # where two stretches meet, both ends are sought in the same places
        _, one, each = np.unique(both + 1j * middle, return_index=True, return_inverse=True)
        is_inside = at(both[one], middle[one])[each] == wanted
        inner, outer = np.where(is_inside, middle, inner), np.where(is_inside, outer, middle)
    return _Runs(rows, level, inner[: len(rows)], inner[len(rows) :])


def _outlines(runs: _Runs, level: int, along: Points, foot: Points) -> tuple[Points, ...]:
    """Return the outlines of the patches of a band."""
    spans: list[list[tuple[float, float]]] = [[] for _ in along]
    own = runs.levels == level
    for row, near, far in zip(*(part[own].tolist() for part in (runs.rows, *runs[2:])), strict=True):
        spans[row].append((near, far))
    return tuple(
        np.concatenate([foot + far * along[rows], (foot + near * along[rows])[::-1]])
        for rows, near, far in _chains(spans)
    )


def _chains(
    spans: list[list[tuple[float, float]]],
) -> list[tuple[NDArray[np.int64], Points, Points]]:
    """Join spans of neighbouring bearings that overlap: bearings, near and far radii (k, 1) of each chain, k > 1.

    A chain that goes round ends with the bearing that it began with.
    """
    count = len(spans)
    start = next((row for row in range(count) if not spans[row]), 0)
    done: list[list[tuple[int, float, float]]] = []
    going: list[list[tuple[int, float, float]]] = []
    for number in range(count + 1):
        row = (start + number) % count
        rest, kept = list(spans[row]), []
        for chain in going:
            _, near, far = chain[-1]
            match = next((span for span in rest if span[0] <= far and near <= span[1]), None)
            if match is None:
                done.append(chain)
                continue
            rest.remove(match)
            chain.append((row, *match))
            kept.append(chain)
        going = kept + [[(row, *span)] for span in rest]
    columns = [list(zip(*chain, strict=True)) for chain in (*done, *going) if len(chain) > 1]
    return [(np.array(rows), np.array(near)[:, None], np.array(far)[:, None]) for rows, near, far in columns]


# ---------------------------------------------------------------- outlines
def _area_m2(outline: Points) -> float:
    """Return the area within an outline (n, 2)."""
    offset = outline - outline.mean(axis=0)
    ahead = np.roll(offset, -1, axis=0)
    return float(abs(offset[:, 0] @ ahead[:, 1] - offset[:, 1] @ ahead[:, 0])) / 2.0


def _distance_m(outline: Points, place: Points) -> float:
    """Return the distance of a place from an outline (n, 2), 0 inside it."""
    a, b = outline - place, np.roll(outline, -1, axis=0) - place
    step = b - a
    length = np.maximum((step * step).sum(axis=1), 1e-300)
    share = np.clip(-(a * step).sum(axis=1) / length, 0.0, 1.0)
    least = float(np.hypot(*(a + share[:, None] * step).T).min())
    crosses = (a[:, 1] > 0.0) != (b[:, 1] > 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        right = a[:, 0] - a[:, 1] * step[:, 0] / step[:, 1] > 0.0
    return 0.0 if np.count_nonzero(crosses & right) % 2 else least
