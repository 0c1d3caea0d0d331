"""Inspect the state of an engine, read only: the sensors that cover a voxel, and the number that cover each.

Call it on the engine's thread, after an evaluation and before the next.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from riglens.core.engine.engine import Engine
from riglens.core.kernels.review.overlap import covered_levels
from riglens.core.metric.scores import Method
from riglens.core.metric.voxel import Voxel, word_and_bit
from riglens.core.rig.model import Rig, Sensor

MOST_COUNTED = 3


def sees_voxel(engine: Engine, sensor: Sensor, method: Method, voxel: Voxel) -> bool | None:
    """Return whether a sensor covers a voxel; None when the voxel is not informative or the sensor is not held."""
    index = engine.field.index
    word, bit = word_and_bit(index.grid, voxel)
    words = engine.marks_of(sensor, method)
    if words is None or not int(index.words[word]) & bit:
        return None
    return bool(int(words[word]) & bit)


def covered_at_least(engine: Engine, rig: Rig, method: Method) -> NDArray[np.uint64]:
    """Return the informative voxels that at least 1, 2, 3 enabled sensors of the rig cover, (3, words)."""
    sensors = [sensor for sensor in rig.sensors if sensor.enabled]
    stack, slots = engine.stack_of(sensors, method)
    keep = engine.field.index.words
    levels = np.empty((MOST_COUNTED, keep.size), np.uint64)
    covered_levels(stack, slots, keep, engine.workers, levels)
    return levels
