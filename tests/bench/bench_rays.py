"""Ray scaling: how much longer an edit takes when the sensor casts many times as many rays."""

from __future__ import annotations

import pytest

from riglens.core.rig.model import Rig
from tests.bench.race import Goal, Race
from tests.bench.scenes import Scenes, dense_rays, moved, names_of, wide_trapezoid

GOALS = {"camera": 2.0, "lidar": 8.0}
RAYS = {"camera": "352 x 128 to 1600 x 900", "lidar": "16 x 360 to 128 x 3600"}


@pytest.mark.parametrize("kind", ["camera", "lidar"])
@pytest.mark.parametrize("voxel_m", [0.10, 0.05])
def test_more_rays(race: Race, scenes: Scenes, voxel_m: float, kind: str) -> None:
    scene = scenes.at(voxel_m)
    few = wide_trapezoid()
    name = names_of(few, kind)[0]
    many = few.with_sensor(name, dense_rays(few.sensor(name)))
    engines = {"few": scene.engine(), "many": scene.engine()}
    engines["few"].evaluate(few)
    engines["many"].evaluate(many)

    def edit(which: str, rig: Rig, number: int) -> None:
        engines[which].evaluate(rig.with_sensor(name, moved(rig.sensor(name), number)), with_seen=False)

    goal = Goal("ray scaling", f"{name} moved, {RAYS[kind]} rays, {scene.edge}", GOALS[kind], "lower")
    numbers = iter(range(1, 1000))
    race.run(goal, numbers, lambda n: edit("many", many, n), lambda n: edit("few", few, n))
