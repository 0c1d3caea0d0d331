"""Values at spots colour the skin around them, and nothing farther away."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import pyvista as pv
from vtkmodules.vtkRenderingCore import vtkRenderer

from riglens.core.rig.model import Vehicle
from riglens.core.view.heatmap_data import HeatmapData
from riglens.widgets.car.parts import drawn_parts
from riglens.widgets.drawing.surface import join
from riglens.widgets.heatmap.scale import colours
from riglens.widgets.viewport.gain_layer import REACH_M, SKIN, GainLayer
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


def test_the_colours_lie_just_off_the_skin_and_are_lit_as_it_is() -> None:
    layer = GainLayer(vtkRenderer())
    layer.show(CAR, DATA)
    skin = join([mesh for name, mesh in drawn_parts(CAR).items() if name in SKIN])
    points, normals = np.asarray(skin.points), np.asarray(skin.point_data["Normals"])
    shown, away = np.asarray(layer.mesh.points), np.asarray(layer.mesh.point_data["Normals"])
    assert np.linalg.norm(away, axis=1) == pytest.approx(1.0, abs=1e-3)
    for point, normal in zip(shown, away, strict=True):
        on_skin = np.abs(points - (point - 0.003 * normal)).max(axis=1)
        same = on_skin < 1e-5
        assert same.any() and np.abs(normals[same] - normal).max(axis=1).min() < 1e-5
    assert (shown[:, 2] > CAR.height).any(), "outside, not below the roof"
    corners = shown[layer.mesh.regular_faces]
    facing = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    turned = (facing * away[layer.mesh.regular_faces[:, 0]]).sum(axis=1)
    assert (turned > -1e-6).all(), "faces look to where their normals point"
