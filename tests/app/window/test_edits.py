"""Adding, copying, deleting, hiding, renaming and dragging in the window, as a person does it."""

from collections.abc import Callable
from functools import partial

import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtWidgets import QApplication, QLineEdit

from riglens.core.geometry import Pose
from riglens.core.rig.library import default_library
from riglens.widgets.panels.sensors.tree import EYE, NAME
from tests.app.window.desk import FullDesk
from tests.app.window_bench import LIDAR, RIG, Bench
from tests.waiting import TIMEOUT_MS


def click_row(bench: FullDesk, name: str, column: int = NAME, dx: int = 0) -> None:
    tree = bench.panels.tree
    item = tree._items[name]
    rect = tree.visualItemRect(item)
    x = tree.columnViewportPosition(column) + (rect.left() + 60 if column == NAME else 12) + dx
    bench.qtbot.mouseClick(tree.viewport(), Qt.MouseButton.LeftButton, pos=QPoint(x, rect.center().y()))


def agree(bench: FullDesk) -> bool:
    """Whether view, list and inspector show the document's selection and the document's rig."""
    document = bench.document
    chosen = [item.text(NAME) for item in bench.panels.tree.selectedItems()]
    subject = bench.panels.inspector.form.subject
    wanted = document.rig if document.selected is None else document.rig.sensor(document.selected)
    return (
        bench.viewport.state.rig == document.rig
        and bench.viewport.state.selected == document.selected
        and chosen == ([] if document.selected is None else [document.selected])
        and subject == wanted
    )


@pytest.mark.parametrize("model", ["velodyne-vlp-16", "paper-camera-110"])
def test_a_sensor_of_the_library_is_added_above_the_roof_and_selected(bench: FullDesk, model: str) -> None:
    action = next(
        action
        for menu in bench.features.sensors.add_menus.values()
        for maker in menu.actions()
        for action in maker.menu().actions()
        if action.objectName() == model
    )
    action.trigger()
    added = bench.document.selected_sensor()
    assert added is not None
    assert added.model == model
    assert added.kind == default_library().entry(model).kind
    assert added.position[2] > bench.document.rig.vehicle.height
    assert agree(bench)


def test_two_added_sensors_do_not_stand_in_each_other(bench: FullDesk) -> None:
    bench.features.sensors.add("generic-16")
    bench.features.sensors.add("generic-16")
    first, second = bench.document.rig.sensors[-2:]
    assert first.position != second.position
    assert first.name != second.name


def test_picking_in_the_view_and_in_the_list_is_the_same(bench: FullDesk) -> None:
    bench.viewport.sensor_picked.emit("front")
    assert bench.document.selected == "front"
    assert agree(bench)
    click_row(bench, "roof")
    assert bench.document.selected == "roof"
    assert agree(bench)
    bench.viewport.sensor_picked.emit(None)
    assert bench.document.selected is None
    assert agree(bench)


def test_the_eye_hides_a_sensor_from_the_view_but_not_from_the_scores(bench: FullDesk) -> None:
    before = bench.panels.scores.table.as_text()
    click_row(bench, "roof", EYE)
    assert bench.viewport.state.hidden == {"roof"}
    assert bench.panels.scores.table.as_text() == before
    click_row(bench, "roof", EYE)
    assert bench.viewport.state.hidden == frozenset()


def rename_in_list(bench: FullDesk, name: str, text: str) -> None:
    tree = bench.panels.tree
    tree.editItem(tree._items[name], NAME)
    editor = tree.viewport().findChild(QLineEdit)
    assert editor is not None
    editor.setText(text)
    bench.qtbot.keyClick(editor, Qt.Key.Key_Return)
    QApplication.processEvents()  # the list takes the text when the key press is over


def test_a_sensor_is_renamed_in_the_list(bench: FullDesk) -> None:
    click_row(bench, "roof")
    rename_in_list(bench, "roof", "mast")
    assert [sensor.name for sensor in bench.document.rig.sensors] == ["mast", "front"]
    assert agree(bench)


@pytest.mark.parametrize("text", ["front", "  "])
def test_a_name_that_is_taken_or_empty_is_refused_in_the_list(bench: FullDesk, text: str) -> None:
    rename_in_list(bench, "roof", text)
    assert bench.document.rig == RIG
    assert bench.panels.tree._items["roof"].text(NAME) == "roof"
    assert "name" in bench.workbench.errors.message


