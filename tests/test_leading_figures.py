"""The leading figures of all sorts of rigs: value or reason, moved by the sensors they count, the same everywhere."""

import json

import numpy as np
import pytest

from riglens.app.terminal.figures import leading_table
from riglens.core.figures.documents import evaluation_document
from riglens.core.figures.evaluated import Evaluated, EvaluationSettings, Evaluator
from riglens.core.figures.figure import ALL, CLASSES_AND_ALL, Figure
from riglens.core.figures.objects import ObjectFigure
from riglens.core.figures.registry import leading_figures
from riglens.core.figures.text import estimate_text
from riglens.core.figures.values import FigureCells, values_of_objects
from riglens.core.figures.weakest import Weakest, weakest_by_class
from riglens.core.metric.scores import PAPER_SETTINGS
from riglens.core.rig.model import Camera, Rig, Sensor
from riglens.core.scene.boxes import CLASSES
from riglens.core.sweep.rows import Sweeper, SweepFigures
from riglens.core.targets.settings import USUAL
from riglens.results import RigResult
from tests.core.builders import grid_of, random_field, spinning
from tests.core.targets.cases import random_traffic
from tests.core.test_sectors import radar

TRAFFIC = random_traffic(np.random.default_rng(4), 30, 12)
FIELD = random_field(grid_of(20, 16, 6, 1.0), np.random.default_rng(0))
ROOF, LOW = spinning((0.0, 0.0, 1.9), beams=16, count=720), spinning((1.5, 0.5, 0.6), beams=8, count=360)
AHEAD = Camera(name="ahead", position=(0.5, 0.0, 1.5), hfov_deg=150.0, cast=(90, 40))
ASIDE = Camera(
    name="aside", position=(0.0, 0.5, 1.5), rpy_deg=(0.0, 0.0, 90.0), hfov_deg=100.0, cast=(90, 40)
)
RADAR, REAR = radar((2.0, 0.0, 0.5), name="radar"), radar((-2.0, 0.0, 0.5), name="rear")
RIGS: dict[str, tuple[Sensor, ...]] = {
    "none": (),
    "off": (ROOF.replace(name="roof", enabled=False),),
    "lidar": (ROOF.replace(name="roof"),),
    "low": (LOW.replace(name="low"),),
    "lidars": (ROOF.replace(name="roof"), LOW.replace(name="low")),
    "camera": (AHEAD,),
    "cameras": (AHEAD, ASIDE),
    "radar": (RADAR,),
    "radars": (RADAR, REAR),
    "fused": (ROOF.replace(name="roof"), AHEAD, ASIDE),
    "seeing radar": (AHEAD, RADAR),
    "all": (ROOF.replace(name="roof"), AHEAD, ASIDE, RADAR),
}
COUNTED = {
    "predicted": ("lidar", "camera"),
    "share_5": ("lidar",),
    "seen_by_cameras": ("camera",),
    "missed": ("lidar", "camera", "radar"),
}
"""Kinds of sensors that each of the four counts."""


@pytest.fixture(scope="module")
def evaluator() -> Evaluator:
    return Evaluator(FIELD, TRAFFIC, EvaluationSettings(PAPER_SETTINGS, USUAL), 1)


def the_four() -> list[ObjectFigure]:
    return [one for one in leading_figures() if isinstance(one, ObjectFigure)]


def test_four_figures_of_objects_lead_in_this_order_and_the_score_of_the_paper_is_last() -> None:
    assert [one.key for one in leading_figures()] == [*COUNTED, "s_ms"]


@pytest.mark.parametrize("name", RIGS)
def test_each_has_a_value_or_a_reason_and_all_count_the_same_objects(name: str, evaluator: Evaluator) -> None:
    found = evaluator(Rig(name=name, sensors=RIGS[name]))
    kinds = {one.kind for one in RIGS[name] if one.enabled}
    for who in CLASSES_AND_ALL:
        estimates = {one.key: one.of(found, who) for one in the_four()}
        for key, one in estimates.items():
            assert one.exists == bool(kinds & set(COUNTED[key])), key
            assert one.exists or "no enabled" in one.reason
        assert len({one.objects for one in estimates.values() if one.exists}) <= 1


