"""What an engine holds, read only: which sensors cover a voxel, and how many cover each.

Call it on the engine's thread, after an evaluation and before the next.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from riglens.core.engine.engine import Engine
from riglens.core.metric.scores import Method
from riglens.core.metric.voxel import Voxel, word_and_bit
from riglens.core.rig.model import Rig, Sensor

MOST_COUNTED = 3


def sees_voxel(engine: Engine, sensor: Sensor, method: Method, voxel: Voxel) -> bool | None:
    """Whether a sensor covers a voxel; None when the voxel is not informative or the sensor is not held."""
    index = engine.field.index
    word, bit = word_and_bit(index.grid, voxel)
    words = engine.marks_of(sensor, method)
    if words is None or not int(index.words[word]) & bit:
        return None
    return bool(int(words[word]) & bit)


def covered_at_least(engine: Engine, rig: Rig, method: Method) -> NDArray[np.uint64]:
    """Informative voxels that at least 1, 2, 3 enabled sensors of the rig cover, (3, words)."""
    levels = np.zeros((MOST_COUNTED, engine.field.index.words.size), np.uint64)
    for sensor in rig.sensors:
        words = engine.marks_of(sensor, method) if sensor.enabled else None
        if words is None:
            continue
        for level in range(MOST_COUNTED - 1, 0, -1):
            levels[level] |= levels[level - 1] & words
        levels[0] |= words
    levels &= engine.field.index.words
    return levels
