"""Engines beside each other share what they have counted of a sensor, and nothing else."""

import numpy as np
import pytest

from riglens.core.errors import never_stale
from riglens.core.in_threads import in_threads
from riglens.core.rig.presets import preset
from riglens.core.targets.contribution import TargetCaster
from riglens.core.targets.engine import TargetEngine
from riglens.core.targets.settings import EXACT
from tests.core.targets.cases import random_rig, random_traffic
from tests.core.targets.test_target_engine import same


@pytest.fixture
def casts(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Frames that sensors were cast into, a number for each time."""
    made, cast = list[int](), TargetCaster.cast

    def noted(self, sensor, settings, barrier, frames, is_stale):
        made.append(frames[1] - frames[0])
        return cast(self, sensor, settings, barrier, frames, is_stale)

    monkeypatch.setattr(TargetCaster, "cast", noted)
    return made


def test_a_sensor_of_both_rigs_is_cast_once_into_each_frame(casts):
    rng = np.random.default_rng(3)
    world, rig = random_traffic(rng, 20), random_rig(rng, 4)
    moved = rig.sensors[0].replace(position=(1.5, 0.5, 1.8), enabled=True)
    other, sensors = rig.with_sensor(moved.name, moved), sum(sensor.enabled for sensor in rig.sensors)
    engine = TargetEngine(world, threads=1)
    beside = engine.beside()
    few, of_other, whole = engine.evaluate(rig, frames=5), beside.evaluate(other), engine.evaluate(rig)
    assert sorted(casts) == sorted([5] * sensors + [20] + [15] * sensors)
    for found, one, frames in ((few, rig, 5), (of_other, other, None), (whole, rig, None)):
        assert same(found, TargetEngine(world, threads=1).evaluate(one, frames=frames))


def test_what_no_engine_holds_is_forgotten(casts):
    rng = np.random.default_rng(4)
    world, rig = random_traffic(rng, 5), random_rig(rng, 2)
    engine = TargetEngine(world, threads=1)
    engine.beside().evaluate(rig)
    casts.clear()
    engine.evaluate(rig)
    assert casts


def test_engines_that_take_turns_count_as_alone():
    rng = np.random.default_rng(5)
    world = random_traffic(rng, 12)
    rigs = [random_rig(rng, 4), random_rig(rng, 3)]
    engine = TargetEngine(world, threads=1)
    engines = [engine, engine.beside()]
    for step in range(16):
        turn = step // 2 % 2
        rig = rigs[turn]
        sensor = rig.sensors[step % len(rig.sensors)]
        moved = sensor.replace(position=(0.1 * step, 0.5, 1.8), enabled=True)
        rig = rigs[turn] = rig.with_sensor(sensor.name, moved)
        frames = 12 if step % 3 else 5
        found = engines[turn].evaluate(rig, frames=frames)
        assert same(found, TargetEngine(world, threads=1).evaluate(rig, frames=frames))


def test_an_engine_of_one_thread_beside_one_of_several_counts_as_alone():
    rng = np.random.default_rng(3)  # LiDARs
    world, rig = random_traffic(rng, 12), random_rig(rng, 4)
    engine = TargetEngine(world, threads=2)
    for sensor in rig.sensors:
        here, there = (
            rig.with_sensor(sensor.name, sensor.replace(position=(x, 0.5, 1.8), enabled=True))
            for x in (0.5, 1.5)
        )
        engine.evaluate(here)
        found = engine.beside(threads=1).evaluate(there)
        assert same(found, TargetEngine(world, threads=1).evaluate(there))


def test_a_caster_called_by_several_threads_at_a_time_counts_as_alone():
    caster = TargetCaster(random_traffic(np.random.default_rng(6), 300))
    (dense,) = (sensor for sensor in preset("nuScenes car").sensors if sensor.kind == "lidar")

    def found(share: int) -> np.ndarray:
        moved = dense.replace(position=(0.0, 0.0, 1.8 + 0.05 * share))
        return caster.cast(moved, EXACT, None, (0, 300), never_stale).found

    alone = [found(share) for share in range(4)]
    for mine, its in zip(alone, in_threads(4, found), strict=True):
        np.testing.assert_array_equal(mine, its)
