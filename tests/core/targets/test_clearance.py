"""Counts do not depend on where a ray ends between the car and the nearest object."""

import math

import numpy as np
import pytest

from riglens.core.errors import never_stale
from riglens.core.sensing.body_ends import NO_EMPTY_BOX, barrier_of
from riglens.core.targets.clearance import Clearance
from riglens.core.targets.contribution import Contribution, TargetCaster
from riglens.core.targets.settings import TargetSettings
from riglens.core.targets.traffic import Traffic
from riglens.core.vehicle.solid import solid_of
from tests.core.targets.cases import random_rig, random_traffic, traffic

CAR = np.array([-2.0, -1.0, 0.0, 2.0, 1.0, 1.5])


def _traffic(centre: tuple[float, float, float], yaw_deg: float, size: tuple[float, float, float]) -> Traffic:
    return traffic([(0, 0, centre, size, math.radians(yaw_deg))])


@pytest.mark.parametrize(
    ("centre", "yaw_deg", "size", "is_clear"),
    [
        ((30.0, 0.0, 0.8), 0.0, (4.0, 2.0, 1.6), True),
        ((0.0, 2.2, 0.8), 0.0, (4.0, 2.0, 1.6), True),
        ((0.0, 1.9, 0.8), 0.0, (4.0, 2.0, 1.6), False),
        ((3.2, 2.2, 0.8), -45.0, (6.0, 2.0, 1.6), True),
        ((3.2, 2.2, 0.8), -45.0, (6.0, 4.0, 1.6), False),
        ((0.0, 0.0, 1.9), 0.0, (4.0, 2.0, 0.2), False),
        ((0.0, 0.0, 2.2), 0.0, (4.0, 2.0, 0.2), True),
    ],
)
def test_room_ends_where_an_object_begins(
    centre: tuple[float, float, float], yaw_deg: float, size: tuple[float, float, float], is_clear: bool
) -> None:
    found = Clearance(_traffic(centre, yaw_deg, size)).empty_box(CAR, np.array([0.0, 0.0, 1.9]), (0, 1))
    assert (found is not NO_EMPTY_BOX) == is_clear
    if is_clear:
        assert found.tolist() == [-2.0, -1.0, 0.0, 2.0, 1.0, 1.9]


def test_objects_of_other_frames_and_sensors_far_from_the_car() -> None:
    clearance = Clearance(_traffic((0.0, 0.0, 1.0), 0.0, (1.0, 1.0, 1.0)))
    assert clearance.empty_box(CAR, np.array([0.0, 0.0, 1.0]), (0, 0)) is not NO_EMPTY_BOX
    assert clearance.empty_box(CAR, np.array([0.0, 0.0, 9.0]), (0, 0)) is NO_EMPTY_BOX


def _hits(made: Traffic, seed: int) -> list[Contribution]:
    rig, settings = random_rig(np.random.default_rng(seed), 5), TargetSettings(body="blocks")
    solid, caster = solid_of(rig.vehicle), TargetCaster(made)
    found = [caster.cast(one, settings, barrier_of(one, solid), (0, 4), never_stale) for one in rig.sensors]
    return [one for one in found if one is not None]


@pytest.mark.parametrize("seed", range(12))
def test_counts_are_those_of_exact_ends(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    made = random_traffic(np.random.default_rng(seed), 4, 2 if seed % 2 else 12)
    quick = _hits(made, seed)
    monkeypatch.setattr(Clearance, "empty_box", lambda *_: NO_EMPTY_BOX)
    for one, exact in zip(quick, _hits(made, seed), strict=True):
        assert (one.found == exact.found).all() and (one.cells == exact.cells).all()
