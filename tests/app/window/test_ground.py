"""View > Ground: blind areas and overlap lie on the ground, follow answers, are asked for only then, and are kept."""

from __future__ import annotations

import numpy as np
import pytest
from pytestqt.qtbot import QtBot

from riglens.app.evaluation.ground_map import OVERLAP_HEIGHT_M
from riglens.app.window.settings import Settings
from riglens.core.review.blind import BlindEngine, BlindMap, BlindSettings
from riglens.core.rig.model import Rig
from riglens.widgets.viewport.ground_map import NOTHING
from tests.app.window.desk import FullDesk, full_desk

COARSE = BlindSettings(0.5, within_m=5.0)


def found_of(rig: Rig) -> BlindMap:
    return BlindEngine(rig.vehicle, COARSE, threads=1).evaluate(rig)


def test_nothing_is_asked_for_while_nothing_lies_on_the_ground(desk: FullDesk) -> None:
    assert not desk.recompute.requests[-1].blind and desk.viewport.state.ground_map is None
    assert desk.workbench.actions["ground_none"].isChecked()
    desk.workbench.actions["ground_blind"].trigger()
    assert desk.recompute.requests[-1].blind and desk.viewport.state.ground_map is None
    count = len(desk.recompute.requests)
    desk.workbench.actions["ground_none"].trigger()
    assert len(desk.recompute.requests) == count and not desk.session.request().blind


@pytest.mark.parametrize("mode", ["blind", "overlap"])
def test_what_lies_on_the_ground_is_that_of_the_answer_and_follows_it(desk: FullDesk, mode: str) -> None:
    desk.workbench.actions[f"ground_{mode}"].trigger()
    for place in ((0.0, 0.0, 2.0), (1.0, 0.5, 3.0)):
        desk.drag("roof", place)
        found = found_of(desk.document.rig)
        desk.answer(blind=found)
        shown = desk.viewport.state.ground_map
        assert shown is not None
        counted = sum((found.lowest_m("any", k) <= OVERLAP_HEIGHT_M + 1e-9).astype(int) for k in (1, 2, 3))
        wanted = found.steps() if mode == "blind" else counted
        np.testing.assert_array_equal(shown.steps, np.where(found.ground.counts, wanted, NOTHING))
        assert shown.cell_m == 0.5 and shown.steps[shown.steps != NOTHING].max() < len(shown.meanings)
        assert "is better" in shown.title
    desk.workbench.actions["ground_none"].trigger()
    assert desk.viewport.state.ground_map is None


def test_the_choice_is_kept_and_a_broken_one_is_none(qtbot: QtBot) -> None:
    kept = Settings()
    kept.write("ground/shown", "overlap")
    with full_desk(qtbot, kept=kept) as desk:
        assert desk.workbench.actions["ground_overlap"].isChecked() and desk.recompute.requests[-1].blind
        again = Settings()
        desk.features.ground.keep(again)
        assert again.read("ground/shown", "") == "overlap"
    kept.write("ground/shown", "lava")
    with full_desk(qtbot, kept=kept) as desk:
        assert desk.workbench.actions["ground_none"].isChecked()
