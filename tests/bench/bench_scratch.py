"""From scratch: all ten sensors of W+T with nothing known from before, POG ready, against plain DDA."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial

import pytest

from riglens.core.engine.engine import evaluate_from_scratch
from riglens.core.metric.scores import MetricSettings
from riglens.core.rig.model import Rig
from tests.bench.race import Goal, Race
from tests.bench.scenes import THREADS, GridRays, Scene, Scenes, grid_rays, moved, wide_trapezoid

GOAL = 8.0
ROUNDS = 7


@dataclass(frozen=True)
class _Case:
    rig: Rig
    rays: list[GridRays]


@pytest.mark.parametrize("voxel_m", [0.10, 0.05])
def test_all_sensors(race: Race, scenes: Scenes, voxel_m: float) -> None:
    scene = scenes.at(voxel_m)

    def plain(case: _Case) -> None:
        for origin, directions in case.rays:
            scene.plain.cast(origin, directions)
        scene.plain.sums()

    goal = Goal("from scratch", f"all ten sensors of W+T, {scene.edge}", GOAL)
    coming: list[Rig] = []
    answers = evaluate_from_scratch(scene.field, iter(coming.pop, None), MetricSettings(), THREADS)

    def ours(case: _Case) -> None:
        coming.append(case.rig)
        next(answers)

    race.run(
        goal,
        _cases(scene),
        ours,
        plain,
        rounds=ROUNDS,
    )


def _cases(scene: Scene) -> Iterator[_Case]:
    """W+T, every sensor a little elsewhere each time; the yardstick is cleared."""
    number = 0
    while True:
        number += 1
        scene.plain.clear()
        rig = wide_trapezoid(partial(moved, number=number))
        yield _Case(rig, [grid_rays(scene, sensor) for sensor in rig.sensors])
