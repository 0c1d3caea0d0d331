"""The engine's promises: an edit casts the moved sensor alone, and nothing depends on order, threads or giving up."""

from dataclasses import replace
from weakref import ref

import numpy as np
import pytest

from riglens.core.errors import Cancelled
from riglens.core.rig.edits import with_enabled, without
from riglens.core.rig.model import Rig, Vehicle
from riglens.core.targets import contribution
from riglens.core.targets.counts import Counted
from riglens.core.targets.engine import TargetEngine
from riglens.core.targets.groups import Groups, Parts
from riglens.core.targets.settings import EXACT, TargetSettings
from riglens.core.targets.traffic import read_traffic
from tests.core.builders import Boxes, rig_of, spinning
from tests.core.targets.cases import parts, random_rig, random_traffic


def same(one: Counted, other: Counted) -> bool:
    arrays = ("box", "points", "pixels", "points_alone", "pixels_alone", "cells", "height_px")
    equal = all(np.array_equal(getattr(one.objects, name), getattr(other.objects, name)) for name in arrays)
    return equal and parts(one) == parts(other)


@pytest.fixture(scope="module")
def world():
    return random_traffic(np.random.default_rng(5), 40)


def test_any_number_of_threads_gives_the_same_bits(world):
    rig = random_rig(np.random.default_rng(6), 6)
    one = TargetEngine(world, threads=1).evaluate(rig)
    assert one.objects.all_points.sum() > 100
    assert same(one, TargetEngine(world, threads=3).evaluate(rig))


class Editor:
    """Edits a rig at random: places, switches, bodies, settings, samples."""

    def __init__(self, rng: np.random.Generator) -> None:
        self.rng, self.rig = rng, random_rig(rng, 4)
        self.settings, self.frames = TargetSettings(), None

    def step(self) -> None:
        rng, chance = self.rng, self.rng.random()
        if chance < 0.1:
            length = float(rng.choice([3.0, 4.6]))
            self.rig = self.rig.replace(
                vehicle=Vehicle(body=str(rng.choice(["sedan", "suv"])), length=length)
            )
        elif chance < 0.3:
            body, seed = str(rng.choice(["ignored", "blocks"])), int(rng.integers(3))
            usual, way = TargetSettings(seed=seed), str(rng.choice(["box", "class"]))
            self.settings = replace(EXACT if rng.random() < 0.5 else usual, body=body, shape=way)
        elif chance < 0.4:
            self.frames = None if rng.random() < 0.5 else int(rng.integers(1, 41))
        else:
            sensor = self.rig.sensors[int(rng.integers(len(self.rig.sensors)))]
            moved = {
                "position": tuple(rng.uniform(-2.0, 2.0, 3).tolist()),
                "enabled": bool(rng.random() < 0.8),
            }
            self.rig = self.rig.with_sensor(sensor.name, sensor.model_copy(update=moved))


def edit_at_random(world, seed: int, steps: int, compare_every: int) -> None:
    editor, engine, blocked = Editor(np.random.default_rng(seed)), TargetEngine(world, threads=2), 0
    for step in range(steps):
        editor.step()
        found = engine.evaluate(editor.rig, editor.settings, editor.frames)
        if step % compare_every:
            continue
        fresh = TargetEngine(world, threads=1)
        assert same(found, fresh.evaluate(editor.rig, editor.settings, editor.frames)), (seed, step)
        if editor.settings.body == "blocks":
            free = fresh.evaluate(editor.rig, replace(editor.settings, body="ignored"), editor.frames)
            blocked += not np.array_equal(free.objects.all_points, found.objects.all_points)
    assert blocked > 0


def test_edits_in_any_order_give_the_bits_of_an_evaluation_from_scratch(world):
    edit_at_random(world, 7, 60, 2)


@pytest.mark.slow
def test_ten_thousand_edits_give_the_bits_of_an_evaluation_from_scratch(world):
    edit_at_random(world, 8, 10_000, 20)


def test_cells_of_twins_count_once_however_many_are_added(world):
    """Without phases and losses they have the same rays, and what they get is held once."""
    engine = TargetEngine(world)
    names, others = ("a", "b", "c"), (spinning((0.5, 0.0, 2.0)), spinning((-0.5, 0.0, 2.0)))
    twins = [spinning((0.0, 0.0, 2.0)).replace(name=name) for name in names]
    for kept in ((), others[:1], others):
        alone = TargetEngine(world).evaluate(rig_of(twins[0], *kept), EXACT).objects.cells
        assert alone.sum() > 100
        for number in (1, 2, 3):
            rig = rig_of(*twins[:number], *kept)
            assert np.array_equal(engine.evaluate(rig, EXACT).objects.cells, alone)


