"""Tables of targets: the numbers of the scores, cut by ring and sector, with changes road user by road user."""

from __future__ import annotations

import math

import numpy as np
import pytest

from riglens.core.rig.model import Rig
from riglens.core.scene.boxes import CLASSES
from riglens.core.scene.sectors import SECTORS, sector_of
from riglens.core.targets.engine import TargetEngine
from riglens.core.targets.quantities import CLASSES_AND_ALL, QUANTITIES, Quantity
from riglens.core.targets.scores import ObjectCounts, TargetScores, sectors_of
from riglens.core.targets.settings import EXACT, HEIGHT_PX, USUAL
from riglens.core.targets.tables import rose_of, table_of
from riglens.core.targets.traffic import Traffic
from tests.core.builders import lidar, rig_of, spinning
from tests.core.targets.cases import random_rig, random_traffic, traffic

RNG = np.random.default_rng(7)
TRAFFIC = random_traffic(RNG, 40)
NOW, BEFORE = random_rig(RNG), random_rig(RNG)
ROWS = {
    "on_target": "on_target", "lidar": "share_n", "points": "median_points", "visible": "visible",
    "camera": "share_25px", "height": "median_height_px", "both": "both", "neither": "neither",
}  # fmt: skip


def quantity(key: str) -> Quantity:
    return next(one for one in QUANTITIES if one.key == key)


def scores(rig: Rig, frames: int | None = None, among: Traffic = TRAFFIC) -> TargetScores:
    return TargetEngine(among, threads=1).evaluate(rig, USUAL, frames)


@pytest.mark.parametrize("key", list(ROWS))
@pytest.mark.parametrize("frames", [None, 11])
def test_a_table_holds_the_numbers_of_the_scores(key: str, frames: int | None) -> None:
    now = scores(NOW, frames)
    table = table_of(TRAFFIC, now, now, quantity(key))
    for number, name in enumerate(CLASSES, start=1):
        of_class = now.classes[name]
        for place, row in enumerate((of_class.total, *of_class.rings)):
            told = getattr(row, ROWS[key])
            value, se = (told.value, told.se) if hasattr(told, "se") else (told, 0.0)
            assert table.cells.objects[number, place] == row.objects
            if row.objects:
                assert table.cells.value[number, place] == pytest.approx(value, rel=1e-12, abs=1e-15)
                assert table.cells.se[number, place] == pytest.approx(se, rel=1e-9, abs=1e-15)
            else:
                assert math.isnan(table.cells.value[number, place])


@pytest.mark.parametrize("frames", [None, 11])
def test_each_object_counts_in_one_sector_and_sectors_add_up_to_what_rings_do(frames: int | None) -> None:
    now = scores(NOW, frames)
    for name, sectors in sectors_of(TRAFFIC, now).items():
        rings, parts = now.classes[name].rings, list(sectors.values())
        assert tuple(sectors) == SECTORS
        assert sum(row.objects for row in parts) == sum(row.objects for row in rings)
        for key in ("on_target", "share_1", "share_5", "share_n", "visible", "share_25px", "both", "neither"):
            by_sector = sum(row.objects * getattr(row, key).value for row in parts)
            assert by_sector == pytest.approx(sum(row.objects * getattr(row, key).value for row in rings))
        known = [[row.predicted for row in rows if row.predicted] for rows in (parts, rings)]
        by_sector, by_ring = (sum(one.objects * one.value for one in found) for found in known)
        assert by_sector == pytest.approx(by_ring)


def test_a_sector_holds_the_objects_whose_centres_are_in_it() -> None:
    now = scores(NOW)
    box = now.objects.box
    place, cls = sector_of(*TRAFFIC.centre_m[box, :2].T), TRAFFIC.cls[box]
    for number, sectors in enumerate(sectors_of(TRAFFIC, now).values()):
        for sector, row in enumerate(sectors.values()):
            mine = (cls == number) & (place == sector)
            assert row.objects == mine.sum()
            assert row.on_target.value == pytest.approx(
                now.objects.on_target[mine].mean() if mine.any() else 0.0
            )


