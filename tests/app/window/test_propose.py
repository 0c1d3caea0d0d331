"""Propose: a search in a process of its own gives what the command gives; its rigs are looked at, compared, applied."""

from __future__ import annotations

import queue
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtTest import QTest
from pytestqt.qtbot import QtBot

import riglens as rl
from riglens.app.background.proposing import (
    Gains,
    GainsRequest,
    ProposalRequest,
    Proposer,
    SearchEnd,
    SearchProgress,
    Server,
    Spots,
    answer_of,
)
from riglens.app.window.features.propose import DOCK, merged
from riglens.app.window.settings import Settings
from riglens.core.errors import InputError
from riglens.core.figures.text import value_text
from riglens.core.geometry import Pose
from riglens.core.optimise.additions import Move
from riglens.core.optimise.problem import Problem
from riglens.core.optimise.run import optimise
from riglens.core.rig.yaml.file import load_rig
from riglens.evaluation.options import SceneOptions
from riglens.evaluation.search_options import SearchOptions
from riglens.reporting.figures import WhyHere
from riglens.widgets.panels.fields.edits import ValueEdit
from riglens.widgets.panels.propose.chart import apart
from riglens.widgets.panels.propose.shown import (
    RUNNING,
    check_cells,
    front_plot,
    sentence_of,
    verdict_of,
)
from tests.app.town import write_town
from tests.app.window.desk import FullDesk, full_desk
from tests.app.window_bench import RIG, choose_item
from tests.waiting import TIMEOUT_MS

OPTIONS = SearchOptions(("generic-16",), frames=4, spots_m=1.0)


