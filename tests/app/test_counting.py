"""Counts on road users come from a thread of their own: a sample at once, all frames when nothing newer is asked."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from PySide6.QtCore import Qt
from pytestqt.qtbot import QtBot

from riglens.app.background.counting import (
    FIRST_FRAMES,
    NO_BOXES,
    CountAnswer,
    Counter,
    CountRequest,
    OtherCount,
    make_counter,
)
from riglens.core.figures.hits import ON_TARGET
from riglens.core.figures.registry import leading_figures, object_figures
from riglens.core.figures.values import FigureCells, Values, values_of_objects
from riglens.core.rig.model import Rig
from riglens.core.scene.boxes import BoxSource
from riglens.core.scene.readers import open_boxes
from riglens.core.targets.engine import TargetEngine
from riglens.core.targets.settings import USUAL
from riglens.core.targets.traffic import read_traffic
from riglens.evaluation.known_body import with_known_body
from riglens.evaluation.options import SceneOptions
from tests.app.window_bench import RIG, scene_options
from tests.waiting import TIMEOUT_S

FRAMES = 3 * FIRST_FRAMES
ROW = "a,{frame},car,{x},0.0,0.8,4.0,1.8,1.6,0.0\n"


def many_frames(folder: Path) -> Path:
    path = folder / "many.csv"
    rows = [ROW.format(frame=frame, x=8.0 + frame % 7) for frame in range(FRAMES)]
    path.write_text("seq,frame,cls,x,y,z,length,width,height,yaw\n" + "".join(rows), encoding="utf-8")
    return path


@pytest.fixture
def boxes(tmp_path: Path) -> SceneOptions:
    return scene_options(tmp_path, boxes=many_frames(tmp_path))


@pytest.fixture
def counter(qtbot: QtBot) -> Iterator[Counter]:
    made = make_counter(close_s=TIMEOUT_S)
    yield made
    made.close()


def answers_to(counter: Counter, request: CountRequest) -> list[CountAnswer]:
    found = list[CountAnswer]()
    counter.answered.connect(lambda _, answer: found.append(answer), Qt.ConnectionType.DirectConnection)
    counter.ask(request)
    assert counter.wait_until_idle(TIMEOUT_S)
    return found


def ask_for(boxes: SceneOptions, rig: Rig = RIG, is_preview: bool = False, revision: int = 0) -> CountRequest:
    return CountRequest(revision, rig, RIG, USUAL, boxes, is_preview)


def source(boxes: SceneOptions) -> BoxSource:
    assert boxes.boxes is not None
    return open_boxes([boxes.boxes])


def test_at_rest_samples_grow_until_all_frames_are_in(counter: Counter, boxes: SceneOptions) -> None:
    found = answers_to(counter, ask_for(boxes))
    assert [answer.counted.frames_used for answer in found] == [FIRST_FRAMES, FRAMES]
    assert [answer.is_whole for answer in found] == [False, True]


def test_the_last_answer_is_that_of_the_engine_over_all_frames(counter: Counter, boxes: SceneOptions) -> None:
    last = answers_to(counter, ask_for(boxes))[-1]
    whole = TargetEngine(read_traffic(source(boxes)), threads=1).evaluate(RIG)
    assert last.figures == values_of_objects(whole) == last.baseline_figures
    assert set(last.figures) == {figure.key for figure in object_figures()}
    for figure in object_figures():
        if figure.leads:
            assert last.cells[figure.key].compared() == FigureCells.of(figure, whole, whole).compared()


def test_a_sample_has_the_leading_figures_alone(counter: Counter, boxes: SceneOptions) -> None:
    sample = answers_to(counter, ask_for(boxes))[0]
    objects = {one.key for one in object_figures()}
    assert {one.key for one in leading_figures()} & objects <= set(sample.cells) < objects
    assert not sample.figures and not sample.ground


def test_a_preview_gets_one_sample(counter: Counter, boxes: SceneOptions) -> None:
    found = answers_to(counter, ask_for(boxes, is_preview=True))
    assert [answer.counted.frames_used for answer in found] == [FIRST_FRAMES]


def test_the_baseline_is_counted_in_the_same_frames(counter: Counter, boxes: SceneOptions) -> None:
    rig = RIG.model_copy(update={"sensors": RIG.sensors[:1]})
    engine = TargetEngine(read_traffic(source(boxes)), threads=1)
    strict = replace(USUAL, min_points=7)
    for settings, shown, is_preview in (
        (USUAL, rig, False), (USUAL, rig, True), (USUAL, RIG, False), (strict, rig, True), (strict, rig, False),
    ):  # fmt: skip
        request = replace(ask_for(boxes, shown, is_preview=is_preview), settings=settings)
        for answer in answers_to(counter, request):
            assert answer.baseline.rig == RIG and answer.counted.rig == shown
            fresh = engine.evaluate(RIG, with_known_body(settings, RIG), answer.counted.frames_used)
            assert answer.baseline.settings == fresh.settings
            for name in ("box", "points", "pixels", "cells", "heights_px", "shown", "points_alone"):
                found, expected = (getattr(one.objects, name) for one in (answer.baseline, fresh))
                assert (found == expected).all() and found.shape == expected.shape


def test_slow_sensors_get_smaller_samples_and_quick_ones_larger(qtbot: QtBot, boxes: SceneOptions) -> None:
    for budget_ms, larger in ((0.0, False), (1e9, True)):
        counter = make_counter(budget_ms=budget_ms, close_s=TIMEOUT_S)
        try:
            answers_to(counter, ask_for(boxes, is_preview=True))
            again = answers_to(counter, ask_for(boxes, is_preview=True))[-1].counted.frames_used
            assert (again > FIRST_FRAMES) == larger and again != FIRST_FRAMES
        finally:
            counter.close()


def test_a_stored_pog_has_nobody_to_count(counter: Counter, boxes: SceneOptions, tmp_path: Path) -> None:
    stored = SceneOptions(pog=tmp_path / "x.npz")
    said = list[str]()
    counter.failed.connect(said.append, Qt.ConnectionType.DirectConnection)
    counter.ask(ask_for(stored))
    assert counter.wait_until_idle(TIMEOUT_S)
    assert said == [NO_BOXES]


def test_unsound_boxes_are_told_in_one_line(counter: Counter, boxes: SceneOptions) -> None:
    assert boxes.boxes is not None
    boxes.boxes.write_text(
        "seq,frame,cls,x,y,z,length,width,height,yaw\na,0,car,far,0,1,4,2,2,0\n", encoding="utf-8"
    )
    said = list[str]()
    counter.failed.connect(said.append, Qt.ConnectionType.DirectConnection)
    counter.ask(ask_for(boxes))
    assert counter.wait_until_idle(TIMEOUT_S)
    assert len(said) == 1 and "many.csv" in said[0] and "far" in said[0]


def others_of(counter: Counter, requests: list[OtherCount]) -> list[tuple[OtherCount, Values | None]]:
    found = list[tuple[OtherCount, Values | None]]()
    counter.answered_in_background.connect(
        lambda request, figures: found.append((request, figures)), Qt.ConnectionType.DirectConnection
    )
    counter.ask_in_background(requests)
    assert counter.wait_until_idle(TIMEOUT_S)
    return found


def test_other_rigs_are_counted_in_all_frames_in_the_order_of_asking(
    counter: Counter, boxes: SceneOptions
) -> None:
    rigs = [RIG.model_copy(update={"sensors": RIG.sensors[:count]}) for count in (0, 1, 2)]
    requests = [OtherCount("a", str(k), rig, USUAL, boxes) for k, rig in enumerate(rigs)]
    found = others_of(counter, requests)
    assert [request for request, _ in found] == requests
    for (_, figures), rig in zip(found, rigs, strict=True):
        whole = TargetEngine(read_traffic(source(boxes)), threads=1).evaluate(rig)
        assert figures is not None
        assert figures == values_of_objects(whole)
        assert figures[ON_TARGET.key]["car"] == ON_TARGET.estimates(whole, "all")["car"][0]


def test_a_class_without_road_users_has_no_figures(counter: Counter, boxes: SceneOptions) -> None:
    ((_, figures),) = others_of(counter, [OtherCount("a", "b", RIG, USUAL, boxes)])
    assert figures is not None
    found = figures[ON_TARGET.key]["bicycle"]
    assert not found.exists and found.objects == 0 and "bicycle" in found.reason


def test_a_rig_that_cannot_be_counted_is_answered_without_figures(
    counter: Counter, boxes: SceneOptions, tmp_path: Path
) -> None:
    stored = SceneOptions(pog=tmp_path / "x.npz")
    ((_, figures),) = others_of(counter, [OtherCount("a", "b", RIG, USUAL, stored)])
    assert figures is None
