"""The Checks dock: a page for each check, of which only the one in sight costs anything."""

from __future__ import annotations

from riglens.core.rig.edits import with_enabled
from riglens.widgets.panels.sensors.losses import measures
from tests.app.window.desk import FullDesk, scores
from tests.waiting import TIMEOUT_MS

KEYS = ("test_objects", "mounts", "detection_range", "redundancy", "tolerances", "audit")


def test_every_check_has_a_page_that_its_action_brings_up(desk: FullDesk) -> None:
    checks = desk.panels.checks
    titles = [checks.names.item(row).text() for row in range(checks.names.count())]
    assert titles == [desk.workbench.actions[key].text() for key in KEYS]
    desk.workbench.window.show()
    for key in reversed(KEYS):
        desk.act(key)
        assert titles[checks.names.currentRow()] == desk.workbench.actions[key].text()


def test_only_the_page_in_sight_is_kept_up_to_date(desk: FullDesk) -> None:
    mounts, objects = desk.features.mounts, desk.features.objects
    asked = {"mounts": list[object](), "objects": list[object]()}
    mounts._worker.ask = asked["mounts"].append  # type: ignore[method-assign]
    objects._worker.ask = asked["objects"].append  # type: ignore[method-assign]
    desk.workbench.window.show()
    desk.document.set_enabled(("roof",), False)
    assert asked == {"mounts": [], "objects": []}
    desk.act("mounts")
    desk.qtbot.waitUntil(lambda: bool(asked["mounts"]), timeout=TIMEOUT_MS)
    desk.document.set_enabled(("roof",), True)
    assert len(asked["mounts"]) == 2 and asked["objects"] == []


def test_redundancy_lists_what_the_rig_loses_without_each_sensor(desk: FullDesk) -> None:
    feature = desk.features.marginals
    for request in list(desk.recompute.others):
        if request.rig == with_enabled(desk.document.rig, (request.name,), False):
            feature._take(request, scores(0.25 if request.name == "roof" else 0.5))
    table = feature.panel.table
    place = list(measures()).index("s_ms")
    desk.qtbot.waitUntil(lambda: table.texts_of("roof")[place] == "0.08↑", timeout=TIMEOUT_MS)
    assert table.texts_of("front")[place] == "0.00"
    table.clicked.emit(table.figures.index(0, 0))
    assert desk.document.selected == "roof"
