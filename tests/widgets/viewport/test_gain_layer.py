"""Values at spots colour the skin around them, and nothing farther away."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pyvista as pv
from vtkmodules.vtkRenderingCore import vtkRenderer

from riglens.core.rig.model import Vehicle
from riglens.core.view.heatmap_data import HeatmapData
from riglens.widgets.heatmap.scale import colours
from riglens.widgets.viewport.gain_layer import REACH_M, GainLayer
from riglens.widgets.viewport.scene_state import SceneState

CAR = Vehicle()
SPOTS = np.array([[0.0, 0.4, CAR.height], [0.0, -0.4, CAR.height], [-0.5, 0.0, CAR.height]], np.float32)
VALUES = np.array([0.0, 0.2, np.nan], np.float32)
DATA = HeatmapData(SPOTS, 0.0, VALUES, "Gain", "", 0.0, 0.2, scale="level")


def test_the_skin_near_a_spot_has_its_colour_and_other_values_change_colours_alone() -> None:
    renderer = vtkRenderer()
    layer = GainLayer(renderer)
    layer.show(CAR, DATA)
    mesh = layer.mesh
    assert isinstance(mesh, pv.PolyData) and mesh.n_cells > 0
    away = np.linalg.norm(mesh.points[:, None] - SPOTS[None], axis=2)
    assert away.min(axis=1).max() < REACH_M + 0.01, "nothing far from all spots"
    nearest, shown = away.argmin(axis=1), np.asarray(mesh["gain"])
    assert {0, 1} <= set(nearest.tolist())
    for spot, row in ((0, 0), (1, 255)):
        assert (shown[nearest == spot, :3] == colours("level")[row]).all()
    assert (shown[nearest == 2, 3] == 0).all(), "no value, no colour"
    layer.show(CAR, replace(DATA, values=VALUES[::-1].copy()))
    assert layer.mesh is mesh and (np.asarray(mesh["gain"])[nearest == 0, 3] == 0).all()
    layer.show(CAR, replace(DATA, centres_m=SPOTS + np.float32(50.0)))
    assert not layer._actor.visibility, "no spot is on the car"
    layer.show(CAR, None)
    assert not layer._actor.visibility
    layer.show(Vehicle(body="missing.glb"), DATA)
    assert not layer._actor.visibility


def test_the_legend_is_about_the_skin_while_it_is_coloured() -> None:
    heat = HeatmapData(SPOTS, 0.4, np.ones(3, np.float32), "Seen", "nat", 0.0, 1.0)
    state = SceneState(heatmap=heat)
    assert state.legend_data is heat
    assert replace(state, skin_gain=DATA).legend_data is DATA
