"""Lenses of other programs as a camera's lens: OpenCV's distortions, and those that are fitted.

Fitted by the nearest Kannala-Brandt lens are the f-theta polynomials of DriveWorks, and models that project by way of
a unit sphere: unified (MEI of VINS, `omni` of Kalibr), extended unified (`eucm`) and double sphere (`ds`).
Source: Mei and Rives, ICRA 2007; Khomutenko et al., RA-L 2016; Usenko et al., The double sphere camera model, 3DV 2018.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from riglens.core.formats.report import Notes
from riglens.core.formats.source import MAX_PIXELS, Value
from riglens.core.rig.model import BrownConrady, KannalaBrandt
from riglens.core.rig.yaml.nodes import shortened

Doubles = NDArray[np.float64]
BROWN_CONRADY = ("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6")
KANNALA_BRANDT = ("k1", "k2", "k3", "k4")
_LIMIT = 1e9
_SAMPLES = 400
_POWERS = (1, 3, 5, 7, 9)


def pinhole(matrix: Doubles) -> dict[str, Any]:
    """Return focal lengths and principal point of a camera matrix, (3, 3) or more."""
    return {
        "fx": float(matrix[0, 0]),
        "fy": float(matrix[1, 1]),
        "cx": float(matrix[0, 2]),
        "cy": float(matrix[1, 2]),
    }


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
class RoundLens:
    """Lens that is round about its principal point (pixels), stretched by `stretch` pixels along u for one along v.

    `project`: from angles off the axis in radians to distances from the principal point in pixels along v, or
    backwards where `is_backward`.
    """

    cx_px: float
    cy_px: float
    stretch: float
    project: Callable[[Doubles], Doubles]
    is_backward: bool = False

    def farthest_px(self, image: tuple[int, int]) -> float:
        """Return how far the farthest corner of the image is from the principal point, in pixels along v."""
        centre = (self.cx_px, self.cy_px)
        far_x, far_y = (max(abs(c), abs(s - c)) for c, s in zip(centre, image, strict=True))
        return math.hypot(far_x / self.stretch, far_y)

    @np.errstate(all="ignore")
    def samples(self, image: tuple[int, int]) -> tuple[Doubles, Doubles]:
        """Return angles in radians and distances in pixels of points between principal point and farthest corner."""
        if self.is_backward:
            distances = np.linspace(0.0, self.farthest_px(image), _SAMPLES)
            return np.asarray(self.project(distances)), distances
        angles = np.linspace(0.0, math.pi, 4 * _SAMPLES)
        distances = np.asarray(self.project(angles))
        reached = np.flatnonzero(distances > self.farthest_px(image))
        end = int(reached[0]) + 1 if reached.size else len(angles)
        return angles[:end], distances[:end]


def ftheta_fields(
    lens: RoundLens,
    coefficients: Sequence[float],
    image: tuple[int, int],
    where: Value,
    name: str,
    notes: Notes,
) -> dict[str, Any]:
    """Return image and lens of the Kannala-Brandt camera nearest to an f-theta lens; report the difference.

    coefficients: of the polynomial that the lens projects by, lowest first.
    """
    parts = [*coefficients, *([0.0] * len(_POWERS) * 2)]
    is_odd = all(part == 0.0 for power, part in enumerate(parts) if power not in _POWERS)
    if not lens.is_backward and is_odd and 0.0 < parts[1] <= _LIMIT:
        focal_px, *rest = (parts[power] for power in _POWERS)
        notes.converted("f-theta polynomial of odd powers: a Kannala-Brandt lens", name)
    else:
        focal_px, rest, off_px = _nearest_kannala_brandt(lens, image, where)
        notes.approximated("f-theta polynomial as the nearest Kannala-Brandt lens", name)
        notes.converted(f"f-theta lens: at most {off_px:.2g} pixels off", name)
    return _fitted(lens, image, focal_px, rest, where)


def sphere_fields(
    model: str,
    numbers: Sequence[float],
    lens: tuple[float, float, float, float],
    bend: Sequence[float],
    image: tuple[int, int],
    where: Value,
    name: str,
    notes: Notes,
) -> dict[str, Any]:
    """Return image and lens of the Kannala-Brandt camera nearest to a lens by way of a sphere; report how far off.

    numbers: those of the model before fx, fy, cx, cy (`lens`, pixels); bend: k1 k2 p1 p2 on the plane, if any.
    """
    fx, fy, cx, cy = lens
    if not (0.0 < fx <= _LIMIT and 0.0 < fy <= _LIMIT):
        where.refuse("a lens with focal lengths in pixels", "another one")
    k1, k2, p1, p2 = (*bend, 0.0, 0.0, 0.0, 0.0)[:4]
    project = SPHERE_MODELS[model][1]

    def plane(angles: Doubles) -> Doubles:
        across = project(numbers, np.sin(angles), np.cos(angles))
        return fy * (across * (1.0 + k1 * across**2 + k2 * across**4))

    said = RoundLens(cx, cy, fx / fy, plane)
    focal_px, rest, off_px = _nearest_kannala_brandt(said, image, where)
    notes.approximated(
        f"lens of model '{model}' as the nearest Kannala-Brandt lens, at most {off_px:.2g} pixels off", name
    )
    if p1 or p2:
        aside_px = 3.0 * math.hypot(p1, p2) * said.farthest_px(image) ** 2 / fy
        notes.ignored(f"tangential distortion: at most {aside_px:.2g} pixels", name)
    return _fitted(said, image, focal_px, rest, where)


RADIAL_TANGENTIAL = ("radtan", "radial-tangential")
EQUIDISTANT = ("equidistant",)


def named_lens(
    model: str,
    intrinsics: Value,
    kind: str,
    coefficients: Value | None,
    image: tuple[int, int],
    name: str,
    notes: Notes,
) -> dict[str, Any]:
    """Return image and lens by the names of Kalibr and maplab: numbers of the model, fx, fy, cx, cy; a distortion.

    Of other models only focal lengths and centre are kept.
    """
    bend = [] if coefficients is None or kind == "none" else coefficients.numbers()
    if model in SPHERE_MODELS:
        count = SPHERE_MODELS[model][0]
        *numbers, fx, fy, cx, cy = intrinsics.numbers(count + 4)
        if bend and kind not in RADIAL_TANGENTIAL:
            notes.ignored(f"lens distortion of model '{shortened(kind, 20)}'", name)
            bend = []
        return sphere_fields(model, numbers, (fx, fy, cx, cy), bend, image, intrinsics, name, notes)
    fx, fy, cx, cy = intrinsics.numbers(4)
    lens = {"image": image, "fx": fx, "fy": fy, "cx": cx, "cy": cy}
    if model != "pinhole":
        notes.approximated(
            f"lens of model '{shortened(model, 20)}' as a pinhole with its focal lengths", name
        )
    if coefficients is None or kind == "none":
        return lens
    if model == "pinhole" and kind in RADIAL_TANGENTIAL:
        return lens | brown_conrady(coefficients, coefficients.numbers(4), name, notes)
    if model == "pinhole" and kind in EQUIDISTANT:
        return lens | kannala_brandt(coefficients, coefficients.numbers(4), name, notes)
    notes.ignored(f"lens distortion of model '{shortened(kind, 20)}'", name)
    return lens


def kalibr_lens(value: Value, coefficients: str, name: str, notes: Notes) -> dict[str, Any]:
    """Return image and lens from the fields of Kalibr; `coefficients` is the name of those of the distortion."""
    width, height = (side.whole(1, MAX_PIXELS) for side in value.item("resolution").elements(2))
    model, kind = (
        value.item(key, absent).text().lower()
        for key, absent in (("camera_model", "pinhole"), ("distortion_model", "none"))
    )
    bend = value.get(coefficients)
    return named_lens(model, value.item("intrinsics"), kind, bend, (width, height), name, notes)


def _unified(numbers: Sequence[float], across: Doubles, ahead: Doubles) -> Doubles:
    return across / (ahead + numbers[0])


def _extended(numbers: Sequence[float], across: Doubles, ahead: Doubles) -> Doubles:
    alpha, beta = numbers
    return across / (alpha * np.sqrt(beta * across**2 + ahead**2) + (1.0 - alpha) * ahead)


def _double(numbers: Sequence[float], across: Doubles, ahead: Doubles) -> Doubles:
    xi, alpha = numbers
    return across / (alpha * np.sqrt(across**2 + (xi + ahead) ** 2) + (1.0 - alpha) * (xi + ahead))


SPHERE_MODELS: dict[str, tuple[int, Callable[[Sequence[float], Doubles, Doubles], Doubles]]] = {
    "omni": (1, _unified),
    "mei": (1, _unified),
    "eucm": (2, _extended),
    "ds": (2, _double),
}
"""Number of parameters of each model, and the place on the plane of a direction (across, ahead)."""


def _fitted(
    lens: RoundLens, image: tuple[int, int], focal_px: float, rest: list[float], where: Value
) -> dict[str, Any]:
    """Return image and lens of a fitted camera."""
    if any(abs(number) > _LIMIT * focal_px for number in rest):
        where.refuse("a lens with a focal length", "another one")
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


def _rising(angles: Doubles, distances: Doubles) -> tuple[Doubles, Doubles]:
    """Return the samples from the first on as long as both rise, up to 180 degrees: a lens may end inside its image."""
    with np.errstate(all="ignore"):
        rises = (np.diff(angles) > 0.0) & (np.diff(distances) > 0.0) & (angles[1:] <= math.pi)
    rises &= np.isfinite(angles[1:]) & np.isfinite(distances[1:])
    end = len(angles) if rises.all() else int(np.argmin(rises)) + 1
    return angles[:end], distances[:end]


def _nearest_kannala_brandt(
    lens: RoundLens, image: tuple[int, int], where: Value
) -> tuple[float, list[float], float]:
    """Return the focal length in pixels, the coefficients of the higher powers, and the error in pixels."""
    angles, distances = _rising(*lens.samples(image))
    nearest_edge_px = min(lens.cx_px, image[0] - lens.cx_px, lens.cy_px, image[1] - lens.cy_px)
    if len(angles) < len(_POWERS) or not distances[-1] >= min(nearest_edge_px, image[0]) / 2.0:
        where.refuse("a lens whose image grows with the angle, to 180 degrees at most", "another one")
    columns = np.stack([angles**power for power in _POWERS], axis=1)
    found, *_ = np.linalg.lstsq(columns, distances, rcond=None)
    focal_px, *rest = (float(number) for number in found)
    if not focal_px > 0.0:
        where.refuse("a lens with a focal length", "another one")
    return focal_px, rest, float(np.abs(columns @ found - distances).max())
