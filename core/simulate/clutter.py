"""Draw clutter that looks like objects from afar: bushes, bins, poles, walls, separately for each frame.

All figures are our choice.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from riglens.core.scene.boxes import rotations_from_yaw
from riglens.core.targets.shapes import WHOLE, Part

Doubles = NDArray[np.float64]
WITHIN_M = 60.0
"""Largest distance of clutter from the car."""
APART_M = 0.3
"""Least distance of clutter from objects."""
OWN_PLACE_M = (8.0, 4.0)
"""Length and width of the area around the car without clutter, whichever rig it carries."""


@dataclass(frozen=True)
class Kind:
    """Kind of clutter: its share, least and greatest length, width and height in metres, its parts, and the depth to
    which rays enter it, metres."""

    name: str
    share: float
    least_m: tuple[float, float, float]
    most_m: tuple[float, float, float]
    parts: tuple[Part, ...] = WHOLE
    soft_m: float = 0.0


_CROWN = (
    Part((-0.85, 0.85), (-0.85, 0.85), (-1.0, 0.2)),
    Part((-1.0, 1.0), (-0.6, 0.6), (-0.6, 0.6)),
    Part((-0.6, 0.6), (-1.0, 1.0), (-0.6, 0.6)),
    Part((-0.5, 0.5), (-0.5, 0.5), (0.2, 1.0)),
)
_BIN = (Part((-0.9, 0.9), (-0.85, 0.85), (-1.0, 0.75)), Part((-1.0, 1.0), (-1.0, 1.0), (0.75, 1.0)))
_SIGN = (Part((-0.5, 0.5), (-0.5, 0.5), (-1.0, 0.1)), Part((-1.0, 1.0), (-1.0, 1.0), (0.1, 1.0)))
_RACK = (Part((-1.0, 1.0), (-0.25, 0.25), (-1.0, 0.0)), Part((-0.3, 0.3), (-1.0, 1.0), (0.0, 1.0)))
KINDS = (
    Kind("bush", 0.24, (0.6, 0.6, 0.5), (2.2, 2.2, 1.9), _CROWN, 0.25),
    Kind("hedge", 0.10, (2.0, 0.5, 0.8), (8.0, 1.2, 1.9), WHOLE, 0.15),
    Kind("bin", 0.12, (0.5, 0.5, 0.9), (0.8, 0.8, 1.3), _BIN),
    Kind("container", 0.10, (1.4, 1.0, 1.1), (4.5, 2.0, 1.7)),
    Kind("pole", 0.15, (0.1, 0.1, 2.5), (0.3, 0.3, 8.0)),
    Kind("post", 0.14, (0.3, 0.3, 1.2), (0.7, 0.7, 2.0), _SIGN),
    Kind("rack", 0.08, (1.2, 0.3, 0.8), (2.0, 0.7, 1.2), _RACK),
    Kind("wall", 0.07, (2.0, 0.15, 0.8), (12.0, 0.4, 2.5)),
)


class Clutter(NamedTuple):
    """Clutter on a flat ground: kind (n,), index into KINDS; foot_m (n, 2), their places; size_m (n, 3); yaw_rad
    (n,)."""

    kind: NDArray[np.int64]
    foot_m: Doubles
    size_m: Doubles
    yaw_rad: Doubles

    def rotation(self) -> Doubles:
        """Return rotations (n, 3, 3) from their axes to the vehicle frame."""
        return rotations_from_yaw(self.yaw_rad)


class Footprints(NamedTuple):
    """Rectangles on the ground: centre_m (n, 2); half_m (n, 2) length and width; ahead (n, 2) unit vectors."""

    centre_m: Doubles
    half_m: Doubles
    ahead: Doubles


def scattered(rng: np.random.Generator, number: int, users: Footprints) -> Clutter:
    """Draw clutter uniformly over the disc around the car, except in objects or the car."""
    shares = np.array([kind.share for kind in KINDS])
    kind = np.searchsorted(np.cumsum(shares / shares.sum()), rng.random(number), side="right")
    least, most = np.array([one.least_m for one in KINDS]), np.array([one.most_m for one in KINDS])
    size_m = least[kind] + (most - least)[kind] * rng.random((number, 3))
    far_m, bearing = WITHIN_M * np.sqrt(rng.random(number)), 2.0 * np.pi * rng.random(number)
    foot_m = np.stack([far_m * np.cos(bearing), far_m * np.sin(bearing)], axis=1)
    yaw_rad = np.pi * (2.0 * rng.random(number) - 1.0)
    ahead = np.stack([np.cos(yaw_rad), np.sin(yaw_rad)], axis=1)
    mine = Footprints(foot_m, size_m[:, :2] / 2.0 + APART_M, ahead)
    free = ~overlaps(mine, _with_own_place(users)).any(axis=1)
    return Clutter(kind[free], foot_m[free], size_m[free], yaw_rad[free])


def _with_own_place(users: Footprints) -> Footprints:
    return Footprints(
        np.concatenate([users.centre_m, np.zeros((1, 2))]),
        np.concatenate([users.half_m, np.array([OWN_PLACE_M]) / 2.0]),
        np.concatenate([users.ahead, np.array([[1.0, 0.0]])]),
    )


def overlaps(some: Footprints, others: Footprints) -> NDArray[np.bool_]:
    """Return whether rectangles (k,) overlap others (n,), (k, n): unless an axis of one of the two lies between
    them."""
    apart = others.centre_m[None] - some.centre_m[:, None]
    cos = np.abs(some.ahead @ others.ahead.T)
    sin = np.abs(some.ahead @ _left(others.ahead).T)
    result = np.ones(cos.shape, np.bool_)
    for axis in (0, 1):
        across = (some.ahead, others.ahead) if axis == 0 else (_left(some.ahead), _left(others.ahead))
        theirs, mine = others.half_m[None], some.half_m[:, None]
        along, beside = (cos, sin) if axis == 0 else (sin, cos)
        gap = np.abs((apart * across[0][:, None]).sum(axis=2))
        result &= gap <= mine[..., axis] + along * theirs[..., 0] + beside * theirs[..., 1]
        gap = np.abs((apart * across[1][None]).sum(axis=2))
        result &= gap <= theirs[..., axis] + along * mine[..., 0] + beside * mine[..., 1]
    return result


def _left(ahead: Doubles) -> Doubles:
    return np.stack([-ahead[:, 1], ahead[:, 0]], axis=1)
