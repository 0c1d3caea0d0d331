"""The backdrop may be drawn smaller and stretched: the picture keeps its size, its places and its colours."""

from dataclasses import replace

import numpy as np
import pytest
import pyvista as pv

from riglens.core.rig.model import Rig
from riglens.widgets.drawing.camera import OrbitCamera
from riglens.widgets.drawing.stage import COARSE, render_window
from riglens.widgets.viewport.drawn_scene import DrawnScene
from riglens.widgets.viewport.scene_state import SceneState
from tests.widgets.viewport.test_still import LIDAR, wall

CAMERA = OrbitCamera((0.0, 0.0, 0.7), 14.0, -70.0, 12.0)
STATE = SceneState(rig=Rig(sensors=(LIDAR,)), heatmap=wall(4.0), camera=CAMERA)


@pytest.fixture(params=[(320, 200), (323, 199)], ids=["even", "odd"])
def plotter(request):
    plotter = pv.Plotter(off_screen=True, window_size=list(request.param), lighting="none")
    render_window(plotter).SetMultiSamples(0)
    yield plotter
    plotter.close()


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


def test_a_moving_picture_shows_everything_where_it_is_at_rest(plotter):
    scene = DrawnScene(plotter)
    scene.show(STATE)
    rest, moving = (picture(plotter, scene, quick) for quick in (False, True))
    assert rest.shape == moving.shape
    assert mean_off(rest, moving) < 0.5 * mean_off(rest, np.roll(rest, 20, axis=1))
    assert np.abs(rest.mean(axis=(0, 1)) - moving.mean(axis=(0, 1))).max() < 4.0


def test_only_the_backdrop_is_coarse_and_only_while_something_moves(plotter):
    scene = DrawnScene(plotter)
    scene.show(STATE)
    width, height = scene.size
    picture(plotter, scene, True)
    assert scene._stage.backdrop_size == (-(-width // COARSE), -(-height // COARSE))
    assert scene._stage.main.GetSize() == (width, height)
    picture(plotter, scene, False)
    assert scene._stage.backdrop_size == (width, height)


@pytest.mark.parametrize("selected", [None, "roof"])
def test_edges_are_smooth_with_and_without_anything_in_front(plotter, selected):
    scene = DrawnScene(plotter)
    scene.show(replace(STATE, heatmap=None, selected=selected))
    rough = picture(plotter, scene, False)
    scene.set_smooth(True)
    smooth = picture(plotter, scene, False)
    assert len(np.unique(smooth.reshape(-1, 3), axis=0)) > 1.2 * len(np.unique(rough.reshape(-1, 3), axis=0))


def test_smooth_edges_leave_places_colours_and_words_alone(plotter):
    scene = DrawnScene(plotter)
    scene.show(STATE)
    rough = picture(plotter, scene, False)
    scene.set_smooth(True)
    smooth = picture(plotter, scene, False)
    assert scene.is_smooth and 0.0 < mean_off(rough, smooth) < 2.0
    width = scene.size[0]
    legend = np.s_[-40:, width // 2 :]
    assert np.abs(rough[legend] - smooth[legend]).max() < 25 < np.abs(rough - smooth).max()


def test_the_coarse_backdrop_follows_the_size_of_the_window(plotter):
    scene = DrawnScene(plotter)
    scene.show(STATE)
    picture(plotter, scene, True)
    render_window(plotter).SetSize(200, 150)
    rest, moving = (picture(plotter, scene, quick) for quick in (False, True))
    assert moving.shape == (150, 200, 3)
    assert mean_off(rest, moving) < 6.0
