"""A rig that makes the engine compile every kernel, or load it from disk, before times are taken."""

from __future__ import annotations

from riglens.core.engine.engine import Engine
from riglens.core.metric.entropy import EntropyField
from riglens.core.metric.scores import MetricSettings
from riglens.core.rig.model import Camera, Lidar, Rig

WARM_UP = Rig(
    sensors=(
        Lidar(name="lidar", position=(0.0, 0.0, 2.0), elevations_deg=(0.0,), azimuths_deg=(0.0,)),
        Lidar(
            name="close",
            position=(0.0, 0.0, 2.0),
            rpy_deg=(0.0, 5.0, 0.0),
            elevations_deg=(0.0,),
            azimuths_deg=(0.0, 0.1),
        ),
        Camera(name="camera", position=(0.0, 0.0, 2.0), hfov_deg=90.0, cast=(1, 1)),
        Camera(
            name="tilted", position=(0.0, 0.0, 2.0), rpy_deg=(0.0, 5.0, 0.0), hfov_deg=90.0, cast=(64, 64)
        ),
    )
)
"""Few rays: upright sensors, a tilted LiDAR whose rays are close, and a tilted camera dense enough for voxel walking
and too sparse for it alone."""

ON_THE_CAR = Rig(
    sensors=(
        Lidar(name="lidar", position=(0.0, 0.0, 1.7), elevations_deg=(-60.0, 0.0), azimuths_deg=(0.0,)),
        Camera(
            name="camera", position=(0.0, 0.0, 1.7), rpy_deg=(0.0, 40.0, 0.0), hfov_deg=90.0, cast=(64, 64)
        ),
    )
)
"""Sensors so close to the roof of the usual car that it stops some of their rays."""


def warm_up(field: EntropyField, threads: int | None = None) -> None:
    """Compile the kernels, or load them from disk, so that no answer's time includes it."""
    engine = Engine(field, threads, for_edits=False)
    engine.evaluate(WARM_UP, with_seen=False)
    engine.evaluate(ON_THE_CAR, MetricSettings(body="blocks"), with_seen=False)
