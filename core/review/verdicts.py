"""Decide which objects of a profile a rig sees: exact rays against upright cylinders, never voxels.

Each object is alone; the car's own body hides it where it blocks. Two things are told for every sensor: how
many of its rays meet the object, of a camera those of all its pixels, and which share of the surface that faces it lies
in its view, between the sensor and which nothing of the car stands. The share does not depend on how densely a sensor
looks.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import singledispatch

import numpy as np
from numpy.typing import NDArray

from riglens.core.blind.outline import Outline
from riglens.core.geometry import Pose
from riglens.core.metric.scores import Body
from riglens.core.review.profiles import Profile, Target, targets_of
from riglens.core.rig.model import Camera, Lidar, Rig, Sensor
from riglens.core.sensing.body_ends import barrier_ends, barrier_of, rays_in_metres
from riglens.core.sensing.rays import limits_m
from riglens.core.sensors.camera import project_px
from riglens.core.sensors.kind import REFERENCE, Echo
from riglens.core.sensors.registry import kind_of
from riglens.core.vehicle.housings import car_of
from riglens.core.vehicle.solid import Barrier

Doubles = NDArray[np.float64]
_AROUND, _UP, _RINGS = 24, 16, 3
"""Points on the side of a cylinder, around and upwards, and rings of points on its top."""
_OFF_M = 1e-3
"""Length before a point over which a ray need not be free: contact with the car there is not in the way."""


@dataclass(frozen=True)
class ObjectVerdict:
    """Visibility of an object: `rays` of the sensors that count, the best `share`, and both by sensor."""

    target: Target
    is_seen: bool
    rays: int
    share: float
    rays_by_sensor: dict[str, int]
    share_by_sensor: dict[str, float]


@dataclass(frozen=True)
class ProfileVerdict:
    """Every object of a profile; the profile holds where all are seen."""

    profile: Profile
    objects: tuple[ObjectVerdict, ...]

    @property
    def failed(self) -> tuple[ObjectVerdict, ...]:
        """The objects that are not seen."""
        return tuple(one for one in self.objects if not one.is_seen)

    @property
    def passes(self) -> bool:
        """Return whether all objects are seen."""
        return not self.failed

    def without(self, failed: Collection[str]) -> ProfileVerdict:
        """Return the verdict on the rig without some sensors."""
        objects = (
            _judged(
                self.profile,
                one.target,
                {name: rays for name, rays in one.rays_by_sensor.items() if name not in failed},
                {name: share for name, share in one.share_by_sensor.items() if name not in failed},
            )
            for one in self.objects
        )
        return ProfileVerdict(self.profile, tuple(objects))


def _judged(
    profile: Profile, target: Target, rays: dict[str, int], shares: dict[str, float]
) -> ObjectVerdict:
    """Judge an object by the rays on it and the shares of it, both by sensor."""
    total, best = sum(rays.values()), max(shares.values(), default=0.0)
    return ObjectVerdict(target, total >= profile.rays and best >= profile.share, total, best, rays, shares)


class ObjectVisibility:
    """Visibility of objects by a rig's enabled sensors."""

    def __init__(self, rig: Rig, body: Body, workers: int = 1, stance: Pose = Pose()) -> None:
        self._outline, self._workers = Outline.of(rig.vehicle), workers
        solid = car_of(rig, stance) if body == "blocks" else None
        self._sensors = [sensor.finest() for sensor in rig.sensors if sensor.enabled]
        self._barriers = {s.name: None if solid is None else barrier_of(s, solid) for s in self._sensors}
        self._ends = {s.name: _ends(s, self._barriers[s.name], workers) for s in self._sensors}

    def verdict(self, profile: Profile) -> ProfileVerdict:
        """Return which objects of a profile the rig sees."""
        (found,) = self.verdicts([profile])
        return found

    def verdicts(self, profiles: Sequence[Profile]) -> tuple[ProfileVerdict, ...]:
        """Return which objects of profiles the rig sees; the rays of each sensor are made once for all of them."""
        targets = [targets_of(profile, self._outline) for profile in profiles]
        rays: list[list[dict[str, int]]] = [[{} for _ in mine] for mine in targets]
        shares: list[list[dict[str, float]]] = [[{} for _ in mine] for mine in targets]

        def look(sensor: Sensor) -> tuple[list[tuple[int, int]], list[int], list[float]]:
            """Return the objects that count for a sensor, its rays on each, and the share of each in its view."""
            places = [
                (number, place)
                for number, profile in enumerate(profiles)
                if profile.by in ("any", sensor.kind)
                for place in range(len(targets[number]))
            ]
            looked_at, barrier = (
                [targets[number][place] for number, place in places],
                self._barriers[sensor.name],
            )
            counts = ray_counts(sensor, looked_at, self._ends[sensor.name])[:, 0]
            return places, counts.tolist(), [surface_share(sensor, target, barrier) for target in looked_at]

        with ThreadPoolExecutor(self._workers) as pool:  # its kernels are serial
            for sensor, found in zip(self._sensors, pool.map(look, self._sensors), strict=True):
                for (number, place), count, share in zip(*found, strict=True):
                    rays[number][place][sensor.name], shares[number][place][sensor.name] = count, share
        return tuple(
            ProfileVerdict(
                profile,
                tuple(
                    _judged(profile, target, own, parts)
                    for target, own, parts in zip(mine, by_rays, by_share, strict=True)
                ),
            )
            for profile, mine, by_rays, by_share in zip(profiles, targets, rays, shares, strict=True)
        )


