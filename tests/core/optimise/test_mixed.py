"""Shopping lists of several kinds under one budget: against brute force, and where each kind is mounted."""

from collections import Counter
from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest

from riglens.core.errors import InputError
from riglens.core.optimise.additions import Additions, counts_of
from riglens.core.optimise.candidates import choices_of, mounted
from riglens.core.optimise.problem import Problem
from riglens.core.optimise.run import solved
from riglens.core.optimise.space import cast
from riglens.core.optimise.tables import UNIT
from riglens.core.review.mounts import MountLimits, violations
from riglens.core.rig.edits import mirrored_pose
from riglens.core.rig.model import PARAMETRIC_BODIES, Lidar, LinearAngles, Rig, Vehicle
from riglens.core.vehicle.solid import solid_of
from riglens.core.vehicle.standing import status_of
from tests.core.targets.cases import random_traffic

ANYWHERE = MountLimits(height_m=(0.4, 100.0), spacing_m=0.25, keep_out=())
OWN = Lidar(
    name="own",
    position=(0.0, 0.0, 1.8),
    elevations_deg=LinearAngles(from_=-20.0, to=5.0, count=4),
    azimuths_deg=LinearAngles(from_=-180.0, to=180.0, count=90),
)
LIST = ("nuscenes-front/nuscenes-back:0-1", "generic-corner-radar:2", "generic-16:0-2")
COSTS = {"generic-16": 2.0, "generic-corner-radar": 0.5}


def listed(words: tuple[str, ...], **more: object) -> Additions:
    """What a shopping list adds at few places."""
    models, counts = counts_of(words)
    usual = {"rules": ANYWHERE, "spots_m": 0.4, "tilts_deg": (0.0,), "counts": counts, "costs": COSTS}
    return Additions(models, **{**usual, **more})  # type: ignore[arg-type]


@pytest.mark.parametrize("objective", ["blind_m2", "missed"])
@pytest.mark.parametrize(("seed", "budget"), [(0, 4.0), (1, 6.0), (2, float("inf"))])
def test_no_set_of_mixed_kinds_beats_what_is_proven_or_the_bound(
    objective: str, seed: int, budget: float
) -> None:
    traffic, rig = random_traffic(np.random.default_rng(seed), 30), Rig(sensors=(OWN,))
    problem = Problem(rig, traffic, listed(LIST, budget=budget), objective, 6, 8, seed)
    every = choices_of(problem.rig, problem.additions, problem.seed, moves=problem.moves)
    kinds = {sensor.kind for one in every.candidates for sensor in one.sensors}
    assert kinds == {"camera", "lidar", "radar"}
    rng = np.random.default_rng(seed)
    some = sorted(
        place
        for model in ("nuscenes-front", "nuscenes-back", "generic-corner-radar", "generic-16")
        for place in rng.permutation(
            [n for n, c in enumerate(every.candidates) if c.sensors[0].model == model]
        )[:3]
    )
    assert len(some) <= 14
    listed_ones = tuple(every.candidates[n] for n in some)
    choices = replace(every, candidates=listed_ones, limits=every.limits.among(some))
    few = cast(problem, choices, 1)
    ((found, *_), bound, _), limits = solved(few), few.choices.limits
    sets = [
        list(chosen)
        for count in range(6)
        for chosen in combinations(range(len(some)), count)
        if limits.allow(chosen)
    ]
    best = max(sets, key=few.goal.value)
    assert bound is not None and limits.allow(found)
    assert few.goal.value(found) <= few.goal.value(best)
    whole = few.goal.value(best) - few.figure.value(best)
    assert bound.value >= few.goal.value(best) - whole - 1e-8 * UNIT
    assert (bound.kind == "proven") == few.figure.is_submodular
    if bound.kind == "proven":
        assert few.goal.value(found) >= few.goal.value(best) - 1e-8 * UNIT
    proposed = few.choices.rig_with(found)
    models = Counter(sensor.model for sensor in proposed.sensors)
    assert models["generic-corner-radar"] == 2 and models["generic-16"] in (0, 2)
    assert models["nuscenes-front"] + models["nuscenes-back"] <= 1
    spent = sum(COSTS.get(sensor.model or "", 1.0) for sensor in proposed.sensors if sensor != OWN)
    assert spent <= budget
    left, right = (one for one in proposed.sensors if one.model == "generic-corner-radar")
    assert right.pose == mirrored_pose(left.pose)


@pytest.mark.parametrize("body", PARAMETRIC_BODIES)
def test_each_kind_is_mounted_where_it_belongs(body: str) -> None:
    height = {"sedan": 1.45, "suv": 1.7, "van": 2.4}.get(body, 2.9)
    car = Vehicle(body=body, length=4.7, width=1.9, height=height)  # type: ignore[arg-type]
    rig = Rig(vehicle=car)
    for model in ("generic-corner-radar", "generic-ultrasonic"):
        found = choices_of(rig, Additions((model,), spots_m=0.3, tilts_deg=(0.0,))).candidates
        places = np.array([one.places_m[0] for one in found])
        assert (np.abs(places[:, 0]) > 0.35 * car.length).all()
        assert (places[:, 2] < 0.8).all()
        for one in found:
            assert violations(mounted(rig, [one]), MountLimits()) == ()
    solid = solid_of(car)
    one_camera = Additions(
        ("nuscenes-front",), spots_m=0.3, tilts_deg=(0.0,), counts={"nuscenes-front": (0, 1)}
    )
    cameras = choices_of(rig, one_camera).candidates
    behind = [one for one in cameras if status_of(one.sensors[0], solid).behind_glass]
    assert behind, "behind the windscreen"
    for one in behind:
        assert violations(mounted(rig, [one]), MountLimits()) == ()
        assert abs(one.sensors[0].rpy_deg[2]) < 20.0
    lidars = choices_of(rig, Additions(("generic-16",), spots_m=0.3, tilts_deg=(0.0,))).candidates
    assert not any(status_of(one.sensors[0], solid).behind_glass for one in lidars)


def test_cameras_may_hang_from_mirrors_and_lidars_may_not() -> None:
    half_m = Vehicle().width / 2.0
    for model, may in (("nuscenes-front", True), ("generic-16", False)):
        found = choices_of(Rig(), Additions((model,), spots_m=0.18, tilts_deg=(0.0,))).candidates
        on_mirrors = [one for one in found if one.on is not None and abs(one.on.point_m[1]) > half_m]
        assert bool(on_mirrors) == may


def test_one_of_several_models_is_named_with_a_stroke() -> None:
    models, counts = counts_of(("a/b:1", "c:0-2", "d"))
    assert models == ("a", "b", "c", "d") and counts == {"a/b": (1, 1), "c": (0, 2)}
    with pytest.raises(InputError, match="once"):
        counts_of(("a/b:1", "b:2"))
    choices = choices_of(Rig(), listed(LIST))
    slots = {one.sensors[0].model: one.slot for one in choices.candidates}
    assert slots["nuscenes-front"] == slots["nuscenes-back"] != slots["generic-16"]
