"""Checks > Mounts: the lines of `riglens check`, kept up to date while in sight, against limits of the user's own."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from PySide6.QtCore import QCoreApplication
from pytestqt.qtbot import QtBot

from riglens.app.background.rig_questions import mount_violations
from riglens.app.background.worker import BackgroundWorker
from riglens.app.window.features.mounts import Mounts
from riglens.core.review.mounts import USUAL_LIMITS, violations
from riglens.core.review.requirements import read_requirements
from riglens.widgets.panels.checks.panel import COMPUTING
from tests.app.window.desk import Desk, open_desk
from tests.waiting import TIMEOUT_S

REQUIRED = "riglens_requirements: 1\nmounts: {height_m: [2.5, 3.0], spacing_m: 5.0, keep_out: []}\n"


@pytest.fixture
def desk(qtbot: QtBot) -> Desk:
    return open_desk(qtbot)


@pytest.fixture
def mounts(desk: Desk) -> Iterator[Mounts]:
    made = Mounts(desk.workbench, BackgroundWorker("mounts", mount_violations, close_s=TIMEOUT_S))
    yield made
    made._worker.close()


def lines(mounts: Mounts) -> list[str]:
    assert mounts._worker.wait_until_idle(TIMEOUT_S)
    QCoreApplication.processEvents()
    return [mounts.page.lines.item(place).text() for place in range(mounts.page.lines.count())]


def test_the_lines_are_those_of_the_command_and_follow_a_drag_while_in_sight(
    desk: Desk, mounts: Mounts
) -> None:
    assert mounts.page.head.text() == COMPUTING
    desk.open_page("mounts", mounts)
    wanted = [f"{one.sensor}: {one.text}" for one in violations(desk.document.rig, USUAL_LIMITS)]
    assert lines(mounts) == wanted and any("roof: " in line and "over the skin" in line for line in wanted)
    assert mounts.page.head.text() == f"{len(wanted)} violations"
    desk.viewport.press("roof")
    desk.document.begin_drag(("roof",))
    desk.document.preview({"roof": desk.document.rig.sensor("roof").pose.__class__((0.1, 0.2, 0.9))})
    assert any("roof: " in line and "inside the body" in line for line in lines(mounts))
    desk.document.cancel_drag()
    assert lines(mounts) == wanted
    desk.put_away(mounts)
    desk.document.apply(desk.document.rig.replace(sensors=()))
    assert lines(mounts) == wanted  # nobody looks
    desk.open_page("mounts", mounts)
    assert lines(mounts) == [] and "Every mount" in mounts.page.head.text()


def test_limits_of_a_file_take_the_place_of_the_usual_ones_and_a_click_selects(
    desk: Desk, mounts: Mounts, tmp_path: Path
) -> None:
    desk.open_page("mounts", mounts)
    usual, page = lines(mounts), mounts.page
    desk.dialogs.path = tmp_path / "required.yaml"
    desk.dialogs.path.write_text(
        "riglens_requirements: 1\nblind_areas: [{height_m: 0.3, at_most_m2: 0}]\n", encoding="utf-8"
    )
    page.file.click()
    assert "'mounts'" in desk.workbench.errors.message and lines(mounts) == usual
    desk.dialogs.path.write_text(REQUIRED, encoding="utf-8")
    page.file.click()
    limits = read_requirements(desk.dialogs.path).mounts
    assert limits is not None
    assert lines(mounts) == [f"{one.sensor}: {one.text}" for one in violations(desk.document.rig, limits)]
    assert "height over the ground" in lines(mounts)[0] and "1.900 m" in lines(mounts)[0]
    assert page.source.text() == "Checked against: required.yaml"
    page.chosen.emit(page.lines.item(0).data(256))
    assert desk.document.selected == "roof"
    page.chosen.emit("car")
    assert desk.document.selected == "roof"
    page.usual.click()
    assert lines(mounts) == usual
