"""Commands by their names, guide, greeting, version, and notes that explain moving scores."""

from __future__ import annotations

from importlib.metadata import version
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from PySide6.QtCore import QEvent, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QDialog, QMainWindow, QPushButton, QToolBar
from pytestqt.qtbot import QtBot

from riglens.app.window.dialogs import Dialogs
from riglens.app.window.features.help import GREETING, commands_of, guide_page
from riglens.app.window.features.scene_data import why_scores_move
from riglens.app.window.settings import Settings
from riglens.core.rig.yaml.file import new_rig_file
from riglens.core.scene.boxes import DataReport
from riglens.core.scene.grid import VoxelGrid
from riglens.version import installed_version
from riglens.widgets.panels.controls.style import apply_style
from riglens.widgets.panels.help.command_palette import NOTHING_FOUND, CommandPalette, fitting
from riglens.widgets.panels.help.guide import Guide
from riglens.widgets.panels.scene.voxel_card import VoxelCard
from tests.app.window.desk import FullDesk, full_desk
from tests.app.window_bench import RIG, Bench, open_bench
from tests.waiting import wait_for


# ---------------------------------------------------------------------- commands
def palette(bench: Bench) -> CommandPalette:
    bench.qtbot.keyClick(bench.window, Qt.Key.Key_K, Qt.KeyboardModifier.ControlModifier)
    [found] = (each for each in bench.window.findChildren(CommandPalette) if each.isVisible())
    return found


def shown(opened: CommandPalette) -> list[str]:
    rows = opened.rows
    return [rows.topLevelItem(place).text(0) for place in range(rows.topLevelItemCount())]


def test_a_command_is_found_by_a_few_letters_and_done_by_return(unscored: Bench) -> None:
    opened = palette(unscored)
    QTest.keyClicks(opened.typed, "select al")
    assert shown(opened) == ["Edit › Select all"]
    QTest.keyClick(opened.typed, Qt.Key.Key_Return)
    assert len(unscored.document.selection) == 2 and not opened.isVisible()


def test_models_presets_and_themes_are_commands_too_and_arrow_keys_choose(unscored: Bench) -> None:
    opened = palette(unscored)
    QTest.keyClicks(opened.typed, "preset Narrow")
    first, second = shown(opened)[:2]
    assert first.startswith("File › New from preset › Narrow")
    QTest.keyClick(opened.typed, Qt.Key.Key_Down)
    QTest.keyClick(opened.typed, Qt.Key.Key_Return)
    assert second.endswith(f"({unscored.document.rig.name})")
    opened = palette(unscored)
    QTest.keyClicks(opened.typed, "vlp-16")
    QTest.keyClick(opened.typed, Qt.Key.Key_Return)
    added = unscored.document.selected_sensor()
    assert added is not None and added.model == "velodyne-vlp-16"


def test_escape_closes_it_and_what_cannot_be_done_now_does_nothing(unscored: Bench) -> None:
    opened = palette(unscored)
    QTest.keyClicks(opened.typed, "duplicate")
    QTest.keyClick(opened.typed, Qt.Key.Key_Return)  # nothing is selected
    assert unscored.document.rig == RIG and opened.isVisible()
    QTest.keyClick(opened.typed, Qt.Key.Key_Escape)
    assert not opened.isVisible()


def test_words_that_nothing_says_are_answered(unscored: Bench) -> None:
    opened = palette(unscored)
    QTest.keyClicks(opened.typed, "qwertz")
    assert shown(opened) == [NOTHING_FOUND]
    QTest.keyClick(opened.typed, Qt.Key.Key_Return)
    assert opened.isVisible() and unscored.document.rig == RIG


def test_every_action_of_a_menu_is_found_and_titles_that_begin_so_come_first(bench: FullDesk) -> None:
    commands = commands_of(bench.workbench.places, bench.workbench.actions["commands"])
    listed = {command.action for command in commands}
    missing = {
        spec.key
        for spec in bench.workbench.actions.specs
        if bench.workbench.actions[spec.key] not in listed and spec.key != "commands"
    }
    assert missing == set()
    assert fitting(commands, "top")[0].title == "Top"
    assert fitting(commands, "no such thing") == []
    assert fitting(commands, "ruler")[0].title == "Measure a distance"
    assert fitting(commands, "remove")[0].title == "Delete"
    assert all("&" not in command.words.replace(" & ", "") for command in commands)


# ---------------------------------------------------------------------- texts
def test_the_about_text_says_the_version_and_what_it_stands_on(bench: FullDesk) -> None:
    bench.act("about")
    text = bench.dialogs.shown[0]
    assert f"RigLens {installed_version()}" in text and f"numba {version('numba')}" in text


def test_f1_opens_the_guide_and_its_links_lead_to_other_pages(unscored: Bench, qtbot: QtBot) -> None:
    unscored.qtbot.keyClick(unscored.window, Qt.Key.Key_F1)
    page = guide_page()
    assert page is not None and unscored.dialogs.shown == [str(page)]
    Dialogs().show_guide(unscored.window, page)
    guide = unscored.window.findChild(Guide)
    assert guide is not None and "first five minutes" in guide.text.toPlainText()
    assert "](" in page.read_text(encoding="utf-8") and "](" not in guide.text.toPlainText()
    guide.text.setSource(guide.text.source().resolved("heatmap.md"))
    assert "heatmap" in guide.text.source().fileName() and len(guide.text.toPlainText()) > 200
    back = next(button for button in guide.findChildren(QPushButton) if button.text() == "Back")
    QTest.mouseClick(back, Qt.MouseButton.LeftButton)
    assert guide.text.source().fileName() == page.name
    QTest.keyClick(guide, Qt.Key.Key_Escape)
    assert not guide.isVisible()


