"""A frame in the 3D view: chosen in the Targets panel, following edits, and flying to who is missed."""

from __future__ import annotations

import gc
import weakref
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from pytestqt.qtbot import QtBot

from riglens.app.background.counting import CountAnswer
from riglens.app.background.frames import FrameCasting, FrameRequest, boxes_of
from riglens.app.background.worker import BackgroundWorker
from riglens.app.window.features.follow import Follow
from riglens.app.window.features.frame import (
    FRAME_MS,
    NONE_MISSED,
    FrameView,
    missed_objects,
    missed_text,
)
from riglens.app.window.features.pick import hidden_from, voxel_text
from riglens.app.window.features.targets import Targets
from riglens.core.engine.sight import Sight
from riglens.core.kernels.runtime.codes import BODY, GROUND
from riglens.core.metric.scores import Body
from riglens.core.metric.voxel import VoxelFacts
from riglens.core.rig.model import Rig
from riglens.core.sensors.ultrasonic import Ultrasonic
from riglens.core.targets.engine import TargetEngine
from riglens.core.targets.settings import USUAL, TargetSettings
from riglens.core.vehicle.solid import Solid
from riglens.core.view.frame_scene import FrameScene, Missed, frame_scene
from riglens.evaluation.requests import PickedVoxel
from riglens.widgets.theme import DARK
from riglens.widgets.traffic.frame import ShownFrame, plain_frame
from riglens.widgets.traffic.layer import box_colours
from tests.app.window.desk import Desk, FakeWorker, full_desk, open_desk
from tests.app.window_bench import RIG
from tests.core.targets.cases import random_traffic, traffic
from tests.hand_clock import HandTimers
from tests.waiting import TIMEOUT_MS, TIMEOUT_S

PLACES = [(0, 12.0), (0, 30.0), (1, 20.0), (2, -55.0)]
TRAFFIC = traffic([(frame, 0, (x, 4.0, 0.8), (4.0, 1.8, 1.6), 0.0) for frame, x in PLACES], frames=4)
NO_BODY = Solid.of(np.zeros((0, 3, 3)))


class FakeCaster(FakeWorker):
    """Answers when a test says so."""

    def answer(self, missed: Missed | None = None) -> None:
        request = self.requests[-1]
        frame = int(request.traffic.frame[request.place])
        scene = frame_scene(request.rig, frame, boxes_of(request.traffic, request.place), NO_BODY)
        self.answered.emit(request, (scene, missed))


class Stand:
    """A desk with counts on it, and the frame view."""

    def __init__(self, qtbot: QtBot) -> None:
        self.desk: Desk = open_desk(qtbot)
        self.qtbot = qtbot
        Follow(self.desk.workbench)
        self.targets, self.caster = Targets(self.desk.workbench), FakeCaster()
        self.timers = HandTimers()
        self.view = FrameView(self.desk.workbench, self.targets, self.caster, self.timers)
        self.desk.workbench.answers.ask()
        self.desk.load()
        self.desk.answer()

    def count(self) -> CountAnswer:
        request = self.desk.counter.requests[-1]
        found = TargetEngine(TRAFFIC, threads=1).evaluate(request.rig, request.settings)
        answer = CountAnswer.of(request, found, found)
        self.targets._take(request, answer)
        return answer

    def settle(self) -> None:
        self.qtbot.waitUntil(lambda: self.view.is_current, timeout=TIMEOUT_MS)

    @property
    def shown(self):
        return self.desk.viewport.state.traffic


@pytest.fixture
def stand(qtbot: QtBot) -> Iterator[Stand]:
    made = Stand(qtbot)
    yield made
    made.desk.workbench.closing.emit()


def test_nothing_can_be_chosen_before_there_are_counts(stand: Stand) -> None:
    assert not stand.desk.is_enabled("show_frame") and not stand.targets.panel._frame.isEnabled()
    stand.count()
    assert stand.desk.is_enabled("show_frame") and stand.targets.panel._frame.maximum() == 3


def test_a_chosen_frame_is_shown_with_its_boxes_and_points(stand: Stand) -> None:
    stand.count()
    stand.targets.panel.frame_wanted.emit(0)
    stand.caster.answer()
    stand.settle()
    assert stand.shown is not None and stand.shown.centre_m[:, 0].tolist() == [12.0, 30.0]
    assert stand.shown.points.sum() == np.count_nonzero(stand.shown.on_box)


def test_the_frame_follows_a_drag_and_rests_at_its_end(stand: Stand) -> None:
    stand.count()
    stand.view._choose(0)
    stand.desk.drag("roof", (0.3, 0.0, 2.0))
    assert [request.is_preview for request in stand.caster.requests][-2:] == [True, False]
    assert stand.caster.requests[-1].rig == stand.desk.document.rig