@pytest.fixture(scope="module")
def town(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Objects around the car in 10 frames."""
    return write_town(tmp_path_factory.mktemp("town") / "boxes.csv", frames=10, each=1, far_m=30.0)


@pytest.fixture(scope="module")
def result(town: Path) -> rl.OptimiseResult:
    """What the Python interface finds with the options."""
    return rl.optimise(RIG, rl.load_traffic(town), add="generic-16", frames=4, spots_m=1.0, threads=1)


@pytest.fixture
def desk(qtbot: QtBot, town: Path) -> Iterator[FullDesk]:
    with full_desk(qtbot) as made:
        made.load()
        made.session.scene.options = SceneOptions(boxes=town)  # type: ignore[union-attr,misc]
        made.workbench.window.resize(1200, 800)
        made.workbench.window.show()
        made.workbench.docks.bring_up(DOCK)
        made.qtbot.waitUntil(lambda: bool(made.features.propose.in_sight), timeout=TIMEOUT_MS)
        made.features.propose.panel.show_options(OPTIONS)
        yield made


def searched(desk: FullDesk, result: rl.OptimiseResult) -> list[Any]:
    """Start a search that has this result at once; the messages that were sent."""
    propose, sent = desk.features.propose, list[Any]()
    propose.proposer.send = sent.append  # type: ignore[method-assign]
    desk.qtbot.mouseClick(propose.panel.start, Qt.MouseButton.LeftButton)
    propose.proposer.answered.emit(SearchEnd(sent[-1].number, result))
    desk.qtbot.waitUntil(lambda: propose.result is not None, timeout=TIMEOUT_MS)
    return sent


def test_options_are_kept_from_one_session_to_the_next(desk: FullDesk) -> None:
    propose, settings = desk.features.propose, Settings()
    options = SearchOptions(
        ("generic-16", "velodyne-vlp-16"), 3, True, ("generic-16=2",), 7.0, objective="predicted", frames=70,
        weight=("pedestrian=2",), blind_m=0.5,
    )  # fmt: skip
    propose.panel.show_options(options)
    propose.keep(settings)
    propose.panel.show_options(SearchOptions())
    propose.restore(settings)
    panel = propose.panel
    assert panel.options.replace(add=()) == options.replace(add=())
    assert set(panel.models) == set(options.add)
    settings.write("propose/options", {"add": ["generic-16", "gone"], "frames": 9})
    propose.restore(settings)
    assert panel.options == SearchOptions(("generic-16",), frames=9)
    for broken in ({"add": 3}, {"count": "many"}, {"weight": ["car"]}):
        settings.write("propose/options", broken)
        propose.restore(settings)
    assert panel.options == SearchOptions(("generic-16",), frames=9)


def test_what_is_typed_is_searched_for(desk: FullDesk) -> None:
    propose, sent = desk.features.propose, list[Any]()
    propose.proposer.send = sent.append  # type: ignore[method-assign]
    fields = {"weight": "pedestrian=2 car=0.5", "cost": "generic-16=2", "budget": "8"}
    for name, text in fields.items():
        edit = propose.panel.findChild(ValueEdit, name)
        assert edit is not None
        edit.selectAll()
        QTest.keyClicks(edit, text)
        QTest.keyClick(edit, Qt.Key.Key_Return)
    desk.qtbot.mouseClick(propose.panel.start, Qt.MouseButton.LeftButton)
    wanted = OPTIONS.replace(weight=("pedestrian=2", "car=0.5"), cost=("generic-16=2",), budget=8.0)
    assert sent[0].options == wanted
    assert dict(wanted.weights().classes) == {"pedestrian": 2.0, "car": 0.5}
    budget = propose.panel.findChild(ValueEdit, "budget")
    assert budget is not None
    budget.clear()
    QTest.keyClicks(budget, " ")
    QTest.keyClick(budget, Qt.Key.Key_Return)
    assert propose.panel.options.budget is None
    cost = propose.panel.findChild(ValueEdit, "cost")
    assert cost is not None
    cost.selectAll()
    QTest.keyClicks(cost, "generic-16")
    QTest.keyClick(cost, Qt.Key.Key_Return)
    assert "must be MODEL=COST" in propose.panel.forms[2].problem


@pytest.mark.parametrize(
    "objective",
    ["blind_m2", *(pytest.param(one, marks=pytest.mark.slow) for one in ("share_25px", "seen_lidar"))],
)
def test_the_process_searches_for_figures_of_other_sensors_and_voxels(town: Path, objective: str) -> None:
    model = "nuscenes-front" if objective == "share_25px" else "generic-16"
    options = OPTIONS.replace(add=(model,), objective=objective)
    *_, end = answers(request(1, town, options=options), at_once=False)
    assert end.problem == "" and end.result.figure.is_gain(end.result.best.value - end.result.before)
    assert end.result.sentence() in sentence_of(end.result)
    assert end.result.best.verdict in verdict_of(end.result).lower()
    assert len(check_cells(end.result)[0]) == len(end.result.best.guard) + (objective == "share_25px")


def test_the_process_finds_what_the_python_interface_finds(desk: FullDesk, result: rl.OptimiseResult) -> None:
    propose = desk.features.propose
    propose.panel.tabs.setCurrentIndex(2)
    desk.qtbot.mouseClick(propose.panel.start, Qt.MouseButton.LeftButton)
    assert not propose.panel.start.isEnabled() and propose.panel.stop.isEnabled()
    assert propose.panel.tabs.currentWidget() is propose.panel.table
    desk.qtbot.waitUntil(lambda: propose.panel.start.isEnabled(), timeout=TIMEOUT_MS)
    assert desk.workbench.errors.message == "" and propose.result is not None
    assert propose.result.to_dict() == result.to_dict()
    assert result.sentence() in propose.panel.sentence.text()
    assert result.best.verdict in propose.panel.verdict.text().lower()
    assert propose.panel.table.text_of("Proposal 1", "Value") == value_text(result.figure, result.best.value)
    assert propose.panel.checks.text_of("Held-out frames", "Kept") == f"{result.best.guard[0].share:.0%}"


def test_a_proposal_is_seen_compared_applied_and_undone(desk: FullDesk, result: rl.OptimiseResult) -> None:
    searched(desk, result)
    propose, before = desk.features.propose, desk.document.rig
    assert propose.why() is None, "the rig has none of them yet"
    added = result.best.rig.sensors[len(before.sensors) :]
    table = propose.panel.table
    propose.panel.table.entered.emit(table.model().index(2, 0))
    assert desk.viewport.state.ghosts == added
    propose.panel.hovered.emit("")
    assert desk.viewport.state.ghosts == ()
    at = table.visualRect(table.model().index(2, 0)).center()
    QTest.mouseClick(table.viewport(), Qt.MouseButton.LeftButton, pos=at)
    assert desk.viewport.state.ghosts == added
    assert [row.rig.sensors for row in desk.features.compare.rows][-1] == result.best.rig.sensors
    rows = len(desk.features.compare.rows)
    QTest.mouseClick(table.viewport(), Qt.MouseButton.LeftButton, pos=at)
    assert len(desk.features.compare.rows) == rows, "listed once"
    propose.panel.select("")
    assert not propose.panel.apply.isEnabled()
    titles = table.verticalHeader()
    on_title = QPoint(10, titles.sectionViewportPosition(2) + 5)
    QTest.mouseClick(titles.viewport(), Qt.MouseButton.LeftButton, pos=on_title)
    assert propose.panel.apply.isEnabled(), "a click on the title of a row chooses it, too"
    desk.qtbot.mouseClick(propose.panel.apply, Qt.MouseButton.LeftButton)
    assert desk.document.rig.sensors == (*before.sensors, *added), "names keep their draws"
    assert "edited since" in propose.panel.sentence.text()
    why = WhyHere.model_validate(propose.why())
    assert why.sensors == [sensor.name for sensor in added] and why.verdict == result.best.verdict
    desk.qtbot.mouseClick(propose.panel.apply, Qt.MouseButton.LeftButton)
    assert "already in the rig" in desk.workbench.errors.message
    desk.act("undo")
    assert desk.document.rig == before


def test_dots_of_the_charts_are_rigs(desk: FullDesk, result: rl.OptimiseResult) -> None:
    desk.features.propose.panel.show_options(OPTIONS.replace(blind_m=0.3))
    searched(desk, with_front(result))
    plots = desk.features.propose.panel.plots
    place = QPointF(plots.place_of(1, 1))  # the proposal in the chart of the front
    QTest.mouseMove(plots, place.toPoint())
    desk.qtbot.waitUntil(lambda: len(desk.viewport.state.ghosts) == 2, timeout=TIMEOUT_MS)
    QTest.mouseMove(plots, QPointF(1.0, 1.0).toPoint())
    desk.qtbot.waitUntil(lambda: desk.viewport.state.ghosts == (), timeout=TIMEOUT_MS)


@pytest.mark.parametrize(("length_px", "kept"), [(400.0, 8), (150.0, 4), (60.0, 2), (5.0, 1)])
def test_numbers_of_an_axis_stay_apart(length_px: float, kept: int) -> None:
    ticks = [5.0 * place for place in range(8)]
    found = apart(ticks, (-2.0, 38.0), length_px, 30.0)
    assert len(found) == kept and found[0] == 0.0 and set(found) <= set(ticks)
    assert all((b - a) / 40.0 * length_px >= 30.0 for a, b in pairwise(found))


def with_front(result: rl.OptimiseResult) -> rl.OptimiseResult:
    """The result as a search finds it that also minimises blind ground."""
    better = replace(result.best, blind_m2=3.0)
    return replace(result, before_blind_m2=5.0, proposals=(better,))


def test_the_front_is_the_rigs_by_unseen_ground(result: rl.OptimiseResult) -> None:
    assert front_plot(result).dots == (), "it was not asked for"
    dots = front_plot(with_front(result)).dots
    assert [(dot.key, dot.x) for dot in dots] == [("", 5.0), ("proposal 1", 3.0)]


def test_costs_are_shown_where_they_were_asked_for(desk: FullDesk, result: rl.OptimiseResult) -> None:
    table = desk.features.propose.panel.table
    searched(desk, result)
    assert "Cost" not in table.figures.column_titles
    asked = replace(result.problem, additions=replace(result.problem.additions, budget=9.0))
    searched(desk, replace(result, problem=asked))
    assert table.text_of("Proposal 1", "Cost") == "2"


def test_proposals_are_exported_as_rigs_and_a_table(
    desk: FullDesk, result: rl.OptimiseResult, tmp_path: Path
) -> None:
    searched(desk, result)
    desk.dialogs.path = tmp_path / "out"
    desk.qtbot.mouseClick(desk.features.propose.panel.export, Qt.MouseButton.LeftButton)
    assert load_rig(tmp_path / "out" / "proposal-1.yaml").rig == result.best.rig
    assert len((tmp_path / "out" / "proposals.csv").read_text(encoding="utf-8").splitlines()) == 1 + len(
        result.proposals
    )


def test_pause_stop_and_a_process_that_does_not_stop(desk: FullDesk, result: rl.OptimiseResult) -> None:
    propose, sent, ended = desk.features.propose, list[Any](), list[bool]()
    panel, click = propose.panel, desk.qtbot.mouseClick
    propose.proposer.send = sent.append  # type: ignore[method-assign]
    propose.proposer.end = lambda: ended.append(True)  # type: ignore[method-assign]
    click(panel.start, Qt.MouseButton.LeftButton)
    click(panel.pause, Qt.MouseButton.LeftButton)
    click(panel.pause, Qt.MouseButton.LeftButton)
    assert sent[1:] == ["pause", "go on"] and panel.sentence.text() == RUNNING
    best = SearchProgress(sent[0].number, 1.0, "searching", 0.0, result.best.rig, 0.5, 0.6, None)
    propose.proposer.answered.emit(best)
    desk.qtbot.waitUntil(lambda: "60.00 %" in panel.sentence.text(), timeout=TIMEOUT_MS)
    click(panel.stop, Qt.MouseButton.LeftButton)
    assert sent[-1] == "stop" and ended == []
    desk.qtbot.waitUntil(lambda: panel.start.isEnabled(), timeout=TIMEOUT_MS)
    assert ended == [True], "it did not answer"
    panel.choose("best")
    click(panel.apply, Qt.MouseButton.LeftButton)
    assert desk.document.rig.sensors == result.best.rig.sensors, "the best so far stays"


def test_searches_of_the_session_are_kept_until_other_data_are_loaded(
    desk: FullDesk, result: rl.OptimiseResult
) -> None:
    propose, box = desk.features.propose, desk.features.propose.panel.searches
    searched(desk, result)
    assert not box.isVisible(), "one search"
    other = replace(result, before=0.123)
    searched(desk, other)
    desk.qtbot.waitUntil(lambda: box.count() == 2, timeout=TIMEOUT_MS)
    assert propose.result is other and "12.30 % now" in propose.panel.sentence.text()
    titles = [box.itemText(place) for place in range(2)]
    assert titles[0] != titles[1] and all("generic-16" in title for title in titles)
    choose_item(box, box.itemText(0))
    assert propose.result is result and "12.30 % now" not in propose.panel.sentence.text()
    desk.load()
    assert propose.result is None and box.count() == 0


def break_down(pipe: Connection) -> None:
    raise ValueError("no such thing")


def test_a_process_that_ends_by_itself_is_told(qtbot: QtBot) -> None:
    proposer, lines = Proposer(work=f"{__name__}:break_down"), list[str]()
    proposer.failed.connect(lines.append, Qt.ConnectionType.QueuedConnection)
    proposer.send("stop")
    qtbot.waitUntil(lambda: bool(lines), timeout=TIMEOUT_MS)
    assert lines == ["ValueError: no such thing"]
    proposer.end()


def test_a_search_needs_objects_and_a_model(desk: FullDesk) -> None:
    propose, errors = desk.features.propose, desk.workbench.errors
    propose.panel.show_models(())
    desk.qtbot.mouseClick(propose.panel.start, Qt.MouseButton.LeftButton)
    assert "choose at least one sensor model" in errors.message
    propose.panel.show_models(OPTIONS.add)
    desk.session.scene.options = SceneOptions(pog=Path("a.pog"))  # type: ignore[union-attr,misc]
    desk.qtbot.mouseClick(propose.panel.start, Qt.MouseButton.LeftButton)
    assert "a stored POG holds no objects" in errors.message


def test_changes_are_made_to_the_rig_as_it_is_now() -> None:
    roof, front = RIG.sensors
    moved, more = roof.replace(position=(0.0, 0.0, 1.7)), roof.replace(name="more")
    now = RIG.replace(sensors=(roof, front.replace(position=(1.1, 0.0, 1.4))))
    assert merged(now, RIG, (moved, more)).sensors == (moved, now.sensors[1], more)
    with pytest.raises(InputError, match="'roof' is no longer in the rig"):
        merged(RIG.replace(sensors=(front,)), RIG, (moved,))


# ---------------------------------------------------------------------- the process
def answers(*messages: object, at_once: bool = True) -> list[Any]:
    """Return the answers of the process to messages that have all arrived when it starts; or to
    messages that each arrive when the one before has been served."""
    inbox, found = queue.SimpleQueue[Any](), list[bytes]()
    server = Server(inbox, found.append)
    for message in messages:
        inbox.put(message)
        if not at_once:
            server.serve_one()
    inbox.put(None)
    while server.serve_one():
        pass
    return [answer_of(content) for content in found]


def request(number: int, town: Path, **changes: Any) -> ProposalRequest:
    fields: dict[str, Any] = {"work": "add", "rig": RIG, "options": OPTIONS}
    return ProposalRequest(number=number, scene=SceneOptions(boxes=town), **(fields | changes))


def test_stop_ends_a_search_and_a_newer_one_replaces_it(town: Path) -> None:
    assert [type(one) for one in answers(request(1, town), "stop")] == [SearchEnd]
    found = answers(request(1, town), request(2, town, work="skin"))
    assert [one.number for one in found if isinstance(one, SearchEnd)] == [1, 2]


def test_a_problem_is_one_line(town: Path) -> None:
    (end,) = answers(request(1, town, options=SearchOptions(("no-such",), frames=4)))
    assert "no-such" in end.problem and "\n" not in end.problem


def test_gains_change_as_a_sensor_moves(town: Path) -> None:
    roof, front = RIG.sensors
    low = RIG.replace(sensors=(roof.replace(position=(2.0, 0.0, 0.5)), front))
    found = answers(request(1, town, work="skin"), GainsRequest(low), at_once=False)
    first, second = (one for one in found if isinstance(one, Gains))
    assert (first.rig, second.rig) == (RIG, low) and len(first.gains) == len(second.gains) > 1
    assert (first.gains >= 0.0).all() and first.gains.max() > 0.0
    assert not np.array_equal(first.gains, second.gains)


def test_a_process_that_knows_other_traffic_answers_as_a_fresh_one(town: Path, tmp_path: Path) -> None:
    other = write_town(tmp_path / "other.csv", frames=10, each=1, far_m=12.0)
    first, second = request(1, town, work="skin"), request(2, other, work="skin")
    before, found, fresh = (
        one.gains
        for messages in ((first, second), (second,))
        for one in answers(*messages, at_once=False)
        if isinstance(one, Gains)
    )
    assert np.array_equal(found, fresh) and not np.array_equal(found, before)


def test_the_car_is_coloured_by_the_gains_of_the_rig_as_it_is(desk: FullDesk) -> None:
    propose, sent = desk.features.propose, list[Any]()
    propose.proposer.send = sent.append  # type: ignore[method-assign]
    propose.panel.skin.click()
    assert sent[0].work == "skin"
    number, points = sent[0].number, np.array([[1.0, 0.5, 1.0], [1.0, -0.5, 1.0]])
    rig = desk.session.working_rig
    propose.proposer.answered.emit(Spots(number, points))
    propose.proposer.answered.emit(Gains(number, rig, np.array([0.1, 0.3])))
    desk.qtbot.waitUntil(lambda: desk.viewport.state.skin_gain is not None, timeout=TIMEOUT_MS)
    assert desk.viewport.state.skin_gain.values.tolist() == pytest.approx([0.1, 0.3])
    desk.drag("roof", (0.1, 0.2, 2.0), (0.1, 0.2, 2.1))
    asked = [one for one in sent if isinstance(one, GainsRequest)]
    assert [one.rig.sensor("roof").position[2] for one in asked] == [2.0], "one at a time"
    propose.proposer.answered.emit(Gains(number, asked[0].rig, np.array([0.1, 0.2])))
    desk.qtbot.waitUntil(
        lambda: isinstance(sent[-1], GainsRequest) and sent[-1] is not asked[0], timeout=TIMEOUT_MS
    )
    assert sent[-1].rig.sensor("roof").position[2] == 2.1, "the last place follows"
    shown = desk.viewport.state.skin_gain
    assert shown.values.tolist() == pytest.approx([0.1, 0.2]) and shown.vmax == 0.3, "the scale stays"
    propose.panel.skin.click()
    assert desk.viewport.state.skin_gain is None


def test_one_sensor_is_improved_and_offered(desk: FullDesk, town: Path) -> None:
    propose, sent = desk.features.propose, list[Any]()
    propose.proposer.send = sent.append  # type: ignore[method-assign]
    desk.document.select("front")
    assert not desk.is_enabled("improve"), "a camera"
    desk.document.move({"roof": Pose((0.0, 0.3, 1.5), (0.0, 60.0, 0.0))})
    before = desk.document.rig
    desk.document.select("roof")
    desk.act("improve")
    assert (sent[0].work, sent[0].sensor) == ("improve", "roof")
    problem = Problem(before, rl.load_traffic(town), frames=4, moves=(Move("roof", 0.5),))
    better = optimise(problem, 1)
    assert better.best.value > better.before
    propose.proposer.answered.emit(SearchEnd(sent[0].number, better))
    desk.qtbot.waitUntil(lambda: propose.result is not None, timeout=TIMEOUT_MS)
    (ghost,) = desk.viewport.state.ghosts
    assert ghost.name == "roof" and ghost == better.best.rig.sensor("roof")
    desk.qtbot.mouseClick(propose.panel.apply, Qt.MouseButton.LeftButton)
    assert desk.document.rig.sensor("roof") == ghost and len(desk.document.rig.sensors) == 2
    desk.act("undo")
    assert desk.document.rig == before
