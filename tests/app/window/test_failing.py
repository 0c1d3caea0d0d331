"""Sensors failed: figures of the rig without them, and nothing else changes."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtWidgets import QMenu
from pytestqt.qtbot import QtBot

from riglens.app.session.session import HeatChoice
from riglens.app.window.features.compared import CURRENT
from riglens.app.window.features.failing import Failing
from riglens.app.window.features.follow import Follow
from riglens.app.window.features.pick import voxel_text
from riglens.core.engine.sight import Sight
from riglens.core.metric.voxel import VoxelFacts
from riglens.core.rig.edits import without
from riglens.core.rig.model import Rig
from riglens.core.rig.yaml.file import dumps
from riglens.evaluation.requests import PickedVoxel
from riglens.rendering.picture import PictureWords, with_words
from riglens.widgets.panels.sensors.rows import FAILED, LOSS, NAME
from riglens.widgets.viewport.scene_state import SceneState
from tests.app.window.desk import Desk, FullDesk, full_desk, open_desk
from tests.app.window_bench import CAMERA, LIDAR, RIG, Bench, open_bench

ONE = "1 sensor failed: roof"


@pytest.fixture
def desk(qtbot: QtBot) -> Desk:
    made = open_desk(qtbot)
    Follow(made.workbench).show_all()
    made.workbench.answers.ask()
    return made


@pytest.fixture
def failing(desk: Desk) -> Failing:
    return Failing(desk.workbench)


@pytest.fixture
def full(qtbot: QtBot) -> Iterator[FullDesk]:
    with full_desk(qtbot) as made:
        yield made


def test_scores_heatmap_and_map_are_those_of_the_rig_without_it(qtbot: QtBot, tmp_path: Path) -> None:
    with open_bench(qtbot, tmp_path) as bench:
        bench.session.set_heat(HeatChoice("sensors", "car"))
        bench.session.look_at_map("any")
        bench.document.set_failed(("roof",), True)
        failed = answer(bench)
        assert bench.workbench.status.failed.text() == ONE
        bench.document.set_failed(("roof",), False)
        whole = answer(bench)
        bench.document.apply(without(bench.document.rig, ("roof",)))
        deleted = answer(bench)
    assert failed.evaluation.scores == deleted.evaluation.scores != whole.evaluation.scores
    assert np.array_equal(failed.heatmap.values, deleted.heatmap.values)
    assert not np.array_equal(failed.heatmap.values, whole.heatmap.values)
    assert np.array_equal(failed.top_view.seen, deleted.top_view.seen)


def answer(bench: Bench):
    bench.settle()
    result = bench.workbench.answers.result
    assert result is not None and result.heatmap is not None and result.top_view is not None
    return result


def test_the_rig_its_file_and_its_history_stay_as_they_are(desk: Desk, failing: Failing) -> None:
    document = desk.document
    text = dumps(document.rig)
    document.select(None)
    assert not failing.actions["fail"].isEnabled()
    document.select("roof")
    desk.act("fail")
    assert document.failed == {"roof"} and document.rig == RIG and dumps(document.rig) == text
    assert not document.is_modified and document.undo_label is None
    asked = desk.recompute.requests[-1]
    assert [sensor.enabled for sensor in asked.rig.sensors] == [False, True] and asked.baseline_rig == RIG
    desk.act("fail")
    assert document.failed == frozenset() and document.working_rig is document.rig
    assert desk.recompute.requests[-1].rig is document.rig


def test_it_is_marked_in_the_list_and_a_ghost_without_rays_in_the_view(desk: Desk, failing: Failing) -> None:
    row = desk.panels.tree._items["roof"]
    desk.document.set_failed(("roof",), True)
    assert row.text(LOSS) == FAILED and row.font(NAME).strikeOut()
    state = desk.viewport.state
    assert state.failed == {"roof"} and state.rig == RIG
    assert [sensor.name for sensor in state.shown] == ["roof", "front"]
    assert [sensor.name for sensor in state.enabled] == ["front"]
    desk.panels.tree.set_losses_stale()
    assert row.text(LOSS) == FAILED
    desk.act("restore_failed")
    assert row.text(LOSS) == "" and not row.font(NAME).strikeOut()
    assert desk.workbench.status.failed.text() == "" and desk.workbench.status.failed.isHidden()


def test_the_failure_follows_renaming_undo_deletion_and_ends_with_the_rig(
    desk: Desk, failing: Failing
) -> None:
    document = desk.document
    document.set_failed(("roof", "nobody"), True)
    document.rename("roof", "top")
    assert document.failed == {"top"} and desk.workbench.status.failed.text() == "1 sensor failed: top"
    document.undo()
    assert document.failed == {"roof"}
    document.delete(("roof",))
    assert document.failed == frozenset() and desk.workbench.status.failed.text() == ""
    document.undo()
    document.set_failed(("roof", "front"), True)
    assert desk.workbench.status.failed.text() == "2 sensors failed: front, roof"
    document.show(RIG)
    assert document.failed == frozenset()


def test_a_failed_sensor_can_be_dragged_and_the_drag_asks_for_the_rig_without_it(
    desk: Desk, failing: Failing
) -> None:
    desk.document.set_failed(("roof",), True)
    desk.drag("front", (1.2, 0.0, 1.4))
    asked = desk.recompute.requests[-1].rig
    assert asked.sensor("front").position == (1.2, 0.0, 1.4) and not asked.sensor("roof").enabled


def test_what_fails_together_is_offered_by_name(qtbot: QtBot) -> None:
    rig = Rig(sensors=(LIDAR.replace(fails_with=("ecu",)), CAMERA.replace(fails_with=("ecu", "glass"))))
    with full_desk(qtbot, rig) as desk:
        menu = desk.features.failing.menu
        menu.aboutToShow.emit()
        assert texts(menu) == ["ecu  (2 sensors)", "glass  (1 sensor)"]
        menu.actions()[0].trigger()
        assert desk.document.failed == {"roof", "front"}
        menu.aboutToShow.emit()
        assert menu.actions()[0].isChecked() and menu.actions()[1].isChecked()
        menu.actions()[1].trigger()
        assert desk.document.failed == {"roof"}
        desk.document.select("roof")
        opened = desk.panels.tree.context_menu()
        own = next(action.menu() for action in opened.actions() if action.menu() is not None)
        assert isinstance(own, QMenu) and texts(own) == ["ecu  (2 sensors)"]
        failed = next(action for action in opened.actions() if action.text() == "Failed")
        assert failed.isChecked()


def texts(menu: QMenu) -> list[str]:
    return [action.text() for action in menu.actions()]


def test_targets_and_compare_are_of_the_rig_that_works_and_snapshots_of_the_whole(full: FullDesk) -> None:
    full.load()
    full.answer()
    full.document.set_failed(("roof",), True)
    full.answer(0.25)
    assert not full.counter.requests[-1].rig.sensor("roof").enabled
    rows = {row.key: row for row in full.features.compare.rows}
    assert rows[CURRENT].name == f"small, {ONE}"
    full.act("snapshot")
    assert full.features.compare.rows[-1].rig == RIG
    assert full.features.compare.rows[-1].scores is None


@pytest.mark.parametrize("words", [PictureWords(), PictureWords(title=True)])
def test_no_picture_hides_that_a_sensor_has_failed(words: PictureWords) -> None:
    shown = with_words(SceneState(rig=RIG, failed=frozenset({"roof"})), words, None)
    assert shown.caption.title == ONE
    assert with_words(SceneState(rig=RIG), words, None).caption.title == ""


def test_the_card_of_a_voxel_tells_what_has_failed_from_what_is_switched_off() -> None:
    facts = VoxelFacts((0, 0, 0), (0.0, 0.0, 0.5), (0.5, 0.5, 0.5), (0.7, 0.7, 0.7))
    picked = PickedVoxel(facts, (Sight("roof", "off", 2.0), Sight("front", "off", 2.0)))
    assert [line.text for line in voxel_text(picked, {}, {"roof"}).sensors] == [
        "failed",
        "disabled",
    ]
