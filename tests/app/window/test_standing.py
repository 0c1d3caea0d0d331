"""Sensors off the body, inside it or in the ground are marked everywhere, and follow a drag."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from PySide6.QtCore import QCoreApplication
from pytestqt.qtbot import QtBot

from riglens.app.background.standing import MountStatuses, MountStatusRequest, stopped_rays
from riglens.app.background.worker import BackgroundWorker
from riglens.app.window.features.follow import Follow
from riglens.app.window.features.standing import Standing, shared_places
from riglens.core.geometry import Pose
from riglens.core.kernels.runtime.codes import BODY
from riglens.core.rig.model import Rig
from riglens.core.sensing.body_ends import barrier_of
from riglens.core.sensing.rays import sensor_rays
from riglens.core.vehicle.solid import solid_of
from riglens.core.vehicle.standing import mount_status
from riglens.core.view.frames import FrameBoxes
from riglens.core.view.hits import cast
from riglens.widgets.panels.inspector.panel import places_text
from riglens.widgets.panels.sensors.rows import NAME, PROBLEM
from tests.app.window.desk import Desk, open_desk
from tests.app.window_bench import LIDAR, RIG
from tests.waiting import TIMEOUT_S

ON_ROOF, CABIN, GROUND = (0.1, 0.0, 1.5), (0.0, 0.0, 0.9), (3.0, 0.0, -0.2)


@pytest.fixture
def desk(qtbot: QtBot) -> Desk:
    made = open_desk(qtbot)
    made.workbench.answers.ask()
    return made


@pytest.fixture
def standing(desk: Desk) -> Iterator[Standing]:
    Follow(desk.workbench).show_all()
    made = Standing(desk.workbench, BackgroundWorker("places of sensors", MountStatuses(), close_s=TIMEOUT_S))
    yield made
    made.worker.close()


def settle(standing: Standing) -> None:
    assert standing.worker.wait_until_idle(TIMEOUT_S)
    QCoreApplication.processEvents()


def start(desk: Desk, standing: Standing) -> None:
    desk.load()
    desk.answer()
    settle(standing)


def marked(desk: Desk) -> dict[str, str]:
    tree, rig = desk.panels.tree, desk.document.rig
    found = {sensor.name: tree._items[sensor.name].data(NAME, PROBLEM) for sensor in rig.sensors}
    return {name: problem for name, problem in found.items() if problem}


def test_nothing_is_said_before_the_first_scores(desk: Desk, standing: Standing) -> None:
    desk.load()
    settle(standing)
    assert marked(desk) == {} and desk.viewport.state.masts == ()


def test_a_sensor_in_the_air_is_marked_in_list_view_and_inspector(desk: Desk, standing: Standing) -> None:
    start(desk, standing)
    rig = desk.document.rig
    problem = mount_status(rig.sensor("roof").position, solid_of(rig.vehicle)).problem
    assert "above the body: needs a bracket" in problem and marked(desk)["roof"] == problem
    assert problem.capitalize() in desk.panels.tree._items["roof"].toolTip(NAME)
    mast = next(mast for mast in desk.viewport.state.masts if mast.name == "roof")
    assert mast.full == problem and mast.foot_m[2] == pytest.approx(1.41, abs=0.02)
    assert "bracket needed" in desk.panels.inspector._rig_form._places.text()
    desk.document.select("roof")
    assert desk.panels.inspector.form.place == problem


def test_the_line_about_the_rig_names_the_heights_that_the_view_does() -> None:
    solid = solid_of(RIG.vehicle)
    above = {name: mount_status((-0.9, 0.3, z_m), solid) for name, z_m in (("low", 1.9), ("high", 2.2))}
    assert all(found.gap_m < found.away_m for found in above.values())  # the roof slopes
    said = f"low, high: {above['low'].height.split()[0]} to {above['high'].height} off the body"
    assert places_text(above) == f"{said}, bracket needed"


def test_the_line_about_the_rig_says_how_deep_sensors_are_inside_and_why_they_may_be() -> None:
    solid = solid_of(RIG.vehicle)
    buried = {"behind": mount_status(CABIN, solid), "below": mount_status(GROUND, solid)}
    inside, below = places_text(buried).splitlines()
    assert inside.startswith(f"behind: {buried['behind'].gap_m:.2f} m inside the body: behind a panel, or")
    assert below == "below: below the ground"


@pytest.mark.parametrize(
    ("place", "said", "short"),
    [(CABIN, "inside the body", "inside"), (GROUND, "below the ground", "0.20 m deep")],
)
def test_a_sensor_inside_or_in_the_ground_is_seen_through_both(
    desk: Desk, standing: Standing, place: tuple[float, float, float], said: str, short: str
) -> None:
    start(desk, standing)
    desk.drag("roof", place)
    settle(standing)
    mast = next(mast for mast in desk.viewport.state.masts if mast.name == "roof")
    assert marked(desk)["roof"].endswith(said) and mast.is_buried and mast.short == short
    assert said in desk.panels.inspector._rig_form._places.text()


def test_the_mark_follows_the_drag_and_goes_on_the_roof(desk: Desk, standing: Standing) -> None:
    start(desk, standing)
    desk.viewport.press("roof")
    desk.drag("roof", ON_ROOF)
    settle(standing)
    assert "roof" not in marked(desk)
    assert "roof" not in [mast.name for mast in desk.viewport.state.masts]


def test_a_body_that_was_not_read_says_nothing(desk: Desk, standing: Standing) -> None:
    start(desk, standing)
    assert marked(desk)
    rig = desk.document.rig
    desk.document.apply(rig.replace(vehicle=rig.vehicle.replace(body="car.ply")))
    settle(standing)
    assert marked(desk) == {} and desk.viewport.state.masts == ()


def test_only_what_moved_is_found_anew(standing: Standing, monkeypatch: pytest.MonkeyPatch) -> None:
    found: list[object] = []

    def counted(place_m, solid):
        found.append(place_m)
        return mount_status(place_m, solid)

    monkeypatch.setattr("riglens.app.background.standing.mount_status", counted)
    body, still = Rig().vehicle, ("a", (0.0, 0.0, 2.0))
    for x in (0.1, 0.2):
        standing.worker.ask(MountStatusRequest(body, (still, ("b", (x, 0.0, 2.0)))))
        settle(standing)
    assert found == [(0.0, 0.0, 2.0), (0.1, 0.0, 2.0), (0.2, 0.0, 2.0)]


def test_rays_end_where_they_first_meet_the_car_and_beyond_the_housing() -> None:
    sensor = LIDAR.replace(position=(0.0, 0.0, 1.6))
    body = RIG.vehicle
    barrier = barrier_of(sensor, solid_of(body))
    hits = cast(
        sensor.position,
        sensor_rays(sensor).directions,
        FrameBoxes.none(),
        barrier,
        (0.0, np.inf),
        has_ground=False,
    )
    stopped = hits.what == BODY
    wanted = np.array(sensor.position) + hits.range_m[stopped, None] * sensor_rays(sensor).directions[stopped]
    found = stopped_rays(MountStatusRequest(body, (), sensor))
    assert len(found) == stopped.sum() > 10 and np.allclose(found, wanted, atol=1e-6)
    assert len(stopped_rays(MountStatusRequest(body, ()))) == 0


def test_stopped_rays_of_the_selected_sensor_are_shown_at_rest_while_the_car_is_solid(
    desk: Desk, standing: Standing
) -> None:
    start(desk, standing)
    assert desk.viewport.state.stubs is None
    desk.drag("roof", (0.0, 0.0, 1.6))
    desk.document.select("roof")
    settle(standing)
    stubs = desk.viewport.state.stubs
    assert (
        stubs is not None and stubs.name == "roof" and stubs.place_m == (0.0, 0.0, 1.6) and len(stubs.ends_m)
    )
    desk.viewport.press("roof")
    desk.viewport.drag_to("roof", Pose((0.0, 0.0, 1.7)))
    settle(standing)
    assert desk.viewport.state.stubs is None
    desk.viewport.release("roof")
    settle(standing)
    assert desk.viewport.state.stubs is not None
    assert desk.viewport.state.solid_body == RIG.vehicle, "drawn rays end where those cast do"
    desk.document.set_failed(("roof",), True)
    settle(standing)
    assert desk.viewport.state.stubs is None, "a failed sensor draws nothing"
    desk.document.set_failed(("roof",), False)
    settle(standing)
    assert desk.viewport.state.stubs is not None
    desk.document.apply(desk.document.rig.replace(self_occlusion=False))
    settle(standing)
    assert desk.viewport.state.stubs is None and desk.viewport.state.solid_body is None


def test_two_sensors_in_one_place_are_marked_until_they_part(desk: Desk, standing: Standing) -> None:
    start(desk, standing)
    desk.document.move(
        {"front": Pose((*RIG.sensor("roof").position[:2], 0.01 + RIG.sensor("roof").position[2]))}
    )
    settle(standing)
    assert shared_places(desk.document.rig.sensors) == {
        "roof": "in the same place as front",
        "front": "in the same place as roof",
    }
    desk.document.move({"roof": Pose(ON_ROOF), "front": Pose(ON_ROOF)})
    settle(standing)
    assert marked(desk) == shared_places(desk.document.rig.sensors)
    above = Pose((*ON_ROOF[:2], 3.0))
    desk.document.move({"roof": above, "front": above})
    settle(standing)
    shared, stand = marked(desk)["roof"].split("; ")
    assert shared == "in the same place as front" and "above the body" in stand, "one problem hides no other"
    desk.document.select("roof")
    assert desk.panels.inspector.form.place == marked(desk)["roof"]
    for _ in range(3):
        desk.document.undo()
    settle(standing)
    assert not any("same place" in text for text in marked(desk).values())