def verdicts(
    rig: Rig, profiles: Sequence[Profile], body: Body, workers: int = 1
) -> tuple[ProfileVerdict, ...]:
    """Return a rig's verdicts on profiles."""
    return ObjectVisibility(rig, body, workers).verdicts(profiles)


def _ends(sensor: Sensor, barrier: Barrier | None, workers: int) -> Doubles:
    """Return the distance at which the car stops each ray (rays,), metres; empty where it stops none."""
    found = np.zeros(0) if barrier is None else barrier_ends(sensor, barrier, workers)
    return found if np.isfinite(found).any() else np.zeros(0)


def ray_counts(sensor: Sensor, targets: Sequence[Target], ends_m: Doubles) -> NDArray[np.int64]:
    """Return the rays of a sensor that meet each object (m, 2): before the car stops them, and if it did not."""
    from riglens.core.kernels.objects.cylinders import count_on_cylinders  # the compiler

    counts = np.zeros((len(targets), 2), np.int64)
    if targets:
        rays, cylinders = rays_in_metres(sensor), np.array([target.cylinder for target in targets])
        cones, diameters = _cones(np.array(sensor.position), cylinders), 2.0 * cylinders[:, 2]
        for diameter in np.unique(diameters):
            mine, limits = diameters == diameter, limits_m(sensor, Echo(width_m=float(diameter)))
            ends = (
                np.minimum(limits, ends_m)
                if limits.size and ends_m.size
                else ends_m
                if ends_m.size
                else limits
            )
            found = counts[mine]
            count_on_cylinders(rays._replace(ends=ends), cylinders[mine], cones[mine], found)
            counts[mine] = found
    return counts


def _cones(origin: Doubles, cylinders: Doubles) -> Doubles:
    """Return cones (m, 4) from a sensor around the balls that cylinders fit in; the whole sphere if it is inside the
    ball."""
    x, y, radius, bottom, top = cylinders.T
    middle = np.stack([x, y, (bottom + top) / 2], axis=1) - origin
    distance = np.maximum(np.linalg.norm(middle, axis=1), 1e-12)
    sine = np.hypot(radius, (top - bottom) / 2) * (1.0 + 1e-9) / distance
    cosine = np.where(sine < 1.0, np.sqrt(np.maximum(0.0, 1.0 - sine * sine)) - 1e-9, -2.0)
    return np.column_stack([middle / distance[:, None], cosine])


def surface_share(sensor: Sensor, target: Target, barrier: Barrier | None) -> float:
    """Return the share of the surface facing a sensor that is in its view with nothing of the car before it, by even
    points."""
    points, weights = _facing(np.array(sensor.position, np.float64), target)
    total = float(weights.sum())
    if not total:
        return 0.0
    ahead = points - np.array(sensor.position)
    distance = np.linalg.norm(ahead, axis=1)
    seen = in_view(sensor, ahead @ sensor.pose.rotation(), distance, Echo(width_m=2.0 * target.radius_m))
    if barrier is not None and seen.any():
        from riglens.core.kernels.body.solid import meet_listed  # the compiler

        most = distance[seen] - _OFF_M
        way = np.ascontiguousarray(ahead[seen] / distance[seen, None])
        met = meet_listed(
            np.array(sensor.position, np.float64), way, barrier.tree, barrier.stops, most, barrier.start_m
        )
        seen[seen] = ~np.isfinite(met[0])
    return float(weights[seen].sum()) / total


