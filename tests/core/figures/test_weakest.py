"""Figures of objects are worst where a search through the objects one by one finds it."""

import json

import numpy as np
import pytest

from riglens.core.figures.figure import ALL
from riglens.core.figures.hits import MISSED, POINTS, SEEN_BY_CAMERAS, SHARE_5
from riglens.core.figures.objects import ObjectFigure
from riglens.core.figures.weakest import FEWEST, NOWHERE, Weakest, weakest_by_class, weakest_text
from riglens.core.review.documents import places_document
from riglens.core.rig.model import Camera, Rig
from riglens.core.scene.boxes import CLASSES
from riglens.core.scene.sectors import SECTORS, sector_of
from riglens.core.targets.counts import Counted
from riglens.core.targets.engine import TargetEngine
from riglens.core.targets.settings import USUAL
from tests.core.builders import rig_of, spinning
from tests.core.targets.cases import random_traffic, traffic

TRAFFIC = random_traffic(np.random.default_rng(5), 300, 20)
RIG = Rig(
    name="one of each",
    sensors=(
        spinning((0.0, 0.0, 1.9), beams=8, count=180),
        Camera(name="ahead", position=(0.5, 0.0, 1.5), hfov_deg=100.0, cast=(90, 40)),
    ),
)


@pytest.fixture(scope="module")
def counted() -> Counted:
    return TargetEngine(TRAFFIC, threads=1).evaluate(RIG, USUAL)


@pytest.mark.parametrize("figure", [SHARE_5, SEEN_BY_CAMERAS, MISSED], ids=lambda one: one.key)
def test_the_worst_parts_are_those_of_a_search_through_all_objects(
    figure: ObjectFigure, counted: Counted
) -> None:
    box, values = counted.objects.box, figure.values(counted)
    cls, sector = TRAFFIC.cls[box], sector_of(*TRAFFIC.centre_m[box, :2].T)
    ring = np.minimum(TRAFFIC.distance_m[box] // 10.0, 5.0)
    sign = -1.0 if figure.better == "less" else 1.0

    def worst(names: tuple[str, ...], masks: list[np.ndarray]) -> tuple[str, float]:
        means = {n: values[m].mean() for n, m in zip(names, masks, strict=True) if m.sum() >= FEWEST}
        name = min(means, key=lambda one: sign * means[one])
        return name, means[name]

    found = weakest_by_class(figure, counted)
    masks = [cls == n for n in range(len(CLASSES))]
    name, value = worst(CLASSES, masks)
    assert found[ALL].cls is not None and found[ALL].cls[0] == name
    assert found[ALL].cls[1] == pytest.approx(value)
    for mine, who in zip(masks, CLASSES, strict=True):
        name, value = worst(SECTORS, [mine & (sector == n) for n in range(len(SECTORS))])
        one = found[who].sector
        assert found[who].cls is None and one is not None
        assert (one[0], one[1]) == (name, pytest.approx(value))
        is_bad = {
            10.0 * r: sign * (values[inside].mean() - 0.5) < 0.0
            for r in range(6)
            if (inside := mine & (ring == r)).sum() >= FEWEST
        }
        beyond = [at for at in is_bad if all(bad for other, bad in is_bad.items() if other >= at)]
        expected = None if not beyond else 0.0 if beyond[0] == min(is_bad) else beyond[0]
        assert found[who].half_from_m == expected


def test_a_rig_without_the_sensors_few_objects_and_figures_in_other_units_have_less_to_say(
    counted: Counted,
) -> None:
    alone = TargetEngine(TRAFFIC, threads=1).evaluate(rig_of(spinning((0.0, 0.0, 1.9))), USUAL)
    assert set(weakest_by_class(SEEN_BY_CAMERAS, alone).values()) == {NOWHERE}
    few = TargetEngine(traffic([(0, 0, (9.0, 0.0, 1.0), (1.0, 1.0, 1.0), 0.0)]), threads=1)
    assert set(weakest_by_class(SHARE_5, few.evaluate(RIG, USUAL)).values()) == {NOWHERE}
    assert weakest_by_class(POINTS, counted)["car"].half_from_m is None


@pytest.mark.parametrize(
    "found", [NOWHERE, Weakest(("car", 0.25), ("rear", 0.125), 20.0), Weakest(half_from_m=0.0)]
)
def test_plain_data_reads_back_and_the_words_name_all_of_it(found: Weakest) -> None:
    assert Weakest.of_dict(json.loads(json.dumps(found.as_dict()))) == found
    text = weakest_text(SHARE_5, found)
    assert bool(text) == (found != NOWHERE)
    for named in (found.cls, found.sector):
        assert named is None or f"{named[0]} {100.0 * named[1]:.1f} %" in text
    assert ("20 m" in text) == (found.half_from_m == 20.0)


def test_places_of_a_change_are_those_of_a_search_through_all_objects(counted: Counted) -> None:
    lower = Rig(name="lower", sensors=RIG.sensors[:1])
    before = TargetEngine(TRAFFIC, threads=1).evaluate(lower, USUAL)
    found = places_document(MISSED, counted, before)
    box = counted.objects.box
    cls, sector = TRAFFIC.cls[box], sector_of(*TRAFFIC.centre_m[box, :2].T)
    ring = np.minimum(TRAFFIC.distance_m[box] // 10.0, 5.0)
    now, then = MISSED.values(counted), MISSED.values(before)
    for number, name in enumerate(CLASSES):
        of_class, mine = found["classes"][name], cls == number
        assert of_class["rose"] == pytest.approx((now > then)[mine].mean())
        assert of_class["fell"] == pytest.approx((now < then)[mine].mean())
        for row in range(len(found["rings_m"]) - 1):
            for column in range(len(SECTORS)):
                there = mine & (ring == row) & (sector == column)
                assert of_class["objects"][row][column] == there.sum()
                if there.any():
                    assert of_class["value"][row][column] == pytest.approx(now[there].mean())
                    assert of_class["change"][row][column] == pytest.approx((now - then)[there].mean())
                else:
                    assert of_class["value"][row][column] is None is of_class["change"][row][column]
