"""What road users get over the ground is what a loop over cells and road users finds."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from riglens.core.figures.heatmaps import MISSED_OBJECTS, OF_TARGETS, ObjectHeatMap
from riglens.core.figures.objects import ObjectFigure
from riglens.core.figures.registry import object_figures
from riglens.core.scene.boxes import CLASSES
from riglens.core.targets.counts import Counted
from riglens.core.targets.engine import TargetEngine
from riglens.core.targets.ground import CELL_M, GroundView, ground_view
from riglens.core.targets.settings import NEAR_M
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
    view, objects = ground_view(SCORES, name), SCORES.objects
    means, missed = OF_TARGETS.over(view), MISSED_OBJECTS.over(view)
    busy = np.argwhere(means.objects > 0)
    assert len(busy) > 20
    for ix, iy in [*busy[:: max(1, len(busy) // 60)].tolist(), [0, 0], [59, 60]]:
        mine = near(view, (ix, iy), SCORES, name)
        assert means.objects[ix, iy] == missed.objects[ix, iy] == len(mine)
        assert missed.values[ix, iy] == sum(objects.all_points[k] < SCORES.settings.min_points for k in mine)
        mean = np.mean([objects.on_target[k] for k in mine]) if mine else np.nan
        assert means.values[ix, iy] == pytest.approx(100.0 * mean, nan_ok=True)


@pytest.mark.parametrize("figure", [figure for figure in object_figures() if not figure.is_median])
def test_any_figure_of_objects_can_be_spread_over_the_ground(figure: ObjectFigure) -> None:
    """Objects without a value of the figure count nowhere."""
    heat, values = ObjectHeatMap.of(figure), figure.values(SCORES)
    found = heat.over(ground_view(SCORES, "car"))
    for ix, iy in np.argwhere(ground_view(SCORES, "car").near(np.ones(len(values)))[0] > 0)[::40].tolist():
        mine = values[near(found.ground, (ix, iy), SCORES, "car")]
        mine = mine[~np.isnan(mine)]
        assert found.objects[ix, iy] == len(mine)
        wanted = 100.0 * max(mine.mean(), figure.least) if len(mine) else np.nan
        assert found.values[ix, iy] == pytest.approx(wanted, nan_ok=True)
    data = heat.data(found)
    assert len(data.values) == np.count_nonzero(found.objects) and not np.isnan(data.values).any()
    assert data.vmax == 100.0 and data.unit == "%"


def test_a_road_user_with_just_as_many_points_as_are_asked_for_is_not_missed() -> None:
    most = int(SCORES.objects.all_points.max())
    found = []
    for asked in (most, most + 1):
        scores = replace(SCORES, settings=replace(SCORES.settings, min_points=asked))
        missed = [MISSED_OBJECTS.over(ground_view(scores, name)) for name in CLASSES]
        found.append(sum(int((one.objects - one.values).sum()) for one in missed))
    assert found[0] > 0 and found[1] == 0


def test_every_road_user_counts_in_thirteen_cells() -> None:
    total = sum(OF_TARGETS.over(ground_view(SCORES, name)).objects.sum() for name in CLASSES)
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
