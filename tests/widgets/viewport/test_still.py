"""Pictures made without a window: what must be seen is seen, at any size."""

from dataclasses import replace

import numpy as np
import pytest

from riglens.core.rig.model import EvenAngles, Lidar, Rig
from riglens.widgets.drawing.camera import OrbitCamera
from riglens.widgets.heatmap.scale import HeatmapData
from riglens.widgets.sensors.ray_look import RayLook
from riglens.widgets.theme import LIGHT
from riglens.widgets.viewport.scene_state import SceneState
from riglens.widgets.viewport.still import render_still

SIZE = (320, 200)
LIDAR = Lidar(
    name="roof",
    position=(0.0, 0.0, 2.0),
    elevations_deg=EvenAngles(**{"from": -25.0, "to": 25.0, "count": 16}),
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
    state = SceneState(camera=camera)
    bare, walled = picture(state), picture(SceneState(camera=camera, heatmap=wall(-2.5)))
    assert share_changed(bare, walled, slice(85, 115), slice(110, 210)) < 0.02
    assert share_changed(bare, walled, slice(10, 24), slice(3, 14)) > 0.8


def test_traffic_behind_the_car_is_hidden_by_it_but_seen_beside_it():
    bare, walled = (
        picture(SceneState(camera=SIDE_VIEW)),
        picture(SceneState(camera=SIDE_VIEW, heatmap=wall(4.0))),
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


@pytest.mark.parametrize("distance_m", [0.5, 1.5, 6.0])
@pytest.mark.parametrize("parallel", [False, True])
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
