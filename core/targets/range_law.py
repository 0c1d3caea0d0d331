"""Model the range of a LiDAR: which of its rays return from a surface.

A diffuse surface of reflectivity rho that faces the sensor is seen up to R(rho) = R_ref sqrt(rho / rho_ref), because
the returned power falls with the square of the distance; a surface turned away by an angle returns the cosine of it.
A ray returns with a probability that falls around R like a logistic.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from riglens.core.errors import InputError
from riglens.core.rig.library import Entry, default_library
from riglens.core.rig.model import Sensor
from riglens.core.sensors.registry import kind_of
from riglens.core.targets.beams import OPAQUE
from riglens.core.targets.settings import TargetSettings
from riglens.core.targets.shapes import GLASS_PASSES, GLASS_RETURNS, REFLECTIVITY, WIDTH

EDGE = 0.08
"""Relative width of the logistic by which returns of one target fall around their range: Ouster states for the OS1 of
REV6 100 m with 90 % and 120 m with 50 % at a reflectivity of 80 %, 45 m and 55 m at 10 %, hence 0.076 and 0.083."""
NOMINAL_REFLECTIVITY = 0.8
"""Reflectivity to which the maximum range of a sensor refers where its maker states none: our choice."""
_NONE = np.zeros(0)


def law_of(sensor: Sensor, settings: TargetSettings) -> NDArray[np.float64]:
    """Return R for the three classes in metres and the relative width, (4,), for the kernels; (0,) where all rays
    return: without the law, for cameras, and for a LiDAR that states no range."""
    if not settings.range_law or not kind_of(sensor).has_range_law:
        return _NONE
    anchors = anchors_of(sensor)
    if not anchors:
        return _NONE
    return np.array([*(range_for(rho, anchors) for rho in REFLECTIVITY), WIDTH])


def glass_of(sensor: Sensor, settings: TargetSettings) -> NDArray[np.float64]:
    """Return up to which draw a ray passes through glass and from which on it returns, (2,), for the kernels; without
    the law, and for cameras, glass stops all rays."""
    if not settings.range_law or not kind_of(sensor).has_range_law:
        return OPAQUE
    return np.array([GLASS_PASSES, 1.0 - GLASS_RETURNS])


def anchors_of(sensor: Sensor) -> tuple[tuple[float, float], ...]:
    """Return pairs of reflectivity and range in metres, at which half of the rays return: those of its model, else its
    maximum range at 80 %, unless that is infinite."""
    try:
        stated = _half_way(default_library().entry(sensor.model)) if sensor.model is not None else ()
    except InputError:
        stated = ()
    if stated or math.isinf(sensor.range_m[1]):
        return stated
    return ((NOMINAL_REFLECTIVITY, sensor.range_m[1]),)


def _half_way(entry: Entry) -> tuple[tuple[float, float], ...]:
    """Return the ranges that a model states, as those at which half of the rays return."""
    probability = entry.range_probability or 0.5
    share = 1.0 - EDGE * math.log(probability / (1.0 - probability))
    return tuple((reflectivity, metres / share) for reflectivity, metres in entry.range_anchors())


def range_for(reflectivity: float, anchors: tuple[tuple[float, float], ...]) -> float:
    """Return R in metres from the anchor whose reflectivity is nearest by ratio."""
    share, metres = min(anchors, key=lambda anchor: abs(math.log(anchor[0] / reflectivity)))
    return metres * math.sqrt(reflectivity / share)
