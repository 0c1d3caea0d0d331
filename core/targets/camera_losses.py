"""Say what hides objects from cameras: the edge of the picture, traffic in front of them, or the car itself."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

Doubles = NDArray[np.float64]
Counts = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class CameraLosses:
    """Shares (k,) of objects' silhouettes that are lost to the camera that shows most of each, or, of objects that none
    shows, to the one whose picture holds most of them: outside the picture, behind traffic, and, of the rest, behind
    the car. With the visible share they add up to one; NaN without a camera."""

    outside: Doubles
    traffic: Doubles
    car: Doubles

    @classmethod
    def of(cls, inside: Doubles, alone: Counts, unblocked: Counts, seen: Counts) -> Self:
        """Return the losses of objects from numbers of each camera, (k, cameras).

        inside: share of the silhouette inside the picture; alone: rays that meet the object; unblocked: those of them
        that traffic leaves; seen: those of these that the car leaves.
        """
        if not inside.shape[1]:
            none = np.full(len(inside), np.nan)
            return cls(none, none, none)
        shares = inside[..., None] * np.stack([alone, unblocked, seen], axis=-1)
        shares /= np.maximum(alone, 1)[..., None]
        best = np.where(
            shares[..., 2].any(axis=1), shares[..., 2].argmax(axis=1), shares[..., 0].argmax(axis=1)
        )
        held, left, shown = shares[np.arange(len(best)), best].T
        return cls(1.0 - held, held - left, left - shown)
