"""Proposals of rigs for scripts: sensors added to the car's skin, with a bound and a guard."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from riglens.arguments import StrPath
from riglens.core.optimise.mounts import LEVELS_DEG, USUAL_RULES, Additions
from riglens.core.optimise.results import OptimiseResult, Problem
from riglens.core.optimise.run import finished
from riglens.core.review.mounts import MountLimits
from riglens.core.rig.model import Rig
from riglens.core.scene.boxes import Progress
from riglens.core.targets.traffic import Traffic
from riglens.core.vehicle.mesh_file import with_mesh_read

__all__ = ["OptimiseResult", "optimise"]


def optimise(
    rig: Rig,
    traffic: Traffic,
    *,
    add: Sequence[str],
    count: int = 1,
    mirrored: bool = True,
    objective: str = "on_target",
    cost: Mapping[str, float] | None = None,
    budget: float = float("inf"),
    limits: MountLimits = USUAL_RULES,
    spots_m: float = 0.2,
    tilts_deg: Sequence[float] = LEVELS_DEG,
    frames: int = 100,
    held_out: int = 1000,
    seed: int = 0,
    against: Rig | None = None,
    blind_m: float | None = None,
    threads: int | None = None,
    mesh_folder: StrPath = ".",
    progress: Progress | None = None,
) -> OptimiseResult:
    """Propose where to add LiDARs on the car's skin; every sensor of the rig stays where it is.

    Parameters
    ----------
    rig, traffic
        The rig to add to, and the objects it is to see: made by `load_traffic`.
    add
        Models of the library to choose among.
    count, mirrored
        How many mirror pairs to add at most, or single sensors.
    objective
        "on_target": the mean over classes of the hit coverage of objects.
    cost, budget
        Cost of a sensor by model, 1 by default, and the most that all added ones may cost.
    limits, spots_m, tilts_deg
        Rules that every mount keeps, distance between neighbouring mounts, and how far sensors may lean outwards.
    frames, held_out, seed
        Number of frames to choose by, and of other frames to check in; seed of all draws.
    against
        The rig that gains are compared with; by default the best of some mounts chosen by hand.
    blind_m
        Also find the front between the objective and the area where an object of this height is in no sensor's view.
    threads
        Threads to use, all processors by default. The result does not depend on it.
    mesh_folder
        The folder from which a car body in a mesh file is named.
    progress
        Gets the share that is done.

    Raises InputError when nothing can be added, or a number is out of its range.
    """
    models = (add,) if isinstance(add, str) else tuple(add)
    additions = Additions(models, count, mirrored, cost or {}, budget, limits, spots_m, tuple(tilts_deg))
    rig = with_mesh_read(rig, Path(mesh_folder), lambda _: None)
    if against is not None:
        against = with_mesh_read(against, Path(mesh_folder), lambda _: None)
    problem = Problem(rig, traffic, additions, objective, frames, held_out, seed, against, blind_m)
    return finished(problem, threads, progress)
