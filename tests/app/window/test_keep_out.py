"""Keep-out zones: shown on the car as the limits on mounts say, painted with a brush, kept in the rig, checked live."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from pytestqt.qtbot import QtBot

from riglens.app.window.features.keep_out import RADII_M, KeepOutZones, zone_of
from riglens.core.blind.outline import Outline
from riglens.core.review.mounts import PAINTED, USUAL_KEEP_OUT, USUAL_LIMITS, violations
from riglens.core.rig.model import MAX_SPOTS
from riglens.widgets.car.keep_out import KeepOut
from tests.app.window.desk import FullDesk, full_desk

ROOF_M = (0.1, 0.2, 1.44)


@pytest.fixture
def desk(qtbot: QtBot) -> Iterator[FullDesk]:
    with full_desk(qtbot) as made:
        yield made


def zones(desk: FullDesk) -> KeepOutZones:
    return desk.features.keep_out


def stroke(desk: FullDesk, *places_m: tuple[float, float, float], kept: bool = True) -> None:
    for number, place_m in enumerate(places_m):
        desk.viewport.brushed.emit(place_m, number == 0)
    desk.viewport.brush_ended.emit(kept)


def test_the_zones_of_the_limits_are_shown_by_choice_and_those_of_a_file_take_their_place(
    desk: FullDesk, tmp_path: Path
) -> None:
    assert desk.viewport.state.keep_out is None
    desk.act("keep_out_shown")
    vehicle = desk.document.rig.vehicle
    wanted = tuple(zone_of(one, Outline.of(vehicle), vehicle.height) for one in USUAL_KEEP_OUT)
    assert desk.viewport.state.keep_out == KeepOut(wanted) and wanted[0].material == "glass"
    (low, high) = wanted[-1].boxes_m[0]
    assert low == pytest.approx((0.28 * 4.6 - 2.3, 0.9 * 1.9 - 0.95, 0.2 * 1.45))
    assert high == pytest.approx((0.72 * 4.6 - 2.3, 1.1 * 1.9 - 0.95, 0.62 * 1.45))
    desk.document.apply(desk.document.rig.replace(vehicle=vehicle.replace(length=4.0)))
    shown = desk.viewport.state.keep_out
    assert shown is not None and shown.zones[-1].boxes_m[0][0][0] == pytest.approx(0.28 * 4.0 - 2.0)
    desk.dialogs.path = tmp_path / "required.yaml"
    desk.dialogs.path.write_text(
        "riglens_requirements: 1\nmounts: {keep_out: [{name: paint, material: paint}]}\n"
    )
    desk.features.mounts._choose_file()
    shown = desk.viewport.state.keep_out
    assert shown is not None and [zone.material for zone in shown.zones] == ["paint"]
    desk.act("keep_out_shown")
    assert desk.viewport.state.keep_out is None
    desk.drag("roof", (0.0, 0.0, 2.0))
    assert desk.viewport.state.keep_out is None


def test_a_stroke_paints_spots_as_one_undo_step_and_the_check_says_who_stands_there(desk: FullDesk) -> None:
    desk.act("keep_out_paint")
    assert desk.viewport.told[-1] == ("paint", True) and desk.workbench.actions["keep_out_shown"].isChecked()
    stroke(desk, ROOF_M, (0.101, 0.2, 1.44), (0.3, 0.2, 1.4404))
    painted = ((*ROOF_M, 0.1), (0.3, 0.2, 1.44, 0.1))
    assert desk.document.rig.keep_out == painted
    shown = desk.viewport.state.keep_out
    assert shown is not None and shown.spots == painted
    rig = desk.document.rig.with_sensor(
        "roof", desk.document.rig.sensor("roof").replace(position=(0.1, 0.2, 1.5))
    )
    said = [one.text for one in violations(rig, USUAL_LIMITS) if one.sensor == "roof"]
    assert f"is in the keep-out zone {PAINTED}" in said
    bare = rig.replace(keep_out=())
    assert f"is in the keep-out zone {PAINTED}" not in [one.text for one in violations(bare, USUAL_LIMITS)]
    desk.document.undo()
    assert desk.document.rig.keep_out == () and desk.viewport.state.keep_out != shown
    desk.document.redo()
    assert desk.viewport.state.keep_out == shown


def test_from_a_painted_spot_on_the_brush_erases_and_a_stroke_given_up_changes_nothing(
    desk: FullDesk,
) -> None:
    desk.act("keep_out_paint")
    desk.act("brush_large")
    stroke(desk, ROOF_M, (-0.5, 0.2, 1.44))
    assert [spot[3] for spot in desk.document.rig.keep_out] == [RADII_M["brush_large"]] * 2
    stroke(desk, (0.15, 0.2, 1.44), (0.6, 0.2, 1.44), kept=False)
    assert len(desk.document.rig.keep_out) == 2
    stroke(desk, (0.15, 0.2, 1.44), (0.6, 0.2, 1.44))
    assert [spot[0] for spot in desk.document.rig.keep_out] == [-0.5]
    desk.act("keep_out_clear")
    assert desk.document.rig.keep_out == ()
    desk.document.undo()
    assert len(desk.document.rig.keep_out) == 1
    desk.viewport.escaped.emit()
    assert (
        desk.viewport.told[-1] == ("paint", False)
        and not desk.workbench.actions["keep_out_paint"].isChecked()
    )


def test_one_tool_takes_the_mouse_and_a_full_rig_says_so(desk: FullDesk) -> None:
    desk.act("measure")
    desk.act("keep_out_paint")
    assert not desk.workbench.actions["measure"].isChecked()
    desk.act("pick")
    assert not desk.workbench.actions["keep_out_paint"].isChecked()
    desk.act("keep_out_paint")
    full = tuple((0.001 * i, 0.0, 3.0, 0.05) for i in range(MAX_SPOTS))
    desk.document.apply(desk.document.rig.replace(keep_out=full))
    stroke(desk, ROOF_M)
    assert desk.document.rig.keep_out == full and "erase some" in desk.workbench.status.currentMessage()


def test_whether_zones_are_shown_is_kept(qtbot: QtBot, desk: FullDesk) -> None:
    desk.act("keep_out_shown")
    zones(desk).keep(desk.workbench.kept)
    with full_desk(qtbot, kept=desk.workbench.kept) as again:
        assert again.viewport.state.keep_out is not None
