"""The curve of a field comes point by point, and is given up for a newer one."""

# ruff: noqa: F811

from __future__ import annotations

import pytest

from riglens.app.background.field_sweep import FieldRequest, field_curve
from riglens.app.background.worker import Context
from riglens.core.errors import Cancelled
from riglens.core.sweep.curve import FRAMES, nearby_values
from riglens.core.sweep.fields import field_called
from riglens.core.sweep.rows import Sweeper, SweepFigures
from riglens.core.targets.settings import USUAL
from tests.core.sweep.test_curve import traffic  # noqa: F401
from tests.core.sweep.test_fields import RIG


def context(published, stale_after=1000):
    """Context that keeps what is published, and is stale after some points."""
    return Context(lambda: len(published) >= stale_after, lambda: False, published.append, lambda _: None)


def test_points_come_one_by_one(traffic):
    field, published = field_called(RIG, "top.z"), []
    found = field_curve(FieldRequest(RIG, field, USUAL, traffic), context(published))
    assert [point.value for point in found.points] == list(nearby_values(RIG, field))
    assert [len(one.points) for one in published] == list(range(1, len(found.points) + 1))
    assert found.has_floor and not published[-1].has_floor


def test_the_last_answer_adds_the_noise_floor_of_a_sweep(traffic):
    field, published = field_called(RIG, "top.z"), []
    found = field_curve(FieldRequest(RIG, field, USUAL, traffic), context(published))
    floor = Sweeper(SweepFigures(None, USUAL, FRAMES), RIG, None, traffic, 1).noise_floor()
    for before, after in zip(published[-1].points, found.points, strict=True):
        for name, (change, noise) in after.changes.items():
            assert (change, noise - before.changes[name][1]) == (
                before.changes[name][0],
                pytest.approx(floor[f"{name}.lidar.on_target"]),
            )
    assert max(floor[f"{name}.lidar.on_target"] for name in found.points[0].changes) > 0.0


def test_a_curve_is_given_up_for_a_newer_one(traffic):
    published = []
    with pytest.raises(Cancelled):
        field_curve(FieldRequest(RIG, field_called(RIG, "top.z"), USUAL, traffic), context(published, 3))
    assert len(published) == 3
