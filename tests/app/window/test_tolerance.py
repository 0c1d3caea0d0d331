"""The strip of tolerances: drawn only when a profile is chosen and nobody edits, void with the next edit."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from PySide6.QtWidgets import QLabel
from pytestqt.qtbot import QtBot

from riglens.app.background.background_requests import ToleranceProgress
from riglens.app.window.features.tolerance import DRAWS, Tolerance, magnified, range_of
from riglens.core.figures.figure import Estimate
from riglens.core.review.tolerance import (
    PROFILES,
    Spread,
    ToleranceProfile,
    ToleranceRun,
    chance_bounds,
    profile_called,
)
from riglens.core.scene.boxes import CLASSES
from riglens.widgets.panels.checks.tolerance import Below, points_text, range_text
from tests.app.window.desk import FullDesk, full_desk


@pytest.fixture
def desk(qtbot: QtBot) -> Iterator[FullDesk]:
    with full_desk(qtbot) as made:
        made.load()
        made.answer()
        yield made


def feature(desk: FullDesk) -> Tolerance:
    return desk.features.tolerance


def choose(desk: FullDesk, profile: str) -> None:
    feature(desk).strip.profile_chosen.emit(profile)


def tell(desk: FullDesk, steps: int) -> ToleranceProgress:
    """Answer the last request after so many steps, with figures that tell the draws apart."""
    request = desk.recompute.tolerances[-1]
    run = ToleranceRun(request.rig, request.profile, request.draws)
    for step in range(steps):
        run.take(
            {
                f"seen {name}": Estimate(0.5 - 0.01 * (step % 7) * (place + 1))
                for place, name in enumerate(CLASSES)
            }
        )
    answer = ToleranceProgress(run.done, run.steps, run.result())
    feature(desk)._take(request, answer)
    return answer


def test_nothing_is_drawn_until_a_profile_is_chosen_and_all_ends_with_it(desk: FullDesk) -> None:
    strip = feature(desk).strip
    reason = strip._head.text()
    assert desk.recompute.tolerances == [] and reason
    choose(desk, "service")
    (asked,) = desk.recompute.tolerances
    assert (
        "service" in strip._head.text() and asked.rig == desk.document.rig and asked.profile.name == "service"
    )
    assert asked.draws == DRAWS and asked.settings == replace(desk.session.settings, body="blocks")
    tell(desk, 20)
    choose(desk, "")
    assert strip._head.text() == reason and feature(desk).answer is None
    desk.drag("roof", (0.0, 0.0, 2.0))
    desk.answer()
    assert len(desk.recompute.tolerances) == 1


def test_an_edit_voids_what_is_shown_and_at_rest_it_is_asked_anew(desk: FullDesk) -> None:
    choose(desk, "assembly")
    tell(desk, 30)
    strip = feature(desk).strip
    assert (
        "draws plus the rig as designed, 37 %" in strip._head.text() and "pp" in strip._rows["car"][1].text()
    )
    desk.viewport.press("roof")
    desk.viewport.drag_to("roof", desk.document.rig.sensor("roof").pose)
    desk.document.preview({"roof": desk.document.rig.sensor("front").pose})
    assert strip._head.text() == "assembly: measured between edits" and feature(desk).answer is None
    desk.answer()
    assert len(desk.recompute.tolerances) == 1  # the mouse has not rested yet
    desk.viewport.release("roof")
    desk.answer()
    assert desk.recompute.tolerances[-1].rig == desk.document.rig
    feature(desk)._take(desk.recompute.tolerances[0], ToleranceProgress(81, 81, None))
    assert feature(desk).answer is None
    assert not all(label.isEnabled() for label in strip.findChildren(QLabel))
    tell(desk, 30)
    assert all(label.isEnabled() for label in strip.findChildren(QLabel))


def test_what_is_only_shown_otherwise_is_not_drawn_again_and_a_failed_sensor_is(desk: FullDesk) -> None:
    choose(desk, "assembly")
    desk.document.select("front")
    desk.session.look_at_map("any")
    desk.answer()
    assert len(desk.recompute.tolerances) == 1
    desk.document.set_failed(("roof",), True)
    desk.answer()
    assert not desk.recompute.tolerances[-1].rig.sensor("roof").enabled


def test_the_worst_draw_is_a_ghost_in_the_view_by_choice(desk: FullDesk) -> None:
    choose(desk, "assembly")
    tell(desk, 81)
    assert desk.viewport.state.ghosts == ()
    strip = feature(desk).strip
    strip.worst.setChecked(True)
    ghosts = desk.viewport.state.ghosts
    assert [ghost.name for ghost in ghosts] == ["roof", "front"]
    assert 0.0 < abs(ghosts[0].position[0] - 0.1) <= 0.15 and "errors × 50" in strip.ghost_note.text()
    desk.document.delete(("front",))
    assert desk.viewport.state.ghosts == () and strip.ghost_note.text() == ""


def test_the_choice_is_kept_and_one_that_is_no_more_is_none(qtbot: QtBot, desk: FullDesk) -> None:
    choose(desk, "ride")
    feature(desk).keep(desk.workbench.kept)
    with full_desk(qtbot, kept=desk.workbench.kept) as again:
        assert feature(again).profile == profile_called("ride")
    desk.workbench.kept.write("tolerance/profile", "nonsense")
    with full_desk(qtbot, kept=desk.workbench.kept) as again:
        assert feature(again).profile is None


@pytest.mark.parametrize(
    ("below", "draws", "verdict"), [(0, 8, "not shown"), (0, 64, "met"), (40, 64, "NOT MET")]
)
def test_a_chance_is_judged_by_its_bounds_as_the_command_does(below: int, draws: int, verdict: str) -> None:
    low, high = chance_bounds(below, draws)
    assert Below(50.0, 100.0 * below / draws, 100.0 * low, 100.0 * high, 5.0).verdict == verdict


def test_ranges_read_in_percentage_points_beside_the_rig_as_designed() -> None:
    wide, floor = Spread(0.5, 0.49, 0.47, 0.51, 0.4, 3, ()), Spread(0.5, 0.5, 0.499, 0.501, 0.49, 0, ())
    found = range_of(wide, floor)
    assert range_text(found) == "\u22123.00 … +1.00 pp" and found.widest == pytest.approx(10.0)
    assert range_text(range_of(floor, wide)).endswith("within noise")
    assert points_text(-0.001) == "0.00"


def test_magnified_errors_are_seen_and_the_car_is_not_turned_over() -> None:
    assert {profile.name: magnified(profile) for profile in PROFILES} == {
        "assembly": 50.0, "service": 20.0, "brackets": 50.0, "ride": 5.0, "load": 2.0,
    }  # fmt: skip
    assert magnified(ToleranceProfile(name="none", source="a test")) == 1.0


def test_draws_below_what_a_file_requires_are_told_with_their_error(desk: FullDesk, tmp_path: Path) -> None:
    choose(desk, "assembly")
    tell(desk, 81)
    strip = feature(desk).strip
    assert strip._below["car"].text() == "" and strip.required.text() == "Requirements…"
    desk.dialogs.path = tmp_path / "required.yaml"
    desk.dialogs.path.write_text("riglens_requirements: 1\nmounts: {gap_m: 0.1}\n", encoding="utf-8")
    strip.required.click()
    assert "needs a section" in desk.workbench.errors.message and strip._below["car"].text() == ""
    desk.dialogs.path.write_text(
        "riglens_requirements: 1\n"
        "seen: [{class: bicycle, at_least: 0.47}, {class: car, at_least: 0.9}]\n"
        "tolerance: [{profile: assembly, class: car, limit: 0.475, at_most: 0.1}, "
        "{profile: ride, class: pedestrian, limit: 0.1}]\n",
        encoding="utf-8",
    )
    strip.required.click()
    assert strip.required.text() == "Without required.yaml", desk.workbench.errors.message
    result = feature(desk).answer
    assert result is not None and result.result is not None
    values = result.result.spreads["seen car"].values
    below = sum(value < 0.475 for value in values)
    low, high = chance_bounds(below, len(values))
    assert low > 0.1
    share = f"{100 * below / len(values):.1f} % of draws < 47.5 %, at most {100 * high:.1f} %"
    assert strip._below["car"].text() == f"{share} (≤ 10 %): NOT MET"
    assert strip._below["car"].styleSheet() != "" and strip._below["pedestrian"].text() == ""
    assert "% of draws < 47 %, at most " in strip._below["bicycle"].text()
    assert strip.required.text() == "Without required.yaml"
    choose(desk, "ride")
    tell(desk, 81)
    assert (
        "of draws < 90 %, at most 100.0 %" in strip._below["car"].text()
    )  # of this profile, seen alone is required
    assert strip._below["pedestrian"].text().endswith("(≤ 5 %): met")
    strip.required.click()
    assert strip._below["car"].text() == "" and strip.required.text() == "Requirements…"
