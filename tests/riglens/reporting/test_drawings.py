"""Drawings of a report's page: the car in three dimensions, and maps that a dark page recolours."""

import re
from types import SimpleNamespace

import numpy as np
import pytest

from riglens.core.rig.presets import preset
from riglens.reporting.drawings import view_data
from riglens.reporting.plans import _middle_of
from riglens.reporting.svg import DARK, DEGREES, PAPER, Drawing
from riglens.widgets.theme import rgb


def test_a_sensor_of_which_all_is_blocked_is_in_the_picture_without_rays() -> None:
    rig = preset("Line")
    everything = {"azimuth_deg": (-180.0, 180.0), "elevation_deg": (-90.0, 90.0)}
    blind = rig.sensors[0].replace(name="blind", blocked=(everything,))
    seeing, unseeing = view_data(rig.replace(sensors=(rig.sensors[0], blind)))["rays"]
    assert seeing["ends"] and not unseeing["ends"]


def test_the_cells_of_a_map_are_covered_once_each_and_no_others() -> None:
    chosen = np.random.default_rng(1).random((13, 17)) < 0.6
    chosen[:, -1] = chosen[4] = True
    drawing = Drawing("map", 40.0, 40.0, "cells")
    drawing.cells(chosen, (1.0, 2.0), 0.5, DEGREES[0])
    drawn = str(drawing.__html__())
    assert 'transform="translate(1.000 2.000) scale(0.50000)"' in drawn
    covered = np.zeros(chosen.shape, np.int64)
    for column, row, wide, back in re.findall(r"M(\d+) (\d+)h(\d+)v1h-(\d+)z", drawn):
        assert wide == back
        covered[int(row), int(column) : int(column) + int(wide)] += 1
    assert np.array_equal(covered, chosen)


def test_degrees_move_away_from_the_paper_on_light_and_dark_pages_alike() -> None:
    def light(colour: str) -> float:
        return float(np.dot(rgb(colour), (0.2126, 0.7152, 0.0722)))

    for colours, paper in ((DEGREES, PAPER), ([DARK[one] for one in DEGREES], DARK[PAPER])):
        away = [abs(light(one) - light(paper)) for one in colours]
        assert away == sorted(away) and away[0] > 0.08


def test_the_number_of_a_footprint_is_at_its_middle_or_nearer_in_the_same_direction() -> None:
    square_m = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])

    def at(x_m: float, y_m: float) -> tuple[float, float]:
        band = SimpleNamespace(patches=[np.add(square_m, (x_m, y_m)), 0.5 * square_m])
        return _middle_of(SimpleNamespace(bands=[band]), (50.0, 40.0), 2.0, 100.0)  # type: ignore[arg-type]

    assert at(30.0, -40.0) == pytest.approx((50.0 + 80.0, 40.0 - 60.0))
    assert at(60.0, -80.0) == pytest.approx((50.0 + 0.8 * 124.0, 40.0 - 0.6 * 124.0))