def test_a_rig_of_one_lidar_releases_the_lidars_before(world):
    engine, rig = TargetEngine(world, threads=1), random_rig(np.random.default_rng(8), 6)
    assert len(rig.enabled_lidars()) > 1
    engine.evaluate(rig)
    held = [ref(found) for found in engine._held.values()]
    engine.evaluate(rig_of(spinning((0.5, 0.0, 2.0))))
    assert held and not any(found() for found in held)


def test_a_sensor_that_is_switched_off_counts_as_one_that_is_not_there(world):
    rig = random_rig(np.random.default_rng(8), 4)
    name = rig.sensors[1].name
    off, gone = (TargetEngine(world).evaluate(made(rig, (name,))) for made in (switched_off, without))
    assert parts(off) == parts(gone) != parts(TargetEngine(world).evaluate(rig))
    assert np.array_equal(off.objects.all_points, gone.objects.all_points)


def switched_off(rig: Rig, names: tuple[str, ...]) -> Rig:
    return with_enabled(rig, names, False)


def test_only_the_moved_sensor_is_cast_and_a_sample_goes_on_where_it_ended(world, monkeypatch):
    cast, calls = contribution.TargetCaster.cast, []

    def noted(self, sensor, settings, barrier, frames, is_stale):
        calls.append((sensor.position[2], *frames))
        return cast(self, sensor, settings, barrier, frames, is_stale)

    monkeypatch.setattr(contribution.TargetCaster, "cast", noted)
    engine = TargetEngine(world)
    rig = rig_of(spinning((0.0, 0.0, 2.0)), spinning((0.0, 0.0, 3.0)))
    engine.evaluate(rig, frames=10)
    engine.evaluate(rig)
    assert sorted(calls[:2]) == [(2.0, 0, 10), (3.0, 0, 10)] and sorted(calls[2:]) == [
        (2.0, 10, 40),
        (3.0, 10, 40),
    ]
    calls.clear()
    engine.evaluate(rig.with_sensor("S1", rig.sensor("S1").replace(position=(0.0, 0.0, 4.0))))
    engine.evaluate(rig, TargetSettings(min_points=1))
    engine.evaluate(rig, TargetSettings(min_points=9))
    assert sorted(calls) == [(3.0, 0, 40), (4.0, 0, 40)]


def test_a_stale_request_is_cancelled_and_the_next_one_is_as_good_as_any(world, monkeypatch):
    monkeypatch.setattr(contribution, "TURNING_RAYS_AT_ONCE", 1)
    rig = rig_of(spinning((0.0, 0.0, 2.0)), spinning((0.0, 0.0, 3.0)))
    asked = []

    def is_stale() -> bool:
        asked.append(0)
        return len(asked) > 50

    engine = TargetEngine(world)
    with pytest.raises(Cancelled):
        engine.evaluate(rig, cancel=is_stale)
    assert same(engine.evaluate(rig), TargetEngine(world).evaluate(rig))


@pytest.mark.parametrize("threads", [1, 3])
def test_cells_are_the_same_however_many_frames_are_cast_at_once(world, threads, monkeypatch):
    rig = rig_of(spinning((0.0, 0.0, 2.0)), spinning((0.5, 0.0, 3.0)))
    whole = TargetEngine(world, threads).evaluate(rig)
    assert whole.objects.cells.sum() > 100
    for frames in (1, 5):
        monkeypatch.setattr(contribution, "TURNING_RAYS_AT_ONCE", frames * rig.sensors[0].ray_count)
        assert same(whole, TargetEngine(world, threads).evaluate(rig))


def test_moving_renaming_and_reordering_against_the_draws(world):
    engine = TargetEngine(world)
    a, b = spinning((0.0, 0.0, 2.0)).replace(name="a"), spinning((0.0, 0.0, 2.0)).replace(name="b")
    both = engine.evaluate(Rig(sensors=(a, b))).objects.points
    assert (both[:, 0] != both[:, 1]).any()  # equal LiDARs do not turn in step
    swapped = engine.evaluate(Rig(sensors=(b, a))).objects.points
    np.testing.assert_array_equal(both, swapped[:, ::-1])
    in_step = engine.evaluate(Rig(sensors=(a, b)), EXACT).objects.points
    np.testing.assert_array_equal(in_step[:, 0], in_step[:, 1])
    other = engine.evaluate(Rig(sensors=(a, b)), TargetSettings(seed=1)).objects.points
    assert (other != both).any()


