"""Lowest visible heights on the map: colours by steps, contours, the value of a place, and a summary with areas."""

import numpy as np
import pytest
from PySide6.QtGui import QColor
from pytestqt.qtbot import QtBot

from riglens.core.blind.outline import Outline
from riglens.core.blind.zones import HEIGHTS_M, NONE, BlindMap, BlindSettings, Ground, by_names, grid_around
from riglens.core.rig.model import Rig, Vehicle
from riglens.core.scene.grid import VoxelGrid
from riglens.widgets.maps.lowest_items import Lowest, lowest_colours, lowest_summary, lowest_text
from riglens.widgets.maps.map_view import MapView
from riglens.widgets.maps.paint import argb
from riglens.widgets.theme import BLIND_COLOURS
from tests.widgets.maps.test_map_view import colour_at

VEHICLE = Vehicle(length=4.0, width=2.0)
SETTINGS = BlindSettings(0.25, within_m=5.0)


@pytest.fixture(scope="module")
def lowest() -> Lowest:
    """Ahead of x = 3 m seen from 0.25 m up, behind -3 m by nobody, else from 1.0 m up, and by two sensors nowhere."""
    outline = Outline.of(VEHICLE)
    grid = grid_around(outline, SETTINGS)
    ground = Ground.of(grid, outline, SETTINGS.bands_m)
    levels = np.full((1, 3, *grid.shape[:2]), NONE, np.uint16)
    ahead = np.where(ground.x_m > 3.0, 0, np.where(ground.x_m < -3.0, int(NONE), 3))
    levels[0, 0] = ahead[:, None]
    return Lowest(BlindMap(Rig(vehicle=VEHICLE), SETTINGS, grid, ground, ("any",), levels), "any", 1)


def test_steps_are_the_number_of_heights_below_the_lowest_visible_one(lowest: Lowest) -> None:
    found = lowest.found
    for by in by_names():
        for k in (1, 2):
            above = found.lowest_m(by, k)[..., None] > np.array(HEIGHTS_M) + 1e-9
            np.testing.assert_array_equal(found.steps(by, k), above.sum(axis=2))


def test_colours_are_those_of_steps_and_contours_are_darker(lowest: Lowest) -> None:
    shown, ground = lowest_colours(lowest), lowest.found.ground
    column = int(np.argmin(np.abs(ground.y_m - 1.6)))
    at = {x: shown[int(np.argmin(np.abs(ground.x_m - x))), column] for x in (-4.0, -3.1, 0.0, 2.9, 4.0)}
    assert at[-4.0] == argb(BLIND_COLOURS[5]) and at[0.0] == argb(BLIND_COLOURS[3])
    assert at[4.0] == argb(BLIND_COLOURS[1])
    for x in (-3.1, 2.9):  # the higher side of a step
        plain = BLIND_COLOURS[5 if x < 0 else 3]
        assert QColor(int(at[x])).lightness() < 0.6 * QColor(plain).lightness()
    assert (shown[~ground.counts] == 0).all() and (shown[ground.counts] >> 24 == 255).all()


@pytest.mark.parametrize(
    ("x_m", "y_m", "text"),
    [
        (4.0, 1.6, "seen by 1 sensor from 0.25 m up"),
        (0.0, 1.6, "seen by 1 sensor from 1.00 m up"),
        (-4.0, 1.6, "unseen by any sensor up to 2 m"),
        (0.0, 0.0, "the car itself"),
        (6.9, 5.9, "more than 5 m from the car"),
        (90.0, 0.0, "more than 5 m from the car"),
    ],
)
def test_a_place_tells_its_value(lowest: Lowest, x_m: float, y_m: float, text: str) -> None:
    assert lowest_text(lowest, (x_m, y_m)) == text


def test_the_summary_tells_areas_in_m2_and_the_direction(lowest: Lowest) -> None:
    area = lowest.found.area_m2(0.8).sum()
    text = lowest_summary(lowest)
    assert (
        text.startswith("Unseen by any sensor: ")
        and f", {area:.1f}, " in text
        and " m² at 0.3, 0.8, 1.8 m" in text
        and text.endswith("less is better")
    )
    assert lowest_summary(Lowest(lowest.found, "lidar", 2)).startswith("Seen by fewer than 2 LiDARs: ")


def test_the_map_shows_all_that_is_looked_at_and_goes_back(qtbot: QtBot, lowest: Lowest) -> None:
    view = MapView()
    qtbot.addWidget(view)
    view.resize(300, 360)
    view.set_grid(VoxelGrid(0.5, (100.0, 80.0, 4.0)))
    before = view.plane.scale
    view.set_lowest(lowest)
    assert view.plane.scale > 3.0 * before
    assert colour_at(view, 4.2, 1.6) == QColor(BLIND_COLOURS[1])
    assert view.readout() == lowest_summary(lowest)
    view.set_lowest(None)
    assert view.plane.scale == before
