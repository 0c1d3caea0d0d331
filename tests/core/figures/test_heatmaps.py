"""Every heatmap mode shows what the engine found, cell by cell."""

import numpy as np
import pytest

from riglens.core.engine.engine import Engine
from riglens.core.figures.heatmaps import (
    CHANGE,
    COUNT_LABELS,
    ENTROPY,
    PROBABILITY,
    SEEN_BY_TWO_KINDS,
    SEEN_ENTROPY,
    SEEN_THRICE,
    SEEN_TWICE,
    SENSORS,
    UNSEEN_ENTROPY,
    Heatmaps,
    Marks,
)
from riglens.core.figures.registry import voxel_heat_maps
from riglens.core.metric.entropy import EntropyField
from riglens.core.rig.model import Camera
from riglens.core.scene.boxes import CLASSES
from riglens.core.view.display import DisplayGrid
from tests.core.builders import grid_of, rig_of, seen_by, spinning, synthetic_pog

GRID = grid_of(12, 10, 8, 0.5)
FIRST, SECOND = spinning((0.0, 0.0, 2.0), beams=6, count=40), spinning((1.0, 0.5, 3.0), beams=9, count=60)


class Bench:
    """A small scene with two LiDARs, evaluated, and its heatmaps at the resolution of the voxels."""

    def __init__(self) -> None:
        rng = np.random.default_rng(3)
        counts = rng.integers(1, 20, (*GRID.shape, 3)) * (rng.random((*GRID.shape, 3)) < 0.6)
        pog = synthetic_pog(GRID, counts, 20)
        self.field = EntropyField.from_pog(pog)
        self.maps = Heatmaps(DisplayGrid.build(pog, self.field))
        self.engine = Engine(self.field)
        self.rig = rig_of(FIRST, SECOND)
        self.evaluation = self.engine.evaluate(self.rig)

    def shown(self, heat, marks=None):
        marks = Marks(heat.sets(self.engine, self.evaluation)) if marks is None else marks
        return self.maps.drawn(heat, "car", marks)

    def at_cells(self, shown, dense):
        places = np.floor((shown.centres_m - np.array(GRID.origin_m)) / GRID.voxel_m).astype(int)
        return dense[tuple(places.T)]


@pytest.fixture(scope="module")
def bench() -> Bench:
    return Bench()


def test_seen_and_unseen_entropy_make_up_the_entropy(bench):
    whole, seen, unseen = (bench.shown(mode) for mode in (ENTROPY, SEEN_ENTROPY, UNSEEN_ENTROPY))
    assert whole.centres_m is seen.centres_m is unseen.centres_m
    assert np.allclose(seen.values + unseen.values, whole.values, atol=1e-6)
    covered = bench.at_cells(seen, seen_by(bench.field, FIRST, SECOND))
    assert np.array_equal(seen.values > 0, covered) and np.array_equal(unseen.values > 0, ~covered)
    assert whole.vmax == seen.vmax == unseen.vmax


def test_the_number_of_sensors_is_that_of_each_taken_alone(bench):
    shown = bench.shown(SENSORS)
    alone = sum(seen_by(bench.field, sensor).astype(int) for sensor in (FIRST, SECOND))
    assert np.array_equal(shown.values, bench.at_cells(shown, alone))
    assert shown.labels == COUNT_LABELS and shown.scale == "steps"
    assert shown.weights.min() > 0.0 and shown.weights.max() == pytest.approx(1.0)


@pytest.mark.parametrize("count", [1, 2, 3])
def test_redundancy_shows_the_entropy_that_so_many_sensors_see(bench, count):
    """Of the first LiDAR there are two: what it sees counts twice, and three times beside the second."""
    engine = Engine(bench.field)
    evaluation = engine.evaluate(rig_of(FIRST, FIRST, SECOND))
    heat = (SEEN_ENTROPY, SEEN_TWICE, SEEN_THRICE)[count - 1]
    shown = bench.maps.drawn(heat, "car", Marks(heat.sets(engine, evaluation)))
    one, other = (bench.at_cells(shown, seen_by(bench.field, s)).astype(int) for s in (FIRST, SECOND))
    whole = bench.shown(ENTROPY)
    assert np.allclose(shown.values, np.where(2 * one + other >= count, whole.values, 0.0), atol=1e-6)
    assert shown.unit == "nat" and shown.note.endswith("more is better") == (count > 1)