def test_a_frame_that_is_not_shown_costs_nothing(stand: Stand) -> None:
    stand.count()
    stand.view._choose(0)
    stand.view._choose(None)
    asked = len(stand.caster.requests)
    stand.desk.drag("roof", (0.3, 0.0, 2.0))
    assert len(stand.caster.requests) == asked and stand.shown is not None and stand.shown.is_plain


def test_an_answer_for_another_frame_is_not_shown(stand: Stand) -> None:
    stand.count()
    stand.view._choose(0)
    first = stand.caster.requests[-1]
    stand.view._choose(1)
    stand.view._take(first, (frame_scene(Rig(), 0, boxes_of(TRAFFIC, first.place), NO_BODY), None))
    assert stand.shown is not None and stand.shown.is_plain


def test_the_action_turns_the_frame_on_and_off(stand: Stand) -> None:
    stand.count()
    stand.desk.act("show_frame")
    assert stand.caster.requests and stand.targets.panel._frame_on.isChecked()
    stand.desk.act("show_frame")
    assert not stand.targets.panel._frame_on.isChecked()


def test_other_traffic_ends_the_frame(stand: Stand) -> None:
    stand.count()
    stand.view._choose(0)
    stand.caster.answer()
    stand.settle()
    stand.desk.load()
    assert stand.shown is None and not stand.targets.panel._frame_on.isChecked()


def test_other_traffic_releases_that_before(stand: Stand) -> None:
    held = weakref.ref(stand.count().request)
    stand.view.show_next_missed()
    stand.desk.load()
    stand.desk.answer()
    del stand.desk.counter.requests[:-1]
    stand.count()
    gc.collect()
    assert held() is None


def test_who_another_kind_detects_is_not_missed(stand: Stand) -> None:
    sonar = Ultrasonic(name="sonar", position=(9.0, 4.0, 0.8), wall_range_m=5.0)
    stand.desk.document.apply(Rig(name="sonar", sensors=(sonar,)), "sonar")
    assert (
        sorted(TRAFFIC.distance_m[missed_objects(stand.count())].tolist())
        == sorted(TRAFFIC.distance_m.tolist())[1:]
    )


def test_who_is_missed_comes_nearest_first_and_round_again(stand: Stand) -> None:
    everybody = Rig(name="blind", sensors=())
    stand.desk.document.apply(everybody, "blind")
    answer = stand.count()
    nearest = sorted(TRAFFIC.distance_m.tolist())
    assert [TRAFFIC.distance_m[box] for box in missed_objects(answer)] == nearest
    for turn in range(len(PLACES) + 1):
        stand.view.show_next_missed()
        request = stand.caster.requests[-1]
        assert request.explain is not None
        box = int(TRAFFIC.starts[request.place]) + request.explain
        assert TRAFFIC.distance_m[box] == nearest[turn % len(PLACES)]
    x_m, y_m, _ = TRAFFIC.centre_m[box].tolist()
    assert stand.desk.viewport.told[-1] == ("look", x_m, y_m)


def test_why_somebody_is_missed_stands_in_the_panel(stand: Stand) -> None:
    stand.desk.document.apply(Rig(name="blind", sensors=()), "blind")
    stand.count()
    stand.view.show_next_missed()
    stand.caster.answer(Missed("no LiDARs", 0, 0))
    stand.settle()
    assert stand.targets.panel._note.text().endswith("no LiDAR is enabled")
    assert stand.shown is not None and stand.shown.pointed_out == stand.caster.requests[-1].explain


def test_why_somebody_is_missed_stays_while_more_frames_are_counted_and_goes_with_the_frame(
    stand: Stand,
) -> None:
    stand.desk.document.apply(Rig(name="blind", sensors=()), "blind")
    stand.count()
    note = stand.targets.panel._note
    stand.view.show_next_missed()
    stand.caster.answer(Missed("no LiDARs", 0, 0))
    stand.settle()
    stand.count()
    assert note.text().endswith("no LiDAR is enabled")
    stand.view.actions["show_frame"].trigger()
    assert "objects within 60 m" in note.text()


