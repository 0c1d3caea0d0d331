"""Lens models: from a point of the image plane to a direction and back, as OpenCV defines them.

Optical axes here: x right, y down, z along the view. A distortion is followed only from the optical axis outwards
to where it first stops growing; farther out several directions would fall on one pixel. Pixels beyond that have
no direction, and directions beyond it no pixel: both come out as NaN.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from riglens.core.plain import Frozen

Coefficient = Annotated[float, Field(allow_inf_nan=False, ge=-1e9, le=1e9)]


class BrownConrady(Frozen):
    """Radial and tangential distortion; with k4, k5 or k6 the rational model (OpenCV, calib3d).

    r' / r = (1 + k1 r^2 + k2 r^4 + k3 r^6) / (1 + k4 r^2 + k5 r^4 + k6 r^6), r on the plane at distance 1.
    """

    model: Literal["brown_conrady"] = "brown_conrady"
    k1: Coefficient = 0.0
    k2: Coefficient = 0.0
    p1: Coefficient = 0.0
    p2: Coefficient = 0.0
    k3: Coefficient = 0.0
    k4: Coefficient = 0.0
    k5: Coefficient = 0.0
    k6: Coefficient = 0.0


class KannalaBrandt(Frozen):
    """Fisheye: theta' = theta (1 + k1 theta^2 + k2 theta^4 + k3 theta^6 + k4 theta^8) (OpenCV, fisheye)."""

    model: Literal["kannala_brandt"] = "kannala_brandt"
    k1: Coefficient = 0.0
    k2: Coefficient = 0.0
    k3: Coefficient = 0.0
    k4: Coefficient = 0.0


Distortion = Annotated[BrownConrady | KannalaBrandt, Field(discriminator="model")]

Doubles = NDArray[np.float64]
_STEPS = 100
_NEWTON_STEPS = 12
"""Then halving: near its end Newton may go to and fro between doubles that are equally good."""
_NOTHING = 1e-100
"""Coefficients below this bend no ray measurably in doubles."""
_SHORTEST_STEP = 2.0**-8
_ROUNDING = 2.0**-52
_REACHED = 1e-11
"""Tolerance of a solution, as a share of the image plane's unit."""


@dataclass(frozen=True)
class Radial:
    """g(t) = t N(t^2) / D(t^2) with coefficients in rising order, growing on [0, limit)."""

    numerator: tuple[float, ...]
    denominator: tuple[float, ...]
    limit: float

    def value(self, t: Doubles) -> Doubles:
        """Return g at t, any shape."""
        s = t * t
        return t * _horner(self.numerator, s) / _horner(self.denominator, s)

    def slope(self, t: Doubles) -> Doubles:
        """Return dg / dt at t."""
        s = t * t
        n, d = _horner(self.numerator, s), _horner(self.denominator, s)
        dn, dd = _horner(_derived(self.numerator), s), _horner(_derived(self.denominator), s)
        return ((n + 2.0 * s * dn) * d - 2.0 * s * n * dd) / (d * d)

    @np.errstate(all="ignore")  # the limit may be a pole
    def inverse(self, g: Doubles) -> Doubles:
        """Return t in [0, limit) with g(t) = g >= 0, (n,); NaN for missing ones. Newton, kept between two bounds."""
        low, high = np.zeros_like(g), self._above(g)
        t = np.where(g <= high, g, 0.5 * high)
        todo = np.flatnonzero(np.isfinite(high) & (g > 0.0))
        for step in range(_STEPS):
            if not todo.size:
                break
            now, excess = t[todo], self.value(t[todo]) - g[todo]
            low[todo] = np.where(excess < 0.0, now, low[todo])
            high[todo] = np.where(excess > 0.0, now, high[todo])
            following = now - excess / self.slope(now)
            between = (following >= low[todo]) & (following <= high[todo]) & (step < _NEWTON_STEPS)
            following = np.where(between, following, 0.5 * (low[todo] + high[todo]))
            moved = (following != now) & (high[todo] - low[todo] > np.spacing(now))
            is_met = np.abs(excess) <= _ROUNDING * g[todo]
            t[todo] = np.where(is_met, now, following)
            todo = todo[moved & ~is_met]
        return np.where(np.isfinite(high), t, np.nan)

    def _above(self, g: Doubles) -> Doubles:
        """Return a t below or at the limit with g(t) >= g; NaN for missing ones."""
        if math.isfinite(self.limit):
            top = np.full_like(g, self.limit)
            return np.where(self.value(top) > g, top, np.nan)
        top = np.maximum(g, 1.0)
        for _ in range(_STEPS):
            top = np.where(self.value(top) < g, 2.0 * top, top)
        return np.where(self.value(top) >= g, top, np.nan)


