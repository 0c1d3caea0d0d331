"""A camera alone: the proposal against every pose that it may have."""

import numpy as np
import pytest

from riglens.core.optimise.additions import Additions, counts_of
from riglens.core.optimise.candidates import choices_of
from riglens.core.optimise.problem import Problem
from riglens.core.optimise.weights import Weights
from riglens.core.review.mounts import MountLimits
from riglens.core.rig.model import Rig
from riglens.core.scene.boxes import CLASSES
from riglens.core.targets.engine import TargetEngine
from riglens.core.targets.traffic import Traffic
from tests.core.optimise.problems import proposed
from tests.core.targets.cases import random_traffic

NEAR_M = 40.0
LENSES = "nuscenes-front/nuscenes-back:1"


def best_pose(traffic: Traffic, frames: int, additions: Additions) -> int:
    """Compare a proposal for pedestrians within 40 m with brute force by the engine; the number of poses."""
    near = Weights({"pedestrian": 1.0, "car": 0.0, "bicycle": 0.0}, {(NEAR_M, 1000.0): 0.0})
    problem = Problem(Rig(), traffic, additions, "seen_by_cameras", frames, 8, weights=near)
    result = proposed(problem)
    (added,) = result.best.added
    engine, values = TargetEngine(traffic, 1), dict[str, float]()
    for one in choices_of(problem.rig, problem.additions, problem.seed, moves=problem.moves).candidates:
        rig = problem.rig.replace(sensors=one.sensors)
        objects = engine.evaluate(rig, problem.settings, frames).objects
        of_class = traffic.cls[objects.box] == CLASSES.index("pedestrian")
        counts = of_class & (traffic.distance_m[objects.box] < NEAR_M)
        values[one.sensors[0].name] = float(objects.visible[counts].mean())
    best = max(values.values())
    assert values[added.sensors[0].name] == pytest.approx(best, abs=1e-9)
    assert result.best.value == pytest.approx(best, abs=1e-9)
    assert result.bound is not None and result.bound.kind == "proven"
    return len(values)


def test_the_best_yaw_and_lens_for_pedestrians_are_those_of_brute_force() -> None:
    models, counts = counts_of((LENSES,))
    rules = MountLimits(height_m=(0.4, 100.0))
    additions = Additions(
        models,
        mirrored=True,
        rules=rules,
        spots_m=0.4,
        tilts_deg=(0.0, 8.0),
        counts=counts,
        yaw_deg=(-30.0, 0.0, 30.0),
    )
    assert best_pose(random_traffic(np.random.default_rng(3), 30), 6, additions) >= 12