def test_the_next_missed_is_behind_the_last_one_when_more_frames_are_counted(stand: Stand) -> None:
    stand.desk.document.apply(Rig(name="blind", sensors=()), "blind")
    distances_m = []
    for _ in PLACES:
        stand.count()
        stand.view.show_next_missed()
        request = stand.caster.requests[-1]
        assert request.explain is not None
        distances_m.append(TRAFFIC.distance_m[int(TRAFFIC.starts[request.place]) + request.explain])
    assert distances_m == sorted(TRAFFIC.distance_m.tolist())
    stand.desk.document.apply(Rig(name="another", sensors=()), "blind")
    stand.count()
    stand.view.show_next_missed()
    request = stand.caster.requests[-1]
    assert TRAFFIC.distance_m[int(TRAFFIC.starts[request.place]) + request.explain] == distances_m[0]


def test_a_rig_that_misses_nobody_is_told_so(stand: Stand, monkeypatch: pytest.MonkeyPatch) -> None:
    stand.count()
    monkeypatch.setattr("riglens.app.window.features.frame.missed_objects", lambda _: [])
    stand.view.show_next_missed()
    assert stand.targets.panel._note.text() == NONE_MISSED


SCENE = FrameScene(
    0, boxes_of(TRAFFIC, int(np.flatnonzero(TRAFFIC.frame == 0)[0])), np.zeros(2, np.int64),
    np.zeros((0, 3), np.float32), np.zeros(0, np.int32),
)  # fmt: skip


@pytest.mark.parametrize(
    ("missed", "end"),
    [
        (Missed("out of range", 0, 0), "out of range of every LiDAR"),
        (Missed("hidden", 1, 9, 0), "1 of 9 points reach it, behind car, 13 m, front"),
        (Missed("hidden", 0, 9, BODY), "behind the own car's body"),
        (Missed("hidden", 0, 9, None), "0 of 9 points reach it, behind an object in front of it"),
        (Missed("hidden", 0, 9, GROUND), "behind the ground"),
        (Missed("between beams", 0, 2), "between beams, 2 points even without occlusion"),
    ],
)
def test_reasons_are_whole_sentences(missed: Missed, end: str) -> None:
    text = missed_text(SCENE, 1, missed)
    assert text.startswith("Missed: car, 30 m, front: ") and text.endswith(end)


def test_the_thread_answers_the_latest_frame_and_ends(qtbot: QtBot) -> None:
    caster = BackgroundWorker("frame view", FrameCasting(), close_s=TIMEOUT_S)
    with qtbot.waitSignal(caster.answered, timeout=TIMEOUT_MS) as told:
        caster.ask(FrameRequest(RIG, TRAFFIC, 0, USUAL, explain=0))
    scene, missed = told.args[1]
    assert missed is not None and scene.frame == int(TRAFFIC.frame[0])
    caster.close()


@pytest.mark.parametrize("body", ["ignored", "blocks"])
def test_every_road_user_of_a_frame_has_the_points_that_the_panel_counts(qtbot: QtBot, body: Body) -> None:
    many = random_traffic(np.random.default_rng(7), 5)
    settings, rig = TargetSettings(body=body), RIG
    counted = TargetEngine(many, threads=1).evaluate(rig, settings).objects
    caster = BackgroundWorker("frame view", FrameCasting(), close_s=TIMEOUT_S)
    for place in range(many.frames):
        with qtbot.waitSignal(caster.answered, timeout=TIMEOUT_MS) as told:
            caster.ask(FrameRequest(rig, many, place, settings, is_preview=place % 2 == 0))
        first, end = int(many.starts[place]), int(many.starts[place + 1])
        here = (counted.box >= first) & (counted.box < end)
        points = told.args[1][0].points
        assert here.any()
        assert np.array_equal(points[counted.box[here] - first], counted.all_points[here])
    caster.close()


def test_why_somebody_is_missed_is_told_in_the_points_of_the_panel(qtbot: QtBot) -> None:
    many = random_traffic(np.random.default_rng(7), 5)
    counted = TargetEngine(many, threads=1).evaluate(RIG).objects
    caster = BackgroundWorker("frame view", FrameCasting(), close_s=TIMEOUT_S)
    few = np.flatnonzero((counted.all_points < USUAL.min_points) & (counted.points_alone > 0))[:4]
    assert len(few)
    for k in few:
        place = int(many.frame_of_box[counted.box[k]])
        number = int(counted.box[k] - many.starts[place])
        with qtbot.waitSignal(caster.answered, timeout=TIMEOUT_MS) as told:
            caster.ask(FrameRequest(RIG, many, place, USUAL, explain=number))
        missed = told.args[1][1]
        assert (missed.points, missed.alone) == (counted.all_points[k], counted.points_alone[k])
        assert missed.verdict == ("hidden" if missed.alone >= USUAL.min_points else "between beams")
    caster.close()


