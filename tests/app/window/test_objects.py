"""Checks > Test objects: verdicts of the commands, kept up to date while in sight; a click looks at an object."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtCore import QCoreApplication, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QTreeWidget, QTreeWidgetItem
from pytestqt.qtbot import QtBot

from riglens.app.background.rig_questions import object_verdicts
from riglens.app.background.worker import BackgroundWorker
from riglens.app.window.features.objects import Objects
from riglens.core.review.profiles import bundled_profiles
from riglens.core.review.verdicts import ProfileVerdict, verdicts
from riglens.widgets.panels.checks.panel import COMPUTING
from riglens.widgets.viewport.scene_state import Post
from tests.app.window.desk import Desk, open_desk
from tests.waiting import TIMEOUT_S


@pytest.fixture
def desk(qtbot: QtBot) -> Desk:
    return open_desk(qtbot)


@pytest.fixture
def objects(desk: Desk) -> Iterator[Objects]:
    made = Objects(desk.workbench, BackgroundWorker("test objects", object_verdicts, close_s=TIMEOUT_S))
    yield made
    made._worker.close()


def settle(objects: Objects) -> None:
    assert objects._worker.wait_until_idle(TIMEOUT_S)
    QCoreApplication.processEvents()


def expected(desk: Desk) -> tuple[ProfileVerdict, ...]:
    return verdicts(desk.session.rig, bundled_profiles(), desk.session.body)


def shown(objects: Objects) -> list[tuple[str, str]]:
    tree = objects.page.tree
    items = [tree.topLevelItem(number) for number in range(tree.topLevelItemCount())]
    return [(item.text(0), item.text(1)) for item in items]


def test_the_list_says_what_the_command_says_and_follows_an_edit_while_in_sight(
    desk: Desk, objects: Objects
) -> None:
    waiting = objects.page.tree.topLevelItem(0)
    assert waiting is not None and waiting.text(0) == COMPUTING
    desk.open_page("test_objects", objects)
    settle(objects)
    assert objects.page.isVisible()

    def told() -> list[tuple[str, str]]:
        return [
            (v.profile.title, f"{len(v.objects) - len(v.failed)} of {len(v.objects)}") for v in expected(desk)
        ]

    first = told()
    assert shown(objects) == first and "type approval" in objects.page.note.text()
    low = desk.document.rig.sensor("roof").replace(position=(0.0, 0.0, 6.0))
    desk.document.apply(desk.document.rig.with_sensor("roof", low))
    settle(objects)
    assert shown(objects) == told() != first
    desk.put_away(objects)
    desk.document.undo()
    settle(objects)
    assert shown(objects) != first
    desk.open_page("test_objects", objects)
    settle(objects)
    assert shown(objects) == first


def click(tree: QTreeWidget, item: QTreeWidgetItem) -> None:
    tree.scrollToItem(item)
    QTest.mouseClick(tree.viewport(), Qt.MouseButton.LeftButton, pos=tree.visualItemRect(item).center())


def test_a_click_on_an_object_goes_there_and_what_is_open_stays_open(desk: Desk, objects: Objects) -> None:
    """Seen from the side on which it stands, not from far, and pointed out in the colour of its verdict until the
    list is put away."""
    desk.open_page("test_objects", objects)
    settle(objects)
    tree, one = objects.page.tree, expected(desk)[-2].objects[3]
    group = tree.topLevelItem(tree.topLevelItemCount() - 2)
    group.setExpanded(True)
    child = group.child(3)
    far = replace(desk.viewport.state.camera, distance_m=80.0, elevation_deg=90.0, azimuth_deg=0.0)
    desk.viewport.show_state(replace(desk.viewport.state, camera=far))
    click(tree, child)
    x, y = one.target.x_m, one.target.y_m
    camera, post = desk.viewport.state.camera, desk.viewport.state.post
    assert camera.focal_m == (x, y, one.target.height_m / 2) and camera.distance_m <= 9.0
    away = camera.position_m()[:2] - (x, y)
    assert np.dot(away, (x, y)) == pytest.approx(np.linalg.norm(away) * np.hypot(x, y))
    assert camera.position_m()[2] > one.target.height_m
    assert post == Post(x, y, one.target.radius_m, one.target.height_m, one.is_seen)
    assert child.text(2) == f"{one.rays:,}" and child.text(0) == one.target.name
    click(tree, group)
    assert desk.viewport.state.post == post
    objects.page.show_verdicts(expected(desk))
    assert group.isExpanded() and tree.topLevelItem(tree.topLevelItemCount() - 2) is group
    for sensor in desk.document.rig.sensors:
        desk.document.apply(desk.document.rig.with_sensor(sensor.name, sensor.replace(enabled=False)))
    settle(objects)
    assert desk.viewport.state.post == replace(post, is_seen=False)
    desk.put_away(objects)
    assert desk.viewport.state.post is None


def test_a_bar_fills_while_objects_are_checked_and_keeps_its_room(desk: Desk, objects: Objects) -> None:
    desk.open_page("test_objects", objects)
    settle(objects)
    bar, tree = objects.page.bar, objects.page.tree
    top, shares = tree.mapTo(objects.page, tree.rect().topLeft()), list[float]()
    assert not bar.isVisible()
    objects._worker.progressed.connect(lambda _, share: shares.append(share))
    objects._worker.progressed.emit(None, 0.5)
    QCoreApplication.processEvents()
    assert bar.isVisible() and bar.value() == bar.maximum() // 2
    assert tree.mapTo(objects.page, tree.rect().topLeft()) == top
    desk.document.set_enabled(("roof",), False)
    settle(objects)
    assert not bar.isVisible() and shares[-1] == 1.0 and shares == sorted(shares[:1]) + sorted(shares[1:])
