"""What an edit costs is learnt for each sensor, from evaluations that cast that sensor alone."""

from __future__ import annotations

import pytest

from riglens.core.rig.model import Rig
from riglens.evaluation.edit_costs import REMEMBERED, EditCosts
from tests.app.window_bench import LIDAR, RIG


def moved(name: str, x: float, rig: Rig = RIG) -> Rig:
    return rig.with_sensor(name, rig.sensor(name).replace(position=(x, 0.0, 2.0)))


@pytest.fixture
def costs() -> EditCosts:
    """The small rig is held; it took 40 ms for two sensors."""
    costs = EditCosts()
    costs.note(RIG, 40.0)
    return costs


def test_nothing_new_to_cast_costs_nothing(costs: EditCosts) -> None:
    roof = RIG.sensor("roof")
    for same in (RIG, RIG.replace(name="other"), RIG.with_sensor("roof", roof.replace(name="top"))):
        assert costs.expected_ms(same) == 0.0
    off = RIG.with_sensor("roof", roof.replace(enabled=False))
    assert costs.expected_ms(off) == 0.0


def test_before_the_first_time_everything_is_a_guess_of_nothing() -> None:
    unknown = EditCosts()
    assert unknown.expected_ms(RIG) == unknown.slowest_ms(RIG) == 0.0 and unknown.is_guess(RIG)
    assert not unknown.is_guess(RIG.replace(sensors=()))


def test_a_sensor_that_was_never_moved_is_guessed_from_all(costs: EditCosts) -> None:
    assert costs.expected_ms(moved("roof", 1.0)) == 20.0
    assert costs.expected_ms(moved("front", 1.0, moved("roof", 1.0))) == 40.0
    assert costs.is_guess(moved("roof", 1.0))


def test_each_sensor_has_its_own_median(costs: EditCosts) -> None:
    rig = RIG
    for x, elapsed_ms in ((1.0, 3.0), (2.0, 100.0), (3.0, 5.0)):
        rig = moved("roof", x, rig)
        costs.note(rig, elapsed_ms)
    assert costs.expected_ms(moved("roof", 9.0, rig)) == 5.0
    assert not costs.is_guess(moved("roof", 9.0, rig))
    assert costs.expected_ms(moved("front", 9.0, rig)) == 20.0
    assert costs.slowest_ms(rig) == 20.0


def test_old_times_are_forgotten(costs: EditCosts) -> None:
    rig = RIG
    for step in range(2 * REMEMBERED):
        rig = moved("roof", float(step), rig)
        costs.note(rig, 500.0 if step < REMEMBERED else 2.0)
    assert costs.expected_ms(moved("roof", -1.0, rig)) == 2.0


def test_linking_a_mirror_pair_costs_nothing() -> None:
    pair = RIG.replace(sensors=(LIDAR, LIDAR.replace(name="left", position=(0.1, -0.2, 1.9))))
    costs = EditCosts()
    costs.note(pair, 30.0)
    linked = pair.with_sensor("left", pair.sensor("left").replace(mirror_of="roof"))
    assert costs.expected_ms(linked) == 0.0
