"""Find a box around the car and a sensor that no object reaches into: where in it a ray stops counts for nothing."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from riglens.core.sensing.body_ends import NO_EMPTY_BOX
from riglens.core.targets.traffic import Traffic

Doubles = NDArray[np.float64]
_REACH_M = np.array([1.0, 1.0, 0.5, 1.0, 1.0, 2.5])
"""Margin around the car, low and high, within which objects are looked at again for each sensor."""
_GAP_M = 1e-3


class Clearance:
    """Room around a car between the objects of some traffic."""

    def __init__(self, traffic: Traffic) -> None:
        self._traffic = traffic
        self._near: tuple[bytes, NDArray[np.int64]] | None = None

    def empty_box(self, car: Doubles, place: Doubles, frames: tuple[int, int]) -> Doubles:
        """Return the box (6,) around bounds of the car (6,) and the place of a sensor (3,); `NO_EMPTY_BOX` where an
        object of frames first..end-1 reaches into it, or the place is far from the car."""
        key = car.tobytes()
        if self._near is None or self._near[0] != key:
            wide = car + np.where(np.arange(6) < 3, -_REACH_M, _REACH_M)
            away = self._traffic.centre_m - (wide[:3] + wide[3:]) / 2.0
            reach = np.linalg.norm((wide[3:] - wide[:3]) / 2.0) + np.linalg.norm(self._traffic.half_m, axis=1)
            some = np.flatnonzero(np.einsum("ni,ni->n", away, away) <= reach**2)
            self._near = key, self._inside(wide, some)
        box = np.concatenate([np.minimum(car[:3], place), np.maximum(car[3:], place)])
        if (np.abs(box - car) >= _REACH_M - _GAP_M).any():
            return NO_EMPTY_BOX
        first, end = self._traffic.starts[list(frames)]
        near = self._near[1]
        some = near[(first <= near) & (near < end)]
        return NO_EMPTY_BOX if self._inside(box, some).size else box

    def _inside(self, box: Doubles, some: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return which of some objects may reach into a box: no side of either lies between them."""
        traffic = self._traffic
        turn, half, size = traffic.rotation[some], traffic.half_m[some], (box[3:] - box[:3]) / 2.0
        away = traffic.centre_m[some] - (box[:3] + box[3:]) / 2.0
        theirs = np.einsum("nij,nj->ni", np.abs(turn), half)
        ours = np.einsum("nij,i->nj", np.abs(turn), size)
        apart = (np.abs(away) > size + theirs + _GAP_M).any(axis=1)
        apart |= (np.abs(np.einsum("nij,ni->nj", turn, away)) > half + ours + _GAP_M).any(axis=1)
        return np.asarray(some[~apart])
