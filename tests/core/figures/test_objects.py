"""Tables of objects: the same numbers cut by ring and sector, with changes object by object."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from riglens.core.figures.figure import ALL, CLASSES_AND_ALL, Estimate, error_of_runs
from riglens.core.figures.hits import ENOUGH_POINTS, MISSED, ON_TARGET, POINTS, SHARE_5
from riglens.core.figures.objects import ObjectFigure
from riglens.core.figures.registry import object_figures
from riglens.core.rig.model import Rig
from riglens.core.scene.boxes import CLASSES
from riglens.core.scene.sectors import SECTORS, sector_of
from riglens.core.targets.counts import Counted, ObjectCounts
from riglens.core.targets.engine import TargetEngine
from riglens.core.targets.groups import RUNS, Groups
from riglens.core.targets.settings import EXACT, HALF, HEIGHT_PX, USUAL
from riglens.core.targets.traffic import Traffic
from tests.core.builders import lidar, rig_of, spinning
from tests.core.targets.cases import by_sector, figures_of, parts, random_rig, random_traffic, traffic

RNG = np.random.default_rng(7)
TRAFFIC = random_traffic(RNG, 40)
NOW, BEFORE = random_rig(RNG), random_rig(RNG)
FIGURES = object_figures(("lidar", "camera"))


def scores(rig: Rig, frames: int | None = None, among: Traffic = TRAFFIC) -> Counted:
    return TargetEngine(among, threads=1).evaluate(rig, USUAL, frames)


@pytest.mark.parametrize("figure", FIGURES, ids=lambda figure: figure.key)
@pytest.mark.parametrize("frames", [None, 11])
def test_a_table_holds_the_numbers_of_the_scores(figure: ObjectFigure, frames: int | None) -> None:
    now = scores(NOW, frames)
    total, rings = figure.cells(now, now), figure.cells(now, now, "ring")
    for number, name in enumerate(CLASSES, start=1):
        of_class = parts(now)[name]
        for place, row in enumerate((of_class.total, *of_class.rings)):
            cells, column = (total, 0) if place == 0 else (rings, place - 1)
            estimate = row[figure.key]
            assert cells.objects[number, column] == estimate.objects
            if estimate.objects:
                assert cells.value[number, column] == estimate.value
                assert cells.se[number, column] == estimate.se
            else:
                assert math.isnan(cells.value[number, column])


@pytest.mark.parametrize("frames", [None, 11])
def test_each_object_counts_in_one_sector_and_sectors_add_up_to_what_rings_do(frames: int | None) -> None:
    now = scores(NOW, frames)
    for name, sectors in by_sector(now).items():
        rings, places = parts(now)[name].rings, list(sectors.values())
        assert tuple(sectors) == SECTORS
        assert sum(row.objects for row in places) == sum(row.objects for row in rings)
        for figure in figures_of(now):
            if not figure.is_median and figure.least == -math.inf:
                by_ring, by_place = (
                    sum(row[figure.key].objects * row[figure.key].value for row in rows)
                    for rows in (rings, places)
                )
                assert by_place == pytest.approx(by_ring)


def test_a_sector_holds_the_objects_whose_centres_are_in_it() -> None:
    now = scores(NOW)
    box = now.objects.box
    place, cls = sector_of(*TRAFFIC.centre_m[box, :2].T), TRAFFIC.cls[box]
    for number, sectors in enumerate(by_sector(now).values()):
        for sector, row in enumerate(sectors.values()):
            mine = (cls == number) & (place == sector)
            assert row.objects == mine.sum()
            assert row.on_target.value == pytest.approx(
                now.objects.on_target[mine].mean() if mine.any() else 0.0
            )


def test_an_object_with_just_enough_points_or_half_of_it_in_a_picture_is_detected() -> None:
    shown = np.array([[HALF], [HALF - 1e-9], [HALF]])
    points, height = np.array([[4], [5], [5]]), np.array([[HEIGHT_PX], [HEIGHT_PX - 1.0], [HEIGHT_PX]])
    none = np.zeros(3, np.int64)
    objects = ObjectCounts(none, ("l",), ("c",), points, height, none, none * 1.0, none, height, shown)
    counted = Counted(NOW, USUAL, Groups(TRAFFIC, 1), objects)
    values = {one.key: one.values(counted).tolist() for one in FIGURES if one.calibration is None}
    assert USUAL.min_points == 5 and values["share_min_points"] == [0.0, 1.0, 1.0]
    assert values["share_25px"] == [1.0, 0.0, 1.0] and values["both"] == [0.0, 0.0, 1.0]
    assert values["missed"] == [0.0, 0.0, 0.0] and values["seen_by_cameras"] == shown[:, 0].tolist()


def test_everybody_is_the_mean_over_all_road_users() -> None:
    now = scores(NOW)
    cells = ON_TARGET.cells(now, now)
    assert cells.objects[0, 0] == len(now.objects.box)
    assert cells.value[0, 0] == pytest.approx(now.objects.on_target.mean())


def test_changes_are_counted_road_user_by_road_user() -> None:
    now, before = scores(NOW, 9), scores(BEFORE, 9)
    differences = now.objects.on_target - before.objects.on_target
    cells = ON_TARGET.cells(now, before)
    assert cells.change[0, 0] == pytest.approx(differences.mean())
    same = ON_TARGET.cells(now, now)
    assert not np.nan_to_num(same.change).any() and not same.change_se.any()
    assert same.se[0, 0] > 0.0, "a sample still has an error of its own"


@pytest.mark.parametrize("figure", FIGURES, ids=lambda figure: figure.key)
def test_numbers_without_details_are_the_same(figure: ObjectFigure) -> None:
    now, before = scores(NOW, 11), scores(BEFORE, 11)
    full, plain = figure.cells(now, before), figure.cells(now, before, in_detail=False)
    for name in ("objects", "value", "se", "change", "change_se"):
        assert np.array_equal(getattr(full, name), getattr(plain, name), equal_nan=True)
    for who, (whole,) in figure.estimates(now, "all").items():
        (bare,) = figure.estimates(now, "all", in_detail=False)[who]
        assert replace(whole, parts={}, runs=()) == bare
        assert figure.estimates(now, "all", (who,))[who] == [whole]
    for row, (change, se) in enumerate(figure.changes(now, before).values(), start=1):
        assert (change, se) == (np.nan_to_num(full.change[row, 0]), full.change_se[row, 0])


@pytest.mark.parametrize("frames", [None, 11])
def test_the_error_of_a_change_is_that_of_means_over_runs_of_frames(frames: int | None) -> None:
    now, before = scores(NOW, frames), scores(BEFORE, frames)
    more = now.objects.on_target - before.objects.on_target
    box = now.objects.box
    run = TRAFFIC.frame[TRAFFIC.frame_of_box[box]] * RUNS // TRAFFIC.frames
    cells = ON_TARGET.cells(now, before)
    for row, who in enumerate(CLASSES_AND_ALL):
        mine = (TRAFFIC.cls[box] == row - 1) | (who == ALL)
        left = more[mine] - more[mine].mean()
        moved = [left[run[mine] == one].sum() / mine.sum() for one in np.unique(run)]
        expected = math.sqrt(sum(one**2 for one in moved) * len(moved) / (len(moved) - 1))
        assert cells.traffic_se[row, 0] == pytest.approx(max(expected, cells.change_se[row, 0]))
        (mine_, theirs) = (ON_TARGET.estimates(one, "all")[who][0] for one in (now, before))
        assert mine_.minus(theirs).se == pytest.approx(expected)


def test_a_change_to_nothing_has_the_error_of_all_that_is_lost() -> None:
    (value,) = SHARE_5.estimates(scores(NOW), "all")[ALL]
    lost = Estimate().minus(value)
    assert lost.value == -value.value and lost.se == float(error_of_runs(np.array(value.runs))) > 0.0


def test_a_median_of_an_even_number_lies_between_the_middle_two() -> None:
    boxes = [(0, 0, (x, 0.0, 1.0), (1.0, 1.0, 1.0), 0.0) for x in (5.0, 15.0)]
    among = traffic(boxes)
    rays = lidar((0.0, 0.0, 1.0))  # one ray: the near box has one point, the far one none
    found = TargetEngine(among, threads=1).evaluate(rig_of(rays), EXACT)
    assert POINTS.cells(found, found).value[0, 0] == 0.5
    assert parts(found)[CLASSES[0]].total.median_points.value == 0.5


def test_sectors_are_centred_on_the_axes_and_count_to_the_left() -> None:
    places = [(10.0, 0.0), (0.0, 10.0), (-10.0, 0.0), (0.0, -10.0), (10.0, -0.1)]
    boxes = [(0, 1, (x, y, 1.0), (1.0, 1.0, 1.0), 0.0) for x, y in places]
    among = traffic(boxes)
    found = TargetEngine(among, threads=1).evaluate(rig_of(spinning((0.0, 0.0, 1.0))), EXACT)
    cells = ON_TARGET.cells(found, found, "sector")
    assert {sector: n for sector, n in enumerate(cells.objects[2].tolist()) if n} == {
        0: 2, 2: 1, 4: 1, 6: 1,
    }  # fmt: skip


@pytest.mark.parametrize("who", CLASSES_AND_ALL)
def test_rings_cut_by_sector_hold_each_object_of_a_ring_once(who: str) -> None:
    now = scores(NOW)
    row = CLASSES_AND_ALL.index(who)
    rings, both = (ENOUGH_POINTS.cells(now, now, by).objects[row] for by in ("ring", "ring and sector"))
    assert both.reshape(len(rings), len(SECTORS)).sum(axis=1).tolist() == rings.tolist()
    if who != ALL:
        sectors = by_sector(now)[who].values()
        assert both.reshape(len(rings), len(SECTORS)).sum(axis=0).tolist() == [one.objects for one in sectors]


def test_no_objects_make_an_empty_table_with_a_reason() -> None:
    found = TargetEngine(traffic([]), threads=1).evaluate(NOW, USUAL)
    for figure in FIGURES:
        cells = figure.cells(found, found)
        assert not cells.objects.any() and np.isnan(cells.value).all()
        (estimate,) = figure.estimates(found, "all")[ALL]
        assert estimate.state == "none" and estimate.reason


def test_a_rig_without_the_sensors_of_a_figure_says_so_instead_of_zero() -> None:
    found = scores(rig_of(lidar((0.0, 0.0, 1.0))))
    for figure in object_figures(("lidar", "camera", "radar")):
        (estimate,) = figure.estimates(found, "all")["car"]
        is_made = figure.least_kinds == 1 and (not figure.kinds or "lidar" in figure.kinds)
        assert estimate.exists == is_made and (is_made or estimate.reason)
    assert MISSED.estimates(found, "all")["car"][0].exists