def test_a_sample_tells_how_far_it_may_be_off(world):
    engine = TargetEngine(world)
    rig = rig_of(spinning((0.0, 0.0, 2.0), beams=16, count=180))
    total = parts(engine.evaluate(rig))["car"].total
    part = parts(engine.evaluate(rig, frames=20))["car"].total
    assert total.on_target.se == 0.0 < part.on_target.se
    assert abs(part.on_target.value - total.on_target.value) < 4.0 * part.on_target.se


def test_the_standard_error_is_that_of_many_samples():
    """Of 300 disjoint samples of 40 frames, the spread of the means is what the samples say."""
    rng = np.random.default_rng(3)
    many = random_traffic(rng, 12_000, 6)
    level = rng.uniform(0.0, 1.0, many.frames)
    values = np.clip(level[many.frame_of_box] + rng.normal(0.0, 0.1, len(many.cls)), 0.0, 1.0)
    means, errors = [], []
    for first in range(0, many.frames, 40):
        boxes = slice(int(many.starts[first]), int(many.starts[first + 40]))
        part = replace(
            many, starts=many.starts[first : first + 41] - boxes.start, frame=many.frame[first : first + 40],
            cls=np.zeros_like(many.cls[boxes]), centre_m=many.centre_m[boxes], within_m=1e6,
        )  # fmt: skip
        groups, none = Groups(part, 40), np.zeros(len(part.cls), np.int64)
        estimate = Parts(none, 1, none, 1, groups.frame, (40, many.frames)).means(values[boxes])
        means.append(estimate.value[0, 0])
        errors.append(estimate.se[0, 0])
    assert np.std(means) == pytest.approx(np.mean(errors), rel=0.1)


def test_adding_a_road_user_never_raises_anothers_points():
    for seed in range(6):
        rng = np.random.default_rng(200 + seed)
        more = random_traffic(rng, 3, 14).within(1e6)
        rig = random_rig(rng, 3)
        keep = rng.random(len(more.cls)) < 0.6
        order = np.argsort(more.row[keep], kind="stable")
        number = np.bincount(more.frame_of_box[keep], minlength=more.frames)
        fewer = type(more)(
            more.data, more.frame, np.concatenate([[0], np.cumsum(number)]), np.arange(keep.sum()), more.cls[keep],
            more.centre_m[keep], more.size_m[keep], more.rotation[keep], 1e6,
        )  # fmt: skip
        assert order.size
        with_all = TargetEngine(more).evaluate(rig).objects
        without = TargetEngine(fewer).evaluate(rig).objects
        assert (with_all.points[keep] <= without.points).all()
        assert (with_all.pixels[keep] <= without.pixels).all()
        rays = sum(sensor.ray_count for sensor in rig.enabled_lidars())
        per_frame = np.bincount(more.frame_of_box, with_all.all_points, more.frames)
        assert per_frame.max() <= rays


def test_two_hundred_sensors(world):
    rig = rig_of(*(spinning((0.01 * number, 0.0, 2.0), beams=2, count=30) for number in range(200)))
    scores = TargetEngine(world).evaluate(rig, frames=5)
    one = TargetEngine(world).evaluate(rig_of(spinning((0.0, 0.0, 2.0), beams=2, count=30)), frames=5)
    assert scores.objects.points.shape[1] == 200
    assert (scores.objects.cells >= one.objects.cells).sum() > 0


def test_boxes_are_read_in_the_order_of_the_data_and_frames_are_shuffled():
    rng = np.random.default_rng(1)
    truth = random_traffic(rng, 9)
    order = np.argsort(truth.row)
    source = Boxes(
        frame=np.sort(truth.frame[truth.frame_of_box]), cls=truth.cls[order], centre_m=truth.centre_m[order],
        size_m=truth.size_m[order], rotation=truth.rotation[order], frames=9,
    )  # fmt: skip
    read = read_traffic(source)
    np.testing.assert_array_equal(read.row, truth.row)
    np.testing.assert_array_equal(read.centre_m, truth.centre_m)
    assert sorted(read.frame.tolist()) == list(range(9)) and read.frame.tolist() != list(range(9))
