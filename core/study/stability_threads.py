"""Print a hash of everything that the engine says, once per number of threads named on the command line.

A process of its own, because the number of threads that may be started is fixed when Numba starts.
"""

from __future__ import annotations

import hashlib
import sys

import numpy as np

from riglens.core.engine.engine import Engine
from riglens.core.metric.scores import METHODS, READINGS, MetricSettings
from riglens.core.study.stability_edits import field_of, random_counts
from riglens.core.study.stability_methods import rig_of
from riglens.core.study.stability_sensors import OPEN_ROAD, camera, spinning


def digest(threads: int) -> str:
    """SHA-256 over scores and covered voxels of some rigs by all methods and readings."""
    field = field_of(OPEN_ROAD, random_counts(OPEN_ROAD, np.random.default_rng(1)))
    upright = (spinning((0.3, 0.2, 2.17)), camera((1.1, -0.6, 1.8), (0.0, 0.0, 40.0), (352, 128)))
    tilted = (spinning((-0.4, 0.6, 2.2), (16.0, 3.0, 0.0)), camera((0.0, 0.5, 1.8), (1.0, 9.0, 200.0)))
    engine, everything = Engine(field, threads), hashlib.sha256()
    for rig in (rig_of(upright), rig_of((*upright, *tilted)), rig_of(tilted)):
        for settings in (MetricSettings(method, reading) for method in METHODS for reading in READINGS):
            found = engine.evaluate(rig, settings)
            assert found is not None  # nothing abandons it
            if found.threads != threads:
                raise RuntimeError(f"{found.threads} threads used, {threads} asked for")
            everything.update(repr(found.scores).encode())
            everything.update(found.seen_camera.tobytes())
            everything.update(found.seen_lidar.tobytes())
    return everything.hexdigest()


if __name__ == "__main__":
    for count in sys.argv[1:]:
        print(digest(int(count)))