@lru_cache(maxsize=32)
def radial_of(lens: BrownConrady | KannalaBrandt) -> Radial:
    """Return the radial part of a lens: of the radius on the plane at distance 1, or of the angle off the axis."""
    if isinstance(lens, KannalaBrandt):
        fisheye = (1.0, lens.k1, lens.k2, lens.k3, lens.k4)
        return Radial(fisheye, (1.0,), min(math.pi, _turning_point(fisheye, (1.0,))))
    top, bottom = (1.0, lens.k1, lens.k2, lens.k3), (1.0, lens.k4, lens.k5, lens.k6)
    found = Radial(top, bottom, _turning_point(top, bottom))
    # at a pole of the rational model, rounding may put the limit behind it, where the image is turned over
    with np.errstate(divide="ignore"):
        is_behind_pole = math.isfinite(found.limit) and found.value(np.array(found.limit)) < 0.0
    return replace(found, limit=found.limit * (1.0 - 1e-12)) if is_behind_pole else found


def undistorted(lens: BrownConrady | KannalaBrandt, x: Doubles, y: Doubles) -> Doubles:
    """Return unit directions (n, 3) in optical axes of points (x, y), ((u - cx) / fx, (v - cy) / fy), of the image."""
    with np.errstate(all="ignore"):
        radial, length = radial_of(lens), np.hypot(x, y)
        t = radial.inverse(length)
        if isinstance(lens, KannalaBrandt):
            across = np.where(length > 0.0, np.sin(t) / length, 1.0)
            return np.stack([across * x, across * y, np.cos(t)], axis=-1)
        share = np.where(length > 0.0, t / length, 1.0)
        if lens.p1 == 0.0 and lens.p2 == 0.0:
            x, y = share * x, share * y
        else:
            share = np.where(np.isfinite(share), share, 0.99 * radial.limit / length)
            x, y = _without_tangential(lens, x, y, share * x, share * y).T
        norm = np.sqrt(1.0 + x * x + y * y)
        return np.stack([x / norm, y / norm, 1.0 / norm], axis=-1)


def distorted(lens: BrownConrady | KannalaBrandt, points: Doubles) -> Doubles:
    """Return points (x, y) of the image plane, (n, 2), of points or directions (n, 3) in optical axes; NaN: not
    imaged."""
    radial = radial_of(lens)
    with np.errstate(all="ignore"):
        x, y, z = points[:, 0], points[:, 1], points[:, 2]
        if isinstance(lens, KannalaBrandt):
            across = np.hypot(x, y)
            theta = np.arctan2(across, z)
            share = np.where(across > 0.0, radial.value(theta) / across, 0.0)
            plane = np.stack([share * x, share * y], axis=-1)
            inside = (theta < radial.limit) & ((across > 0.0) | (z > 0.0))
        else:
            x, y = x / z, y / z
            plane = np.stack(_brown_conrady(lens, x, y), axis=-1)
            inside = (z > 0.0) & _is_in_front_of_the_fold(lens, radial, x, y)
        return np.where(inside[:, None], plane, np.nan)


def _brown_conrady(lens: BrownConrady, x: Doubles, y: Doubles) -> tuple[Doubles, Doubles]:
    """Return OpenCV's x'' and y''."""
    s = x * x + y * y
    stretch = _horner((1.0, lens.k1, lens.k2, lens.k3), s) / _horner((1.0, lens.k4, lens.k5, lens.k6), s)
    along = x * stretch + 2.0 * lens.p1 * x * y + lens.p2 * (s + 2.0 * x * x)
    return along, y * stretch + lens.p1 * (s + 2.0 * y * y) + 2.0 * lens.p2 * x * y


def _jacobian(lens: BrownConrady, x: Doubles, y: Doubles) -> tuple[Doubles, Doubles, Doubles]:
    """Return dx'' / dx, dx'' / dy = dy'' / dx, dy'' / dy."""
    s = x * x + y * y
    top, bottom = (1.0, lens.k1, lens.k2, lens.k3), (1.0, lens.k4, lens.k5, lens.k6)
    n, d = _horner(top, s), _horner(bottom, s)
    growth = 2.0 * (_horner(_derived(top), s) * d - n * _horner(_derived(bottom), s)) / (d * d)
    across = x * y * growth + 2.0 * (lens.p1 * x + lens.p2 * y)
    along_x = n / d + x * x * growth + 2.0 * lens.p1 * y + 6.0 * lens.p2 * x
    return along_x, across, n / d + y * y * growth + 6.0 * lens.p1 * y + 2.0 * lens.p2 * x


