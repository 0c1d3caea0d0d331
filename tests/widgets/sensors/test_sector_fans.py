"""Radars and ultrasonic sensors in the 3D view: a fan for each scan, and an arc where its range ends."""

import numpy as np
import pytest

from riglens.core.sensors.radar import Radar, RadarScan
from riglens.core.sensors.ultrasonic import Ultrasonic
from riglens.widgets.sensors.ray_look import Strokes
from riglens.widgets.sensors.rays import fan_of, fan_rows
from tests.core.builders import grid_of

GRID = grid_of(80, 80, 10, 1.0)
FAR = RadarScan(azimuth_deg=(-9.0, 9.0), elevation_deg=(-6.0, 6.0), range_m=200.0)
NEAR = RadarScan(azimuth_deg=(-60.0, 60.0), elevation_deg=(-10.0, 10.0), range_m=20.0)
RADAR = Radar(name="r", position=(0.5, 0.5, 1.0), scans=(FAR, NEAR))


def test_a_fan_is_the_middle_row_of_each_scan() -> None:
    columns, rows = RADAR.resolution
    assert set((fan_rows(RADAR, 1000) // columns).tolist()) == {rows // 4, rows // 2 + rows // 4}


def test_an_arc_is_drawn_at_the_range_and_none_where_the_region_ends_before() -> None:
    fan = fan_of(RADAR, GRID, Strokes(1000, 0.2), "#ffffff")
    ends = np.linalg.norm(np.asarray(fan.edges.points) - RADAR.position, axis=1)
    assert (np.abs(ends - 20.0) < 1e-3).sum() > 20
    assert ends.max() < 60.0  # the scan of 200 m leaves the region


def test_sound_is_drawn_up_to_the_range_of_a_pole() -> None:
    sound = Ultrasonic(name="u", position=(0.5, 0.5, 1.0), pole_range_m=3.0)
    fan = fan_of(sound, GRID, Strokes(1000, 0.2), "#ffffff")
    ends = np.linalg.norm(np.asarray(fan.rays.points) - sound.position, axis=1)
    assert ends.max() == pytest.approx(3.0, abs=1e-3)
