"""Heatmap on the ground: what lies above a place decides its colour, and nothing of it is invented."""

import numpy as np
import pytest

from riglens.core.view.heatmap_data import HeatmapData
from riglens.widgets.heatmap.drape import drape_colours, draped, places_of
from riglens.widgets.heatmap.scale import USUAL_LOOK, HeatLook, bar_colours, draped_ramp
from riglens.widgets.theme import DARK, LIGHT, rgb

CELL_M = 0.4


def data(values: np.ndarray, unit: str = "nat", scale: str = "ramp", **more: object) -> HeatmapData:
    """A heatmap with values (nx, ny, nz) at the cells of a grid."""
    index = np.argwhere(np.ones(values.shape, bool))
    centres = ((index + 0.5) * CELL_M - 4.0).astype(np.float32)
    return HeatmapData(
        centres, CELL_M, values.ravel().astype(np.float32), "t", unit, 0.0, float(np.abs(values).max()),
        scale=scale, **more,
    )  # fmt: skip


def test_entropies_are_summed_over_the_height_and_only_spread_to_neighbours():
    values = np.random.default_rng(3).random((9, 7, 4))
    shown, strength = draped(data(values), HeatLook(), places_of(data(values)))
    assert shown.shape == (11, 9) and shown.sum() == pytest.approx(values.sum(), rel=1e-5)
    single = np.zeros((9, 7, 4))
    single[4, 3, 1] = single[4, 3, 2] = 1.0
    shown, strength = draped(data(single), HeatLook(), places_of(data(single)))
    assert shown[5, 4] == pytest.approx(0.5) and shown.argmax() == np.ravel_multi_index((5, 4), shown.shape)
    assert (shown[3:8, 2:7] > 0.0).sum() == 9 and strength.max() == 1.0


def test_of_probabilities_the_highest_counts_and_a_slice_leaves_others_out():
    values = np.zeros((5, 5, 3))
    values[2, 2] = (0.1, 0.6, 0.3)
    shown, _ = draped(data(values, ""), HeatLook(), places_of(data(values)))
    assert shown[3, 3] == pytest.approx(0.6 / 4)
    low = HeatLook(slice_m=(-4.0, -3.7))
    assert draped(data(values, ""), low, places_of(data(values)))[0][3, 3] == pytest.approx(0.1 / 4)


def test_changes_keep_their_sign_and_steps_the_one_with_most_weight():
    values = np.zeros((5, 5, 2))
    values[2, 2] = (-3.0, 1.0)
    shown, strength = draped(data(values, "nat", "change"), HeatLook(), places_of(data(values)))
    assert shown[3, 3] == pytest.approx(-0.5) and strength[3, 3] == 1.0
    steps = np.array([[[1.0, 3.0, 3.0]]])
    weights = np.array([0.5, 0.2, 0.2], np.float32)
    stepped = data(steps, "", "steps", labels=("0", "1", "2", "3+"), weights=weights)
    assert draped(stepped, HeatLook(), places_of(stepped))[0][1, 1] == 1.0


@pytest.mark.parametrize("palette", [DARK, LIGHT])
def test_low_values_are_clear_and_the_highest_have_the_end_of_the_scale(palette):
    one = data(np.ones((1, 1, 1)))
    strengths = np.array([[0.0, 0.17, 0.4, 1.0]])
    rgba = drape_colours(one, USUAL_LOOK, strengths, strengths, palette)[0]
    assert rgba[:2, 3].tolist() == [0, 0] and 0 < rgba[2, 3] < rgba[3, 3] == int(255 * 0.85)
    assert np.allclose(rgba[3, :3] / 255.0, rgb(palette.heat[-1]), atol=0.01)
    assert np.allclose(
        draped_ramp(np.array([0.0, 1.0]), palette), [rgb(palette.heat[0]), rgb(palette.heat[-1])]
    )


def test_a_heatmap_without_cells_is_draped_as_nothing():
    empty = HeatmapData(np.zeros((0, 3), np.float32), CELL_M, np.zeros(0, np.float32), "t", "nat", 0.0, 1.0)
    assert places_of(empty).shape == (0, 0)


@pytest.mark.parametrize("palette", [DARK, LIGHT])
def test_the_ground_is_clear_where_little_is_lost_and_opaque_where_little_is_reached(palette):
    shares, weights = np.array([[0.0, 10.0, 100.0]]), np.ones((1, 3))
    level = data(np.array([[[100.0]]]), "%", "level")
    lost = data(np.array([[[100.0]]]), "%", "level", is_loss=True)
    (_, *opaque), (clear, faint, full) = (
        drape_colours(one, USUAL_LOOK, shares, weights, palette)[0, :, 3].tolist() for one in (level, lost)
    )
    assert min(opaque) > 200 and (clear, faint) == (0, 0) and full > 200
    bar = bar_colours(lost, USUAL_LOOK, palette)
    assert bar[0] == pytest.approx(rgb(palette.ground)) and bar[-1] == pytest.approx(rgb(palette.heat[-1]))
