"""Study > Test objects: verdicts of the commands, kept up to date while in sight; a click looks at an object."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from PySide6.QtCore import QCoreApplication
from pytestqt.qtbot import QtBot

from riglens.app.background.onlooking import ObjectsJudge
from riglens.app.window.features.objects import Objects
from riglens.core.review.profiles import bundled_profiles
from riglens.core.review.verdicts import ProfileVerdict, verdicts
from tests.app.window.desk import Desk, open_desk
from tests.waiting import TIMEOUT_S


@pytest.fixture
def desk(qtbot: QtBot) -> Desk:
    return open_desk(qtbot)


@pytest.fixture
def objects(desk: Desk) -> Iterator[Objects]:
    made = Objects(desk.workbench, ObjectsJudge(close_s=TIMEOUT_S))
    yield made
    made.judge.close()


def settle(objects: Objects) -> None:
    assert objects.judge.wait_until_idle(TIMEOUT_S)
    QCoreApplication.processEvents()


def expected(desk: Desk) -> tuple[ProfileVerdict, ...]:
    return verdicts(desk.document.rig, bundled_profiles(), desk.session.body, desk.session.mesh)


def shown(objects: Objects) -> list[tuple[str, str]]:
    assert objects.dialog is not None
    tree = objects.dialog.tree
    items = [tree.topLevelItem(number) for number in range(tree.topLevelItemCount())]
    return [(item.text(0), item.text(1)) for item in items]


def test_the_list_says_what_the_command_says_and_follows_an_edit_while_in_sight(
    desk: Desk, objects: Objects
) -> None:
    desk.workbench.actions["test_objects"].trigger()
    settle(objects)
    assert objects.dialog is not None and objects.dialog.isVisible()

    def told() -> list[tuple[str, str]]:
        return [
            (v.profile.title, f"{len(v.objects) - len(v.failed)} of {len(v.objects)}") for v in expected(desk)
        ]

    first = told()
    assert shown(objects) == first and "no approval" in objects.dialog.note.text()
    low = desk.document.rig.sensor("roof").replace(position=(0.0, 0.0, 6.0))
    desk.document.apply(desk.document.rig.with_sensor("roof", low))
    settle(objects)
    assert shown(objects) == told() != first
    objects.dialog.close()
    desk.document.undo()
    settle(objects)
    assert shown(objects) != first
    desk.workbench.actions["test_objects"].trigger()
    settle(objects)
    assert shown(objects) == first


def test_a_click_on_an_object_looks_at_it_and_what_is_open_stays_open(desk: Desk, objects: Objects) -> None:
    objects.open()
    settle(objects)
    assert objects.dialog is not None
    tree, one = objects.dialog.tree, expected(desk)[-2].objects[3]
    group = tree.topLevelItem(tree.topLevelItemCount() - 2)
    group.setExpanded(True)
    child = group.child(3)
    tree.itemClicked.emit(child, 0)
    assert desk.viewport.told[-1] == ("look", one.target.x_m, one.target.y_m)
    assert child.text(2) == f"{one.rays:,}" and child.text(0) == one.target.name
    tree.itemClicked.emit(group, 0)
    assert [told[0] for told in desk.viewport.told].count("look") == 1
    objects.dialog.show_verdicts(expected(desk))
    assert group.isExpanded() and tree.topLevelItem(tree.topLevelItemCount() - 2) is group
