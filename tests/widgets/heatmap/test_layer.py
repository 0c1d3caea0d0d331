"""The heatmap in a scene: coarser cells merge faithfully, a drag writes values in place, the legend tells the truth."""

from dataclasses import replace

import numpy as np
import pytest
import pyvista as pv

from riglens.core.view.heatmap_data import HeatmapData
from riglens.widgets.drawing.stage import render_window
from riglens.widgets.heatmap.levels import DRAG_CELLS, coarse_level, full_level
from riglens.widgets.heatmap.scale import HeatLook
from riglens.widgets.viewport.drawn_scene import DrawnScene
from riglens.widgets.viewport.scene_state import SceneState

CELL_M = 0.4


def block_of_cells(nx: int, ny: int, nz: int) -> np.ndarray:
    axes = [CELL_M * (np.arange(count) + 0.5) for count in (nx, ny, nz)]
    centres = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    return (centres - [nx * CELL_M / 2, ny * CELL_M / 2, 0.0]).astype(np.float32)


CENTRES = block_of_cells(60, 60, 10)


def heat(values, centres=CENTRES, **more) -> HeatmapData:
    values = np.asarray(values, np.float32)
    return HeatmapData(centres, CELL_M, values, "Entropy, car", "nat", 0.0, 1.0, "cells of 0.4 m", **more)


@pytest.fixture
def plotter():
    made = pv.Plotter(off_screen=True, window_size=[960, 600], lighting="none")
    yield made
    made.close()


@pytest.fixture
def scene(plotter) -> DrawnScene:
    return DrawnScene(plotter)


def drawn(scene: DrawnScene) -> int:
    """How many cells the picture shows."""
    scene.prepare()
    cells = scene._heatmap._drawn
    assert cells is not None
    return cells.mesh.GetPolys().GetNumberOfCells() // 2


def test_a_block_shows_gain_or_loss_whichever_is_larger():
    centres = block_of_cells(4, 1, 1)
    level = coarse_level(full_level(centres, CELL_M), most=2)
    values, _ = level.merged(heat([0.2, -0.9, 0.3, -0.1], centres, scale="change"))
    assert values.tolist() == pytest.approx([-0.9, 0.3])


def test_a_block_shows_the_number_of_sensors_that_most_of_it_has():
    centres = block_of_cells(4, 1, 1)
    level = coarse_level(full_level(centres, CELL_M), most=2)
    weights = np.array([0.1, 0.8, 0.5, 0.4], np.float32)
    shown = heat([0, 2, 1, 3], centres, scale="steps", labels=("0", "1", "2", "3+"), weights=weights)
    values, strengths = level.merged(shown)
    assert values.tolist() == [2, 1]
    assert strengths.tolist() == pytest.approx([0.8, 0.5])


def everything(plotter):
    """The VTK objects of all renderers, by address."""
    renderers = render_window(plotter).GetRenderers()
    return [prop.GetAddressAsString("") for renderer in renderers for prop in renderer.GetViewProps()]


def test_a_drag_changes_values_and_no_actor(scene, plotter):
    scene.show(replace(scene.state, heatmap=heat(np.linspace(0, 1, len(CENTRES)))))
    scene.set_quick(True)
    before = drawn(scene)
    mesh = scene._heatmap._drawn.mesh
    props = everything(plotter)
    points = np.array(mesh.points)
    scene.show(replace(scene.state, heatmap=heat(np.linspace(0, 0.3, len(CENTRES)) ** 2)))
    assert 0 < drawn(scene) < before
    assert scene._heatmap._drawn.mesh is mesh
    assert np.array_equal(points, mesh.points)
    assert props == everything(plotter)


def test_what_is_below_the_threshold_is_not_drawn(scene):
    scene.show(replace(scene.state, heatmap=heat(np.linspace(0, 1, len(CENTRES)))))
    assert drawn(scene) == pytest.approx(0.98 * len(CENTRES), abs=2)
    scene.show(replace(scene.state, heat_look=HeatLook(threshold=0.75)))
    assert drawn(scene) == pytest.approx(0.25 * len(CENTRES), abs=2)
    scene.show(replace(scene.state, heat_look=HeatLook(threshold=1.0)))
    assert drawn(scene) == 0


@pytest.mark.parametrize("quick", [False, True])
def test_a_slice_of_one_layer_shows_that_layer_also_while_it_moves(scene, quick):
    scene.show(replace(scene.state, heatmap=heat(np.ones(len(CENTRES)))))
    scene.set_quick(quick)
    scene.show(replace(scene.state, heat_look=HeatLook(slice_m=(0.4, 0.8))))
    assert drawn(scene) == 60 * 60
    assert np.allclose(scene._heatmap._drawn.mesh.points[:, 2], 0.6)
    scene.show(replace(scene.state, heat_look=HeatLook(slice_m=(50.0, 51.0))))
    assert drawn(scene) == 0


def test_an_empty_heatmap_draws_nothing(scene):
    scene.show(replace(scene.state, heatmap=heat([], np.zeros((0, 3), np.float32))))
    assert drawn(scene) == 0


def test_the_legend_says_which_cells_are_shown_at_rest_and_while_it_moves(scene):
    scene.show(replace(scene.state, heatmap=heat(np.ones(len(CENTRES)))))
    scene.prepare()
    assert "cells of 0.4 m" in scene._words._legend.texts
    assert len(CENTRES) > DRAG_CELLS
    scene.set_quick(True)
    scene.prepare()
    assert "cells of 0.8 m while dragging" in scene._words._legend.texts
    scene.set_quick(False)
    scene.prepare()
    assert "cells of 0.4 m" in scene._words._legend.texts


def test_the_legend_names_unit_numbers_and_slice_and_goes_with_the_heatmap(scene):
    scene.show(replace(scene.state, heatmap=heat(np.ones(len(CENTRES)))))
    scene.show(replace(scene.state, heat_look=HeatLook(slice_m=(0.4, 0.8))))
    scene.prepare()
    assert {"Entropy, car [nat]", "slice: z from 0.4 to 0.8 m", "0", "1"} <= set(scene._words._legend.texts)
    scene.show(replace(scene.state, show_legend=False))
    assert scene._words._legend.texts == ()
    scene.show(SceneState())
    assert scene._words._legend.texts == ()
