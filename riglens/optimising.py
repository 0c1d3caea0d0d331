"""Proposals of rigs for scripts: sensors added to the car's skin or moved on it, with a bound and a guard."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path

from riglens.arguments import StrPath
from riglens.core.optimise import run
from riglens.core.optimise.additions import (
    LEVELS_DEG,
    SPACING_M,
    TURNS_DEG,
    USUAL_RULES,
    Additions,
    counts_of,
    moves_of,
)
from riglens.core.optimise.problem import Problem
from riglens.core.optimise.results import OptimiseResult
from riglens.core.optimise.weights import Weights
from riglens.core.review.mounts import MountLimits
from riglens.core.rig.model import Rig
from riglens.core.scene.boxes import Progress
from riglens.core.targets.traffic import Traffic
from riglens.core.vehicle.mesh_file import with_mesh_read
from riglens.scenes import Scene

__all__ = ["OptimiseResult", "optimise"]


def optimise(
    rig: Rig,
    traffic: Traffic,
    *,
    add: Sequence[str] = (),
    move: Sequence[str] | Mapping[str, float] = (),
    exchange: Mapping[str, Sequence[str]] | None = None,
    count: int = 1,
    mirrored: bool = True,
    objective: str = "on_target",
    weights: Mapping[str | tuple[float, float], float] | None = None,
    scene: Scene | None = None,
    cost: Mapping[str, float] | None = None,
    budget: float = float("inf"),
    limits: MountLimits = USUAL_RULES,
    spots_m: float = SPACING_M,
    box_m: tuple[tuple[float, float], ...] | None = None,
    tilts_deg: Sequence[float] | None = None,
    yaw_deg: Sequence[float] = (0.0,),
    frames: int = 100,
    held_out: int = 1000,
    seed: int = 0,
    against: Rig | None = None,
    blind_m: float | None = None,
    checks: Mapping[str, Traffic] | None = None,
    threads: int | None = None,
    mesh_folder: StrPath = ".",
    progress: Progress | None = None,
) -> OptimiseResult:
    """Propose where to add or move sensors on the car's skin; every other sensor of the rig stays as it is.

    Raises InputError when nothing can be added, or a number is out of its range.

    Parameters
    ----------
    rig, traffic
        The rig to add to, and the objects it is to see: made by `load_traffic`.
    add
        Models of the library to choose among; "hesai-xt32:2" for two sensors of one, "hesai-xt32:0-4" for up to four.
    move, exchange
        Sensors that may go elsewhere, with their mirror partners, anywhere or by up to some metres; models that sensors
        may be exchanged for, in their place unless they may move.
    count, mirrored
        How many mirror pairs to add at most, or single sensors, of the models without numbers of their own.
    objective
        Figure to improve: "on_target", the mean over classes of the hit coverage of objects, any other of
        `docs/optimise.md`, such as "predicted", "blind_m2", "share_25px" or "seen_lidar"; or "worst_failure".
    weights
        Weights by class and by ring [from, to) in metres.
    scene
        Voxels for the objectives of them: made by `load_scene`.
    cost, budget
        Cost of a sensor by model, 1 by default, and the most that all added ones may cost.
    limits, spots_m, tilts_deg, yaw_deg
        Rules that every mount keeps, distance between neighbouring mounts, how far sensors may lean outwards, moved
        ones further than now, and turns of added ones that look one way, from straight out.
    box_m
        From and to along x, y and z, where sensors stand in the air instead of on the skin.
    frames, held_out, seed
        Number of frames to choose by, and of other frames to check in; seed of all draws.
    against
        The rig that gains are compared with; by default the best of some typical mounts.
    blind_m
        Also find the front between the objective and the area where an object of this height is in no sensor's view.
    checks
        Other traffic to check the gain in, by the name of the case.
    threads
        Threads to use, all processors by default. The result does not depend on it.
    mesh_folder
        The folder from which a car body in a mesh file is named.
    progress
        Gets the share that is done.
    """
    models, counts = counts_of((add,) if isinstance(add, str) else tuple(add))
    tilts, turns = (LEVELS_DEG, TURNS_DEG) if tilts_deg is None else (tuple(tilts_deg),) * 2
    additions = Additions(
        models, count, mirrored, cost or {}, budget, limits, spots_m, tilts, box_m, counts, tuple(yaw_deg)
    )
    rig = with_mesh_read(rig, Path(mesh_folder), lambda _: None)
    if against is not None:
        against = with_mesh_read(against, Path(mesh_folder), lambda _: None)
    radius_m = move if isinstance(move, Mapping) else dict.fromkeys(move, math.inf)
    by_class = {name: weight for name, weight in (weights or {}).items() if isinstance(name, str)}
    rings = {ring: weight for ring, weight in (weights or {}).items() if not isinstance(ring, str)}
    problem = Problem(
        rig, traffic, additions, objective, frames, held_out, seed, against, blind_m,
        moves_of(radius_m, exchange or {}, turns), Weights(by_class, rings),
        None if scene is None else scene.field, checks=checks or {},
    )  # fmt: skip
    if progress is None:
        return run.optimise(problem, threads)
    return run.optimise(problem, threads, lambda step: progress(step.of_all))
