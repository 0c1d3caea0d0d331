"""Words and dots at places of the scene: what they say, and that none lies over another or over a sensor."""

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest

from riglens.core.rig.model import Camera, Lidar, Rig
from riglens.core.view.heatmap_data import HeatmapData
from riglens.widgets.sensors.ray_look import RayLook
from riglens.widgets.viewport.drawn_scene import DrawnScene
from riglens.widgets.viewport.scene_state import Caption, SceneState

CAMERA = Camera(name="front", position=(0.3, 0.0, 1.5), image=(1600, 900), hfov_deg=65.0)
BACK = CAMERA.replace(name="back", position=(-1.0, 0.0, 1.5), rpy_deg=(0.0, 0.0, 180.0))
LIDAR = Lidar(name="roof", position=(-0.4, 0.0, 1.8), elevations_deg=(-10.0, 0.0))
STATE = SceneState(rig=Rig(sensors=(BACK, CAMERA, LIDAR)))


def words(plotter, state: SceneState, size: tuple[int, int] = (1280, 800)) -> tuple[str, ...]:
    plotter.window_size = list(size)
    scene = DrawnScene(plotter)
    scene.show(state)
    scene.set_view("iso")
    scene.prepare()
    return scene._places.texts


def test_rings_and_the_bands_of_the_camera_that_looks_ahead_are_labelled(plotter):
    found = words(plotter, STATE)
    assert {"5 m", "10 m", "20 m"} <= set(found)
    assert {"25 px/m", "63 px/m", "125 px/m", "250 px/m"} & set(found)
    assert "front" not in found, "a name for the selection only"


@pytest.mark.parametrize("name", ["front", "roof"])
def test_the_selection_says_its_name_and_a_lidar_has_no_bands(plotter, name):
    found = words(plotter, replace(STATE, selected=name))
    assert name in found
    assert any(word.endswith("px/m") for word in found) == (name == "front")


def test_without_legends_ground_or_footprints_there_are_fewer(plotter):
    assert words(plotter, replace(STATE, show_legend=False)) == ()
    assert not [word for word in words(plotter, replace(STATE, show_ground=False)) if word.endswith(" m")]
    bare = replace(STATE, ray_look=RayLook(fill="none"))
    assert not [word for word in words(plotter, bare) if word.endswith("px/m")]


def test_a_small_picture_has_fewer_labels_rather_than_crossing_ones(plotter):
    large = len(words(plotter, replace(STATE, selected="front")))
    plotter.clear()
    assert len(words(plotter, replace(STATE, selected="front"), (220, 140))) < large


def test_the_legend_stands_on_the_table_of_a_picture_that_reaches_below_it(plotter):
    plotter.window_size = [800, 600]
    row = ("a class with a long name", *("100.0 ±10.0 %",) * 5)
    data = HeatmapData(np.zeros((1, 3), np.float32), 0.5, np.ones(1, np.float32), "unseen", "nat", 0.0, 1.0)
    for table in ((row, row), ((*row[:1], "1"),) * 2):
        scene = DrawnScene(plotter)
        scene.show(replace(STATE, caption=Caption("rig", "", table), heatmap=data))
        scene.prepare()
        boxes = scene._words.boxes()
        assert len(boxes) == 5
        assert not any(one.meets(other) for one, other in combinations(boxes, 2))
