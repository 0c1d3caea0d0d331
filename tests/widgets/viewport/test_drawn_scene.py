"""Showing a state makes anew what differs from the state before, and nothing else."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import pyvista as pv

from riglens.core.rig.model import Lidar, LinearAngles, Rig, Vehicle
from riglens.core.scene.grid import VoxelGrid
from riglens.core.scene.streets import StreetView
from riglens.core.vehicle.placing import PlacingRules
from riglens.core.view.heatmap_data import HeatmapData
from riglens.widgets.drawing.camera import OrbitCamera
from riglens.widgets.heatmap.scale import HeatLook
from riglens.widgets.sensors.ray_look import RayLook
from riglens.widgets.theme import palette
from riglens.widgets.traffic.frame import ShownFrame
from riglens.widgets.viewport.drawn_scene import DrawnScene
from riglens.widgets.viewport.ground_map import GroundMap
from riglens.widgets.viewport.masts import Mast, Stubs
from riglens.widgets.viewport.measured import Measured, Place
from riglens.widgets.viewport.scene_state import ALL_FIELDS, Caption, Marker, Post, SceneState

LIDAR = Lidar(
    name="roof",
    position=(0.2, 0.5, 2.2),
    elevations_deg=LinearAngles(**{"from": -25.0, "to": 25.0, "count": 4}),
)
OTHER = LIDAR.replace(name="other")
STATE = SceneState(rig=Rig(sensors=(LIDAR, OTHER)), selected="roof")
HEAT = HeatmapData(
    np.zeros((1, 3), np.float32), 0.4, np.ones(1, np.float32), "seen", "share", vmin=0.0, vmax=1.0
)
GROUND = GroundMap((-1.0, -1.0), 1.0, np.zeros((2, 2), np.uint8), (), "Blind areas")
LAYERS = {
    "_body": ("set_vehicle",),
    "_ground": ("show",),
    "_roi": ("set_grid", "set_shown"),
    "_rig": ("show_bodies", "show_fans", "show_ghosts"),
    "_heatmap": ("set_data", "set_look"),
    "_drape": ("show",),
    "_words": ("show_legend", "show_caption", "show_ground_key"),
    "_skin_gain": ("show",),
    "_masts": ("show",),
    "_stubs": ("show",),
    "_marker": ("set_marker",),
    "_measure": ("show",),
    "_post": ("show",),
    "_ground_map": ("show",),
    "_traffic": ("set_frame",),
    "_gizmo": ("set_palette",),
}


@pytest.fixture(scope="module")
def drawn(xvfb: str) -> Iterator[DrawnScene]:
    plotter = pv.Plotter(off_screen=True, window_size=[64, 48], lighting="none")
    yield DrawnScene(plotter)
    plotter.close()


@pytest.fixture
def scene(drawn: DrawnScene) -> DrawnScene:
    drawn.show(STATE)
    drawn.prepare()  # brings the car
    return drawn


@pytest.fixture
def told(scene: DrawnScene, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """What the layers of the scene are told, as it happens."""
    told: list[str] = []

    def note(layer: str, method: str) -> None:
        do = getattr(getattr(scene, layer), method)

        def noted(*values: Any, **named: Any) -> None:
            suffix = "" if named.get("others", True) else " of the selected sensor"
            told.append(f"{layer[1:]}.{method}{suffix}")
            do(*values, **named)

        monkeypatch.setattr(getattr(scene, layer), method, noted)

    for layer, methods in LAYERS.items():
        for method in methods:
            note(layer, method)
    return told


FRAME = ShownFrame(
    np.zeros(1, np.uint8), np.zeros((1, 3)), np.ones((1, 3)), np.eye(3)[None], np.array([3]),
    np.zeros((1, 3), np.float32), np.array([True]), 5,
)  # fmt: skip
MOVED = Rig(sensors=(LIDAR.replace(position=(0.0, 0.0, 2.0)), OTHER))
OTHER_MOVED = Rig(sensors=(LIDAR, OTHER.replace(position=(0.0, 0.0, 2.0))))
CHANGES: list[tuple[dict[str, Any], set[str]]] = [
    ({}, set()),
    ({"camera": OrbitCamera(distance_m=5.0)}, set()),
    ({"gizmo_mode": "move"}, set()),
    ({"gizmo_space": "world"}, set()),
    ({"show_gizmo": False}, set()),
    ({"snap": True}, set()),
    ({"placing": PlacingRules(upright=True)}, set()),
    ({"show_ground": False}, {"ground.show"}),
    ({"show_selection": False}, {"masts.show", "rig.show_bodies", "rig.show_fans of the selected sensor"}),
    ({"fixed": frozenset({"roof"})}, set()),
    ({"vehicle": Vehicle(length=5.0)}, {"body.set_vehicle", "skin_gain.show"}),
    ({"solid_body": Vehicle()}, {"rig.show_fans"}),
    (
        {"grid": VoxelGrid(0.5, (10.0, 10.0, 4.0))},
        {"roi.set_grid", "rig.show_fans"},
    ),
    ({"rig": MOVED}, {"stubs.show", "masts.show", "rig.show_bodies", "rig.show_fans of the selected sensor"}),
    ({"rig": OTHER_MOVED}, {"stubs.show", "masts.show", "rig.show_bodies", "rig.show_fans"}),
    ({"selected": "other"}, {"masts.show", "rig.show_bodies", "rig.show_fans"}),
    ({"also_selected": frozenset({"other"})}, {"masts.show", "rig.show_bodies"}),
    ({"hidden": frozenset({"other"})}, {"stubs.show", "masts.show", "rig.show_bodies", "rig.show_fans"}),
    ({"failed": frozenset({"other"})}, {"rig.show_bodies", "rig.show_fans"}),
    ({"failed": frozenset({"roof"})}, {"rig.show_bodies", "rig.show_fans"}),
    ({"measured": Measured(Place((1.0, 0.0, 0.0), "ground"))}, {"measure.show"}),
    ({"ghosts": (OTHER,)}, {"rig.show_ghosts"}),
    ({"skin_gain": HEAT}, {"heatmap.set_data", "drape.show", "words.show_legend", "skin_gain.show"}),
    ({"ray_look": RayLook(shown=False)}, {"stubs.show", "rig.show_fans"}),
    ({"heatmap": HEAT}, {"heatmap.set_data", "drape.show", "words.show_legend"}),
    (
        {"heat_look": HeatLook(draped=True)},
        {"heatmap.set_look", "heatmap.set_data", "drape.show", "roi.set_shown", "words.show_legend"},
    ),
    ({"show_legend": False}, {"words.show_legend", "words.show_ground_key"}),
    ({"post": Post(2.0, -3.0, 0.15, 0.8, is_seen=False)}, {"post.show"}),
    (
        {"ground_map": GROUND},
        {"ground_map.show", "words.show_ground_key", "rig.show_fans", "heatmap.set_data", "drape.show"},
    ),
    ({"caption": Caption("A rig")}, {"words.show_caption"}),
    ({"marker": Marker((1.0, 2.0, 0.5), 0.2)}, {"marker.set_marker"}),
    ({"masts": (Mast("roof", (0.2, 0.5, 1.45), "0.75 m", "in full"),)}, {"masts.show"}),
    ({"stubs": Stubs("roof", (0.2, 0.5, 2.2), np.zeros((1, 3), np.float32))}, {"stubs.show"}),
    ({"traffic": FRAME}, {"traffic.set_frame"}),
    ({"streets": StreetView(np.zeros((1, 4, 2)), np.zeros((1, 4, 2)))}, {"ground.show"}),
    (
        {"palette": palette(False)},
        {
            "body.set_vehicle", "ground.show", "heatmap.set_data", "drape.show",
            "roi.set_grid", "rig.show_bodies",
            "rig.show_fans", "rig.show_ghosts", "words.show_legend", "words.show_caption", "marker.set_marker",
            "gizmo.set_palette", "traffic.set_frame", "masts.show", "measure.show", "words.show_ground_key",
        },
    ),
]  # fmt: skip


@pytest.mark.parametrize(
    ("change", "expected"), CHANGES, ids=lambda value: "-".join(sorted(value)) or "nothing"
)
def test_a_change_is_told_to_the_layers_that_show_it(scene, told, change, expected):
    after = replace(STATE, **change)
    scene.show(after)
    scene.prepare()
    assert sorted(told) == sorted(expected)
    assert scene.state == after


def test_fans_are_rebuilt_once_for_a_frame(scene, told):
    for rig in (MOVED, OTHER_MOVED, MOVED):
        scene.show(replace(STATE, rig=rig))
    scene.preview({"roof": LIDAR.pose})
    scene.set_quick(True)
    scene.set_quick(False)
    assert not any("fans" in one for one in told)
    scene.prepare()
    scene.prepare()
    assert [one for one in told if "fans" in one] == ["rig.show_fans"]
    scene.preview({"roof": LIDAR.pose})
    scene.prepare()
    assert [one for one in told if "fans" in one][1:] == ["rig.show_fans of the selected sensor"]


@pytest.mark.parametrize("has_skin", [False, True])
@pytest.mark.parametrize("has_map", [False, True])
@pytest.mark.parametrize("is_draped", [False, True])
def test_a_heatmap_is_in_space_or_on_the_ground_and_gives_way_to_a_coloured_car_and_to_a_map_there(
    scene, monkeypatch, is_draped, has_map, has_skin
):
    cells, drapes = [], []
    monkeypatch.setattr(scene._heatmap, "set_data", cells.append)
    monkeypatch.setattr(scene._drape, "show", lambda data, *look: drapes.append(data))
    for draped_before in (not is_draped, is_draped):
        before = replace(STATE, heat_look=HeatLook(draped=draped_before), heatmap=None)
        scene.show(before)
        after = replace(
            before,
            heat_look=HeatLook(draped=is_draped),
            heatmap=HEAT,
            ground_map=GROUND if has_map else None,
            skin_gain=HEAT if has_skin else None,
        )
        scene.show(after)
        assert cells[-1] is (None if is_draped or has_skin else HEAT)
        assert drapes[-1] is (HEAT if is_draped and not has_skin and not has_map else None)


def test_every_field_is_changed_by_a_case_above():
    assert {name for change, _ in CHANGES for name in change} == ALL_FIELDS


def test_a_body_that_is_not_at_hand_never_leaves_the_car_before(scene, told):
    missing = replace(STATE, vehicle=Vehicle(body="hovercraft.glb"), heatmap=HEAT, palette=palette(False))
    scene.show(missing)
    assert scene.state == missing
    assert {"heatmap.set_data", "body.set_vehicle"} <= set(told)


def test_a_state_made_from_the_one_shown_undoes_no_camera_move_and_no_drag(scene):
    scene.preview({"roof": LIDAR.pose})
    scene.set_camera(OrbitCamera(distance_m=7.0))
    scene.preview({"roof": MOVED.sensor("roof").pose})
    scene.show(replace(scene.state, heatmap=HEAT))
    assert scene.state == replace(STATE, rig=MOVED, camera=OrbitCamera(distance_m=7.0), heatmap=HEAT)


def test_frame_all_leaves_out_a_sensor_kilometres_away_and_framing_it_goes_there(scene):
    far = LIDAR.replace(name="far", position=(4000.0, 0.0, 1.0))
    scene.show(SceneState(rig=Rig(sensors=(LIDAR, far))))
    scene.frame()
    camera = scene.state.camera
    assert scene.state.far_away == ("far",)
    assert np.hypot(*camera.focal_m[:2]) < 3.0 and camera.distance_m < 40.0
    scene.frame(("far",))
    assert scene.state.camera.focal_m == far.position and scene.state.camera.distance_m < 10.0
    scene.frame(("far", "roof"))
    assert scene.state.camera.focal_m == LIDAR.position


def test_named_views_keep_parallel_rays_by_choice(scene):
    scene.set_view("iso")
    assert not scene.state.camera.parallel
    scene.set_camera(scene.state.camera.projected(True))
    scene.set_view("iso")
    assert scene.state.camera.parallel and scene.state.camera.orthographic
