"""What an engine holds, read only: which sensors cover a voxel, and how many cover each.

The one place outside the engine that knows how it keeps its marks. Call it on the engine's thread, after an
evaluation and before the next.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from core.engine.engine import Engine, Sensor, _cast_shape
from core.metric.scores import Method
from core.rig.model import Rig
from core.scene.columns import Words
from core.scene.voxel import Voxel, word_and_bit

MOST_COUNTED = 3


def covered_by(engine: Engine, sensor: Sensor, method: Method) -> Words | None:
    """The voxels that a sensor of the rig evaluated last traverses, all that are informative and maybe others; None
    when it is not held. A view of the engine's own words: read it at once, never write, never keep it."""
    shape = _cast_shape(sensor, method)
    held = next((held for held in engine._state.held if held.shape == shape), None)
    return engine._state.stack[held.slot] if held is not None else None


def sees_voxel(engine: Engine, sensor: Sensor, method: Method, voxel: Voxel) -> bool | None:
    """Whether a sensor covers a voxel; None when the voxel is not informative or the sensor is not held."""
    index = engine._field.index
    word, bit = word_and_bit(index.grid, voxel)
    words = covered_by(engine, sensor, method)
    if words is None or not int(index.words[word]) & bit:
        return None
    return bool(int(words[word]) & bit)


def covered_at_least(engine: Engine, rig: Rig, method: Method) -> NDArray[np.uint64]:
    """Informative voxels that at least 1, 2, 3 enabled sensors of the rig cover, (3, words)."""
    levels = np.zeros((MOST_COUNTED, engine._field.index.words.size), np.uint64)
    for sensor in rig.sensors:
        words = covered_by(engine, sensor, method) if sensor.enabled else None
        if words is None:
            continue
        for level in range(MOST_COUNTED - 1, 0, -1):
            levels[level] |= levels[level - 1] & words
        levels[0] |= words
    levels &= engine._field.index.words
    return levels