def in_view(
    sensor: Sensor, local_m: Doubles, distance_m: Doubles, echo: Echo = REFERENCE
) -> NDArray[np.bool_]:
    """Return whether points (n, 3) of an object, in the sensor frame, lie in its field of view and in its range."""
    near, far = sensor.range_m
    ranged = (distance_m > near) & (distance_m <= far)
    of_kind = kind_of(sensor).in_field
    if of_kind is not None:
        return ranged & of_kind(sensor, local_m, distance_m, echo)
    return np.asarray(ranged & _in_field(sensor, local_m, distance_m))


@singledispatch
def _in_field(sensor: Sensor, local_m: Doubles, _: Doubles) -> NDArray[np.bool_]:
    """Return whether points lie between outermost rays: of any kind, within the angles that its field of view spans."""
    wide, high = kind_of(sensor).view_deg(sensor)
    across = np.degrees(np.abs(np.arctan2(local_m[:, 1], local_m[:, 0])))
    up = np.degrees(np.abs(np.arctan2(local_m[:, 2], np.hypot(local_m[:, 0], local_m[:, 1]))))
    return np.asarray((across <= wide / 2.0) & (up <= high / 2.0))


@_in_field.register
def _in_image(camera: Camera, local_m: Doubles, _: Doubles) -> NDArray[np.bool_]:
    pixels = project_px(camera, local_m)
    width, height = camera.image
    with np.errstate(invalid="ignore"):
        return np.asarray(
            (pixels[:, 0] >= 0) & (pixels[:, 0] <= width) & (pixels[:, 1] >= 0) & (pixels[:, 1] <= height)
        )


@_in_field.register
def _between_beams(lidar: Lidar, local_m: Doubles, distance_m: Doubles) -> NDArray[np.bool_]:
    elevations, azimuths = lidar.elevations(), np.sort(lidar.azimuths())
    up = np.degrees(np.arcsin(np.clip(local_m[:, 2] / np.maximum(distance_m, 1e-12), -1.0, 1.0)))
    within = (up >= elevations.min()) & (up <= elevations.max())
    step = float(np.diff(azimuths).max()) if azimuths.size > 1 else 0.0
    if azimuths[-1] - azimuths[0] + step >= 360.0 - 1e-9:
        return np.asarray(within)
    turn = np.degrees(np.arctan2(local_m[:, 1], local_m[:, 0]))
    behind_first = (turn - azimuths[0]) % 360.0
    return np.asarray(within & (behind_first <= azimuths[-1] - azimuths[0]))


def _facing(origin: Doubles, target: Target) -> tuple[Doubles, Doubles]:
    """Return even points on the surface of a cylinder that face a place, (n, 3), and the area of each (n,)."""
    x, y, radius, bottom, top = target.cylinder
    turn = (np.arange(_AROUND) + 0.5) * 2.0 * math.pi / _AROUND
    up = bottom + (np.arange(_UP) + 0.5) * (top - bottom) / _UP
    around = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    side = np.array([[x + radius * c, y + radius * s, z] for c, s in around for z in up])
    normal = np.repeat(around, _UP, axis=0)
    faces = ((origin[:2] - side[:, :2]) * normal).sum(axis=1) > 0.0
    points, weights = (
        side[faces],
        np.full(faces.sum(), 2.0 * math.pi * radius / _AROUND * (top - bottom) / _UP),
    )
    if origin[2] <= top:
        return points, weights
    rings = (np.arange(_RINGS) + 0.5) * radius / _RINGS
    lid = np.array([[x + r * c, y + r * s, top] for r in rings for c, s in around])
    areas = np.repeat(2.0 * math.pi * rings * (radius / _RINGS) / _AROUND, _AROUND)
    return np.concatenate([points, lid]), np.concatenate([weights, areas])
