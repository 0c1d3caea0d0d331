"""Curves of predicted detection fitted to what was detected: to average precision of rigs, or to objects one by one."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from riglens.core.targets.calibration import CameraCurve, Curve

Doubles = NDArray[np.float64]
Parameters = tuple[float, float, float]

LOWEST, HIGHEST = (0.01, 0.05, 0.1), (1.0, 5000.0, 10.0)
"""Of a, b and c; fits stay within."""
_OF_CAMERAS = ((0.01, 100.0), (1.0, 1000.0))
"""Limits of s and d0, metres."""
_CAMERA_STARTS = ((1.5, 15.0), (1.0, 40.0), (5.0, 5.0))
_STARTS = ((0.9, 5.0, 0.7), (0.9, 30.0, 1.0), (0.9, 30.0, 3.0))


def _curve(found: Parameters, error: float = 0.0, objects: int = 1) -> Curve:
    a, b, c = found
    return Curve(a=a, b=b, c=c, error=min(error, 1.0), objects=objects)


def _fitted(residuals: Callable[[Curve], Doubles], starts: Sequence[Parameters] = _STARTS) -> Parameters:
    """Return a, b and c with the least squares, the best that is reached from a few starts."""

    def of(x: Doubles) -> Doubles:
        return residuals(_curve((float(x[0]), float(np.exp(x[1])), float(np.exp(x[2])))))

    low, high = ((one[0], *np.log(one[1:])) for one in (LOWEST, HIGHEST))
    found = [
        least_squares(of, (a, np.log(b), np.log(c)), bounds=(low, high), xtol=1e-10, ftol=1e-10)
        for a, b, c in starts
    ]
    a, b, c = min(found, key=lambda one: one.cost).x.tolist()
    return float(a), float(np.exp(b)), float(np.exp(c))


@dataclass(frozen=True)
class MeansOfRigs:
    """A class in the study: n (m,) numbers of points or cells; objects (rigs, m) that have so many; observed (rigs,)
    average precision, 0 to 1."""

    n: Doubles
    objects: Doubles
    observed: Doubles

    def predicted(self, curve: Curve) -> Doubles:
        """Return the mean of g over the objects of each rig, (rigs,)."""
        return np.asarray(self.objects @ curve.at(self.n) / self.objects.sum(axis=1))

    def fitted(self) -> tuple[Curve, Doubles]:
        """Return the curve that predicts all rigs best, and the prediction of each rig by the curve of the others,
        (rigs,), whose error is that of the curve."""
        every = np.arange(len(self.observed))
        best = self._fit(every >= 0)
        left_out = np.array([self.predicted(_curve(self._fit(every != rig, best)))[rig] for rig in every])
        error = float(np.sqrt(np.mean((left_out - self.observed) ** 2)))
        return _curve(best, error, int(self.objects[0].sum())), left_out

    def _fit(self, chosen: NDArray[np.bool_], *starts: Parameters) -> Parameters:
        def misses(curve: Curve) -> Doubles:
            return (self.predicted(curve) - self.observed)[chosen]

        return _fitted(misses, starts or _STARTS)


@dataclass(frozen=True)
class FoundObjects:
    """A class in a recording: n (m,) numbers of points; objects (sequences, m) that have so many, and found (sequences,
    m) of them."""

    n: Doubles
    objects: Doubles
    found: Doubles

    def fitted(self) -> Curve:
        """Return recall by points; its error is that of the mean recall of sequences left out, 1 for one sequence."""
        totals = self.objects.sum(axis=1)
        best = self._fit(totals >= 0)
        misses = []
        for one in np.flatnonzero(totals) if np.count_nonzero(totals) > 1 else ():
            curve = _curve(self._fit(np.arange(len(totals)) != one, best))
            misses.append(self.objects[one] @ curve.at(self.n) - self.found[one].sum())
        error = float(np.sqrt(np.square(misses).sum() / np.square(totals).sum())) if misses else 1.0
        return _curve(best, error, int(totals.sum()))

    def _fit(self, chosen: NDArray[np.bool_], *starts: Parameters) -> Parameters:
        """Fit by the shares found of objects with equally many points, each as certain as its objects are many."""
        objects, found = self.objects[chosen].sum(axis=0), self.found[chosen].sum(axis=0)
        some = objects > 0
        n, share, weight = self.n[some], found[some] / objects[some], np.sqrt(objects[some])
        return _fitted(lambda curve: weight * (curve.at(n) - share), starts or _STARTS)


@dataclass(frozen=True)
class FoundByCameras:
    """Objects (k,) of a recording and what a detector found with pictures alone: the share that cameras show, metres
    from the car, the chance that an object of the class is found at all, and whether it was found."""

    visible: Doubles
    distance_m: Doubles
    most: Doubles
    found: NDArray[np.bool_]

    def fitted(self) -> CameraCurve:
        """Return the curve with the least squares."""

        def curve(x: Doubles) -> CameraCurve:
            return CameraCurve(s=float(np.exp(x[0])), d0_m=float(np.exp(x[1])))

        def misses(x: Doubles) -> Doubles:
            return np.asarray(self.most * curve(x).at(self.visible, self.distance_m) - self.found)

        (least_s, most_s), (least_m, most_m) = np.log(_OF_CAMERAS)
        bounds = (least_s, least_m), (most_s, most_m)
        found = [least_squares(misses, np.log(start), bounds=bounds) for start in _CAMERA_STARTS]
        return curve(min(found, key=lambda one: one.cost).x)
