"""Edit: new exact scores after one sensor of W+T moved, against plain DDA; upright and tilted."""

from __future__ import annotations

import pytest

from tests.bench.race import Goal, Race
from tests.bench.scenes import (
    Scenes,
    competent_edit,
    dense_rays,
    moves,
    names_of,
    plain_edit,
    require_same_answer,
    tilted,
    wide_trapezoid,
)

EDIT_GOAL = 10.0
COMPETENT_GOALS = {
    ("lidar", "upright"): 3.0,
    ("lidar", "tilted"): 1.5,
    ("camera", "upright"): 3.0,
    ("camera", "tilted"): 2.0,
}
NATIVE_GOALS = {0.10: 60.0, 0.05: 20.0}


@pytest.mark.parametrize("pose", ["upright", "tilted"])
@pytest.mark.parametrize("kind", ["lidar", "camera"])
@pytest.mark.parametrize("voxel_m", [0.10, 0.05])
def test_edit(race: Race, scenes: Scenes, voxel_m: float, kind: str, pose: str) -> None:
    scene = scenes.at(voxel_m)
    rig = wide_trapezoid(tilted) if pose == "tilted" else wide_trapezoid()
    names = names_of(rig, kind)
    require_same_answer(scene, rig.sensor(names[0]))
    engine = scene.engine()
    engine.evaluate(rig)
    note = ", tilted" if pose == "tilted" else ""
    goal = Goal("edit", f"one {kind} of W+T moved{note}, {scene.edge}", EDIT_GOAL)
    race.run(
        goal,
        moves(scene, rig, names),
        lambda m: engine.evaluate(m.rig, with_seen=False),
        lambda m: plain_edit(scene, m),
    )


@pytest.mark.parametrize("pose", ["upright", "tilted"])
@pytest.mark.parametrize("kind", ["lidar", "camera"])
@pytest.mark.parametrize("voxel_m", [0.10, 0.05])
def test_edit_on_one_thread(race: Race, scenes: Scenes, voxel_m: float, kind: str, pose: str) -> None:
    scene = scenes.at(voxel_m)
    rig = wide_trapezoid(tilted) if pose == "tilted" else wide_trapezoid()
    engine = scene.engine(1)
    engine.evaluate(rig)
    note = ", tilted" if pose == "tilted" else ""
    work = f"one {kind} of W+T moved{note}, one thread, {scene.edge}"
    race.run(
        Goal("edit, competent", work, COMPETENT_GOALS[kind, pose]),
        moves(scene, rig, names_of(rig, kind)),
        lambda m: engine.evaluate(m.rig, with_seen=False),
        lambda m: competent_edit(scene, m),
    )


@pytest.mark.parametrize("pose", ["upright", "tilted"])
@pytest.mark.parametrize("voxel_m", [0.10, 0.05])
def test_native_camera(race: Race, scenes: Scenes, voxel_m: float, pose: str) -> None:
    scene = scenes.at(voxel_m)
    rig = wide_trapezoid(tilted) if pose == "tilted" else wide_trapezoid()
    name = names_of(rig, "camera")[0]
    rig = rig.with_sensor(name, dense_rays(rig.sensor(name)))
    engine = scene.engine()
    engine.evaluate(rig)
    note = ", tilted" if pose == "tilted" else ""
    goal = Goal(
        "native camera",
        f"{name} of W+T with 1600 x 900 rays moved{note}, {scene.edge}",
        NATIVE_GOALS[voxel_m],
    )
    race.run(
        goal,
        moves(scene, rig, [name]),
        lambda m: engine.evaluate(m.rig, with_seen=False),
        lambda m: plain_edit(scene, m),
        rounds=7,
    )