def test_a_drag_in_the_view_is_followed_by_list_and_inspector_and_is_one_step(unscored: Bench) -> None:
    click_row(unscored, "roof")
    unscored.viewport.press("roof")
    for step in range(1, 4):
        unscored.viewport.drag_to("roof", Pose((0.1, 0.2, 1.9 + step / 4)))
        unscored.qtbot.waitUntil(lambda: agree(unscored), timeout=TIMEOUT_MS)
    unscored.viewport.release("roof")
    assert agree(unscored)
    assert unscored.document.rig.sensor("roof").position == (0.1, 0.2, 2.65)
    unscored.qtbot.keyClick(unscored.workbench.window, Qt.Key.Key_Z, Qt.KeyboardModifier.ControlModifier)
    assert unscored.document.rig == RIG
    assert agree(unscored)
    shift = Qt.KeyboardModifier.ControlModifier | Qt.KeyboardModifier.ShiftModifier
    unscored.qtbot.keyClick(unscored.workbench.window, Qt.Key.Key_Z, shift)
    assert unscored.document.rig.sensor("roof").position == (0.1, 0.2, 2.65)
    assert agree(unscored)


EDITS: dict[str, Callable[[Bench], object]] = {
    **{
        key: partial(Bench.act, key=key)
        for key in ("duplicate", "delete", "cut", "paste", "enable", "mirror", "link")
    },
    "unlink": lambda bench: bench.act("unlink"),
    "add": lambda bench: bench.features.sensors.add("generic-16"),
    "drop": lambda bench: bench.viewport.model_dropped.emit("generic-16", Pose((0.1, 0.2, 1.5))),
    "nudge": lambda bench: bench.viewport.nudged.emit({"roof": Pose((0.3, 0.2, 1.9))}),
    "drag": lambda bench: bench.drag("roof", (1.0, 0.0, 2.0), (1.5, 0.0, 2.0)),
    "rename": lambda bench: bench.panels.tree.renamed.emit("roof", "mast"),
    "field": lambda bench: bench.type("z", "2.5"),
    "model": lambda bench: bench.choose("model", "Velodyne VLP-16 (Puck)"),
    "restore": lambda bench: bench.features.compare.panel.open_wanted.emit("snapshot-1"),
}


def test_everything_that_changes_the_rig_is_one_step_back_and_forth(bench: FullDesk) -> None:
    document = bench.document
    bench.act("snapshot")
    twin = LIDAR.replace(name="twin", position=(0.1, -0.25, 1.9))
    start = RIG.replace(sensors=(*RIG.sensors, twin), vehicle=RIG.vehicle.replace(length=5.0))
    document.show(start)
    for name, edit in EDITS.items():
        document.select("roof")
        if name == "paste":
            bench.act("copy")
        if name == "unlink":
            bench.act("link")
        before = document.rig
        edit(bench)
        after = document.rig
        assert after != before, name
        bench.act("undo")
        assert document.rig == before, name
        bench.act("redo")
        assert document.rig == after, name
        bench.act("undo")
    document.select(None)
    bench.type("length", "4.2")
    bench.type("rig_name", "other")
    assert (document.rig.vehicle.length, document.rig.name) == (4.2, "other")
    while document.undo_label is not None:
        bench.act("undo")
    assert document.rig == start


def test_gizmo_modes_and_views_reach_the_viewport(unscored: Bench) -> None:
    for key in (Qt.Key.Key_W, Qt.Key.Key_E, Qt.Key.Key_Q, Qt.Key.Key_L, Qt.Key.Key_2):
        unscored.qtbot.keyClick(unscored.workbench.window, key)
    assert unscored.viewport.values("gizmo_mode", "gizmo_space")[-4:] == [
        ("move", "world"),
        ("rotate", "world"),
        ("both", "world"),
        ("both", "local"),
    ]
    assert unscored.viewport.told[-1] == ("view", "top")


def test_f_frames_what_is_selected_or_all_and_home_frames_all(unscored: Bench) -> None:
    unscored.qtbot.keyClick(unscored.workbench.window, Qt.Key.Key_F)
    assert unscored.viewport.told[-1] == ("frame",)
    unscored.document.choose_all()
    unscored.qtbot.keyClick(unscored.workbench.window, Qt.Key.Key_F)
    assert set(unscored.viewport.told[-1]) == {"frame", "roof", "front"}
    unscored.qtbot.keyClick(unscored.workbench.window, Qt.Key.Key_Home)
    assert unscored.viewport.told[-1] == ("frame",)
    unscored.qtbot.keyClick(unscored.workbench.window, Qt.Key.Key_6)
    assert unscored.viewport.told[-1] == ("view", "right")


def test_ctrl_y_redoes_unless_something_is_being_typed(unscored: Bench) -> None:
    unscored.document.select("roof")
    unscored.type("x", "2")
    unscored.act("undo")
    unscored.qtbot.keyClick(unscored.find("x"), Qt.Key.Key_Y, Qt.KeyboardModifier.ControlModifier)
    assert unscored.document.rig.sensor("roof").position[0] == 2.0
    unscored.act("undo")
    edit = unscored.find("y")
    edit.setFocus()
    unscored.qtbot.keyClick(edit, Qt.Key.Key_5)
    unscored.qtbot.keyClick(edit, Qt.Key.Key_Y, Qt.KeyboardModifier.ControlModifier)
    assert unscored.document.rig == RIG
