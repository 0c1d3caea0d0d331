"""Edit: new exact scores after a sensor of W+T moved, against plain DDA; the same one as in a drag, or each in turn."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import count

import pytest

from riglens.core.rig.model import Rig
from tests.bench.race import Goal, Race
from tests.bench.scenes import (
    Scenes,
    competent_edit,
    dense_rays,
    moved,
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
FEW, MANY, MANY_GOAL = 4, 60, 1.2


Work = tuple[str, str, str]
WORKS: list[Work] = [
    (kind, pose, mover)
    for kind in ("lidar", "camera")
    for pose in ("upright", "tilted")
    for mover in ("dragged", "in turn")
]
"""Kind, pose, and whether the same sensor moves each time."""


def at_work(work: Work) -> tuple[Rig, list[str], str]:
    """The rig, the names of those who move, and what is done in words."""
    kind, pose, mover = work
    rig = wide_trapezoid(tilted) if pose == "tilted" else wide_trapezoid()
    names = names_of(rig, kind)
    done = f"one {kind} of W+T dragged" if mover == "dragged" else f"{kind}s of W+T moved in turn"
    return rig, names[:1] if mover == "dragged" else names, done + ", tilted" * (pose == "tilted")


@pytest.mark.parametrize("work", WORKS, ids="-".join)
@pytest.mark.parametrize("voxel_m", [0.10, 0.05])
def test_edit(race: Race, scenes: Scenes, voxel_m: float, work: Work) -> None:
    scene = scenes.at(voxel_m)
    rig, names, done = at_work(work)
    require_same_answer(scene, rig.sensor(names[0]))
    engine = scene.engine()
    engine.evaluate(rig)
    goal = Goal("edit", f"{done}, {scene.edge}", EDIT_GOAL)
    race.run(
        goal,
        moves(scene, rig, names),
        lambda m: engine.evaluate(m.rig, with_seen=False),
        lambda m: plain_edit(scene, m),
    )


@pytest.mark.parametrize("work", WORKS, ids="-".join)
@pytest.mark.parametrize("voxel_m", [0.10, 0.05])
def test_edit_on_one_thread(race: Race, scenes: Scenes, voxel_m: float, work: Work) -> None:
    scene = scenes.at(voxel_m)
    rig, names, done = at_work(work)
    engine = scene.engine(1)
    engine.evaluate(rig)
    race.run(
        Goal("edit, competent", f"{done}, one thread, {scene.edge}", COMPETENT_GOALS[work[:2]]),
        moves(scene, rig, names),
        lambda m: engine.evaluate(m.rig, with_seen=False),
        lambda m: competent_edit(scene, m),
    )


def lidars_spread(number: int) -> Rig:
    """The LiDARs of W+T, again and again, each at a place of its own within decimetres, until there are that many."""
    rig = wide_trapezoid()
    lidars = [rig.sensor(name) for name in names_of(rig, "lidar")]
    copies = (moved(lidars[i % len(lidars)], i) for i in range(number))
    return Rig(sensors=tuple(copy.model_copy(update={"name": f"lidar {i}"}) for i, copy in enumerate(copies)))


def steps(rigs: Sequence[Rig], movers: int) -> Iterator[tuple[Rig, ...]]:
    """The rigs with one sensor moved, the same one in each, then the next one of so many, without end."""
    for number in count(1):
        name = f"lidar {number % movers}"
        rigs = [rig.with_sensor(name, moved(rigs[0].sensor(name), number)) for rig in rigs]
        yield tuple(rigs)


@pytest.mark.parametrize("mover", ["the same", "another"])
@pytest.mark.parametrize("voxel_m", [0.10, 0.05])
def test_many_sensors(race: Race, scenes: Scenes, voxel_m: float, mover: str) -> None:
    scene, rigs = scenes.at(voxel_m), [lidars_spread(number) for number in (FEW, MANY)]
    engines = [scene.engine(1) for _ in rigs]
    for engine, rig in zip(engines, rigs, strict=True):
        engine.evaluate(rig)
    work = f"{mover} lidar moved each time, one of {FEW} and of {MANY}, one thread, {scene.edge}"
    race.run(
        Goal("edit, sensors", work, MANY_GOAL, "lower"),
        steps(rigs, 1 if mover == "the same" else FEW),
        lambda each: engines[1].evaluate(each[1], with_seen=False),
        lambda each: engines[0].evaluate(each[0], with_seen=False),
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
