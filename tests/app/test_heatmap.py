"""Every heatmap mode shows what the engine found, cell by cell."""

import numpy as np
import pytest

from riglens.core.engine.engine import Engine
from riglens.core.metric.entropy import EntropyField
from riglens.core.rig.model import Camera
from riglens.core.scene.boxes import CLASSES
from riglens.core.view.display import DisplayGrid
from riglens.evaluation.heatmap import (
    COUNT_LABELS,
    NO_WORDS,
    Heatmaps,
    VoxelMarks,
    marks_for,
    marks_of,
)
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

    def shown(self, mode, marks=None):
        marks = marks_for(mode, self.engine, self.evaluation) if marks is None else marks
        return self.maps.heatmap(mode, "car", marks)

    def at_cells(self, shown, dense):
        places = np.floor((shown.centres_m - np.array(GRID.origin_m)) / GRID.voxel_m).astype(int)
        return dense[tuple(places.T)]


@pytest.fixture(scope="module")
def bench() -> Bench:
    return Bench()


def test_off_shows_nothing(bench):
    assert bench.shown("off") is None


def test_seen_and_unseen_entropy_make_up_the_entropy(bench):
    whole, seen, unseen = (bench.shown(mode) for mode in ("entropy", "seen", "unseen"))
    assert whole.centres_m is seen.centres_m is unseen.centres_m
    assert np.allclose(seen.values + unseen.values, whole.values, atol=1e-6)
    covered = bench.at_cells(seen, seen_by(bench.field, FIRST, SECOND))
    assert np.array_equal(seen.values > 0, covered) and np.array_equal(unseen.values > 0, ~covered)
    assert whole.vmax == seen.vmax == unseen.vmax


def test_the_number_of_sensors_is_that_of_each_taken_alone(bench):
    shown = bench.shown("sensors")
    alone = sum(seen_by(bench.field, sensor).astype(int) for sensor in (FIRST, SECOND))
    assert np.array_equal(shown.values, bench.at_cells(shown, alone))
    assert shown.labels == COUNT_LABELS and shown.scale == "steps"
    assert shown.weights.min() > 0.0 and shown.weights.max() == pytest.approx(1.0)


@pytest.mark.parametrize("count", [1, 2, 3])
def test_redundancy_shows_the_entropy_that_so_many_sensors_see(bench, count):
    """Of the first LiDAR there are two: what it sees counts twice, and three times beside the second."""
    engine = Engine(bench.field)
    evaluation = engine.evaluate(rig_of(FIRST, FIRST, SECOND))
    mode = ("seen", "twice", "thrice")[count - 1]
    shown = bench.maps.heatmap(mode, "car", marks_for(mode, engine, evaluation))
    one, other = (bench.at_cells(shown, seen_by(bench.field, s)).astype(int) for s in (FIRST, SECOND))
    whole = bench.shown("entropy")
    assert np.allclose(shown.values, np.where(2 * one + other >= count, whole.values, 0.0), atol=1e-6)
    assert shown.unit == "nat" and shown.note.endswith("more is better") == (count > 1)


def test_both_kinds_are_lidars_and_cameras_together(bench):
    engine = Engine(bench.field)
    lidars = engine.evaluate(bench.rig)
    assert not bench.maps.heatmap("kinds", "car", marks_for("kinds", engine, lidars)).values.any()
    camera = Camera(name="c", position=(0.0, 0.0, 2.0), hfov_deg=90.0, image=(160, 90), cast=(64, 36))
    evaluation = engine.evaluate(rig_of(FIRST, camera))
    shown = bench.maps.heatmap("kinds", "car", marks_for("kinds", engine, evaluation))
    both = [bench.at_cells(shown, seen_by(bench.field, one)) for one in (FIRST, camera)]
    assert np.array_equal(shown.values > 0, both[0] & both[1]) and shown.values.any()


def test_three_and_more_sensors_are_one_step(bench):
    engine = Engine(bench.field)
    evaluation = engine.evaluate(rig_of(*[FIRST] * 5))
    values = bench.maps.heatmap("sensors", "car", marks_for("sensors", engine, evaluation)).values
    assert set(np.unique(values)) == {0.0, 3.0}


def test_changes_are_what_is_seen_more_and_less_than_by_the_baseline(bench):
    before = Engine(bench.field).evaluate(rig_of(FIRST))
    after = Engine(bench.field).evaluate(rig_of(SECOND))
    shown = bench.shown("change", VoxelMarks(after.seen_by_any(), NO_WORDS, before.seen_by_any(), "one"))
    first, second = (bench.at_cells(shown, seen_by(bench.field, sensor)) for sensor in (FIRST, SECOND))
    assert np.array_equal(np.sign(shown.values), second.astype(int) - first.astype(int))
    assert shown.scale == "change" and shown.note.startswith("against one: cells of 0.5 m")
    assert np.abs(shown.values).max() <= shown.vmax < 3 * np.abs(shown.values).max()


def test_against_itself_a_rig_changes_nothing(bench):
    seen = bench.evaluation.seen_by_any()
    shown = bench.shown("change", VoxelMarks(seen, NO_WORDS, seen))
    assert not shown.values.any() and shown.vmax > 0.0


@pytest.mark.parametrize("mode", ["probability", "entropy", "seen", "unseen", "sensors", "change"])
def test_which_cells_are_shown_depends_on_mode_and_class_alone(bench, mode):
    words = bench.field.index.words
    everything = VoxelMarks(words, np.repeat(words[None], 3, axis=0), words)
    assert bench.shown(mode, everything).centres_m is bench.shown(mode, everything).centres_m
    others = [bench.maps.heatmap(mode, name, everything) for name in CLASSES]
    assert len({len(other.centres_m) for other in others}) > 1


def test_the_legend_says_how_voxels_are_put_together():
    rng = np.random.default_rng(5)
    pog = synthetic_pog(GRID, rng.integers(0, 9, (*GRID.shape, 3)), 9)
    field = EntropyField.from_pog(pog)
    maps = Heatmaps(DisplayGrid.build(pog, field, 100))
    evaluation = Engine(field).evaluate(rig_of(FIRST))
    notes = {
        mode: maps.heatmap(mode, "car", marks_of(evaluation)).note for mode in ("probability", "entropy")
    }
    cell_m, block = maps.display.cell_m, maps.display.block
    assert block > 1 and notes["probability"] == f"cells of {cell_m:g} m, largest of {block}³ voxels"
    assert notes["entropy"] == f"cells of {cell_m:g} m, sum of {block}³ voxels"


def test_what_no_rig_changes_comes_back_as_the_same_object(bench):
    for mode in ("probability", "entropy"):
        first = bench.shown(mode)
        assert bench.shown(mode) is first
        assert bench.maps.heatmap(mode, "bicycle", marks_of(bench.evaluation)) is not first
    assert bench.shown("seen") is not bench.shown("seen")
