"""What can be read from an engine is what its sensors cover, each taken alone."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from riglens.core.engine.engine import Engine
from riglens.core.engine.inspect import covered_at_least, sees_voxel
from riglens.core.metric.scores import PAPER_SETTINGS
from riglens.core.scene.columns import unpack
from tests.core.builders import grid_of, random_field, random_sensor, rig_of, seen_by, spinning

GRID = grid_of(9, 8, 70, 0.5)


@settings(max_examples=8)
@given(seed=st.integers(0, 2**32 - 1))
def test_each_sensor_is_known_to_see_what_it_sees_alone(seed: int) -> None:
    rng = np.random.default_rng(seed)
    field = random_field(GRID, rng)
    rig = rig_of(*(random_sensor(GRID, rng) for _ in range(4)))
    engine = Engine(field)
    engine.evaluate(rig)
    informative = unpack(GRID, field.index.words)
    for sensor in rig.sensors:
        alone = seen_by(field, sensor)
        for voxel in rng.integers(0, GRID.shape, (60, 3)).tolist():
            expected = bool(alone[tuple(voxel)]) if informative[tuple(voxel)] else None
            assert sees_voxel(engine, sensor, "exact", tuple(voxel)) is expected


@settings(max_examples=8)
@given(seed=st.integers(0, 2**32 - 1), count=st.integers(0, 5))
def test_voxels_are_sorted_by_how_many_sensors_cover_them(seed: int, count: int) -> None:
    rng = np.random.default_rng(seed)
    field = random_field(GRID, rng)
    rig = rig_of(*(random_sensor(GRID, rng) for _ in range(count)))
    engine = Engine(field)
    engine.evaluate(rig)
    covers = sum((seen_by(field, sensor).astype(int) for sensor in rig.sensors), np.zeros(GRID.shape, int))
    for level, words in enumerate(covered_at_least(engine, rig, "exact"), start=1):
        assert np.array_equal(unpack(GRID, words), covers >= level)


def test_twins_count_twice_and_a_sensor_that_is_off_not_at_all() -> None:
    field = random_field(GRID, np.random.default_rng(1))
    twin = spinning((0.0, 0.0, 5.0))
    rig = rig_of(twin, twin, twin.replace(position=(1.0, 1.0, 5.0), enabled=False))
    engine = Engine(field)
    engine.evaluate(rig)
    once, twice, thrice = covered_at_least(engine, rig, "exact")
    assert once.any() and np.array_equal(once, twice) and not thrice.any()
    assert engine.marks_of(rig.sensors[2], "exact") is None
    assert engine.marks_of(twin, PAPER_SETTINGS.method) is not None
    assert engine.marks_of(twin, "bresenham") is None


def test_a_twin_that_is_off_is_not_counted_by_the_rays_of_the_other() -> None:
    field = random_field(GRID, np.random.default_rng(1))
    on = spinning((0.0, 0.0, 5.0))
    rig = rig_of(on, on.replace(enabled=False))
    engine = Engine(field)
    engine.evaluate(rig)
    once, twice, _ = covered_at_least(engine, rig, "exact")
    assert once.any() and not twice.any()


@pytest.mark.parametrize("edit", ["move", "remove"])
def test_after_an_edit_the_answer_is_that_of_the_new_rig(edit: str) -> None:
    rng = np.random.default_rng(4)
    field = random_field(GRID, rng)
    first, second = spinning((0.0, 0.0, 5.0)), spinning((1.0, 0.5, 9.0), beams=7)
    moved = [second.replace(position=(0.3, 1.0, 8.0))] if edit == "move" else []
    engine = Engine(field)
    engine.evaluate(rig_of(first, second))
    after = rig_of(first, *moved)
    engine.evaluate(after)
    fresh = Engine(field)
    fresh.evaluate(after)
    same = (covered_at_least(engine, after, "exact"), covered_at_least(fresh, after, "exact"))
    assert np.array_equal(*same)
