"""Bearings that cameras show at the horizon, and how far those of neighbours overlap."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from riglens.core.footprint.detail import in_image
from riglens.core.rig.model import Camera

_STEP_DEG = 0.5
_HALVINGS = 30


@dataclass(frozen=True)
class Bearings:
    """Bearings of a camera, from right to left, in degrees: 0 ahead, positive left; `from_deg` in [-180, 180)."""

    camera: str
    from_deg: float
    to_deg: float

    @property
    def middle_deg(self) -> float:
        """The middle, which may be 180 or more."""
        return (self.from_deg + self.to_deg) / 2.0


@dataclass(frozen=True)
class Overlap:
    """Bearings that a camera shares with its neighbour to the left, in degrees; negative: a gap between them."""

    right: str
    left: str
    overlap_deg: float


@lru_cache(maxsize=128)
def bearings(camera: Camera) -> Bearings | None:
    """Return the widest range of bearings whose horizon is in the picture; None if it shows no horizon."""
    rotation = camera.pose.rotation()

    def shows(bearing_deg: NDArray[np.float64]) -> NDArray[np.bool_]:
        angle = np.radians(bearing_deg)
        level = np.stack([np.cos(angle), np.sin(angle), np.zeros(len(angle))], axis=1)
        return in_image(camera, level @ rotation)

    degrees = np.arange(-180.0, 180.0, _STEP_DEG)
    inside = shows(degrees)
    if not inside.any():
        return None
    if inside.all():
        return Bearings(camera.name, -180.0, 180.0)
    start = int(np.flatnonzero(~inside)[0])
    turned = np.concatenate([np.roll(inside, -start), [False]])
    edges = np.flatnonzero(np.diff(turned.astype(np.int8)))
    first, last = edges[0::2] + 1, edges[1::2]
    widest = int(np.argmax(last - first))
    inner = degrees[start] + _STEP_DEG * np.array([first[widest], last[widest]])
    outer = inner + _STEP_DEG * np.array([-1.0, 1.0])
    for _ in range(_HALVINGS):
        middle = (inner + outer) / 2.0
        is_shown = shows(middle)
        inner, outer = np.where(is_shown, middle, inner), np.where(is_shown, outer, middle)
    ends = inner.tolist()
    turns = 360.0 * np.floor((ends[0] + 180.0) / 360.0)
    return Bearings(camera.name, float(ends[0] - turns), float(ends[1] - turns))


def overlaps(cameras: Iterable[Camera]) -> tuple[Overlap, ...]:
    """Return the overlap of each camera with the next one to the left, by the middles of their bearings.

    Cameras that show no horizon have no neighbours. Of two cameras the side where they share more counts.
    """
    known = [found for found in map(bearings, cameras) if found is not None]
    known.sort(key=lambda found: ((found.middle_deg + 180.0) % 360.0, found.camera))
    if len(known) < 2:
        return ()
    pairs = list(zip(known, [*known[1:], known[0]], strict=True))
    found = [Overlap(a.camera, b.camera, _shared_deg(a, b)) for a, b in pairs]
    return tuple(found) if len(known) > 2 else (max(found, key=lambda one: one.overlap_deg),)


def _shared_deg(right: Bearings, left: Bearings) -> float:
    apart = (left.middle_deg - right.middle_deg) % 360.0
    spans = right.to_deg - right.from_deg, left.to_deg - left.from_deg
    return min(*spans, sum(spans) / 2.0 - apart)
