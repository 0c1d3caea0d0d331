"""Sensors that are not on the car's surface have a line to it, with the height, also while they are dragged."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import pyvista as pv

from riglens.core.geometry import Pose
from riglens.core.rig.model import Lidar, Rig
from riglens.core.rig.presets import preset
from riglens.core.vehicle.standing import mount_statuses
from riglens.widgets.drawing.camera import OrbitCamera
from riglens.widgets.viewport.drawn_scene import DrawnScene
from riglens.widgets.viewport.mast_layer import _meet, _placed, _rooms
from riglens.widgets.viewport.masts import Mast, masts_of
from riglens.widgets.viewport.scene_state import SceneState

SIDE = OrbitCamera(focal_m=(0.0, 0.0, 1.2), distance_m=9.0, azimuth_deg=90.0, elevation_deg=2.0)


def drawn(state: SceneState) -> DrawnScene:
    plotter = pv.Plotter(off_screen=True, window_size=(640, 400))
    scene = DrawnScene(plotter)
    scene.show(state)
    scene.prepare()
    return scene


def floating() -> SceneState:
    rig = preset("W+T")
    return SceneState(rig=rig, masts=masts_of(mount_statuses(rig)), camera=SIDE)


def test_every_lidar_of_the_papers_rig_has_a_mast_down_to_the_roof() -> None:
    state = floating()
    assert {mast.name for mast in state.masts} >= {f"LIDAR_{number}" for number in (1, 2, 3, 4)}
    first = next(mast for mast in state.masts if mast.name == "LIDAR_1")
    assert first.short == "0.75 m" and not first.is_buried
    assert 1.4 < first.foot_m[2] < 1.46 and first.foot_m[:2] == (-0.4, 0.2)


def test_labels_say_heights_and_none_is_over_another() -> None:
    state = floating()
    scene = drawn(state)
    assert "0.86 m" in scene._masts.label_texts
    places = {sensor.name: sensor.position for sensor in state.rig.sensors}
    shown = [(mast, np.array([places[mast.name], mast.foot_m]), False) for mast in state.masts]
    rooms = [room for _, room in _placed(shown, SIDE, (640, 400), 12.0, lambda _: False)]
    assert rooms and not any(_meet(one, other) for k, one in enumerate(rooms) for other in rooms[:k])


def test_the_selected_sensor_says_it_in_full() -> None:
    assert (
        "0.75 m above the body: needs a bracket"
        in drawn(replace(floating(), selected="LIDAR_2"))._masts.label_texts
    )


def test_the_car_hides_the_label_of_a_sensor_behind_it_unless_it_is_selected() -> None:
    beyond = Lidar(name="a", position=(0.0, -1.3, 0.8), elevations_deg=(0.0,))
    mast = Mast("a", (0.0, -1.0, 0.8), "0.30 m", "in full")
    state = SceneState(rig=Rig(sensors=(beyond,)), masts=(mast,), camera=SIDE)
    assert drawn(state)._masts.label_texts == []
    assert drawn(replace(state, selected="a"))._masts.label_texts != []
    assert drawn(replace(state, camera=replace(SIDE, azimuth_deg=-90.0)))._masts.label_texts == ["0.30 m"]
    over = beyond.replace(position=(0.0, 0.0, 2.2))
    above = replace(state, rig=Rig(sensors=(over,)), masts=(replace(mast, foot_m=(0.0, 0.0, 1.45)),))
    assert drawn(above)._masts.label_texts == ["0.30 m"]


def test_hidden_sensors_and_names_that_are_gone_have_no_mast() -> None:
    state = floating()
    everybody = frozenset(sensor.name for sensor in state.rig.sensors)
    assert drawn(replace(state, hidden=everybody))._masts.label_texts == []
    assert drawn(replace(state, rig=Rig()))._masts.label_texts == []


@pytest.mark.parametrize("is_buried", [False, True])
def test_the_line_begins_at_the_sensor_while_it_is_dragged(is_buried: bool) -> None:
    mast = Mast("a", (0.0, 0.0, 1.45), "0.75 m", "in full", is_buried)
    scene = drawn(
        SceneState(
            rig=Rig(sensors=(Lidar(name="a", position=(0.0, 0.0, 2.2), elevations_deg=(0.0,)),)),
            masts=(mast,),
        )
    )
    scene.preview({"a": Pose((0.3, 0.0, 2.0), (0.0, 0.0, 0.0))})
    actors = scene._masts._buried if is_buried else scene._masts._free
    others = scene._masts._free if is_buried else scene._masts._buried
    ends = np.asarray(actors[0].mapper.GetInput().points)[:2]
    assert np.allclose(ends, [(0.3, 0.0, 2.0), (0.0, 0.0, 1.45)])
    assert all(actor.visibility for actor in actors) and not any(actor.visibility for actor in others)


def test_a_label_fits_up_to_the_very_edges_of_the_view() -> None:
    places = np.array([[300.0, 200.0, 1.0]])
    rightmost, leftmost = _rooms("0.75 m", places, (640, 400), 12.0)
    assert list(_rooms("0.75 m", places, (rightmost[2], 400), 12.0)) == [rightmost, leftmost]  # type: ignore[arg-type]
    assert list(_rooms("0.75 m", places, (rightmost[2] - 1e-9, 400), 12.0)) == [leftmost]  # type: ignore[arg-type]
