"""The picked voxel: who sees it is the engine's answer, and reasons are kept while a sensor stays."""

import numpy as np
import pytest

from riglens.core.engine.engine import Engine
from riglens.core.engine.sight import Sight
from riglens.core.metric.entropy import EntropyField
from riglens.evaluation.requests import length_text, sight_text
from riglens.evaluation.scoring import VoxelReporter
from tests.core.builders import camera, grid_of, lidar, rig_of, seen_by, spinning, synthetic_pog

GRID = grid_of(20, 20, 8, 0.5)
COUNTS = np.ones((*GRID.shape, 3), np.int64)
COUNTS[0, 0, 0] = 0
POG = synthetic_pog(GRID, COUNTS, 4)
FIELD = EntropyField.from_pog(POG)
ROOF, FRONT = spinning((0.0, 0.0, 2.1), beams=8, count=180), camera((0.5, 0.0, 1.9), cast=(40, 20))
RIG = rig_of(ROOF, FRONT, lidar((0.0, 0.0, 2.0)).replace(enabled=False))


@pytest.fixture
def engine() -> Engine:
    return Engine(FIELD)


def test_who_sees_a_voxel_is_what_the_engine_marked(engine):
    reporter = VoxelReporter(POG)
    alone = {f"S{i}": seen_by(FIELD, sensor) for i, sensor in enumerate((ROOF, FRONT))}
    for voxel in map(tuple, np.random.default_rng(1).integers(1, GRID.shape, (40, 3)).tolist()):
        picked = reporter.report(engine, engine.evaluate(RIG), voxel, False)
        assert picked.facts.p == (0.25, 0.25, 0.25)
        assert set(picked.seen_by) == {name for name, marks in alone.items() if marks[voxel]}
        assert [found.sensor for found in picked.sights] == ["S0", "S1", "S2"]
        assert picked.sights[2].verdict == "off"


def test_in_haste_there_are_no_new_reasons_but_those_known_stay(engine):
    voxel = next(map(tuple, np.argwhere(~(seen_by(FIELD, ROOF) | seen_by(FIELD, FRONT)))[5:].tolist()))
    reporter = VoxelReporter(POG)
    hasty = reporter.report(engine, engine.evaluate(RIG), voxel, True)
    assert [found.verdict for found in hasty.sights] == ["missed", "missed", "off"]
    full = reporter.report(engine, engine.evaluate(RIG), voxel, False)
    assert "missed" not in [found.verdict for found in full.sights]
    moved = rig_of(ROOF, FRONT.replace(position=(0.6, 0.0, 1.9)), RIG.sensors[2])
    again = reporter.report(engine, engine.evaluate(moved), voxel, True)
    assert again.sights[0] == full.sights[0]
    assert again.sights[1].verdict in ("missed", "sees")


def test_a_voxel_without_uncertainty_counts_for_no_sensor(engine):
    picked = VoxelReporter(POG).report(engine, engine.evaluate(RIG), (0, 0, 0), False)
    assert picked.facts.p == (0.0, 0.0, 0.0) and picked.sights == ()


@pytest.mark.parametrize(
    ("found", "words"),
    [
        (Sight("a", "off", 3.0), "disabled"),
        (Sight("a", "range", 3.0), "out of range"),
        (Sight("a", "between", 3.0, 0.123, 2.0), "between rays, missed by 12.3 cm"),
        (
            Sight("a", "outside", 3.0, 1.5, 33.2, "above"),
            "above field of view by 33.2°",
        ),
        (
            Sight("a", "outside", 3.0, 1.5, 33.2, "beside"),
            "outside field of view by 33.2°",
        ),
    ],
)
def test_reasons_are_said_in_a_few_words(found, words):
    assert sight_text(found) == words


def test_lengths_have_a_unit_that_suits_them():
    assert [length_text(length) for length in (0.0041, 0.123, 2.5)] == ["4.1 mm", "12.3 cm", "2.50 m"]
