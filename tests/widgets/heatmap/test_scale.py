"""How values become colours, opacity and a colour bar."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from riglens.core.view.heatmap_data import HeatmapData
from riglens.widgets.heatmap.scale import (
    HeatLook,
    alphas,
    bar_colours,
    bar_ticks,
    colour_rows,
    colours,
    in_slice,
    off_scale,
    on_scale,
    strength,
    tick_values,
)
from riglens.widgets.theme import DARK, rgb

LOG = HeatLook(log=True)


def data(values, scale="ramp", vmax=1.0, **more):
    values = np.asarray(values, np.float32)
    centres = np.zeros((len(values), 3), np.float32)
    return HeatmapData(centres, 0.4, values, "Entropy", "nat", 0.0, vmax, scale=scale, **more)


def rows(shown):
    return colour_rows(shown.scale, shown.values, strength(shown, shown.values, shown.weights, log=False))


def test_colours_run_from_the_lowest_to_the_highest_value_and_clip_beyond():
    assert rows(data([-1.0, 0.0, 0.5, 1.0, 9.0])).tolist() == [0, 0, 127, 255, 255]


def test_higher_values_are_brighter_and_more_opaque():
    brightness = colours() @ [0.2126, 0.7152, 0.0722]
    assert (np.diff(brightness) > -1.0).all() and brightness[-1] > brightness[0] + 100
    opacity = alphas(np.linspace(0, 1, 256, dtype=np.float32), 0.5).astype(int)
    assert (np.diff(opacity) >= 0).all() and opacity[-1] == 128


def test_changes_are_nearly_opaque_at_their_limit_and_small_ones_are_seen():
    strengths = np.array([0.05, 1.0], np.float32)
    (small, limit), (usual, _) = (alphas(strengths, 0.5, scale).astype(int) for scale in ("change", "ramp"))
    assert limit >= 0.7 * 255 and small > 4 * usual and small >= 0.15 * 255


def test_a_cell_that_stands_for_two_hides_as_much_as_both():
    strengths = np.linspace(0, 1, 256, dtype=np.float32)
    one, both = (alphas(strengths, 0.5, cells_deep=deep) / 255 for deep in (1.0, 2.0))
    assert np.abs(1.0 - (1.0 - one) ** 2 - both).max() < 0.01


def test_gains_and_losses_have_a_colour_each_and_are_as_strong_as_they_are_large():
    shown = data([-1.0, -0.25, 0.0, 0.25, 1.0], scale="change")
    assert strength(shown, shown.values, None, log=False).tolist() == [1.0, 0.25, 0.0, 0.25, 1.0]
    red, blue = (colours("change")[rows(shown)][:, channel].astype(int) for channel in (0, 2))
    assert (red[:2] > blue[:2]).all() and (blue[3:] > red[3:]).all()
    assert rows(shown)[0] == 0 and rows(shown)[-1] == 255


def test_steps_take_their_colour_from_the_value_and_their_opacity_from_the_weight():
    weights = np.array([1.0, 0.1, 0.5, 0.2], np.float32)
    shown = data([0, 1, 2, 3], scale="steps", labels=("0", "1", "2", "3+"), weights=weights)
    assert rows(shown).tolist() == [0, 1, 2, 3]
    assert strength(shown, shown.values, weights, log=False).tolist() == weights.tolist()
    assert len(np.unique(colours("steps"), axis=0)) == 4


@given(st.floats(0.002, 1.0))
def test_a_place_on_the_logarithmic_scale_can_be_read_back(share):
    place = float(on_scale(np.array([share], np.float32), log=True)[0])
    assert off_scale(place, log=True) == pytest.approx(share, rel=1e-4)


def test_a_thousandth_of_the_largest_value_is_where_the_logarithmic_scale_begins():
    assert on_scale(np.array([0.0, 1e-4, 1e-3, 1.0], np.float32), log=True).tolist() == pytest.approx(
        [0, 0, 0, 1]
    )


def test_a_slice_holds_the_cells_whose_centre_lies_in_it():
    heights = np.array([0.2, 0.6, 1.0], np.float32)
    assert in_slice(HeatLook(slice_m=(0.4, 0.8)), heights).tolist() == [1]
    assert in_slice(HeatLook(slice_m=(0.6, 1.0)), heights).tolist() == [1]
    assert in_slice(HeatLook(), heights).tolist() == [0, 1, 2]


@given(st.floats(1e-9, 1e9))
def test_numbers_of_the_bar_are_few_and_round(high):
    values = tick_values(0.0, high, log=False)
    assert 3 <= len(values) <= 6 and values[0] == 0.0 and values[-1] <= high * (1 + 1e-6)
    step = values[1]
    assert round(step / 10.0 ** np.floor(np.log10(step) + 1e-9), 6) in (1.0, 2.0, 5.0)


@given(st.floats(1e-9, 1e9))
def test_a_logarithmic_bar_is_marked_at_powers_of_ten(high):
    values = tick_values(0.0, high, log=True)
    assert len(values) == 3 and high / 10 < values[-1] <= high * (1 + 1e-6)
    places = [tick.place for tick in bar_ticks(data([high], vmax=high), LOG)]
    assert places == sorted(places) and places[0] >= 0.0 and places[-1] <= 1.0


def test_the_bar_of_changes_says_which_side_is_which():
    ticks = bar_ticks(data([1.0], scale="change", vmax=2.0), HeatLook())
    assert [(tick.place, tick.text) for tick in ticks] == [(0.0, "−2 lost"), (0.5, "0"), (1.0, "+2 gained")]


def test_every_step_is_named_in_its_field():
    shown = data([0, 1], scale="steps", labels=("0", "1", "2", "3+"))
    assert [(tick.place, tick.text) for tick in bar_ticks(shown, HeatLook())] == [
        (0.125, "0"), (0.375, "1"), (0.625, "2"), (0.875, "3+"),
    ]  # fmt: skip
    assert len(bar_colours(shown, HeatLook(), DARK)) == 4


def test_the_bar_is_empty_where_cells_are_not_drawn():
    empty = np.array(rgb(DARK.background))
    bar = bar_colours(data([1.0]), HeatLook(threshold=0.5), DARK)
    assert np.allclose(bar[:127], empty) and not np.isclose(bar[130:], empty).all(axis=1).any()
    sides = bar_colours(data([1.0], scale="change"), HeatLook(threshold=0.5), DARK)
    assert np.allclose(sides[70:186], empty) and not np.isclose(sides[[0, -1]], empty).all()
