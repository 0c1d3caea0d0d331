"""The Targets panel follows the rig: asked after the scores, greyed until answered, never shown for an older rig."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtWidgets import QApplication, QToolButton
from pytestqt.qtbot import QtBot

from riglens.app.background.counting import CountAnswer, CountRequest
from riglens.app.window.features.follow import Follow
from riglens.app.window.features.scores import ScoresShown
from riglens.app.window.features.targets import PAUSE_MS, Targets
from riglens.core.figures.figure import ALL, Estimate
from riglens.core.figures.predicted import PREDICTED
from riglens.core.figures.registry import leading_figures
from riglens.core.figures.text import estimate_text
from riglens.core.geometry import Pose
from riglens.core.rig.model import Rig
from riglens.evaluation.options import SceneOptions
from riglens.widgets.panels.scores.text import FIGURES_HELP
from tests.app.window.counts import answer
from tests.app.window.desk import Desk, loaded, open_desk
from tests.hand_clock import HandTimers


@pytest.fixture
def desk(qtbot: QtBot) -> Desk:
    made = open_desk(qtbot)
    made.workbench.answers.ask()
    return made


@pytest.fixture
def targets(desk: Desk) -> Targets:
    Follow(desk.workbench)  # takes moves of the mouse to the document
    return Targets(desk.workbench)


def take(targets: Targets, found: CountAnswer) -> None:
    targets._take(found.request, found)


def predicted(found: CountAnswer) -> Estimate:
    return found.cells["predicted"].at("car")[0]


def text(found: Estimate) -> str:
    return estimate_text(PREDICTED, found)


def start(desk: Desk) -> CountRequest:
    desk.load()
    desk.answer()
    return desk.counter.requests[-1]


def test_nothing_is_counted_before_the_first_scores(desk: Desk, targets: Targets) -> None:
    desk.load()
    assert not desk.counter.requests
    desk.answer()
    assert len(desk.counter.requests) == 1


def name_boxes(desk: Desk, options: SceneOptions) -> None:
    desk.recompute.boxes_named.emit(options)
    QApplication.processEvents()


def test_objects_are_counted_and_shown_while_their_scene_is_loaded(desk: Desk, targets: Targets) -> None:
    scene = loaded()
    name_boxes(desk, scene.options)
    (request,) = desk.counter.requests
    whole, told = answer(request), list[bool]()
    targets.counted.connect(lambda: told.append(targets.answer_on_scene is whole))
    take(targets, whole)
    assert desk.panels.scores.table.cell("car", "predicted").text == text(predicted(whole))
    assert not told and targets.is_current
    desk.session.show_scene(scene)
    QApplication.processEvents()
    assert told == [True]
    desk.answer()
    assert desk.counter.requests == [request]


def test_another_rig_is_counted_while_the_scene_is_loaded(desk: Desk, targets: Targets) -> None:
    scene = loaded()
    name_boxes(desk, scene.options)
    desk.drag("roof", (0.3, 0.0, 2.0))
    first, last = desk.counter.requests[0], desk.counter.requests[-1]
    assert first.rig != last.rig == desk.document.rig
    take(targets, answer(last))
    take(targets, answer(first))
    desk.session.show_scene(scene)
    QApplication.processEvents()
    assert targets.is_current


@pytest.mark.parametrize("is_loaded", [False, True])
def test_boxes_that_were_named_count_no_longer_after_another_load(
    desk: Desk, targets: Targets, is_loaded: bool
) -> None:
    named = SceneOptions()
    name_boxes(desk, named)
    if not is_loaded:
        desk.recompute.load_ended.emit("Loading was cancelled.", named)
        QApplication.processEvents()
    scene = desk.load()
    assert len(desk.counter.requests) == 1
    desk.answer()
    assert desk.counter.requests[-1].options is scene.options is not named


def test_scores_of_the_same_rig_ask_for_nothing_new(desk: Desk, targets: Targets) -> None:
    start(desk)
    desk.answer(0.7)
    assert len(desk.counter.requests) == 1


def test_while_a_sample_grows_the_exact_value_and_the_paired_change_stand_there(
    desk: Desk, targets: Targets
) -> None:
    first = answer(start(desk))
    take(targets, first)
    exact = desk.panels.scores.table.cell("car", "predicted").text
    desk.drag("roof", (0.4, 0.0, 2.3))
    sample, whole = answer(desk.counter.requests[-1], 3), answer(desk.counter.requests[-1])
    take(targets, sample)
    known, (own, change) = predicted(first), sample.cells["predicted"].at("car")
    assert change.value != 0.0
    wanted = text(Estimate(known.value + change.value, float(np.hypot(known.se, change.se))))
    assert desk.panels.scores.table.cell("car", "predicted").text == wanted != text(own)
    mean, in_status = desk.panels.scores.table.cell(ALL, "predicted").text, desk.workbench.status.figure
    assert mean in in_status.text(), "the status bar follows the table"
    four = [one.short for one in leading_figures() if one.key in whole.figures]
    assert len(four) == 4 and all(short in in_status.text() for short in four)
    take(targets, whole)
    assert desk.panels.scores.table.cell("car", "predicted").text == text(predicted(whole))
    desk.document.undo()
    take(targets, answer(desk.counter.requests[-1], 3))
    assert desk.panels.scores.table.cell("car", "predicted").text == exact, (
        "the baseline itself is known exactly"
    )


def test_a_drag_asks_for_previews_and_its_end_for_all_frames(desk: Desk, targets: Targets) -> None:
    start(desk)
    desk.drag("roof", (0.3, 0.0, 2.0))
    assert [request.is_preview for request in desk.counter.requests] == [False, True, False]
    assert desk.counter.requests[-1].rig == desk.document.rig


def test_an_answer_to_the_last_request_is_current_when_it_is_of_all_frames(
    desk: Desk, targets: Targets
) -> None:
    request = start(desk)
    take(targets, answer(request, 3))
    assert targets.answer is not None and not targets.is_current
    take(targets, answer(request))
    assert targets.is_current


@pytest.mark.parametrize("fails", [False, True])
def test_coarse_answers_get_their_base_once_nothing_is_left_to_count(
    desk: Desk, targets: Targets, qtbot: QtBot, fails: bool
) -> None:
    request = start(desk)
    take(targets, answer(request, 3))
    assert desk.recompute.learnt == 0
    if fails:
        targets.counter.failed.emit("no boxes")
        QApplication.processEvents()
    else:
        take(targets, answer(request))
    assert desk.recompute.learnt == 1


def test_an_answer_to_an_earlier_rig_is_not_shown_after_a_later_one(desk: Desk, targets: Targets) -> None:
    first = start(desk)
    desk.drag("roof", (0.3, 0.0, 2.0))
    later = desk.counter.requests[-1]
    assert later is not first
    take(targets, answer(later))
    take(targets, answer(first))
    assert targets.answer is not None and targets.answer.request is later


def test_during_a_drag_counts_are_shown_now_and_then_and_the_last_ones_in_the_end(desk: Desk) -> None:
    Follow(desk.workbench)
    timers = HandTimers()
    targets = Targets(desk.workbench, timers)
    told: list[int] = []
    take(targets, answer(start(desk)))
    targets.counted.connect(lambda: told.append(1))
    timers.advance(PAUSE_MS)
    desk.document.begin_drag(("roof",))
    for step in range(4):
        desk.document.preview({"roof": Pose((0.1 * step, 0.0, 2.0))})
        take(targets, answer(desk.counter.requests[-1]))
    assert len(told) == 1 and targets.answer is not None
    assert targets.answer.request is desk.counter.requests[-1]
    timers.advance(PAUSE_MS)
    assert len(told) == 2
    timers.advance(PAUSE_MS)
    assert len(told) == 2
    desk.document.finish_drag()
    take(targets, answer(desk.counter.requests[-1]))
    assert len(told) == 3


def test_an_answer_from_other_traffic_is_dropped(desk: Desk, targets: Targets) -> None:
    request = start(desk)
    desk.load()
    take(targets, answer(request))
    assert targets.answer is None


def test_another_threshold_is_asked_for_and_kept(desk: Desk, targets: Targets) -> None:
    start(desk)
    targets.panel._points.setValue(12)
    assert desk.counter.requests[-1].settings.min_points == 12
    targets.panel.choose("share_25px")
    targets.keep(desk.workbench.kept)
    assert desk.workbench.kept.read("targets/min_points", "") == "12"
    assert desk.workbench.kept.read("targets/quantity", "") == "share_25px"


def test_a_threshold_that_makes_no_sense_is_not_taken_up(desk: Desk, targets: Targets) -> None:
    for kept, taken in [
        ("1000", 1000),
        ("1", 1),
        *((bad, 1) for bad in ("", "-3", "0", "12x", "1001", "99999")),
    ]:
        desk.workbench.kept.write("targets/min_points", kept)
        targets.restore(desk.workbench.kept)
        assert desk.session.targets.min_points == taken


def test_a_pinned_baseline_is_asked_for(desk: Desk, targets: Targets) -> None:
    start(desk)
    pinned = Rig(name="pinned", sensors=desk.document.rig.sensors[:1])
    desk.session.pin(pinned)
    assert desk.counter.requests[-1].baseline_rig == pinned


def test_the_score_table_shows_what_is_on_target_and_greys_it_with_the_next_move(
    desk: Desk, targets: Targets
) -> None:
    request, scores = start(desk), desk.panels.scores
    assert scores.table.cell("car", "predicted").text == "—"
    take(targets, answer(request))
    shown = scores.table.cell("car", "predicted").text
    assert targets.answer is not None and shown == text(predicted(targets.answer))
    table = scores.table
    assert table.place_of("predicted") not in table.figures._grey
    desk.drag("roof", (0.3, 0.0, 2.0))
    assert scores.table.cell("car", "predicted").text == shown
    assert table.place_of("predicted") in table.figures._grey
    desk.counter.failed.emit("no boxes")
    QApplication.processEvents()
    assert (
        scores.table.cell("car", "predicted").text == "—" and "no boxes" in table.cell("car", "predicted").tip
    )


def test_help_on_the_three_figures_is_a_click_away(desk: Desk, qtbot: QtBot) -> None:
    ScoresShown(desk.workbench)
    button = desk.panels.scores.findChild(QToolButton, "figures_help")
    assert button is not None
    button.click()
    assert desk.dialogs.shown == [FIGURES_HELP]
