"""Lenses of other programs as a camera's lens: OpenCV's distortions, and the f-theta polynomials of DriveWorks."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from riglens.core.formats.report import Notes
from riglens.core.formats.source import Value
from riglens.core.rig.model import BrownConrady, KannalaBrandt

BROWN_CONRADY = ("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6")
KANNALA_BRANDT = ("k1", "k2", "k3", "k4")
_LIMIT = 1e9
_SAMPLES = 400
_POWERS = (1, 3, 5, 7, 9)


def brown_conrady(value: Value, coefficients: Sequence[float], name: str, notes: Notes) -> dict[str, Any]:
    """Return the field `distortion` of coefficients in OpenCV's order k1 k2 p1 p2 k3 ...; nothing when all are 0."""
    return _distortion(BrownConrady, BROWN_CONRADY, value, coefficients, name, notes)


def kannala_brandt(value: Value, coefficients: Sequence[float], name: str, notes: Notes) -> dict[str, Any]:
    """Return the field `distortion` of a fisheye's coefficients k1 k2 k3 k4; an equidistant lens when all are 0."""
    return _distortion(KannalaBrandt, KANNALA_BRANDT, value, coefficients, name, notes)


def _distortion(
    model: type[BrownConrady] | type[KannalaBrandt],
    names: Sequence[str],
    value: Value,
    coefficients: Sequence[float],
    name: str,
    notes: Notes,
) -> dict[str, Any]:
    if len(coefficients) > len(names) or any(abs(number) > _LIMIT for number in coefficients):
        value.refuse(f"at most {len(names)} coefficients within ±{_LIMIT:g}")
    if model is BrownConrady and not any(coefficients):
        return {}
    notes.read("lens distortion", name)
    return {"distortion": model.model_validate(dict(zip(names, coefficients, strict=False)))}


@dataclass(frozen=True)
class FTheta:
    """Principal point in pixels, coefficients lowest first; is_backward: from pixels to radians.

    stretch: pixels along u for one along v.
    """

    cx_px: float
    cy_px: float
    coefficients: Sequence[float]
    is_backward: bool
    stretch: float = 1.0

    def is_kannala_brandt(self) -> bool:
        """Return whether the polynomial leads from angles to pixels by odd powers, which a fisheye has as well."""
        parts = dict(enumerate(self.coefficients))
        odd_only = all(part == 0.0 for power, part in parts.items() if power not in _POWERS)
        return not self.is_backward and odd_only and 0.0 < parts.get(1, 0.0) <= _LIMIT

    def samples(self, image: tuple[int, int]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return angles in radians and distances in pixels of points between principal point and farthest corner."""
        far_x, far_y = (max(abs(c), abs(s - c)) for c, s in zip((self.cx_px, self.cy_px), image, strict=True))
        farthest_px = math.hypot(far_x / self.stretch, far_y)
        polynomial = np.polynomial.Polynomial(self.coefficients or (0.0,))
        with np.errstate(all="ignore"):
            if self.is_backward:
                distances = np.linspace(0.0, farthest_px, _SAMPLES)
                return np.asarray(polynomial(distances)), distances
            angles = np.linspace(0.0, math.pi, 4 * _SAMPLES)
            distances = np.asarray(polynomial(angles))
        reached = np.flatnonzero(distances > farthest_px)
        end = int(reached[0]) + 1 if reached.size else len(angles)
        return angles[:end], distances[:end]


def ftheta_fields(
    lens: FTheta, image: tuple[int, int], where: Value, name: str, notes: Notes
) -> dict[str, Any]:
    """Return image and lens of the Kannala-Brandt camera nearest to an f-theta lens; report the difference."""
    if lens.is_kannala_brandt():
        parts = [*lens.coefficients, *([0.0] * len(_POWERS) * 2)]
        focal_px, *rest = (parts[power] for power in _POWERS)
        notes.converted("f-theta polynomial of odd powers: a Kannala-Brandt lens", name)
    else:
        focal_px, rest, off_px = _nearest_kannala_brandt(lens, image, where)
        notes.approximated("f-theta polynomial as the nearest Kannala-Brandt lens", name)
        notes.converted(f"f-theta lens: at most {off_px:.2g} pixels off", name)
    if any(abs(number) > _LIMIT * focal_px for number in rest):
        where.refuse("an f-theta polynomial with a focal length", "another one")
    scaled = {key: number / focal_px for key, number in zip(KANNALA_BRANDT, rest, strict=True)}
    distortion = KannalaBrandt.model_validate(scaled)
    centre = {"cx": lens.cx_px, "cy": lens.cy_px}
    return {
        "image": image,
        "fx": focal_px * lens.stretch,
        "fy": focal_px,
        **centre,
        "distortion": distortion,
    }


def _rising(
    angles: NDArray[np.float64], distances: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the samples from the first on as long as both rise, up to 180 degrees: a lens may end inside its image."""
    with np.errstate(all="ignore"):
        rises = (np.diff(angles) > 0.0) & (np.diff(distances) > 0.0) & (angles[1:] <= math.pi)
    rises &= np.isfinite(angles[1:]) & np.isfinite(distances[1:])
    end = len(angles) if rises.all() else int(np.argmin(rises)) + 1
    return angles[:end], distances[:end]


def _nearest_kannala_brandt(
    lens: FTheta, image: tuple[int, int], where: Value
) -> tuple[float, list[float], float]:
    """Return the focal length in pixels, the coefficients of the higher powers, and the error in pixels."""
    angles, distances = _rising(*lens.samples(image))
    nearest_edge_px = min(lens.cx_px, image[0] - lens.cx_px, lens.cy_px, image[1] - lens.cy_px)
    if len(angles) < len(_POWERS) or not distances[-1] >= min(nearest_edge_px, image[0]) / 2.0:
        where.refuse("an f-theta polynomial that rises over the image, to 180 degrees at most", "another one")
    columns = np.stack([angles**power for power in _POWERS], axis=1)
    found, *_ = np.linalg.lstsq(columns, distances, rcond=None)
    focal_px, *rest = (float(number) for number in found)
    if not focal_px > 0.0:
        where.refuse("an f-theta polynomial with a focal length", "another one")
    return focal_px, rest, float(np.abs(columns @ found - distances).max())