@pytest.mark.parametrize("name", [name for name in RIGS if name not in ("none", "off")])
def test_each_moves_with_the_sensors_that_it_counts_and_with_no_other(
    name: str, evaluator: Evaluator
) -> None:
    sensors = RIGS[name]
    before = evaluator(Rig(name=name, sensors=sensors))
    for place, sensor in enumerate(sensors):
        x, y, _ = sensor.position
        r, p, yaw = sensor.rpy_deg
        edited = sensor.replace(position=(x - 1.0, y, 1.2), rpy_deg=(r, p, yaw + 75.0))
        moved = evaluator(Rig(name=name, sensors=(*sensors[:place], edited, *sensors[place + 1 :])))
        for figure in the_four():
            changes = [figure.change(moved, before, cls).value for cls in CLASSES]
            assert any(changes) == (sensor.kind in COUNTED[figure.key]), (sensor.name, figure.key)


def test_a_rig_is_compared_with_the_first_of_several_with_its_name(evaluator: Evaluator) -> None:
    found = [evaluator(Rig(name="van", sensors=sensors)) for sensors in RIGS.values()]
    _, *others = evaluation_document(FIELD, PAPER_SETTINGS, found)["rigs"]
    assert len(others) == len(RIGS) - 1 and all("van (1)" in one["against_first"] for one in others)


@pytest.mark.parametrize("name", RIGS)
def test_window_terminal_python_json_and_sweeps_show_the_same(name: str, evaluator: Evaluator) -> None:
    rig = Rig(name=name, sensors=RIGS[name])
    found = evaluator(rig)
    assert found.objects is not None
    document = json.loads(json.dumps(evaluation_document(FIELD, PAPER_SETTINGS, [found])))
    figures = [one["figures"] for one in document["rigs"][0]["classes"].values()]
    lacking = [one for every in figures for one in every.values() if one["value"] is None]
    assert not any(one["se"] for one in lacking), "an error of a value that there is not"
    result = RigResult(FIELD, FIELD, found)
    row = Sweeper(SweepFigures(PAPER_SETTINGS, USUAL, None), rig, FIELD, TRAFFIC, threads=1).row(rig)
    table, *_ = leading_table([found])
    columns = [list(column.cells) for column in table.columns[1:]]  # type: ignore[union-attr]
    values = values_of_objects(found.objects)
    for number, figure in enumerate(the_four()):
        in_window = FigureCells.of(figure, found.objects, found.objects)
        assert str(columns[number][1]).strip("()").startswith(shown(figure, found, ALL))
        mean, weakest = figure.of(found, ALL), weakest_by_class(figure, found.objects)
        written = document["rigs"][0]["figures"][figure.key]
        assert written["value"] == (mean.value if mean.exists else None) and written["se"] == mean.se
        assert values[figure.key][ALL] == mean == result.means[figure.key]
        assert result.rows()[-1].get(figure.key) == (mean.value if mean.exists else None)
        assert Weakest.of_dict(written["weakest"]) == weakest[ALL] == in_window.weakest[ALL]
        assert result.weakest(figure.key) == weakest
        for line, cls in enumerate(CLASSES):
            one = figure.of(found, cls)
            written = document["rigs"][0]["classes"][cls]["figures"][figure.key]
            assert values[figure.key][cls] == one == result[cls].figures[figure.key]
            assert in_window.at(cls)[0].value == pytest.approx(one.value) or not one.exists
            assert in_window.at(cls)[0].exists == one.exists
            assert written["value"] == (one.value if one.exists else None)
            assert written["reason"] == (one.reason or None)
            assert str(columns[number][2 * line + 3]).strip("()").startswith(shown(figure, found, cls))
            if one.exists:
                assert row[figure.column(cls)] == one.value


def shown(figure: Figure, found: Evaluated, cls: str) -> str:
    return estimate_text(figure, figure.of(found, cls))
