"""The rig without each sensor is counted, too: in the list by choice, and in the inspector."""

from __future__ import annotations

from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest

from riglens.app.background.counting import OtherCount
from riglens.app.window.features.marginals import Marginals
from riglens.core.figures.figure import ALL
from riglens.core.figures.hits import SHARE_5
from riglens.core.figures.registry import leading_figures
from riglens.core.figures.values import Values, values_of_objects
from riglens.widgets.panels.controls.style import style_sheet, tones
from riglens.widgets.panels.sensors.losses import changed, measures
from riglens.widgets.panels.sensors.rows import LOSS
from tests.app.window.counts import ENGINE, count
from tests.app.window.desk import FullDesk, scores


def counted(request: OtherCount) -> Values:
    return values_of_objects(ENGINE.evaluate(request.rig, request.settings))


def marginals(desk: FullDesk) -> Marginals:
    return desk.features.marginals


def asked(desk: FullDesk) -> list[OtherCount]:
    return [request for request in desk.counter.others if request.group == "marginal"]


def test_the_rig_without_each_sensor_is_counted_once_all_frames_are(desk: FullDesk) -> None:
    count(desk, 3)
    assert asked(desk) == []
    count(desk)
    assert [request.name for request in asked(desk)] == ["roof", "front"]
    roof = asked(desk)[0]
    assert [sensor.enabled for sensor in roof.rig.sensors] == [False, True]
    count(desk)
    assert len(asked(desk)) == 2
    marginals(desk)._take_count(roof, counted(roof))
    assert set(marginals(desk).figures) == {"roof"}
    desk.document.begin_drag(("roof",))
    desk.document.preview({"roof": desk.document.rig.sensor("front").pose})
    assert asked(desk) == [] and marginals(desk).figures == {}


def test_the_list_shows_the_loss_in_the_measure_that_is_chosen(desk: FullDesk) -> None:
    count(desk)
    roof = asked(desk)[0]
    marginals(desk)._take_count(roof, counted(roof))
    row = desk.panels.tree._items["roof"]
    marginals(desk).choose("share_5")
    assert "At least 5 points" in row.toolTip(LOSS)
    marginals(desk).choose("s_ms")
    assert row.text(LOSS) == row.toolTip(LOSS) == ""  # S-MS is not known yet
    marginals(desk).choose("share_5")
    lost = changed(SHARE_5, ALL, desk.features.targets.answer.figures, counted(roof))
    assert lost is not None and lost.value < 0 and row.text(LOSS) == f"{-100 * lost.value:.1f}"
    assert "At least 5 points" in desk.panels.tree.headerItem().toolTip(
        LOSS
    ) and "car: Predicted AP" in row.toolTip(LOSS)
    marginals(desk)._take(desk.recompute.others[0], scores(0.25))
    marginals(desk).choose("s_ms")
    assert row.text(LOSS) == "0.08↑" and desk.panels.tree.headerItem().text(LOSS) == "10³ nat ▾"
    marginals(desk).keep(desk.workbench.kept)
    assert desk.workbench.kept.read("list/loss", "") == "s_ms"


def test_the_heading_of_losses_is_not_cut(desk: FullDesk) -> None:
    desk.panels.tree.setStyleSheet(style_sheet(tones()))
    header = desk.panels.tree.header()
    for measure in measures():
        marginals(desk).choose(measure)
        assert header.sectionSizeHint(LOSS) <= header.sectionSize(LOSS)


def test_the_inspector_shows_road_users_before_scores_are_there(desk: FullDesk) -> None:
    desk.document.select("roof")
    count(desk)
    marginals(desk)._take_count(asked(desk)[0], counted(asked(desk)[0]))
    view = desk.panels.inspector.form.marginal  # type: ignore[attr-defined]
    shown = view.text_of("car", "predicted")
    assert shown not in ("…", "—")
    assert "objects, now" in view._cells["car", "predicted"].toolTip()
    assert view.text_of("car", "s_ms") == "…"
    desk.document.begin_drag(("roof",))
    desk.document.preview({"roof": desk.document.rig.sensor("front").pose})
    assert view.text_of("car", "predicted") == shown  # the figures of before stay, greyed


def test_what_belongs_to_another_rig_is_not_shown(desk: FullDesk) -> None:
    count(desk)
    old = asked(desk)[0]
    desk.drag("roof", (0.3, 0.0, 2.0))
    count(desk)
    marginals(desk)._take_count(old, counted(old))
    assert marginals(desk).figures == {}


def test_a_click_on_the_title_of_the_losses_offers_the_measures(desk: FullDesk) -> None:
    places: list[QPoint] = []
    tree = desk.panels.tree
    tree.measure_menu_wanted.disconnect()
    tree.measure_menu_wanted.connect(places.append)
    tree.resize(340, 300)
    tree.show()
    header = tree.header()
    for column in (0, LOSS):
        x = header.sectionViewportPosition(column) + header.sectionSize(column) // 2
        QTest.mouseClick(header.viewport(), Qt.MouseButton.LeftButton, pos=QPoint(x, header.height() // 2))
    assert len(places) == 1
    menu = marginals(desk).measure_menu()
    titles = [one.title for one in leading_figures()]
    assert [action.text() for action in menu.actions()] == [f"Loss in {title}" for title in titles]
    checked = [action.text() for action in menu.actions() if action.isChecked()]
    assert checked == [f"Loss in {marginals(desk).measure.title}"]
    menu.actions()[1].trigger()
    assert marginals(desk).measure == leading_figures()[1]
