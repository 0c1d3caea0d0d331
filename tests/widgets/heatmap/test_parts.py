"""A heatmap drawn in parts: every cell once and in its order, parts of about equal effort, the same picture."""

from __future__ import annotations

import numpy as np
import pytest
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkUnsignedCharArray

from riglens.widgets.drawing.camera import OrbitCamera
from riglens.widgets.drawing.stage import render_window
from riglens.widgets.heatmap.levels import LEVEL_LAYERS, RowsBehind, full_level, in_parts
from riglens.widgets.viewport.drawn_scene import DrawnScene
from tests.widgets.drawing.test_stage import STATE

RANDOM = np.random.default_rng(3)
CENTRES = RANDOM.uniform((-30, -20, 0), (30, 20, 4), (20_000, 3)).astype(np.float32)
ORDER = RANDOM.permutation(len(CENTRES))[:15_000]
SIZE = (640, 400)
FROM_ABOVE = OrbitCamera((0.0, 0.0, 0.0), 80.0, 0.0, 90.0, parallel=True)


@pytest.mark.parametrize("camera", [OrbitCamera(), FROM_ABOVE], ids=["perspective", "parallel"])
def test_parts_have_every_cell_once_and_in_order(camera: OrbitCamera) -> None:
    parts = in_parts(CENTRES, ORDER, 0.4, camera, SIZE, part_px=1e5)
    assert len(parts) > 3
    assert np.array_equal(np.concatenate(parts), ORDER)


def test_what_is_out_of_sight_takes_little_effort() -> None:
    away = OrbitCamera((500.0, 0.0, 0.0), 10.0, 180.0, 0.0)
    assert len(in_parts(CENTRES, ORDER, 0.4, away, SIZE, part_px=1e5)) < 5
    assert in_parts(CENTRES, ORDER[:0], 0.4, away, SIZE) == []


def test_a_nearer_view_has_larger_cells_and_more_parts() -> None:
    near, far = (
        len(in_parts(CENTRES, ORDER, 0.4, OrbitCamera(distance_m=distance), SIZE, 1e5))
        for distance in (25.0, 100.0)
    )
    assert near > 2 * far


def pixels(scene: DrawnScene, window) -> np.ndarray:
    width, height = scene.size
    found = vtkUnsignedCharArray()
    window.GetRGBACharPixelData(0, 0, width - 1, height - 1, 0, found, 0)
    return vtk_to_numpy(found).copy()


@pytest.mark.parametrize("smooth", [False, True], ids=["rough", "smooth"])
def test_drawn_in_parts_the_picture_is_the_same_to_the_last_bit(plotter, smooth, monkeypatch) -> None:
    monkeypatch.setattr("riglens.widgets.heatmap.levels.in_parts.__defaults__", (5e3,))
    scene, window = DrawnScene(plotter), render_window(plotter)
    scene.show(STATE)
    scene.set_smooth(smooth)
    scene.prepare()
    window.Render()
    at_once = pixels(scene, window)
    assert sum(1 for _ in scene.draw_in_parts()) > 5
    assert np.array_equal(pixels(scene, window), at_once)
    window.Render()
    assert np.array_equal(pixels(scene, window), at_once)


def test_a_picture_that_was_given_up_leaves_nothing_in_the_next_one(plotter, monkeypatch) -> None:
    monkeypatch.setattr("riglens.widgets.heatmap.levels.in_parts.__defaults__", (5e3,))
    scene, window = DrawnScene(plotter), render_window(plotter)
    scene.show(STATE)
    scene.prepare()
    window.Render()
    whole = pixels(scene, window)
    drawing = scene.draw_in_parts()
    for _ in range(5):
        next(drawing)
    drawing.close()
    window.Render()
    assert np.array_equal(pixels(scene, window), whole)


def rows_behind(deep: int) -> RowsBehind:
    """A wall of strong cells along x, so many cells deep along y."""
    x, y, z = np.meshgrid(np.arange(50), np.arange(deep), np.arange(5), indexing="ij")
    centres = (np.stack([x, y, z], axis=-1).reshape(-1, 3) * 0.4 + 0.2).astype(np.float32)
    behind = RowsBehind(full_level(centres, 0.4))
    behind.count(np.arange(len(centres)), np.ones(len(centres), np.float32))
    return behind


LEFT, FRONT, STEEP = (
    OrbitCamera(azimuth_deg=azimuth, elevation_deg=high) for azimuth, high in ((90, 0), (0, 0), (90, 30))
)


def test_cells_seen_level_are_as_faint_as_many_are_behind_one_another() -> None:
    thick = rows_behind(12)
    assert thick.thinned(LEFT) == pytest.approx(LEVEL_LAYERS / 12)
    assert thick.thinned(FRONT) < thick.thinned(LEFT) < thick.thinned(STEEP) == 1.0


def test_a_single_layer_is_seen_from_its_side_as_it_is_from_above() -> None:
    assert rows_behind(1).thinned(LEFT) == 1.0


def test_nothing_drawn_is_not_thinned_and_few_strong_cells_count_more_than_many_weak_ones() -> None:
    thick = rows_behind(12)
    thick.count(np.zeros(0, np.int64), np.zeros(0, np.float32))
    assert thick.thinned(LEFT) == 1.0
    thick.count(np.arange(50 * 12 * 5), np.full(50 * 12 * 5, 0.05, np.float32))
    assert thick.thinned(LEFT) == 1.0
