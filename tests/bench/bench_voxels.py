"""Voxel scaling: how much longer an edit takes on a grid with 64 times the voxels."""

from __future__ import annotations

import pytest

from tests.bench.race import Goal, Race
from tests.bench.scenes import Scene, Scenes, moved, names_of, wide_trapezoid

GOAL = 20.0


@pytest.mark.parametrize("kind", ["camera", "lidar"])
def test_more_voxels(race: Race, scenes: Scenes, kind: str) -> None:
    coarse, fine = scenes.at(0.20), scenes.at(0.05)
    rig = wide_trapezoid()
    names = names_of(rig, kind)
    engines = {scene.edge: scene.engine() for scene in (coarse, fine)}
    for engine in engines.values():
        engine.evaluate(rig)

    def edit(scene: Scene, number: int) -> None:
        name = names[number % len(names)]
        engines[scene.edge].evaluate(rig.with_sensor(name, moved(rig.sensor(name), number)), with_seen=False)

    goal = Goal("δ scaling", f"one {kind} of W+T moved, {coarse.edge} to {fine.edge}", GOAL, "lower")
    numbers = iter(range(1, 1000))
    race.run(goal, numbers, lambda n: edit(fine, n), lambda n: edit(coarse, n))
