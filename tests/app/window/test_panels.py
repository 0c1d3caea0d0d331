"""Several sensors at once, locks, the library, the baseline and what each sensor is worth, as a person uses them."""

from pathlib import Path

import pytest
from PySide6.QtCore import QEvent, QPoint, Qt
from PySide6.QtGui import QGuiApplication, QHelpEvent
from PySide6.QtWidgets import (
    QApplication,
    QDoubleSpinBox,
    QLabel,
    QLineEdit,
    QMainWindow,
    QMenu,
    QSpinBox,
    QToolButton,
    QToolTip,
    QWidget,
)
from pytestqt.qtbot import QtBot

from riglens.core.figures.coverage import S_MS
from riglens.core.figures.figure import CLASSES_AND_ALL
from riglens.core.figures.text import change_text
from riglens.core.geometry import Pose
from riglens.core.rig.edits import without
from riglens.core.rig.yaml.file import new_rig_file
from riglens.core.shown_values import NONE
from riglens.widgets.maps.map_items import NO_BOXES
from riglens.widgets.panels.inspector.marginal_view import NOT_COUNTED, WAITING
from riglens.widgets.panels.inspector.pose_tools import PoseTools
from riglens.widgets.panels.sensors.library import MODEL_MIME
from riglens.widgets.panels.sensors.rows import EYE, LOCK, LOSS, NAME
from tests.app.window_bench import CAMERA, LIDAR, RIG, Bench, open_bench
from tests.waiting import TIMEOUT_MS

CTRL = Qt.KeyboardModifier.ControlModifier


@pytest.fixture
def bench(unscored: Bench) -> Bench:
    return unscored


def click(bench: Bench, name: str, column: int = NAME, modifiers: Qt.KeyboardModifier | None = None) -> None:
    tree = bench.panels.tree
    rect = tree.visualItemRect(tree._items[name])
    x = tree.columnViewportPosition(column) + (rect.left() + 50 if column == NAME else 12)
    bench.qtbot.mouseClick(
        tree.viewport(), Qt.MouseButton.LeftButton, modifiers or Qt.KeyboardModifier.NoModifier,
        QPoint(x, rect.center().y()),
    )  # fmt: skip


def choose_both(bench: Bench) -> None:
    click(bench, "roof")
    click(bench, "front", modifiers=CTRL)
    assert bench.panels.tree.chosen == ("roof", "front")


# ---------------------------------------------------------------------- all of them
def test_all_that_the_window_is_made_of_stands_in_it(bench: Bench) -> None:
    makers = [bench.window, *bench.window.findChildren(QWidget), *vars(bench.features).values()]
    made = [
        (f"{type(maker).__name__}.{name}", part)
        for maker in makers
        for name, value in vars(maker).items()
        for part in (value.values() if isinstance(value, dict) else [value])
        if isinstance(part, QWidget) and not isinstance(part, QMenu | QMainWindow)
    ]
    assert len(made) > 100 and [name for name, part in made if part.parentWidget() is None] == []


def test_boxes_of_numbers_say_their_unit(bench: Bench) -> None:
    boxes = [*bench.window.findChildren(QSpinBox), *bench.window.findChildren(QDoubleSpinBox)]
    assert {box.objectName() for box in boxes if not box.suffix()} == {"frame", "frame_number"}


# ---------------------------------------------------------------------- several at once
def test_several_sensors_are_deleted_as_one_step(bench: Bench) -> None:
    choose_both(bench)
    bench.qtbot.keyClick(bench.window, Qt.Key.Key_Delete)
    assert bench.document.rig.sensors == ()
    assert bench.document.undo_label == "delete 2 sensors"
    bench.act("undo")
    assert bench.document.rig == RIG


def test_a_tick_on_one_of_several_switches_all_of_them_as_one_step(bench: Bench) -> None:
    choose_both(bench)
    tree = bench.panels.tree
    rect = tree.visualItemRect(tree._items["roof"])
    tick = QPoint(rect.left() + 10, rect.center().y())
    bench.qtbot.mouseClick(tree.viewport(), Qt.MouseButton.LeftButton, pos=tick)
    assert not any(sensor.enabled for sensor in bench.document.rig.sensors)
    bench.act("undo")
    assert bench.document.rig == RIG


