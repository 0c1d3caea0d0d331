"""Any sequence of edits ends with the bits of an evaluation from scratch, on any number of threads."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from riglens.core.engine.caster import Caster
from riglens.core.engine.engine import Engine, Evaluation, evaluate_from_scratch
from riglens.core.errors import Cancelled
from riglens.core.kernels.voxels import update_coverage
from riglens.core.metric.entropy import EntropyField
from riglens.core.metric.scores import MetricSettings
from riglens.core.rig.model import Rig
from tests.core.builders import (
    camera,
    evaluate,
    grid_of,
    lidar,
    random_field,
    rig_of,
    spinning,
)
from tests.core.edits import Editor, differs

REPOSITORY = Path(__file__).resolve().parents[2]
GRID = grid_of(10, 9, 70, 0.5)


@pytest.fixture(scope="module")
def field() -> EntropyField:
    return random_field(GRID, np.random.default_rng(1), share=0.3)


def assert_same(found: Evaluation, expected: Evaluation) -> None:
    assert found.scores == expected.scores
    assert not differs(found, expected)


def test_what_the_others_see_is_found_anew_when_a_slot_has_changed_hands(field: EntropyField) -> None:
    """What is known of the others when one LiDAR moves does not outlive them, though a new one takes their slot."""
    lidars = [spinning((0.3 * i - 1.0, 0.2 * i - 0.4, 0.9 + i), beams=4 + i) for i in range(6)]
    engine = Engine(field, 1)
    for names in ((0, 1), (0, 2), (3,), (4,), (4, 5), (4, 1), (0, 1), (2, 1)):
        rig = rig_of(*(lidars[i] for i in names))
        assert_same(engine.evaluate(rig), evaluate(field, rig))


def test_a_rig_that_shrinks_gives_its_memory_back_and_scores_the_same(field: EntropyField) -> None:
    lidars = [spinning((0.3 * i - 1.0, 0.2 * i - 0.4, 0.9 + i), beams=4 + i) for i in range(9)]
    eyes = [camera((0.4 * i, 0.2, 1.0)) for i in range(3)]
    engine, rows = Engine(field, 1), []
    for names, count in (
        (range(9), 3),
        ((0, 7), 1),
        ((0, 7), 1),
        ((7, 5), 1),
        ((5, 7, 8), 0),
        ((5, 7, 8), 0),
    ):
        rig = rig_of(*(lidars[i] for i in names), *eyes[:count])
        assert_same(engine.evaluate(rig), evaluate(field, rig))
        rows.append(len(engine.stack_of(rig.sensors, "exact")[0]))
    assert rows == [14, 5, 5, 5, 5, 5]
    engine.evaluate(rig_of(*lidars, *eyes))
    moved = rig_of(*(one.replace(position=(0.1, 0.2, 0.3 + i)) for i, one in enumerate(lidars)), *eyes)
    for _ in range(2):
        assert_same(engine.evaluate(moved), evaluate(field, moved))
        rows.append(len(engine.stack_of(moved.sensors, "exact")[0]))
    assert rows[-2:] == [23, 14]


@pytest.mark.parametrize("seed", range(4))
def test_random_edits_end_where_an_evaluation_from_scratch_does(field: EntropyField, seed: int) -> None:
    editor = Editor(np.random.default_rng(seed), GRID)
    engine = Engine(field)
    for _ in range(60):
        editor.step()
        assert_same(
            engine.evaluate(editor.rig, editor.settings), evaluate(field, editor.rig, editor.settings)
        )


@pytest.mark.parametrize("seed", range(3))
def test_a_rig_with_sensors_switched_off_scores_the_same_and_leaves_the_engine_as_it_was(
    field: EntropyField, seed: int
) -> None:
    chance = np.random.default_rng(seed)
    editor, engine = Editor(chance, GRID), Engine(field)
    for _ in range(25):
        editor.step()
        rig, settings = editor.rig, editor.settings
        before = engine.evaluate(rig, settings)
        off = [s.model_copy(update={"enabled": s.enabled and chance.random() < 0.6}) for s in rig.sensors]
        part = rig.model_copy(update={"sensors": tuple(off)})
        assert engine.scores_without(part, settings) == evaluate(field, part, settings).scores
        assert_same(engine.evaluate(rig, settings), before)
    moved = rig_of(lidar((0.3, 0.2, 1.1)))
    assert engine.scores_without(moved) is None, "a sensor that was not evaluated"


def test_rigs_evaluated_from_scratch_score_as_when_their_sensors_are_held_one_by_one(
    field: EntropyField,
) -> None:
    editor = Editor(np.random.default_rng(5), GRID)
    rigs = []
    for _ in range(30):
        editor.step()
        rigs.append(editor.rig)
    held = [Engine(field).evaluate(rig, editor.settings) for rig in rigs]
    anew = list(evaluate_from_scratch(field, rigs, editor.settings, with_seen=True))
    for one, other in zip(anew, held, strict=True):
        assert_same(one, other)


def test_an_abandoned_request_leaves_the_engine_sound(field: EntropyField) -> None:
    rng = np.random.default_rng(9)
    editor = Editor(rng, GRID)
    engine = Engine(field)
    abandoned = 0
    for _ in range(60):
        editor.step()
        patience = int(rng.integers(0, 6))
        asked = iter(range(1000))
        try:
            answer = engine.evaluate(
                editor.rig, editor.settings, cancel=lambda p=patience, a=asked: next(a) >= p
            )
        except Cancelled:
            abandoned += 1
        else:
            assert_same(answer, evaluate(field, editor.rig, editor.settings))
        if rng.random() < 0.3:
            assert_same(
                engine.evaluate(editor.rig, editor.settings), evaluate(field, editor.rig, editor.settings)
            )
    assert abandoned > 5


def test_a_request_that_fails_half_way_leaves_the_engine_sound(field: EntropyField) -> None:
    engine = Engine(field, 1)
    big = spinning((0.0, 0.0, 1.0), (1.0, 2.0, 3.0), beams=250, count=400)
    asked = iter(range(1000))

    def interrupted() -> bool:
        if next(asked) >= 1:
            raise KeyboardInterrupt
        return False

    with pytest.raises(KeyboardInterrupt):
        engine.evaluate(rig_of(big), cancel=interrupted)
    for sensor in (spinning((0.0, 0.0, 2.0)), spinning((0.0, 0.0, 2.0), (3.0, 2.0, 1.0))):
        assert_same(engine.evaluate(rig_of(sensor)), evaluate(field, rig_of(sensor)))


def test_an_answer_does_not_change_when_the_engine_goes_on(field: EntropyField) -> None:
    engine = Engine(field)
    first = engine.evaluate(rig_of(spinning((0.0, 0.0, 2.0))))
    camera_words, lidar_words = first.seen["camera"].copy(), first.seen["lidar"].copy()
    engine.evaluate(rig_of(camera((1.0, 0.0, 2.0)), spinning((1.0, 1.0, 1.0))))
    assert np.array_equal(first.seen["camera"], camera_words)
    assert np.array_equal(first.seen["lidar"], lidar_words)


def test_an_edit_looks_at_the_sets_of_two_sensors_however_many_there_are(
    field: EntropyField, monkeypatch: pytest.MonkeyPatch
) -> None:
    """None is counted among the others, or no more, but the one put down and the one picked up."""
    looked: list[tuple[int, int]] = []
    count_others = update_coverage.count_others

    def counted(stack: np.ndarray, slots: update_coverage.Slots, *rest: object) -> None:
        looked.append((slots.arrived.size, slots.leaving.size))
        count_others(stack, slots, *rest)

    rig = rig_of(*[spinning((0.3 * i, 0.1 * i, 1.0), beams=3, count=9) for i in range(9)])
    engine = Engine(field)
    engine.evaluate(rig)
    monkeypatch.setattr(update_coverage, "count_others", counted)
    for step, i in enumerate((0, 0, 0, 5, 5, 8, 0)):
        sensor = rig.sensors[i]
        x, y, z = sensor.position
        rig = rig.with_sensor(sensor.name, sensor.replace(position=(x, y, z + 0.01 * (step + 1))))
        assert_same(engine.evaluate(rig), evaluate(field, rig))
    assert looked == [(8, 0), (1, 1), (1, 1), (1, 1)]


def test_names_models_and_pairing_cast_nothing_anew(
    field: EntropyField, monkeypatch: pytest.MonkeyPatch
) -> None:
    left, right = (lidar((0.0, y, 1.0)).replace(name=name) for y, name in ((1.0, "left"), (-1.0, "right")))
    engine = Engine(field)
    before = engine.evaluate(Rig(sensors=(left, right)))
    monkeypatch.setattr(Caster, "mark", lambda *_: pytest.fail("a sensor was cast again"))
    paired = left.replace(model="vlp-16"), right.replace(name="other", mirror_of="left")
    after = engine.evaluate(Rig(sensors=paired))
    assert after.scores == before.scores


def test_the_answer_names_its_rig_its_settings_and_its_threads(field: EntropyField) -> None:
    rig, settings = rig_of(spinning((0.0, 0.0, 2.0))), MetricSettings(reading="residual", camera_weight=0.3)
    result = evaluate(field, rig, settings, threads=1)
    assert (result.rig, result.settings, result.threads) == (rig, settings, 1)


RUN = """
import hashlib, json, sys
import numpy as np
from riglens.core.engine.engine import Engine
from riglens.core.metric.scores import MetricSettings
from tests.core.builders import grid_of, random_field, random_sensor, rig_of
rng = np.random.default_rng(12)
field = random_field(grid_of(10, 9, 70, 0.5), rng)
rigs = [rig_of(*[random_sensor(field.grid, rng, rays=300) for _ in range(3)]) for _ in range(3)]
for threads in map(int, sys.argv[1:]):
    engine, lines, used = Engine(field, threads), [], 0
    for rig in rigs * 2:
        for settings in (MetricSettings(), MetricSettings(reading="hits"), MetricSettings("bresenham")):
            answer = engine.evaluate(rig, settings)
            used = answer.threads
            lines.append([repr(answer.scores), answer.seen["camera"].tolist(), answer.seen["lidar"].tolist()])
    print(json.dumps([used, hashlib.sha256(json.dumps(lines).encode()).hexdigest()]))
"""


def test_one_two_and_eight_threads_give_the_same_bits() -> None:
    environment = {**os.environ, "NUMBA_NUM_THREADS": "8", "PYTHONPATH": str(REPOSITORY)}
    command = [sys.executable, "-c", RUN, "1", "2", "8", "8"]
    done = subprocess.run(
        command, env=environment, capture_output=True, encoding="utf-8", check=True, cwd=REPOSITORY
    )
    answers = [json.loads(line) for line in done.stdout.splitlines()]
    assert [used for used, _ in answers] == [1, 2, 8, 8]
    assert len({digest for _, digest in answers}) == 1
