"""The heatmap may be drawn smaller and stretched: the picture keeps its size, its places and its colours."""

from dataclasses import replace

import numpy as np
import pytest

from riglens.core.rig.model import Rig, Vehicle
from riglens.core.scene.grid import VoxelGrid
from riglens.core.view.heatmap_data import HeatmapData
from riglens.widgets.drawing.camera import OrbitCamera
from riglens.widgets.drawing.stage import COARSE, render_window
from riglens.widgets.heatmap.levels import DRAG_CELLS
from riglens.widgets.sensors.ray_look import RayLook
from riglens.widgets.theme import LIGHT
from riglens.widgets.viewport.drawn_scene import DrawnScene
from riglens.widgets.viewport.scene_state import SceneState
from tests.widgets.conftest import BOTH_SIZES
from tests.widgets.viewport.test_still import LIDAR, wall

CAMERA = OrbitCamera((0.0, 0.0, 0.7), 14.0, -70.0, 12.0)
STATE = SceneState(rig=Rig(sensors=(LIDAR,)), heatmap=wall(4.0), camera=CAMERA)


def picture(plotter, scene, quick):
    scene.set_quick(quick)
    scene.prepare()
    render_window(plotter).Render()
    return np.asarray(plotter.screenshot(None, return_img=True))[:, :, :3].astype(int)


def mean_off(first, second):
    """Mean difference of blocks of 10 x 10 pixels."""
    return float(np.abs(blocks(first) - blocks(second)).mean())


def blocks(image):
    height, width = (length // 10 for length in image.shape[:2])
    return image[: 10 * height, : 10 * width].reshape(height, 10, width, 10, 3).mean(axis=(1, 3))


@BOTH_SIZES
def test_a_moving_picture_shows_everything_where_it_is_at_rest(plotter):
    scene = DrawnScene(plotter)
    scene.show(STATE)
    rest, moving = (picture(plotter, scene, quick) for quick in (False, True))
    assert rest.shape == moving.shape
    assert mean_off(rest, moving) < 0.5 * mean_off(rest, np.roll(rest, 20, axis=1))
    assert np.abs(rest.mean(axis=(0, 1)) - moving.mean(axis=(0, 1))).max() < 4.0


@BOTH_SIZES
def test_only_the_haze_is_coarse_and_only_while_something_moves(plotter):
    scene = DrawnScene(plotter)
    scene.show(STATE)
    width, height = scene.size
    picture(plotter, scene, True)
    assert scene._stage.haze_size == (-(-width // COARSE), -(-height // COARSE))
    assert scene._stage.main.GetSize() == (width, height)
    picture(plotter, scene, False)
    assert scene._stage.haze_size == (width, height)


@pytest.mark.parametrize("selected", [None, "roof"])
def test_edges_are_smooth_with_and_without_anything_in_front(plotter, selected):
    scene = DrawnScene(plotter)
    scene.show(replace(STATE, heatmap=None, selected=selected, ray_look=RayLook(shown=False)))
    rough = picture(plotter, scene, False)
    scene.set_smooth(True)
    smooth = picture(plotter, scene, False)
    assert len(np.unique(smooth.reshape(-1, 3), axis=0)) > 1.2 * len(np.unique(rough.reshape(-1, 3), axis=0))


@BOTH_SIZES
def test_the_coarse_haze_follows_the_size_of_the_window(plotter):
    scene = DrawnScene(plotter)
    scene.show(STATE)
    picture(plotter, scene, True)
    render_window(plotter).SetSize(200, 150)
    rest, moving = (picture(plotter, scene, quick) for quick in (False, True))
    assert moving.shape == (150, 200, 3)
    assert mean_off(rest, moving) < 6.0


BARE = replace(STATE, heatmap=None, rig=Rig(), show_legend=False)


@BOTH_SIZES
def test_ground_and_rings_are_the_same_pixels_while_something_moves(plotter):
    scene = DrawnScene(plotter)
    scene.show(replace(BARE, camera=OrbitCamera((12.0, 0.0, 0.0), 12.0, -70.0, 40.0)))
    rest, moving = (picture(plotter, scene, quick) for quick in (False, True))
    assert len(np.unique(rest.reshape(-1, 3), axis=0)) > 4, "there are lines in it"
    assert np.array_equal(rest, moving)


@BOTH_SIZES
def test_every_frame_of_a_drag_shows_the_backdrop_and_only_the_first_draws_it(plotter):
    scene = DrawnScene(plotter)
    scene.show(STATE)
    frames = [picture(plotter, scene, True) for _ in range(3)]
    assert all(np.array_equal(frame, frames[0]) for frame in frames)
    assert not scene._stage.backdrop.GetDraw()


@pytest.mark.parametrize(
    "change",
    [
        {"camera": replace(CAMERA, azimuth_deg=-50.0)},
        {"palette": LIGHT},
        {"show_ground": False},
        {"grid": VoxelGrid(0.5, (10.0, 10.0, 4.0))},
        {"vehicle": Vehicle(length=6.0)},
    ],
    ids=lambda change: next(iter(change)),
)
def test_what_changes_the_backdrop_is_seen_in_the_next_frame_of_a_drag(plotter, change):
    scene = DrawnScene(plotter)
    scene.show(BARE)
    picture(plotter, scene, True)
    scene.show(replace(BARE, **change))
    moving = picture(plotter, scene, True)
    fresh = picture(plotter, scene, False)
    away = np.s_[: fresh.shape[0] // 3]  # from the car, whose light is painted on while something moves
    assert np.array_equal(moving[away], fresh[away])


def test_a_moving_heatmap_is_as_opaque_as_one_at_rest(plotter):
    """Cells are larger, so that fewer are behind one another."""
    deep = np.stack(np.meshgrid(*[np.arange(-6, 6, 0.2)] * 2, np.arange(0.2, 3, 0.2)), -1).reshape(-1, 3)
    cells = HeatmapData(deep.astype(np.float32), 0.2, np.full(len(deep), 0.3, np.float32), "p", "", 0.0, 1.0)
    scene = DrawnScene(plotter)
    scene.show(replace(BARE, heatmap=cells, camera=OrbitCamera((0.0, 0.0, 1.0), 20.0, -70.0, 35.0)))
    rest, moving = (picture(plotter, scene, quick) for quick in (False, True))
    assert len(deep) > DRAG_CELLS
    assert mean_off(rest, moving) < 6.0
