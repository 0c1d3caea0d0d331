"""Pictures made without a window: what must be seen is seen, at any size."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
import pyvista as pv

from riglens.core.rig.model import Camera, Lidar, LinearAngles, Rig
from riglens.core.sensors.registry import kind_names
from riglens.core.view.heatmap_data import HeatmapData
from riglens.widgets.drawing.camera import OrbitCamera
from riglens.widgets.heatmap.scale import HeatLook
from riglens.widgets.sensors.appearance import ray_colour, selected_ray_colour
from riglens.widgets.sensors.ray_look import RayLook
from riglens.widgets.theme import DARK, LIGHT, rgb
from riglens.widgets.traffic.frame import ShownFrame
from riglens.widgets.viewport.drawn_scene import DrawnScene
from riglens.widgets.viewport.scene_state import SceneState
from riglens.widgets.viewport.still import render_still, staged

SIZE = (320, 200)
LIDAR = Lidar(
    name="roof",
    position=(0.0, 0.0, 2.0),
    elevations_deg=LinearAngles(**{"from": -25.0, "to": 25.0, "count": 16}),
)
RIG = Rig(sensors=(LIDAR,))
SIDE_VIEW = OrbitCamera((0.0, 0.0, 0.7), 9.0, -90.0, 5.0)


def wall(y_m: float) -> HeatmapData:
    """A wall of cells with the largest value along the car, at one side of it."""
    x, z = np.meshgrid(np.arange(-20, 20, 0.4), np.arange(0.2, 4, 0.4))
    centres = np.stack([x.ravel(), np.full(x.size, y_m), z.ravel()], axis=1).astype(np.float32)
    return HeatmapData(centres, 0.4, np.ones(len(centres), np.float32), "p", "", 0.0, 1.0)


def picture(state: SceneState, **options) -> np.ndarray:
    return render_still(state, SIZE, **options)[:, :, :3].astype(int)


def share_changed(first: np.ndarray, second: np.ndarray, rows: slice, columns: slice) -> float:
    return float((np.abs(first - second)[rows, columns].max(axis=2) > 40).mean())


@pytest.mark.parametrize("parallel", [False, True])
def test_traffic_between_the_eye_and_the_car_does_not_hide_the_car(parallel):
    camera = OrbitCamera((0.0, 0.0, 0.7), 9.0, -90.0, 5.0, parallel=parallel)
    state = SceneState(camera=camera, show_legend=False)
    bare, walled = picture(state), picture(replace(state, heatmap=wall(-2.5)))
    assert share_changed(bare, walled, slice(85, 115), slice(110, 210)) < 0.02
    assert share_changed(bare, walled, slice(10, 24), slice(3, 14)) > 0.8


def test_traffic_behind_the_car_is_hidden_by_it_but_seen_beside_it():
    bare, walled = (
        picture(SceneState(camera=SIDE_VIEW, show_legend=False)),
        picture(SceneState(camera=SIDE_VIEW, show_legend=False, heatmap=wall(4.0))),
    )
    assert share_changed(bare, walled, slice(100, 115), slice(130, 190)) < 0.02
    assert share_changed(bare, walled, slice(85, 105), slice(4, 14)) > 0.8


def test_a_hidden_sensor_is_not_drawn():
    camera = OrbitCamera(LIDAR.position, 2.0, -60.0, 10.0)
    bare = picture(SceneState(camera=camera))
    shown = picture(SceneState(camera=camera, rig=RIG))
    hidden = picture(SceneState(camera=camera, rig=RIG, hidden=frozenset({"roof"})))
    assert (np.abs(shown - bare).max(axis=2) > 40).mean() > 0.005
    assert np.array_equal(hidden, bare)


def test_the_gizmo_is_seen_through_the_car():
    buried = Rig(sensors=(LIDAR.replace(position=(0.0, 0.0, 0.6)),))
    state = SceneState(camera=SIDE_VIEW, rig=buried, ray_look=RayLook(shown=False))
    without = picture(state)
    chosen = picture(SceneState(camera=SIDE_VIEW, rig=buried, ray_look=RayLook(shown=False), selected="roof"))
    assert (np.abs(chosen - without).max(axis=2) > 60).mean() > 0.003


def test_a_switched_off_sensor_is_drawn_without_rays():
    camera = OrbitCamera(LIDAR.position, 30.0, -60.0, 30.0)
    off = Rig(sensors=(LIDAR.replace(enabled=False),))
    rays = SceneState(camera=camera, rig=off, selected="roof", show_gizmo=False)
    no_rays = SceneState(
        camera=camera, rig=off, selected="roof", show_gizmo=False, ray_look=RayLook(shown=False)
    )
    assert np.array_equal(picture(rays), picture(no_rays))


@pytest.mark.parametrize(("kind", "selected"), [("lidar", True), ("camera", False)])
def test_rays_are_seen_through_a_heatmap_but_not_through_the_car(kind, selected):
    """Every ray here passes behind the nearer wall of cells."""
    camera = Camera(
        name="roof", position=(0.0, 0.0, 2.0), hfov_deg=100.0, cast=(64, 36), rpy_deg=(0.0, 0.0, -90.0)
    )
    above = OrbitCamera((0.0, -6.0, 1.0), 20.0, -90.0, 25.0)
    dense = replace(wall(-9.0), values=np.ones(len(wall(0.0).values), np.float32))
    state = SceneState(
        rig=Rig(sensors=(LIDAR if kind == "lidar" else camera,)), camera=above, heatmap=dense, show_gizmo=False,
        heat_look=HeatLook(opacity=1.0),
        selected="roof" if selected else None, show_legend=False, ray_look=RayLook(of_all=True, lattice=True),
    )  # fmt: skip
    without = replace(state, ray_look=RayLook(shown=False))
    hidden_by_cells = np.abs(picture(without) - picture(replace(without, heatmap=None))).max(axis=2) > 40
    rays = np.abs(picture(state) - picture(without)).max(axis=2) > 30
    assert (rays & hidden_by_cells).sum() > 0.003 * hidden_by_cells.sum()


def test_the_rays_of_kinds_and_of_the_selected_sensor_have_their_own_colours_and_a_key():
    for theme in (DARK, LIGHT):
        colours = [
            look(kind, theme)
            for look in (ray_colour, selected_ray_colour)
            for kind in (*kind_names(), "probe")
        ]
        apart = [np.abs(np.subtract(rgb(a), rgb(b))).max() for a, b in itertools.combinations(colours, 2)]
        assert min(apart) > 0.1
    camera = Camera(name="front", position=(1.0, 0.0, 1.4), hfov_deg=80.0, cast=(64, 36))
    both = Rig(sensors=(LIDAR, camera))
    cases = {
        ("LiDAR", "camera"): SceneState(rig=both),
        ("camera", "selected LiDAR"): SceneState(rig=both, selected="roof"),
        ("LiDAR",): SceneState(rig=RIG),
        (): SceneState(rig=both, ray_look=RayLook(shown=False, fill="none")),
    }
    plotter = pv.Plotter(off_screen=True, window_size=[64, 64], lighting="none")
    scene = DrawnScene(plotter)
    for words, state in cases.items():
        scene.show(state)
        assert scene._words._key.texts == words
    scene.show(replace(SceneState(rig=both), show_legend=False))
    assert scene._words._key.texts == ()
    plotter.close()


def test_a_plotter_has_the_size_that_was_asked_for():
    plotter = staged(SceneState(rig=RIG), (64, 48))
    assert list(plotter.window_size) == [64, 48]
    plotter.close()


def test_a_picture_twice_as_large_shows_the_same():
    state = SceneState(camera=SIDE_VIEW, rig=RIG, heatmap=wall(4.0))
    small, large = picture(state), picture(state, scale=2)
    halved = large.reshape(200, 2, 320, 2, 3).mean(axis=(1, 3))
    assert large.shape == (400, 640, 3)
    assert np.abs(halved - small).mean() < 6.0


def lanes() -> HeatmapData:
    """Traffic to the left and right of the car, in waves."""
    x, y, z = np.meshgrid(np.arange(-12, 12, 0.4), np.arange(-8, 8, 0.4), np.arange(0.2, 2, 0.4))
    centres = np.stack([x.ravel(), y.ravel(), z.ravel()], axis=1).astype(np.float32)
    values = np.exp(-(((np.abs(centres[:, 1]) - 4) / 1.2) ** 2)) * (0.6 + 0.4 * np.cos(centres[:, 0]))
    return HeatmapData(centres, 0.4, values.astype(np.float32), "p", "", 0.0, 1.0)


NEAR_LANE = OrbitCamera((0.0, 0.0, 0.7), 9.0, -60.0, 12.0)
BESIDE_WHEEL = OrbitCamera((3.0, 2.6, 0.5), 2.2, -137.0, 5.0)


@pytest.mark.parametrize("camera", [NEAR_LANE, BESIDE_WHEEL], ids=["lane", "wheel"])
def test_cells_keep_their_size_in_a_picture_four_times_as_large(camera):
    state = SceneState(camera=camera, heatmap=lanes(), show_legend=False)
    small, large = picture(state), picture(state, scale=4)
    reduced = large.reshape(200, 4, 320, 4, 3).mean(axis=(1, 3))
    cells = np.abs(small - picture(replace(state, heatmap=None))).max(axis=2) > 40
    assert cells.mean() > 0.1
    assert np.abs(reduced - small)[cells].mean() < 3.0


@pytest.mark.parametrize(("distance_m", "parallel"), [(0.5, False), (1.5, True), (6.0, False)])
def test_a_wall_of_cells_has_no_gaps_from_any_distance_to_the_edges_of_the_picture(distance_m, parallel):
    camera = OrbitCamera((12.3, 4.0, 1.9), distance_m, -90.0, 0.0, parallel)
    state = SceneState(camera=camera, heatmap=wall(4.0), show_legend=False)
    bare = picture(replace(state, heatmap=None))
    assert share_changed(bare, picture(state), slice(None), slice(None)) == 1.0


def test_light_and_dark_pictures_differ_in_the_background():
    dark, light = picture(SceneState()), picture(SceneState(palette=LIGHT))
    assert light[2, 2].sum() - dark[2, 2].sum() > 300


def test_a_transparent_picture_lets_the_page_shine_through():
    image = render_still(
        SceneState(camera=OrbitCamera((0, 0, 0), 300.0, -60.0, 20.0)), SIZE, transparent=True
    )
    assert image.shape == (200, 320, 4)
    assert image[0, 0, 3] == 0


def test_lines_and_points_are_as_wide_on_a_dense_screen_whenever_it_becomes_one() -> None:
    objects = ShownFrame(
        np.zeros(2, np.uint8), np.zeros((2, 3)), np.ones((2, 3)), np.stack([np.eye(3)] * 2),
        np.array([0, 9]), np.zeros((4, 3), np.float32), np.array([True, True, False, False]), 5, None,
    )  # fmt: skip
    state = SceneState(rig=RIG, selected="roof", traffic=objects)

    def widths(*steps: float | SceneState) -> list[tuple[float, float]]:
        plotter = pv.Plotter(off_screen=True, window_size=list(SIZE))
        scene = DrawnScene(plotter)
        for step in steps:
            scene.show(step) if isinstance(step, SceneState) else scene.set_pixel_ratio(step)
        scene.prepare()
        props = [one for renderer in plotter.render_window.GetRenderers() for one in renderer.GetActors()]
        found = [(one.GetProperty().GetLineWidth(), one.GetProperty().GetPointSize()) for one in props]
        plotter.close()
        return sorted(found)

    after = widths(state, 2.0)
    assert after == widths(2.0, state) == widths(2.0, SceneState(palette=LIGHT), state)
    assert after != widths(state)


def test_whatever_is_shown_has_a_shape(plotter: pv.Plotter) -> None:
    scene = DrawnScene(plotter)
    scene.show(SceneState(rig=RIG, selected="roof", heatmap=wall(4.0)))
    scene.prepare()
    actors = [one for renderer in plotter.render_window.GetRenderers() for one in renderer.GetActors()]
    shown = [one.GetMapper().GetInput() for one in actors if one.GetVisibility()]
    assert len(shown) > 10 and all(mesh is not None and mesh.GetNumberOfPoints() for mesh in shown)
