"""Random problems: whatever a search picks, locked sensors stay and every mount keeps the rules."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from riglens.core.errors import InputError
from riglens.core.geometry import Pose
from riglens.core.optimise.additions import Additions, Move
from riglens.core.optimise.candidates import choices_of, mounted, rules_for
from riglens.core.optimise.search import search
from riglens.core.optimise.space import filled
from riglens.core.review.mounts import MountLimits, Overhang, violations
from riglens.core.rig.edits import mirrored_pose, with_mirror_image
from riglens.core.rig.library import default_library
from riglens.core.rig.model import PARAMETRIC_BODIES, Rig, Vehicle
from tests.core.optimise.problems import random_table

MODELS = ("generic-16", "velodyne-vlp-16")


def random_rig(rng: np.random.Generator) -> Rig:
    """A car with a LiDAR on the roof, sometimes a pair, sometimes a painted zone."""
    body = PARAMETRIC_BODIES[int(rng.integers(len(PARAMETRIC_BODIES)))]
    car = Vehicle(body=body, length=4.7, width=1.9, height=float(rng.uniform(1.4, 2.0)))
    entry = default_library().entry(MODELS[int(rng.integers(2))])
    rig = Rig(vehicle=car, sensors=(entry.sensor("roof", Pose((0.0, 0.0, car.height + 0.05))),))
    if rng.random() < 0.6:
        place = (float(rng.uniform(-1.0, 0.2)), 0.5, car.height + 0.05)
        left = entry.sensor("left", Pose(place, (0.0, 0.0, float(rng.uniform(-20.0, 20.0)))))
        rig = with_mirror_image(rig.replace(sensors=(*rig.sensors, left)), "left", "right")
    if rng.random() < 0.3:
        rig = rig.replace(keep_out=((0.5, 0.0, car.height, 0.4),))
    return rig


def random_moves(rng: np.random.Generator, rig: Rig) -> tuple[Move, ...]:
    """Some of the sensors, near where they are or anywhere, now and then to be exchanged."""
    names = [name for name in ("roof", "right") if name in {sensor.name for sensor in rig.sensors}]
    return tuple(
        Move(name, float(rng.choice([0.0, 0.6, np.inf])), MODELS[: int(rng.integers(0, 2))])
        for name in names
        if rng.random() < 0.5
    )


def keep_locks_and_rules(seed: int) -> None:
    """Search a random problem with a random figure, and look at the rig."""
    rng = np.random.default_rng(seed)
    rig = random_rig(rng)
    moves = random_moves(rng, rig)
    rules = MountLimits(
        height_m=(float(rng.uniform(0.3, 0.8)), float(rng.uniform(1.5, 3.0))),
        spacing_m=float(rng.uniform(0.1, 0.6)),
        gap_m=float(rng.uniform(0.08, 0.2)),
        beyond_m=Overhang(left=0.1, right=0.1, front=float(rng.uniform(0.0, 0.2)), rear=0.05),
        width_m=rig.vehicle.width + 0.2,
        keep_out=None if rng.random() < 0.5 else (),  # few coarse spots are left by the usual zones
    )
    costs = {"generic-16": float(rng.uniform(0.5, 2.0))}
    budget = float(rng.choice([np.inf, 2.0, 5.0]))
    added = MODELS[:1] if rng.random() < 0.7 or not moves else ()
    counts = {model: (0, int(rng.integers(1, 5))) for model in added if rng.random() < 0.4}
    additions = Additions(
        added, int(rng.integers(1, 4)), bool(rng.random() < 0.6), costs, budget, rules, 1.4, (0.0, 15.0),
        counts=counts,
    )  # fmt: skip
    try:
        choices = choices_of(rig, additions, seed, moves=moves)
    except InputError as error:
        assert "\n" not in str(error)
        return
    rules, listed = rules_for(rig, rules), choices.candidates
    limits, stays = choices.limits, choices.stays
    table = filled(random_table(rng, len(listed)), choices)
    assert limits.allow(stays)
    chosen = search(table, limits, stays)
    found = mounted(rig, [listed[one] for one in chosen])
    assert {sensor.name for sensor in rig.sensors} <= {sensor.name for sensor in found.sensors}
    for sensor in choices.rest.sensors:
        assert found.sensor(sensor.name) == sensor
    assert limits.costs[chosen].sum() <= budget * (1.0 + 1e-9)
    most = counts[added[0]][1] if counts else 2 * additions.count
    assert len(found.sensors) - len(rig.sensors) <= most
    for sensor in found.sensors:
        if sensor.mirror_of is not None:
            assert sensor.pose == mirrored_pose(found.sensor(sensor.mirror_of).pose)
    own = {sensor.name: sensor for sensor in rig.sensors}
    changed = {sensor.name for sensor in found.sensors if own.get(sensor.name) != sensor}
    in_place = {
        sensor.name
        for sensor in found.sensors
        if sensor.name in own and own[sensor.name].position == sensor.position
    }
    broken = [one for one in violations(found, rules) if one.sensor in changed - in_place]
    assert broken == []


@settings(max_examples=6, deadline=None)
@given(st.integers(0, 1 << 32))
def test_locks_and_rules_hold_in_random_problems(seed: int) -> None:
    keep_locks_and_rules(seed)


@pytest.mark.slow
@settings(max_examples=1000, deadline=None)
@given(st.integers(0, 1 << 32))
def test_locks_and_rules_hold_in_a_thousand_random_problems(seed: int) -> None:
    keep_locks_and_rules(seed)