def test_who_has_just_as_many_points_and_pixels_as_are_asked_for_is_detected() -> None:
    points, height = np.array([[4], [5], [5]]), np.array([[HEIGHT_PX], [HEIGHT_PX - 1.0], [HEIGHT_PX]])
    none = np.zeros(3, np.int64)
    objects = ObjectCounts(none, ("l",), ("c",), points, height, none, none * 1.0, none, height)
    told = {key: quantity(key).of(objects, USUAL).tolist() for key in ("lidar", "camera", "both", "neither")}
    assert USUAL.min_points == 5 and told["lidar"] == [0.0, 1.0, 1.0]
    assert told["camera"] == [1.0, 0.0, 1.0] and told["both"] == [0.0, 0.0, 1.0]
    assert told["neither"] == [0.0, 0.0, 0.0]


def test_everybody_is_the_mean_over_all_road_users() -> None:
    now = scores(NOW)
    cells = table_of(TRAFFIC, now, now, quantity("on_target")).cells
    assert cells.objects[0, 0] == len(now.objects.box)
    assert cells.value[0, 0] == pytest.approx(now.objects.on_target.mean())


def test_changes_are_counted_road_user_by_road_user() -> None:
    now, before = scores(NOW, 9), scores(BEFORE, 9)
    differences = now.objects.on_target - before.objects.on_target
    cells = table_of(TRAFFIC, now, before, quantity("on_target")).cells
    assert cells.change[0, 0] == pytest.approx(differences.mean())
    same = table_of(TRAFFIC, now, now, quantity("on_target")).cells
    assert not np.nan_to_num(same.change).any() and not same.change_se.any()
    assert same.se[0, 0] > 0.0, "a sample still has an error of its own"


def test_a_median_of_an_even_number_lies_between_the_middle_two() -> None:
    boxes = [(0, 0, (x, 0.0, 1.0), (1.0, 1.0, 1.0), 0.0) for x in (5.0, 15.0)]
    among = traffic(boxes)
    rays = lidar((0.0, 0.0, 1.0))  # one ray: the near box has one point, the far one none
    found = TargetEngine(among, threads=1).evaluate(rig_of(rays), EXACT)
    assert table_of(among, found, found, quantity("points")).cells.value[0, 0] == 0.5
    assert found.classes[CLASSES[0]].total.median_points == 0.5


def test_sectors_are_centred_on_the_axes_and_count_to_the_left() -> None:
    places = [(10.0, 0.0), (0.0, 10.0), (-10.0, 0.0), (0.0, -10.0), (10.0, -0.1)]
    boxes = [(0, 1, (x, y, 1.0), (1.0, 1.0, 1.0), 0.0) for x, y in places]
    among = traffic(boxes)
    found = TargetEngine(among, threads=1).evaluate(rig_of(spinning((0.0, 0.0, 1.0))), EXACT)
    rose = rose_of(among, found, found, quantity("on_target"), "bicycle")
    assert {sector: n for sector, n in enumerate(rose.cells.objects.sum(axis=0).tolist()) if n} == {
        0: 2, 2: 1, 4: 1, 6: 1,
    }  # fmt: skip


@pytest.mark.parametrize("who", CLASSES_AND_ALL)
def test_a_rose_holds_everybody_of_the_rings_once(who: str) -> None:
    now = scores(NOW)
    rose = rose_of(TRAFFIC, now, now, quantity("lidar"), who)
    table = table_of(TRAFFIC, now, now, quantity("lidar"))
    assert rose.cells.objects.shape[1] == len(SECTORS)
    if who in CLASSES:
        by_sector = sectors_of(TRAFFIC, now)[who].values()
        assert rose.cells.objects.sum(axis=0).tolist() == [row.objects for row in by_sector]
    assert (
        rose.cells.objects.sum(axis=1).tolist()
        == table.cells.objects[CLASSES_AND_ALL.index(who), 1:].tolist()
    )


def test_nobody_makes_an_empty_table() -> None:
    among = traffic([])
    found = TargetEngine(among, threads=1).evaluate(NOW, USUAL)
    for each in QUANTITIES:
        cells = table_of(among, found, found, each).cells
        assert not cells.objects.any() and np.isnan(cells.value).all()