def test_both_kinds_are_lidars_and_cameras_together(bench):
    engine = Engine(bench.field)
    lidars = engine.evaluate(bench.rig)
    heat = SEEN_BY_TWO_KINDS
    assert not bench.shown(heat, Marks(heat.sets(engine, lidars))).values.any()
    camera = Camera(name="c", position=(0.0, 0.0, 2.0), hfov_deg=90.0, image=(160, 90), cast=(64, 36))
    evaluation = engine.evaluate(rig_of(FIRST, camera))
    shown = bench.shown(heat, Marks(heat.sets(engine, evaluation)))
    both = [bench.at_cells(shown, seen_by(bench.field, one)) for one in (FIRST, camera)]
    assert np.array_equal(shown.values > 0, both[0] & both[1]) and shown.values.any()


def test_three_and_more_sensors_are_one_step(bench):
    engine = Engine(bench.field)
    evaluation = engine.evaluate(rig_of(*[FIRST] * 5))
    values = bench.shown(SENSORS, Marks(SENSORS.sets(engine, evaluation))).values
    assert set(np.unique(values)) == {0.0, 3.0}


def test_changes_are_what_is_seen_more_and_less_than_by_the_baseline(bench):
    before = Engine(bench.field).evaluate(rig_of(FIRST))
    after = Engine(bench.field).evaluate(rig_of(SECOND))
    shown = bench.shown(CHANGE, Marks(after.seen_by_any(), before.seen_by_any(), "one"))
    first, second = (bench.at_cells(shown, seen_by(bench.field, sensor)) for sensor in (FIRST, SECOND))
    assert np.array_equal(np.sign(shown.values), second.astype(int) - first.astype(int))
    assert shown.scale == "change" and shown.note.startswith("against one: cells of 0.5 m")
    assert np.abs(shown.values).max() <= shown.vmax < 3 * np.abs(shown.values).max()


def test_against_itself_a_rig_changes_nothing(bench):
    seen = bench.evaluation.seen_by_any()
    shown = bench.shown(CHANGE, Marks(seen, seen))
    assert not shown.values.any() and shown.vmax > 0.0


@pytest.mark.parametrize("mode", voxel_heat_maps(), ids=lambda heat: heat.key)
def test_which_cells_are_shown_depends_on_mode_and_class_alone(bench, mode):
    words = bench.field.index.words
    everything = Marks(np.repeat(words[None], 3, axis=0) if mode is SENSORS else words, words)
    assert bench.shown(mode, everything).centres_m is bench.shown(mode, everything).centres_m
    others = [bench.maps.drawn(mode, name, everything) for name in CLASSES]
    assert len({len(other.centres_m) for other in others}) > 1


def test_the_legend_says_how_voxels_are_put_together():
    rng = np.random.default_rng(5)
    pog = synthetic_pog(GRID, rng.integers(0, 9, (*GRID.shape, 3)), 9)
    field = EntropyField.from_pog(pog)
    maps = Heatmaps(DisplayGrid.build(pog, field, 100))
    notes = {heat.key: maps.drawn(heat, "car", Marks()).note for heat in (PROBABILITY, ENTROPY)}
    cell_m, block = maps.display.cell_m, maps.display.block
    assert block > 1 and notes["probability"] == f"cells of {cell_m:g} m, largest of {block}³ voxels"
    assert notes["entropy"] == f"cells of {cell_m:g} m, sum of {block}³ voxels"


def test_what_no_rig_changes_comes_back_as_the_same_object(bench):
    for mode in (PROBABILITY, ENTROPY):
        first = bench.shown(mode)
        assert bench.shown(mode) is first
        assert bench.maps.drawn(mode, "bicycle", Marks()) is not first
    assert bench.shown(SEEN_ENTROPY) is not bench.shown(SEEN_ENTROPY)
