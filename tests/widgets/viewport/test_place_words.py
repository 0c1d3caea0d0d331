"""Words and dots at places of the scene: what they say, and that none lies over another or over a sensor."""

from dataclasses import replace
from itertools import combinations, product

import numpy as np
import pytest
import pyvista as pv
from vtkmodules.vtkRenderingCore import vtkRenderer

from riglens.core.rig.model import Camera, Lidar, Rig
from riglens.core.view.heatmap_data import HeatmapData
from riglens.widgets.drawing.camera import OrbitCamera
from riglens.widgets.sensors.appearance import colour_of
from riglens.widgets.sensors.ray_look import RayLook
from riglens.widgets.theme import DARK, LIGHT, rgb
from riglens.widgets.viewport.drawn_scene import DrawnScene
from riglens.widgets.viewport.place_words import PlaceWordsLayer
from riglens.widgets.viewport.scene_state import Caption, SceneState
from riglens.widgets.viewport.words_layer import EchoLayer, text_size_px

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


@pytest.mark.parametrize("ratio", [1.0, 2.0])
@pytest.mark.parametrize("text", ["x 1.20 m", "x 1.20 m\ny -3.40 m\nz 5.60 m"])
def test_an_echo_stands_right_of_and_above_the_mouse_and_stays_in_the_view(ratio, text):
    renderer, size = vtkRenderer(), (900, 700)
    echo = EchoLayer(renderer)
    wide, high = text_size_px(text, ratio)
    lines = text.split("\n")
    assert high / len(lines) == pytest.approx(26.0 * ratio, rel=0.3), "13 px, and space between lines"
    assert wide > 7.0 * ratio * max(map(len, lines))
    for across, down in product(range(0, 901, 90), range(0, 701, 70)):
        echo.show(text, (across, down), size, ratio, LIGHT)
        left, low = across + 20.0 * ratio, size[1] - down + 26.0 * ratio
        assert (echo.box.left, echo.box.low) == (min(left, size[0] - wide), min(low, size[1] - high))
        (actor,) = renderer.GetViewProps()
        assert actor.GetVisibility() and actor.GetPosition()[:2] == (echo.box.left, echo.box.low)
    echo.show(text, (5.0, 60.0), (40, 30), ratio, LIGHT)
    assert (echo.box.left, echo.box.low) == (0.0, 0.0), "a view that is too small shows the beginning"
    echo.show("", (5.0, 5.0), size, ratio, LIGHT)
    assert echo.box is None and not actor.GetVisibility()


@pytest.mark.parametrize("palette", [LIGHT, DARK], ids=["light", "dark"])
def test_a_dot_in_the_colour_of_its_kind_with_a_rim_marks_each_sensor_that_is_small_and_in_sight(palette):
    renderer, size = vtkRenderer(), (1200, 800)
    layer = PlaceWordsLayer(renderer)
    behind = CAMERA.replace(name="behind", position=(-90.0, 0.0, 1.5))
    camera = OrbitCamera(focal_m=(0.0, 0.0, 1.0), distance_m=60.0, azimuth_deg=180.0, elevation_deg=20.0)
    rig = Rig(sensors=(BACK, CAMERA, LIDAR, behind))
    state = SceneState(rig=rig, camera=camera, palette=palette, selected="front", failed=frozenset({"back"}))
    (dots,) = renderer.GetViewProps()

    def discs(shown: SceneState) -> list[tuple[list[float], float, list[int]]]:
        """Middle, radius and colour of each disc in the picture, from the one below to the one on top."""
        layer.arrange_dots(shown, size, 1.0)
        mesh, found = pv.wrap(dots.GetMapper().GetInput()), []
        for face, colour in zip(
            mesh.regular_faces if dots.GetVisibility() else [], mesh["rgb"], strict=False
        ):
            points = np.asarray(mesh.points)[face, :2]
            middle = points.mean(axis=0)
            found.append((middle.tolist(), np.hypot(*(points - middle).T).max(), colour.tolist()))
        return found

    right, down, depth = camera.project(np.array([one.position for one in rig.sensors]), size).T
    assert (depth > 0.0).tolist() == [True, True, True, False]
    rim, of_camera, of_lidar = (
        [round(255 * part) for part in rgb(name)]
        for name in ("#10141a" if palette is DARK else "#ffffff", colour_of("camera"), colour_of("lidar"))
    )
    expected = [(1, 6.5, rim), (1, 4.5, of_camera), (2, 6.5, rim), (2, 4.5, of_lidar)]
    found = discs(replace(state, selected=""))
    assert len(found) == len(expected), "one has failed, and one is behind the eye"
    for (middle, radius, colour), (sensor, wide, expected_colour) in zip(found, expected, strict=True):
        assert middle == pytest.approx([right[sensor], size[1] - down[sensor]], abs=1e-3)
        assert radius == pytest.approx(wide, abs=1e-3) and colour == expected_colour
    assert discs(state) == found[2:], "the handles of the selected one stand in place of its dot"
    near = replace(state, camera=replace(camera, focal_m=LIDAR.position, distance_m=2.0))
    assert len(discs(near)) < len(expected), "a large one needs no dot"
    far = replace(state, camera=replace(camera, distance_m=300.0))
    assert discs(far) == [], "the car is smaller than two dots"
    assert discs(replace(state, rig=Rig(sensors=()))) == []
