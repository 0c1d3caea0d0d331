"""What road users get over the ground is what a loop over cells and road users finds."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from riglens.core.scene.boxes import CLASSES
from riglens.core.targets.counts import Counted
from riglens.core.targets.engine import TargetEngine
from riglens.core.targets.ground import CELL_M, NEAR_M, GroundView, ground_view
from tests.core.builders import rig_of, spinning
from tests.core.targets.cases import random_traffic

TRAFFIC = random_traffic(np.random.default_rng(11), 25)
SCORES = TargetEngine(TRAFFIC, threads=1).evaluate(rig_of(spinning((0.0, 0.0, 1.9))))


def near(view: GroundView, cell: tuple[int, int], scores: Counted, name: str) -> list[int]:
    """Places among the objects of those whose own cell lies near another, one by one."""
    found = []
    for k, box in enumerate(scores.objects.box.tolist()):
        own = view.cell_at(*TRAFFIC.centre_m[box, :2].tolist())
        assert own is not None
        away_m = CELL_M * np.hypot(own[0] - cell[0], own[1] - cell[1])
        if TRAFFIC.cls[box] == CLASSES.index(name) and away_m <= NEAR_M:
            found.append(k)
    return found


@pytest.mark.parametrize("name", CLASSES)
def test_every_cell_is_what_a_loop_finds(name: str) -> None:
    view = ground_view(SCORES, name)
    objects = SCORES.objects
    busy = np.argwhere(view.objects > 0)
    assert len(busy) > 20
    for ix, iy in [*busy[:: max(1, len(busy) // 60)].tolist(), [0, 0], [59, 60]]:
        mine = near(view, (ix, iy), SCORES, name)
        assert view.objects[ix, iy] == len(mine)
        assert view.missed[ix, iy] == sum(objects.all_points[k] < SCORES.settings.min_points for k in mine)
        mean = np.mean([objects.on_target[k] for k in mine]) if mine else np.nan
        assert view.on_target[ix, iy] == pytest.approx(mean, nan_ok=True)


def test_a_road_user_with_just_as_many_points_as_are_asked_for_is_not_missed() -> None:
    most = int(SCORES.objects.all_points.max())
    found = []
    for asked in (most, most + 1):
        scores = replace(SCORES, settings=replace(SCORES.settings, min_points=asked))
        views = [ground_view(scores, name) for name in CLASSES]
        found.append(sum(int(view.objects.sum() - view.missed.sum()) for view in views))
    assert found[0] > 0 and found[1] == 0


def test_every_road_user_counts_in_thirteen_cells() -> None:
    total = sum(ground_view(SCORES, name).objects.sum() for name in CLASSES)
    inside = TRAFFIC.distance_m[SCORES.objects.box] < 55.0
    assert 13 * inside.sum() <= total <= 13 * len(inside)


def test_places_beside_the_cells_are_none() -> None:
    view = ground_view(SCORES, "car")
    assert view.cell_at(0.0, 0.0) == (60, 60) and view.cell_at(-60.0, 59.9) == (0, 119)
    assert view.cell_at(59.9, -60.0) == (119, 0)
    assert (
        view.cell_at(60.0, 0.0) is None
        and view.cell_at(0.0, 60.0) is None
        and view.cell_at(0.0, -60.1) is None
    )