def test_an_eye_of_one_of_several_hides_all_of_them(bench: Bench) -> None:
    choose_both(bench)
    click(bench, "front", EYE)
    assert bench.document.hidden == {"roof", "front"}


def test_the_one_to_edit_stays_among_several_when_it_changes(bench: Bench) -> None:
    choose_both(bench)
    assert bench.document.selected == "front"
    bench.type("x", "1.2 + 0.05")
    assert bench.document.rig.sensor("front").position[0] == 1.25
    assert bench.panels.tree.chosen == ("roof", "front")


def test_what_is_taken_out_of_the_list_makes_the_one_before_it_current(bench: Bench) -> None:
    bench.document.duplicate(("roof",))
    click(bench, "front")
    for name in ("roof_2", "roof", "roof"):
        click(bench, name, modifiers=CTRL)
    assert bench.document.selection == ("front", "roof_2")


def test_all_of_a_kind_are_selected_by_the_context_menu(bench: Bench) -> None:
    bench.document.duplicate(("front",))
    menu = bench.panels.tree.context_menu()
    next(action for action in menu.actions() if action.text() == "Select all cameras").trigger()
    assert bench.panels.tree.chosen == ("front", "front_2")
    names = [action.text() for action in bench.panels.tree.context_menu().actions()]
    assert {"Enabled", "Hidden", "Locked", "Rename", "Duplicate", "Delete"} <= set(names)


# ---------------------------------------------------------------------- locks
def test_a_locked_sensor_cannot_be_edited_deleted_or_switched_off(bench: Bench) -> None:
    click(bench, "roof")
    click(bench, "roof", LOCK)
    assert bench.document.locked == {"roof"}
    assert not bench.find("x").isEnabled()
    changing = ("align_centre", "cut", "delete", "enable", "place", "rename")
    assert not any(bench.workbench.actions[key].isEnabled() for key in changing)
    assert all(bench.workbench.actions[key].isEnabled() for key in ("copy", "duplicate", "hide", "lock"))
    bench.qtbot.keyClick(bench.window, Qt.Key.Key_Delete)
    bench.qtbot.keyClick(bench.window, Qt.Key.Key_E, CTRL)
    assert bench.document.rig == RIG


def test_every_disabled_action_says_what_is_in_the_way(bench: Bench) -> None:
    document, actions = bench.document, bench.workbench.actions
    names = tuple(sensor.name for sensor in document.rig.sensors)
    tips = {spec.key: actions[spec.key].toolTip().partition("\n")[0] for spec in actions.specs}
    for chosen in ((), names[:1], names[:2]):
        document.choose(chosen)
        for locked in (False, True):
            document.set_locked(names, locked)
            disabled = [key for key in tips if not actions[key].isEnabled()]
            assert disabled
            for key in tips:
                first, _, obstacle = actions[key].toolTip().partition("\n")
                assert first == tips[key] and obstacle.endswith(".") == (key in disabled), (key, obstacle)
            if locked and chosen:
                assert f"{names[0]} is locked" in actions["place"].toolTip()


def test_a_locked_sensor_stays_where_it_is_when_it_is_dragged(bench: Bench) -> None:
    click(bench, "roof", LOCK)
    bench.drag("roof", (3.0, 0.0, 1.0))
    assert bench.document.rig == RIG
    assert "locked" in bench.workbench.errors.message
    assert bench.viewport.dragged is None


def test_an_unlocked_sensor_can_be_edited_again(bench: Bench) -> None:
    click(bench, "roof")
    bench.qtbot.keyClick(bench.window, Qt.Key.Key_L, CTRL)
    bench.qtbot.keyClick(bench.window, Qt.Key.Key_L, CTRL)
    bench.type("x", "2")
    assert bench.document.rig.sensor("roof").position[0] == 2.0


# ---------------------------------------------------------------------- library
def test_the_library_is_searched_by_words_of_name_figures_and_source(bench: Bench) -> None:
    library = bench.features.library.list
    search = library.findChild(QLineEdit, "library_search")
    assert search is not None
    bench.qtbot.keyClicks(search, "ultra velodyne 32")
    assert library.shown == ["velodyne-vlp-32c"]
    lidars, cameras = (library.models.topLevelItem(place) for place in range(2))
    assert " 1 of " in lidars.text(0) and cameras.isHidden()
    search.clear()
    assert "generic-16" in library.shown


