"""The curve of a field: values near its own, and the changes that the counts of each rig show."""

from __future__ import annotations

import numpy as np
import pytest

from riglens.core.errors import InputError
from riglens.core.scene.boxes import CLASSES, DataReport
from riglens.core.sensors.radar import Radar, RadarScan
from riglens.core.sweep.curve import POINTS, curve, nearby_values
from riglens.core.sweep.fields import field_called, with_values
from riglens.core.sweep.rows import Sweeper, SweepFigures
from riglens.core.targets.engine import TargetEngine
from riglens.core.targets.settings import USUAL
from riglens.core.targets.traffic import traffic_of
from tests.core.sweep.test_fields import RIG
from tests.core.targets.cases import parts


@pytest.fixture(scope="module")
def traffic():
    """Objects of all classes in 12 frames."""
    rng, count = np.random.default_rng(1), 36
    turn, far = rng.uniform(0.0, 2.0 * np.pi, count), rng.uniform(5.0, 25.0, count)
    centres = np.column_stack([far * np.cos(turn), far * np.sin(turn), np.full(count, 0.8)])
    frames, classes = np.repeat(np.arange(12), 3), np.tile(np.arange(3, dtype=np.uint8), 12)
    data = DataReport("random", 12, dict.fromkeys(CLASSES, 12))
    return traffic_of(
        data, frames, classes, centres, np.full((count, 3), 1.5), np.tile(np.eye(3), (count, 1, 1))
    )


@pytest.mark.parametrize("name", ["top.z", "top.yaw", "front.yaw"])
def test_changes_are_those_of_counts_from_scratch(traffic, name):
    far = with_values(RIG, {field_called(RIG, "front.hfov_deg"): 30.0})
    field = field_called(far, name)
    sweeper = Sweeper(SweepFigures(None, USUAL, 8), far, None, traffic, threads=1)
    values = nearby_values(far, field)[::5]
    points = list(curve(far, field, values, sweeper))
    assert tuple(point.value for point in points) == values

    def figures(rig):
        rows = parts(TargetEngine(traffic, 1).evaluate(rig, USUAL, 8))
        return {
            c: rows[c].total.share_25px if name.startswith("front") else rows[c].total.on_target
            for c in CLASSES
        }

    before = figures(far)
    for value, changes in points:
        after = figures(with_values(far, {field: value}))
        assert {c: changes[c][0] for c in CLASSES} == {c: after[c].value - before[c].value for c in CLASSES}
    assert len({point.changes["car"] for point in points}) > 1
    if name.startswith("top"):
        row = sweeper.row(with_values(far, {field: values[0]}))
        noise = {c: points[0].changes[c][1] for c in CLASSES}
        assert noise == {c: 2.0 * row[f"{c}.lidar.on_target_change_se"] for c in CLASSES}
        assert max(noise.values()) > 0.0


def test_a_sensor_that_is_off_has_no_curve_where_it_alone_makes_the_figure(traffic):
    far = RadarScan(azimuth_deg=(-45.0, 45.0), elevation_deg=(-10.0, 10.0), range_m=70.0)
    radar = Radar(name="grille", position=(2.2, 0.0, 0.5), scans=(far,), enabled=False)
    rig = RIG.model_copy(update={"sensors": (*RIG.sensors, radar)})
    sweeper = Sweeper(SweepFigures(None, USUAL, 8), rig, None, traffic, threads=1)
    with pytest.raises(InputError, match=r"grille\.z"):
        list(curve(rig, field_called(rig, "grille.z"), [0.5, 0.6], sweeper))


def test_values_lie_around_that_of_the_rig_and_fit():
    values = nearby_values(RIG, field_called(RIG, "top.z"))
    assert len(values) == POINTS and 1.9 in values and values[0] == 1.4 and values[-1] == 2.4
    counts = nearby_values(RIG, field_called(RIG, "top.elevations_deg.count"))
    assert (
        counts == tuple(range(8, 25)) and nearby_values(RIG, field_called(RIG, "front.hfov_deg"))[0] == 75.0
    )
    assert min(nearby_values(RIG, field_called(RIG, "top.range_m.0"))) >= 0.0
