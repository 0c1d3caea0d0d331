"""Streets of a map as surfaces on the ground: asphalt, and the marks on it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from riglens.core.scene.occluders import FrameName, MapPose

Doubles = NDArray[np.float64]
Quads = NDArray[np.float64]
"""Quadrangles (q, 4, 2) on the ground, metres."""
REACH_M = 150.0
_PIECE_M = 6.0
_DASH_M, _PITCH_M = 3.0, 9.0
_THIN_M, _DOUBLE_M, _APART_M = 0.12, 0.11, 0.26
_KERB_M, _BEFORE_CROSSING_M = 0.14, 2.0
_TURN = np.array([[0.0, 1.0], [-1.0, 0.0]])
"""Turns row vectors by a quarter to the left."""


class Street(NamedTuple):
    """Middle of a street (n, 2) in the map, metres, and its lanes, (use, width in metres) from the kerb to the middle,
    alike on both sides; those for walking have no asphalt."""

    middle: Doubles
    lanes: tuple[tuple[str, float], ...]

    @property
    def half_m(self) -> float:
        """Half the width of the asphalt."""
        return sum(width for use, width in self.lanes if use != "sidewalk")


@dataclass(frozen=True, eq=False)
class StreetView:
    """Asphalt and marks around the car, in the vehicle frame. Equal only to itself."""

    asphalt: Quads
    marks: Quads


@dataclass(frozen=True, eq=False)
class Streets:
    """Asphalt and marks of each map, in its frame, and the pose of the vehicle frame in each frame."""

    maps: Mapping[str, StreetView]
    poses: Mapping[FrameName, MapPose]

    def around(self, frame: FrameName, reach_m: float = REACH_M) -> StreetView | None:
        """Return what is within reach of a frame's pose; None without a pose or a map of it."""
        pose = self.poses.get(frame)
        if pose is None or pose.map not in self.maps:
            return None
        whole, cos, sin = self.maps[pose.map], math.cos(pose.yaw_rad), math.sin(pose.yaw_rad)
        asphalt, marks = (
            ((quads - pose.position_m[:2]) @ np.array([[cos, -sin], [sin, cos]]))[
                np.linalg.norm(quads.mean(axis=1) - pose.position_m[:2], axis=1) <= reach_m
            ]
            for quads in (whole.asphalt, whole.marks)
        )
        return StreetView(asphalt, marks)


def surfaces(streets: Iterable[Street]) -> StreetView:
    """Return asphalt and marks of a map's streets, which cross where they have an end in common."""
    streets = list(streets)
    meeting: dict[tuple[float, ...], list[Street]] = {}
    for street in streets:
        for end in (street.middle[0], street.middle[-1]):
            meeting.setdefault(tuple(end.tolist()), []).append(street)
    asphalt = [_ribbon(_even(street.middle), 2.0 * street.half_m) for street in streets]
    asphalt += [_disc(end, max(one.half_m for one in there)) for end, there in meeting.items()]
    marks: list[Quads] = []
    for street in streets:
        cut_m = [
            _cut_m(street, meeting[tuple(end.tolist())]) for end in (street.middle[0], street.middle[-1])
        ]
        marks += _marks(street, *cut_m)
    return StreetView(np.concatenate(asphalt), np.concatenate(marks))


def _cut_m(street: Street, there: list[Street]) -> float:
    """Return how far from an end of a street its marks begin: beyond the streets that it crosses there."""
    return (
        max((one.half_m + _BEFORE_CROSSING_M for one in there if one is not street), default=0.0)
        if len(there) > 2
        else 0.0
    )


def _marks(street: Street, from_m: float, to_m: float) -> Iterator[Quads]:
    """Yield the marks of a street between distances from its two ends."""
    middle = _even(street.middle)
    left = _normals(middle)
    along = _lengths(middle)
    whole_m = along[-1]
    if whole_m - from_m - to_m < _PITCH_M:
        return
    for offset_m, width_m, is_dashed in _lines(street):
        for side in (1.0, -1.0) if offset_m else (1.0,):
            line = middle + side * offset_m * left
            ends = (
                [(at, at + _DASH_M) for at in np.arange(from_m, whole_m - to_m - _DASH_M, _PITCH_M).tolist()]
                if is_dashed
                else list(pairwise(np.linspace(from_m, whole_m - to_m, math.ceil(whole_m / _PIECE_M) + 1)))
            )
            starts, stops = (np.array(part) for part in zip(*ends, strict=True))
            edges = [
                np.column_stack([np.interp(at, along, (line + out * left)[:, axis]) for axis in (0, 1)])
                for at, out in (
                    (starts, width_m / 2), (starts, -width_m / 2), (stops, -width_m / 2), (stops, width_m / 2),
                )
            ]  # fmt: skip
            yield np.stack(edges, axis=1)


def _lines(street: Street) -> Iterator[tuple[float, float, bool]]:
    """Yield the marks on one side of a street: distance from the middle, width, and whether dashed."""
    lanes = [lane for lane in reversed(street.lanes) if lane[0] != "sidewalk"]
    if sum(use == "motor" for use, _ in lanes) > 1:
        yield _APART_M / 2, _DOUBLE_M, False
    else:
        yield 0.0, _THIN_M, True
    offset_m = 0.0
    for (use, width_m), (other, _) in pairwise(lanes):
        offset_m += width_m
        yield offset_m, _THIN_M, use == other
    yield street.half_m - _KERB_M, _KERB_M, False


def _lengths(line: Doubles) -> Doubles:
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])


def _even(line: Doubles) -> Doubles:
    """Return a line with a point at least every `_PIECE_M`."""
    parts = (
        np.linspace(a, b, math.ceil(math.dist(a, b) / _PIECE_M), endpoint=False) for a, b in pairwise(line)
    )
    return np.concatenate([*parts, line[-1:]])


def _normals(line: Doubles) -> Doubles:
    """Return unit vectors to the left of a line at its points."""
    steps = np.diff(line, axis=0)
    steps /= np.linalg.norm(steps, axis=1, keepdims=True)
    ahead = np.concatenate([steps[:1], steps[:-1] + steps[1:], steps[-1:]])
    return np.asarray(ahead / np.linalg.norm(ahead, axis=1, keepdims=True) @ _TURN)


def _ribbon(line: Doubles, width_m: float) -> Quads:
    out = width_m / 2.0 * _normals(line)
    left, right = line + out, line - out
    return np.stack([left[:-1], right[:-1], right[1:], left[1:]], axis=1)


def _disc(middle: tuple[float, ...], radius_m: float, wedges: int = 16) -> Quads:
    turn = np.linspace(0.0, 2.0 * np.pi, 2 * wedges + 1)
    rim = np.array(middle) + radius_m * np.column_stack([np.cos(turn), np.sin(turn)])
    return np.stack([np.broadcast_to(middle, (wedges, 2)), rim[:-1:2], rim[1::2], rim[2::2]], axis=1)