def test_a_model_tells_figures_and_source_where_the_mouse_rests(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    shown: list[str] = []
    monkeypatch.setattr(QToolTip, "showText", lambda place, text, *rest: shown.append(text))
    library = bench.features.library.list
    row, view = library.row_of("velodyne-vlp-32c"), library.models.viewport()
    for item in (library.models.topLevelItem(0), row):
        library.models.scrollToItem(item)
        place = library.models.visualItemRect(item).center()
        QApplication.sendEvent(view, QHelpEvent(QEvent.Type.ToolTip, place, view.mapToGlobal(place)))
    assert len(shown) == 1 and all(
        text in shown[0] for text in ("(velodyne-vlp-32c)", "32 beams", "VeloView")
    )


def test_a_model_is_dragged_as_its_name(bench: Bench) -> None:
    models = bench.features.library.list.models
    data = models.mimeData([bench.features.library.list.row_of("generic-16")])
    assert data.data(MODEL_MIME).data() == b"generic-16"
    assert models.dragEnabled()


def test_a_double_click_in_the_library_adds_the_model_above_the_roof(bench: Bench) -> None:
    library = bench.features.library.list
    row = library.row_of("hesai-xt32")
    library.models.scrollToItem(row)
    place = library.models.visualItemRect(row).center()
    for press in (bench.qtbot.mouseClick, bench.qtbot.mouseDClick):
        press(library.models.viewport(), Qt.MouseButton.LeftButton, pos=place)
    added = bench.document.selected_sensor()
    assert added is not None
    assert added.model == "hesai-xt32"
    assert added.position[2] > bench.document.rig.vehicle.height


def test_return_in_the_library_adds_the_model_too(bench: Bench) -> None:
    library = bench.features.library.list
    library.models.setCurrentItem(library.row_of("generic-16"))
    bench.qtbot.keyClick(library.models, Qt.Key.Key_Return)
    added = bench.document.selected_sensor()
    assert added is not None
    assert added.model == "generic-16"


def test_what_files_say_is_never_read_as_html(whole: Bench) -> None:
    whole.document.rename("roof", "<h1>roof</h1>")
    whole.session.pin(RIG.replace(name="<img src='x'>"))
    whole.settle()
    assert "&lt;h1&gt;roof" in whole.panels.tree._items["<h1>roof</h1>"].toolTip(NAME)
    table = whole.panels.scores.table
    place = table.figures.index(CLASSES_AND_ALL.index("car"), table.place_of("s_ms change"))
    assert "&lt;img" in place.data(Qt.ItemDataRole.ToolTipRole)


def test_no_remark_is_read_as_html_by_chance(bench: Bench) -> None:
    labels = [x for x in bench.window.findChildren(QLabel) if x.objectName() in ("hint", "problem")]
    assert len(labels) >= 5
    by_chance = {label.text() for label in labels if label.textFormat() != Qt.TextFormat.PlainText}
    assert by_chance <= {"10³ nat"}  # captions that never change


def test_tooltips_of_names_and_files_are_plain(whole: Bench, tmp_path: Path) -> None:
    whole.document.rename("roof", "<b>x")
    whole.document.select("<b>x")
    whole.settle()
    tips = [widget.toolTip() for widget in whole.window.findChildren(QWidget)]
    assert any("&lt;b&gt;x" in tip for tip in tips)
    assert not any("<b>x" in tip for tip in tips)


# ---------------------------------------------------------------------- pose
def tool(bench: Bench, name: str) -> QToolButton:
    tools = bench.panels.inspector.form.findChild(PoseTools)
    assert tools is not None
    button = tools.findChild(QToolButton, name)
    assert button is not None
    return button


def test_a_pose_is_copied_from_one_sensor_and_pasted_into_another(bench: Bench) -> None:
    bench.document.select("roof")
    tool(bench, "copy_pose").click()
    assert QGuiApplication.clipboard().text() == "position: [0.1, 0.2, 1.9]\nrpy_deg: [0.0, 0.0, 0.0]\n"
    bench.document.select("front")
    tool(bench, "paste_pose").click()
    assert bench.document.rig.sensor("front").pose == LIDAR.pose
    assert bench.document.undo_label == "move front"


def test_a_text_that_is_no_pose_changes_nothing_and_says_why(bench: Bench) -> None:
    bench.document.select("roof")
    QGuiApplication.clipboard().setText("hello")
    tool(bench, "paste_pose").click()
    assert bench.document.rig == RIG
    assert "hello" in bench.panels.inspector.form.problem


def test_a_pose_goes_back_to_the_last_saved_one(bench: Bench) -> None:
    bench.document.select("roof")
    bench.type("yaw", "30")
    menu = tool(bench, "reset_pose").menu()
    assert menu is not None
    next(action for action in menu.actions() if action.text() == "Last saved pose").trigger()
    assert bench.document.rig == RIG


def test_units_change_what_is_shown_and_nothing_else(bench: Bench) -> None:
    bench.document.select("roof")
    tool(bench, "unit_length").click()
    tool(bench, "unit_angle").click()
    assert bench.find("x").property("text") == "100"
    bench.type("yaw", "pi/2")
    bench.type("y", "250")
    assert bench.document.rig.sensor("roof").rpy_deg[2] == pytest.approx(90.0)
    assert bench.document.rig.sensor("roof").position[1] == 0.25
    bench.document.select("front")
    assert bench.find("x").property("text") == "1000"


def test_panels_take_the_colours_of_another_theme(whole: Bench) -> None:
    whole.document.select("roof")
    wait_for_losses(whole, 2)
    whole.features.marginals.choose("s_ms")
    before = whole.panels.tree._items["front"].foreground(NAME).color()
    try:
        whole.act("theme_dark")
        assert whole.panels.tree._items["front"].foreground(NAME).color() != before
        assert whole.panels.tree._items["front"].text(LOSS) != ""
        assert whole.panels.tree.chosen == ("roof",)
    finally:
        whole.act("theme_light")


# ---------------------------------------------------------------------- baseline
def test_changes_count_from_the_pinned_rig_until_it_is_let_go(whole: Bench, tmp_path: Path) -> None:
    whole.document.set_enabled(("front",), False)
    whole.settle()
    whole.act("pin")
    whole.settle()
    assert whole.shown("car", "s_ms change") == "—"
    assert whole.features.compare.rows[-1].rig is whole.session.baseline, "a snapshot, and nothing else"
    assert "small" in whole.panels.scores.note
    whole.dialogs.path = tmp_path / "rig.yaml"
    whole.act("undo")
    whole.settle()
    assert whole.shown("car", "s_ms change").startswith("−")
    whole.act("unpin")
    whole.settle()
    assert whole.shown("car", "s_ms change") == "—"
    assert "last saved" in whole.panels.scores.note


def test_any_rig_of_the_compare_panel_can_be_the_baseline(whole: Bench, tmp_path: Path) -> None:
    whole.dialogs.path = tmp_path / "empty.yaml"
    new_rig_file(RIG.replace(sensors=(), name="bare car")).save(whole.dialogs.path)
    whole.act("compare_file")
    whole.features.compare.panel.table.pin_wanted.emit(whole.features.compare.rows[-1].key)
    whole.settle()
    now = whole.fresh_scores(RIG).classes["car"].s_ms
    assert whole.shown("car", "s_ms change") == change_text(S_MS, now)
    assert "bare car" in whole.panels.scores.note
    whole.act("unpin")
    whole.settle()
    assert whole.shown("car", "s_ms change") == "—"


# ---------------------------------------------------------------------- what a sensor is worth
def wait_for_losses(bench: Bench, count: int) -> None:
    bench.qtbot.waitUntil(lambda: len(bench.features.marginals.losses) == count, timeout=TIMEOUT_MS)


def test_the_loss_without_a_sensor_is_exact(whole: Bench) -> None:
    whole.document.select("roof")
    wait_for_losses(whole, 2)
    now = whole.fresh_scores(RIG)
    found = whole.features.marginals.losses
    for name in ("roof", "front"):
        assert found[name] == whole.fresh_scores(without(RIG, (name,)))
    view = whole.panels.inspector.form.marginal  # type: ignore[attr-defined]
    lost = found["roof"].classes["car"].s_ms - now.classes["car"].s_ms
    assert lost > 0
    assert view.text_of("car", "s_ms") == change_text(S_MS, lost)
    whole.features.marginals.choose("s_ms")
    assert whole.panels.tree._items["front"].text(LOSS) != ""


def test_losses_follow_edits_and_a_sensor_that_does_not_count_has_none(whole: Bench) -> None:
    wait_for_losses(whole, 2)
    whole.document.set_enabled(("roof",), False)
    assert whole.features.marginals.losses == {}
    whole.settle()
    wait_for_losses(whole, 1)
    alone = RIG.replace(sensors=(LIDAR.replace(enabled=False), CAMERA))
    assert whole.features.marginals.losses["front"] == whole.fresh_scores(without(alone, ("front",)))
    whole.document.select("roof")
    view = whole.panels.inspector.form.marginal  # type: ignore[attr-defined]
    assert view.note == NOT_COUNTED
    assert whole.panels.tree._items["roof"].text(LOSS) == ""


def test_nothing_is_computed_aside_while_the_mouse_is_down(
    whole: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    wait_for_losses(whole, 2)
    whole.viewport.press("roof")
    whole.viewport.drag_to("roof", Pose((3.0, 0.2, 1.0)))
    whole.settle()
    assert whole.features.marginals.result is None
    whole.viewport.release("roof")
    wait_for_losses(whole, 2)
    whole.document.select("roof")
    assert whole.panels.inspector.form.marginal.note != WAITING  # type: ignore[attr-defined]


def test_a_panel_among_tabs_is_named_by_its_tab_alone_and_gets_its_title_back_when_it_stands_alone(
    bench: Bench,
) -> None:
    scores, compare, tree = (bench.workbench.docks[name] for name in ("Scores", "Compare", "Sensors"))
    bench.qtbot.waitUntil(lambda: scores.titleBarWidget() is not None, timeout=TIMEOUT_MS)
    assert compare.titleBarWidget() is not None
    assert tree.titleBarWidget() is None
    for beside in (compare, *(bench.workbench.docks[name] for name in ("Targets", "Checks", "Propose"))):
        beside.toggleViewAction().trigger()
    bench.qtbot.waitUntil(lambda: scores.titleBarWidget() is None, timeout=TIMEOUT_MS)
    compare.toggleViewAction().trigger()
    bench.qtbot.waitUntil(lambda: scores.titleBarWidget() is not None, timeout=TIMEOUT_MS)


def one_way_boxes(folder: Path) -> Path:
    """Labels as those of a front camera: cars within 40 degrees ahead."""
    rows = [
        f"s,{frame},car,{7 + frame % 3},{0.1 * (frame - 30):.2f},0.8,1.5,1.0,1.6,0" for frame in range(60)
    ]
    path = folder / "ahead.csv"
    path.write_text(
        "\n".join(["seq,frame,cls,x,y,z,length,width,height,yaw", *rows]) + "\n", encoding="utf-8"
    )
    return path


def test_a_sensor_that_looks_where_the_data_hold_no_boxes_is_told_not_scored_as_nothing(
    qtbot: QtBot, tmp_path: Path
) -> None:
    rear = CAMERA.replace(name="rear", position=(-1.0, 0.0, 1.4), rpy_deg=(0.0, 0.0, 180.0), hfov_deg=60.0)
    rig = RIG.replace(sensors=(*RIG.sensors, rear))
    with open_bench(qtbot, tmp_path, rig=rig, boxes=one_way_boxes(tmp_path)) as bench:
        wait_for_losses(bench, 3)
        bench.features.marginals.choose("s_ms")
        assert "boxes only ahead" in bench.workbench.status.scene.text()
        row = bench.panels.tree._items["rear"]
        assert row.text(LOSS) == NONE and "almost no boxes in this direction" in row.toolTip(LOSS)
        assert bench.panels.tree._items["front"].text(LOSS) != NONE
        bench.document.select("rear")
        assert bench.panels.inspector.form.marginal.note == NO_BOXES  # type: ignore[attr-defined]
        bench.document.select("front")
        assert bench.panels.inspector.form.marginal.note != NO_BOXES  # type: ignore[attr-defined]
        picture = bench.features.map.panel.map
        picture.resize(400, 400)
        picture._hover = picture.plane.to_px(-6.0, 0.0)
        bench.document.select(None)
        bench.workbench.docks.bring_up("Map")
        bench.settle()
        assert NO_BOXES in picture.readout()
