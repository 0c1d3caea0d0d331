"""The audit of rays: asked for by a button, six shares that add up, greyed after an edit."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PySide6.QtWidgets import QPushButton
from pytestqt.qtbot import QtBot

from riglens.app.window.features.audit import Audit
from riglens.core.engine.audit import RAY_OUTCOMES, RigAudit, audit
from riglens.core.engine.engine import Engine
from riglens.core.rig.model import Rig
from riglens.widgets.panels.checks.audit import ASKED, OUTCOMES, OUTDATED, percents
from tests.app.window.desk import Desk
from tests.app.window_bench import RIG, open_bench
from tests.core.builders import grid_of, random_field
from tests.waiting import TIMEOUT_MS

FIELD = random_field(grid_of(40, 40, 8, 0.5), np.random.default_rng(3), share=0.05)


def audited(rig: Rig) -> RigAudit:
    return audit(Engine(FIELD, 1), rig)


@pytest.fixture
def desk(followed: Desk) -> Desk:
    followed.answer()
    followed.document.select("roof")
    return followed


def press(feature: Audit) -> None:
    button = feature.panel.findChild(QPushButton, "follow_rays")
    assert button is not None
    button.click()


@given(st.lists(st.integers(0, 10**6), min_size=6, max_size=6).filter(any))
def test_shares_as_shown_add_up_to_a_hundred_percent(counts: list[int]) -> None:
    shares = {name: count / sum(counts) for name, count in zip(RAY_OUTCOMES, counts, strict=True)}
    shown = percents(shares)
    assert round(sum(shown.values()), 6) == 100.0
    assert all(abs(shown[name] - 100.0 * share) <= 0.1 + 1e-9 for name, share in shares.items())


def test_the_page_knows_what_becomes_of_every_ray() -> None:
    assert set(OUTCOMES) == set(RAY_OUTCOMES)


def test_rays_are_followed_when_asked_for_and_greyed_after_an_edit(desk: Desk) -> None:
    feature = Audit(desk.workbench)
    table = feature.panel.table
    assert desk.recompute.audits == [] and feature.panel.note == "" and table.figures.rowCount() == 0
    press(feature)
    (request,) = desk.recompute.audits
    assert request.rig == desk.document.rig and feature.panel.note == ASKED
    feature._take(request, audited(request.rig))
    for sensor in RIG.sensors:
        found = audited(request.rig).of(sensor.name)
        assert found is not None
        wanted = percents(found.shares)
        assert table.texts_of(sensor.name) == [f"{found.rays:,}", *(f"{wanted[n]:.1f} %" for n in OUTCOMES)]
    table.clicked.emit(table.figures.index(1, 0))
    assert desk.document.selected == RIG.sensors[1].name
    desk.drag("roof", (0.3, 0.0, 2.0))
    assert feature.panel.note == OUTDATED
    desk.document.undo()
    assert feature.panel.note != OUTDATED


def test_other_traffic_has_no_audit_yet(desk: Desk) -> None:
    feature = Audit(desk.workbench)
    press(feature)
    feature._take(desk.recompute.audits[0], audited(desk.document.rig))
    desk.load()
    assert feature.answer is None and feature.panel.table.figures.rowCount() == 0


def test_an_answer_to_an_earlier_request_is_not_shown(desk: Desk) -> None:
    feature = Audit(desk.workbench)
    press(feature)
    press(feature)
    first, second = desk.recompute.audits
    feature._take(first, audited(first.rig))
    assert feature.answer is None
    feature._take(second, None)
    assert feature.answer is None and feature.panel.note == ""


def test_the_thread_follows_rays_as_the_command_does(qtbot: QtBot, tmp_path: Path) -> None:
    with open_bench(qtbot, tmp_path) as bench:
        bench.document.select("roof")
        bench.features.audit.follow_rays()
        qtbot.waitUntil(lambda: bench.features.audit.answer is not None, timeout=TIMEOUT_MS)
        expected = audit(Engine(bench.scenes[-1].field, 1), RIG, bench.session.body)
        found = bench.features.audit.answer[1]
        assert [s.counts for s in found.sensors] == [s.counts for s in expected.sensors]