def test_frames_play_one_after_the_other_and_wait_for_each(stand: Stand) -> None:
    stand.count()
    frames = lambda: [int(request.traffic.frame[request.place]) for request in stand.caster.requests]  # noqa: E731
    stand.targets.panel._play.click()
    assert frames() == [0] and stand.targets.panel._play.isChecked()
    stand.timers.advance(FRAME_MS)
    assert frames() == [0]  # still being made
    for number in (1, 2, 3, 0):
        stand.caster.answer()
        stand.settle()
        stand.timers.advance(FRAME_MS)
        assert frames()[-1] == number
    stand.desk.act("play_frames")
    stand.caster.answer()
    stand.settle()
    stand.timers.advance(FRAME_MS)
    assert frames()[-1] == 0 and not stand.targets.panel._play.isChecked()


def test_nothing_plays_without_a_frame(stand: Stand) -> None:
    stand.view.play(True)
    assert not stand.caster.requests and not stand.targets.panel._play.isChecked()
    stand.count()
    stand.view.play(True)
    stand.view._choose(None)
    assert not stand.targets.panel._play.isChecked()
    stand.timers.advance(FRAME_MS)
    assert stand.shown is not None and stand.shown.is_plain and len(stand.caster.requests) == 1


def test_a_frame_follows_how_points_are_counted(stand: Stand) -> None:
    stand.count()
    stand.view._choose(0)
    stand.desk.session.set_targets(TargetSettings(min_points=9))
    assert stand.caster.requests[-1].settings.min_points == 9


def test_the_card_of_a_voxel_knows_who_stands_before_it(qtbot: QtBot) -> None:
    with full_desk(qtbot) as desk:
        frame, sensor = desk.features.frame, desk.document.rig.sensor("roof")
        boxes = boxes_of(TRAFFIC, int(np.flatnonzero(TRAFFIC.frame == 0)[0]))
        shown = ShownFrame(
            boxes.cls, boxes.centre_m, boxes.size_m, boxes.rotation, np.zeros(2, np.int64),
            np.zeros((0, 3), np.float32), np.zeros(0, np.bool_), 5,
        )  # fmt: skip
        behind = np.array(sensor.position) + 1.6 * (boxes.centre_m[0] - np.array(sensor.position))
        facts = VoxelFacts((1, 2, 3), tuple(behind.tolist()), (0.1, 0.0, 0.0), (0.3, 0.0, 0.0))
        picked = PickedVoxel(facts, (Sight("roof", "sees", 5.0), Sight("front", "off", 5.0)))
        assert hidden_from(picked, desk.document.rig, shown) == {"roof": "car, 13 m, front"}
        near = replace(picked, facts=replace(facts, centre_m=(3.0, 0.5, 1.9)))
        assert hidden_from(near, desk.document.rig, shown) == {}
        text = voxel_text(picked, {"roof": "car, 13 m, front"})
        assert text.sensors[0].text == "sees it, in this frame behind car, 13 m, front"
        assert frame.is_current


def test_sensor_views_show_the_frame_of_the_3d_view(qtbot: QtBot) -> None:
    with full_desk(qtbot) as desk:
        panel = desk.features.sensor_view.panel
        panel.set_frames(4)
        desk.features.frame.frame_chosen.emit(3)
        assert panel.chosen_frame == 3 and panel.slider.value() == 3


def test_plain_bodies_of_a_typical_frame_stand_there_while_none_is_chosen(stand: Stand) -> None:
    assert stand.shown is None
    stand.count()
    plain = stand.shown
    assert plain is not None and plain.is_plain and len(plain.cls) > 0 and not stand.caster.requests
    assert set(box_colours(plain, DARK)) == {DARK.traffic}
    stand.view._choose(0)
    stand.caster.answer()
    stand.settle()
    assert stand.shown is not None and not stand.shown.is_plain
    stand.view._choose(None)
    assert stand.shown is plain
    stand.desk.act("plain_traffic")
    assert stand.shown is None
    stand.desk.act("plain_traffic")
    assert stand.shown is plain
    stand.desk.load()
    assert stand.shown is None


def test_the_typical_frame_has_objects_ahead_and_none_close() -> None:
    crowd = [(0, 0, (20.0 + 2 * n, 3.0, 0.8), (4.0, 1.8, 1.6), 0.0) for n in range(12)]
    some = [(frame, 0, (20.0 + 2 * n, 3.0, 0.8), (4.0, 1.8, 1.6), 0.0) for frame in (1, 2) for n in range(8)]
    close = [(1, 0, (-6.0, 3.0, 0.8), (4.0, 1.8, 1.6), 0.0)]
    found = plain_frame(traffic([*crowd, *some, *close], frames=4))
    assert len(found.cls) == 8 and found.centre_m[:, 0].min() == 20.0
