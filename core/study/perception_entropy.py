"""Perception entropy of Ma, Liu and Li (arXiv 2104.06615, 2021), for comparison with our figures.

What one sensor measures of an object has a standard deviation of 1 / AP - 1 with AP = a ln m + b of m points or pixels;
what several measure is fused by the inverse of their variances. Their constants, of a PointPillars and a monocular
detector. We read the fused deviation as average precision again, 1 / (1 + deviation): in the order of the entropy of
an object, and on the scale of the figures that it stands beside.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from riglens.core.targets.counts import ObjectCounts

Doubles = NDArray[np.float64]

OF_POINTS = (0.152, 0.659)
OF_PIXELS = (0.055, 0.155)
"""a and b."""
_LEAST, _MOST = 1e-3, 1.0 - 1e-3


def fused_precision(objects: ObjectCounts) -> Doubles:
    """Return the average precision that the points of all LiDARs and the pixels of all cameras give each object, (k,);
    0 without any."""
    weights = _weight(objects.all_points, OF_POINTS) + _weight(objects.pixels.sum(axis=1), OF_PIXELS)
    with np.errstate(divide="ignore"):
        return np.asarray(1.0 / (1.0 + 1.0 / np.sqrt(weights)))


def _weight(count: NDArray[np.number], constants: tuple[float, float]) -> Doubles:
    """Return the inverse of the variance (k,) by counts (k,); 0 without any."""
    a, b = constants
    precision = np.clip(a * np.log(np.maximum(count, 1)) + b, _LEAST, _MOST)
    return np.where(count > 0, (precision / (1.0 - precision)) ** 2, 0.0)