def least_scale(lens: BrownConrady | KannalaBrandt, points: Doubles) -> Doubles:
    """Return how far the image of points (n, 3) in optical axes moves per metre that they move across the line of
    sight, in units of the image plane and in the direction that moves it least, (n,); NaN: not imaged."""
    radial, distance = radial_of(lens), np.linalg.norm(points, axis=1)
    is_imaged = np.isfinite(distorted(lens, points)[:, 0])
    with np.errstate(all="ignore"):
        x, y, z = points.T
        if isinstance(lens, KannalaBrandt):
            across = np.hypot(x, y)
            theta = np.arctan2(across, z)
            around = np.where(across > 0.0, radial.value(theta) / across, 1.0 / distance)
            least = np.minimum(around, radial.slope(theta) / distance)
        else:
            x, y = x / z, y / z
            length = np.hypot(x, y)
            out_x, out_y = np.where(length > 0.0, (x, y) / length, np.array([[1.0], [0.0]]))
            xx, xy, yy = _jacobian(lens, x, y)
            steep = distance / z  # a step along the radius moves the point of the plane so much farther
            along = np.stack([xx * out_x + xy * out_y, xy * out_x + yy * out_y]) * steep
            around_x, around_y = xy * out_x - xx * out_y, yy * out_x - xy * out_y
            squares = (along * along).sum(axis=0) + around_x**2 + around_y**2
            area = np.abs(along[0] * around_y - along[1] * around_x)
            most = np.sqrt((squares + np.sqrt(np.maximum(squares**2 - 4.0 * area**2, 0.0))) / 2.0)
            least = area / most / z
    return np.where(is_imaged, least, np.nan)


def _is_in_front_of_the_fold(lens: BrownConrady, radial: Radial, x: Doubles, y: Doubles) -> NDArray[np.bool_]:
    """Return whether the image grows outwards up to there, and is not turned over by the tangential terms."""
    xx, xy, yy = _jacobian(lens, x, y)
    return (np.hypot(x, y) < radial.limit) & (xx * yy - xy * xy > 0.0)


def _without_tangential(lens: BrownConrady, at_x: Doubles, at_y: Doubles, x: Doubles, y: Doubles) -> Doubles:
    """Return the points (n, 2) that map to (at_x, at_y), from a first guess (x, y); NaN for missing ones.

    Newton in two dimensions; a step that leads farther away is halved.
    """
    found = np.stack([x, y], axis=-1)
    best = _miss(lens, found, at_x, at_y)
    share = np.ones_like(best)
    rounding = _ROUNDING * np.hypot(at_x, at_y)
    todo = np.flatnonzero(np.isfinite(best) & (best > rounding))
    for _ in range(_STEPS):
        if not todo.size:
            break
        trial = found[todo] + share[todo, None] * _newton_step(lens, found[todo], at_x[todo], at_y[todo])
        miss = _miss(lens, trial, at_x[todo], at_y[todo])
        closer = miss < best[todo]
        found[todo] = np.where(closer[:, None], trial, found[todo])
        best[todo] = np.where(closer, miss, best[todo])
        share[todo] = np.where(closer, 1.0, 0.5 * share[todo])
        todo = todo[(share[todo] > _SHORTEST_STEP) & (best[todo] > rounding[todo])]
    inside = _is_in_front_of_the_fold(lens, radial_of(lens), found[:, 0], found[:, 1])
    return np.where((inside & (best <= _REACHED * (1.0 + np.hypot(at_x, at_y))))[:, None], found, np.nan)


def _miss(lens: BrownConrady, points: Doubles, at_x: Doubles, at_y: Doubles) -> Doubles:
    x, y = _brown_conrady(lens, points[:, 0], points[:, 1])
    return np.asarray(np.hypot(x - at_x, y - at_y))


def _newton_step(lens: BrownConrady, points: Doubles, at_x: Doubles, at_y: Doubles) -> Doubles:
    x, y = _brown_conrady(lens, points[:, 0], points[:, 1])
    xx, xy, yy = _jacobian(lens, points[:, 0], points[:, 1])
    x, y, area = at_x - x, at_y - y, xx * yy - xy * xy
    return np.stack([(yy * x - xy * y) / area, (xx * y - xy * x) / area], axis=-1)


def _turning_point(numerator: tuple[float, ...], denominator: tuple[float, ...]) -> float:
    """Return the first t > 0 at which t N(t^2) / D(t^2) stops growing or is undefined; infinite when it always
    grows."""
    n, d = (np.where(np.abs(part) < _NOTHING, 0.0, part) for part in (numerator, denominator))
    s = np.array([0.0, 2.0])
    from numpy.polynomial import polynomial as poly  # late: a window with pinholes opens without it

    times, plus = poly.polymul, poly.polyadd
    slope: Doubles = plus(times(plus(n, times(s, poly.polyder(n))), d), times(times(s, n), -poly.polyder(d)))
    roots = np.concatenate([poly.polyroots(np.trim_zeros(part, "b")) for part in (slope, d)])
    real = roots.real[(np.abs(roots.imag) <= 1e-9 * np.abs(roots)) & (roots.real > 0.0)]
    return float(np.sqrt(real.min())) if real.size else math.inf


def _horner(coefficients: tuple[float, ...], s: Doubles) -> Doubles:
    total = np.full_like(s, coefficients[-1])
    for coefficient in coefficients[-2::-1]:
        total = total * s + coefficient
    return total


def _derived(coefficients: tuple[float, ...]) -> tuple[float, ...]:
    return tuple(power * c for power, c in enumerate(coefficients))[1:] or (0.0,)
