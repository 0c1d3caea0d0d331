"""A click on the heatmap means the nearest cell that is drawn there."""

import numpy as np
import pytest

from riglens.core.view.heatmap_data import HeatmapData
from riglens.widgets.drawing.camera import OrbitCamera
from riglens.widgets.heatmap.pick import cell_at
from riglens.widgets.heatmap.scale import HeatLook

SIZE = (400, 300)
CELL_M = 0.4
BESIDE = OrbitCamera((12.0, 0.0, 1.0), 12.0, -90.0, 20.0)
ABOVE = OrbitCamera((12.0, 0.0, 1.0), 30.0, -90.0, 90.0, parallel=True)


def heat(points, values=None) -> HeatmapData:
    centres = np.array(points, np.float32)
    shown = np.ones(len(centres), np.float32) if values is None else np.array(values, np.float32)
    return HeatmapData(centres, CELL_M, shown, "p", "", 0.0, 1.0)


def pixel_of(camera, point):
    x, y, _ = camera.project(np.array([point]), SIZE)[0]
    return float(x), float(y)


@pytest.mark.parametrize("camera", [BESIDE, ABOVE])
def test_the_nearest_of_several_cells_in_a_row_is_meant(camera):
    near = np.array([12.0, -2.0, 1.0])
    towards_eye = camera.position_m() if not camera.parallel else near - 50 * camera.axes()[2]
    behind = near + 3.0 * (near - towards_eye) / np.linalg.norm(near - towards_eye)
    found = cell_at(heat([behind, near]), HeatLook(), camera, SIZE, pixel_of(camera, near))
    assert found is not None and found.row == 1
    assert np.allclose(found.centre_m, near) and found.cell_m == CELL_M
    offset = near - found.ray.origin_m
    assert np.linalg.norm(offset - (offset @ found.ray.direction) * found.ray.direction) < 0.01


def test_between_cells_nothing_is_meant():
    data = heat([(12.0, 0.0, 1.0), (14.0, 0.0, 1.0)])
    assert cell_at(data, HeatLook(), BESIDE, SIZE, pixel_of(BESIDE, (13.0, 0.0, 1.0))) is None
    assert cell_at(data, HeatLook(), BESIDE, SIZE, pixel_of(BESIDE, (12.15, 0.0, 1.0))) is not None


def test_what_is_not_drawn_cannot_be_picked():
    data = heat([(12.0, -2.0, 1.0), (12.0, 0.0, 1.0)], [0.3, 0.9])
    at = pixel_of(BESIDE, (12.0, -2.0, 1.0))
    hit = [cell_at(data, look, BESIDE, SIZE, at) for look in (HeatLook(), HeatLook(threshold=0.5))]
    assert hit[0].row == 0 and (hit[1] is None or hit[1].row == 1)
    assert cell_at(data, HeatLook(slice_m=(2.0, 3.0)), BESIDE, SIZE, at) is None
    assert cell_at(heat(np.zeros((0, 3))), HeatLook(), BESIDE, SIZE, at) is None


def test_cells_behind_the_eye_are_not_under_the_mouse():
    camera = OrbitCamera((30.0, 0.0, 1.0), 5.0, 180.0, 0.0)
    assert cell_at(heat([(20.0, 0.0, 1.0)]), HeatLook(), camera, SIZE, (200, 150)) is None


def test_clear_cells_in_front_of_the_car_let_the_click_through():
    camera = OrbitCamera((0.0, 0.0, 1.4), 20.0, -90.0, 0.0)
    before, beyond, beside = (0.0, -5.0, 1.4), (0.0, 4.0, 1.4), (9.0, -5.0, 1.4)
    found = cell_at(heat([before, beyond, beside]), HeatLook(), camera, SIZE, pixel_of(camera, before))
    assert found is not None and found.row == 1
    found = cell_at(heat([before, beyond, beside]), HeatLook(), camera, SIZE, pixel_of(camera, beside))
    assert found is not None and found.row == 2


def test_on_the_ground_the_strongest_cell_above_the_place_is_meant():
    data = heat([(12.0, 0.0, 0.2), (12.0, 0.0, 1.0), (12.4, 0.0, 0.2)], [0.4, 0.9, 1.0])
    found = cell_at(data, HeatLook(draped=True), BESIDE, SIZE, pixel_of(BESIDE, (12.1, 0.1, 0.0)))
    assert found is not None and found.row == 1
    sliced = HeatLook(draped=True, slice_m=(0.0, 0.4))
    assert cell_at(data, sliced, BESIDE, SIZE, pixel_of(BESIDE, (12.1, 0.1, 0.0))).row == 0
    assert cell_at(data, HeatLook(draped=True), BESIDE, SIZE, pixel_of(BESIDE, (20.0, 0.0, 0.0))) is None
