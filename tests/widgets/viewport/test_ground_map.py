"""A map on the ground: cells where they are, in their colours, and a key that says what these mean."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pyvista as pv

from riglens.core.rig.model import Rig
from riglens.core.scene.grid import VoxelGrid
from riglens.widgets.drawing.camera import OrbitCamera
from riglens.widgets.theme import DARK
from riglens.widgets.viewport.drawn_scene import DrawnScene
from riglens.widgets.viewport.ground_map import NOTHING, GroundMap, GroundStep
from riglens.widgets.viewport.scene_state import SceneState
from riglens.widgets.viewport.still import render_still

SIZE = (300, 300)
ABOVE = OrbitCamera(focal_m=(0.0, 0.0, 0.0), distance_m=80.0, elevation_deg=90.0)


def corners() -> GroundMap:
    """Cells of 4 m: red behind on the right and ahead on the left, blue ahead on the right, else nothing."""
    steps = np.full((8, 6), NOTHING, np.uint8)
    steps[0, 0], steps[7, 0], steps[7, 5] = 0, 1, 0
    meanings = (GroundStep("low", "#ff0000", 1.0), GroundStep("high", "#0000ff", 1.0))
    return GroundMap((-16.0, -12.0), 4.0, steps, meanings, "how high (less is better)")


def test_cells_lie_where_they_are_and_what_is_left_out_shows_the_ground() -> None:
    state = SceneState(
        rig=Rig(), grid=VoxelGrid(0.5, (40.0, 30.0, 4.0)), ground_map=corners(), camera=ABOVE,
        show_legend=False, palette=DARK,
    )  # fmt: skip
    image, bare = render_still(state, SIZE), render_still(replace(state, ground_map=None), SIZE)
    places = np.array([(-14.0, -10.0, 0.0), (14.0, -10.0, 0.0), (14.0, 10.0, 0.0), (-14.0, 10.0, 0.0)])
    columns, rows = ABOVE.project(places, SIZE)[:, :2].round().astype(int).T
    found = image[rows, columns, :3].astype(int)
    for pixel, strong in zip(found[:3], (0, 2, 0), strict=True):
        assert pixel[strong] > 180 and pixel[2 - strong] < 60, found
    assert np.abs(found[3] - bare[rows[3], columns[3], :3]).max() <= 2


def test_a_key_says_what_the_colours_mean_while_there_is_a_legend() -> None:
    plotter = pv.Plotter(off_screen=True, window_size=list(SIZE))
    scene = DrawnScene(plotter)
    state = SceneState(ground_map=corners())
    scene.show(state)
    assert scene._words._ground_key.texts == ("how high (less is better)", "low", "high")
    scene.show(replace(state, show_legend=False))
    assert scene._words._ground_key.texts == ()
    scene.show(replace(state, ground_map=None))
    assert scene._words._ground_key.texts == ()
    plotter.close()


def test_another_map_takes_the_place_of_the_first_whatever_its_size() -> None:
    """As in a drag, with the same cells, and of another car; each is drawn as it is from the start."""
    first = corners()
    wider = replace(first, steps=np.ones((6, 4), np.uint8), cell_m=5.0)
    plotter = pv.Plotter(off_screen=True, window_size=list(SIZE))
    scene = DrawnScene(plotter)
    base = SceneState(rig=Rig(), camera=ABOVE, show_legend=False, palette=DARK)
    column, row = ABOVE.project(np.array([(-14.0, -10.0, 0.0)]), SIZE)[0, :2].round().astype(int)
    for shown, strong in ((first, 0), (replace(first, steps=1 - first.steps), 2), (wider, 2), (first, 0)):
        scene.show(replace(base, ground_map=shown))
        scene.prepare()
        plotter.render()
        plotter.show(auto_close=False, interactive=False)
        pixel = plotter.screenshot(return_img=True)[row, column].astype(int)
        assert pixel[strong] > 180 and pixel[2 - strong] < 60, pixel
    plotter.close()