# ---------------------------------------------------------------------- texts
def test_what_was_read_is_gone_once_it_is_closed(qapp: QApplication, qtbot: QtBot) -> None:
    window = QMainWindow()
    qtbot.addWidget(window)
    Dialogs().show_text(window, "About RigLens", "<p>version</p>", "details")
    [read] = window.findChildren(QDialog)
    read.close()
    qapp.sendPostedEvents(None, QEvent.Type.DeferredDelete.value)
    assert not window.findChildren(QDialog)


def test_the_first_start_says_where_help_is_and_no_other(qtbot: QtBot) -> None:
    kept = Settings()
    for greeting in (GREETING, ""):
        with full_desk(qtbot, kept=kept) as bench:
            bench.features.help.start()
            assert bench.workbench.status.currentMessage() == greeting


def test_a_message_and_the_state_never_stand_on_each_other(unscored: Bench) -> None:
    status = unscored.workbench.status
    status.showMessage("Not in this view: a sensor far away.")
    status.state.setText("exact, and much longer than it was before")
    task = status.add_strip("work")
    task.show()
    wait_for(lambda: not status.state.isVisible() and not status.figure.isVisible())
    status.clearMessage()
    assert status.state.isVisible() and status.figure.isVisible()
    assert {label.window() for label in (status.state, status.figure)} == {status.window()}
    task.hide()


def test_all_of_the_toolbar_is_in_sight_in_a_small_window(
    unscored: Bench, qapp: QApplication, plain_style: None
) -> None:
    apply_style(qapp, False)
    toolbar = unscored.window.findChild(QToolBar, "toolbar")
    assert toolbar is not None
    tools = [toolbar.widgetForAction(action) for action in toolbar.actions() if action.isVisible()]
    for width_px in (960, 1280, 1920):
        unscored.window.resize(width_px, 540)
        wait_for(lambda: all(it.isVisible() and toolbar.rect().contains(it.geometry()) for it in tools))


def test_no_card_covers_the_view_unasked(bench: FullDesk) -> None:
    assert bench.viewport.findChild(VoxelCard).isHidden()


# ---------------------------------------------------------------------- files
def test_unsaved_changes_are_asked_for_after_the_file_is_chosen(bench: FullDesk, tmp_path: Path) -> None:
    target = tmp_path / "rig.yaml"
    new_rig_file(RIG.replace(name="other")).save(target)
    bench.drag("roof", (1.0, 0.0, 2.0))
    bench.dialogs.path = None
    bench.act("open")
    assert bench.dialogs.asked == 0  # nothing was chosen, so nothing would be lost
    bench.dialogs.path = target
    bench.act("open")
    assert bench.dialogs.asked == 1 and bench.document.rig.name == "small"
    bench.dialogs.answer = "discard"
    bench.act("open")
    assert bench.document.rig.name == "other"


def test_exports_start_beside_the_file_of_the_rig(bench: FullDesk, tmp_path: Path) -> None:
    from riglens.core.formats.exchange import FORMATS

    bench.features.exchange.export(FORMATS["urdf"])
    assert bench.dialogs.suggested == Path("small.urdf")
    target = tmp_path / "rig.yaml"
    new_rig_file(RIG).save(target)
    bench.document.open(target)
    bench.features.exchange.export(FORMATS["urdf"])
    assert bench.dialogs.suggested == tmp_path / "small.urdf"


# ---------------------------------------------------------------------- why scores move
def test_what_another_grid_does_to_the_scores_is_said() -> None:
    small, large = VoxelGrid(0.1, (20.0, 20.0, 4.0)), VoxelGrid(0.2, (20.0, 20.0, 4.0))
    assert why_scores_move(small, small) == ""
    assert "voxels have edges of 0.2 m instead of 0.1 m" in why_scores_move(small, large)
    wide = why_scores_move(small, VoxelGrid(0.1, (40.0, 20.0, 4.0)))
    assert "the region of interest is 40 × 20 × 4 m instead of 20 × 20 × 4 m" in wide and "voxels" not in wide


def scene(edge_m: float) -> Any:
    """What the note asks of a loaded scene."""
    grid = VoxelGrid(edge_m, (20.0, 20.0, 4.0))
    return SimpleNamespace(field=SimpleNamespace(grid=grid, data=DataReport("boxes", 1, {})))


def test_a_change_of_the_voxel_edge_says_why_the_numbers_moved(qtbot: QtBot, tmp_path: Path) -> None:
    with open_bench(qtbot, tmp_path) as bench:
        assert bench.workbench.notes.message == ""
        bench.features.scene_data.load(
            bench.scenes[-1].options.__class__(boxes=tmp_path / "boxes.csv", voxel_m=1.0)
        )
        bench.settle()
        assert "edges of 1 m instead of 0.5 m" in bench.workbench.notes.message


def test_the_note_can_be_silenced_for_good_and_covers_no_other_note(
    bench: FullDesk, monkeypatch: pytest.MonkeyPatch
) -> None:
    def change(before_m: float, after_m: float) -> None:
        monkeypatch.setattr(bench.workbench.session, "_scene", scene(before_m))
        bench.features.scene_data._show_note(scene(after_m))

    notes = bench.workbench.notes
    notes.show_message("Recover?")
    change(0.1, 0.2)
    assert notes.message == "Recover?"
    notes.clear()
    change(0.1, 0.2)
    change(0.2, 0.4)
    assert "0.4 m instead of 0.2 m" in notes.message
    button = notes.findChild(QPushButton, "Do not show this again")
    assert button is not None
    QTest.mouseClick(button, Qt.MouseButton.LeftButton)
    change(0.4, 0.2)
    assert notes.message == ""
