"""A new figure is one declaration: two made-up figures go through the whole product.

`TWENTY`, a share of objects, leads; `SEEN_TWICE` is of voxels. Nothing else in the program names them.
"""

import csv
import io
import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import get_args

import numpy as np
import pytest
from pytestqt.qtbot import QtBot
from rich.table import Table

import riglens as rl
from riglens.app.background.counting import figures_beside_scores
from riglens.app.terminal.figures import leading_table
from riglens.app.window.features.propose import fields_of
from riglens.core.figures.coverage import VoxelFigure
from riglens.core.figures.documents import evaluation_document, objects_document
from riglens.core.figures.evaluated import Evaluated, EvaluationSettings, Evaluator
from riglens.core.figures.figure import ALL, CLASSES_AND_ALL
from riglens.core.figures.objects import ObjectFigure, parts_by_class
from riglens.core.figures.registry import figure_named, figures, leading_figures, object_figures, registered
from riglens.core.figures.text import estimate_text
from riglens.core.figures.values import (
    FigureCells,
    Values,
    compared_scores,
    values_of_objects,
    values_of_scores,
)
from riglens.core.geometry import Pose
from riglens.core.metric.scores import PAPER_SETTINGS, MetricSettings
from riglens.core.optimise.additions import Additions
from riglens.core.optimise.candidates import choices_of, mounted
from riglens.core.optimise.problem import Problem
from riglens.core.optimise.run import optimise
from riglens.core.optimise.weights import Weights
from riglens.core.review.checking import Check, Subject
from riglens.core.review.measures import Measures
from riglens.core.review.requirements import requirements_in
from riglens.core.review.tolerance import PROFILES, tolerance
from riglens.core.rig.edits import with_enabled
from riglens.core.rig.model import Rig
from riglens.core.scene.boxes import CLASSES
from riglens.core.shown_values import NONE
from riglens.core.sweep.rows import Sweeper, SweepFigures
from riglens.core.sweep.table import better_of
from riglens.core.targets.settings import USUAL
from riglens.core.targets.traffic import Traffic
from riglens.evaluation.options import SceneOptions, ScoreOptions
from riglens.evaluation.search_options import SearchOptions
from riglens.rendering.picture import Findings, score_rows
from riglens.reporting.document import document_of
from riglens.reporting.figures import ReportPlan, report_of
from riglens.reporting.page import report_page
from riglens.widgets.panels.compare.model import CompareRow, columns_for, table_text
from riglens.widgets.panels.scores.panel import ScoresPanel
from riglens.widgets.panels.sensors.losses import losses_of
from riglens.widgets.panels.targets.panel import TargetsPanel
from tests.core.builders import camera, grid_of, random_field, spinning
from tests.core.targets.cases import random_traffic
from tools import write_figures

REPOSITORY = Path(__file__).resolve().parents[1]
TWENTY = ObjectFigure(
    key="made_up",
    title="At least 20 points",
    short="≥ 20 pts",
    question="Share of objects with at least 20 LiDAR points.",
    resolved=0.02,
    leads=True,
    kinds=("lidar",),
    values=lambda counted: (counted.objects.all_points >= 20).astype(np.float64),
)
UNSEEN = VoxelFigure(
    key="unseen",
    title="Unseen by any",
    question="Share of the class's entropy H(Ω) that no enabled sensor covers.",
    better="less",
    leads=True,
    value=lambda scores: 1.0 - scores.any_seen,
)
BOXES = "\n".join(
    [
        "seq,frame,cls,x,y,z,length,width,height,yaw",
        "s,0,car,6,0,0.8,4,2,1.6,0",
        "s,1,bicycle,3,-4,0.9,2,0.6,1.7,0",
        "s,2,pedestrian,2,5,0.9,0.6,0.6,1.8,0\n",
    ]
)
RIG = Rig(
    name="mine",
    sensors=(
        spinning((0.0, 0.0, 1.8), beams=16, count=360).replace(name="top"),
        camera((0.5, 0.0, 1.5)).replace(name="front"),
    ),
)


@pytest.fixture(autouse=True)
def known() -> Iterator[None]:
    with registered(TWENTY), registered(UNSEEN):
        yield


@pytest.fixture(scope="module")
def traffic() -> Traffic:
    return random_traffic(np.random.default_rng(4), 12)


@pytest.fixture
def evaluator(traffic: Traffic) -> Evaluator:
    grid = grid_of(40, 40, 8, 0.5)
    field = random_field(grid, np.random.default_rng(1))
    return Evaluator(field, traffic, threads=1)


@pytest.fixture
def evaluated(evaluator: Evaluator) -> Evaluated:
    return evaluator(RIG, ("voxels", "objects", "ground"))


def test_every_figure_says_what_it_is() -> None:
    every = figures()
    assert len({one.key for one in every}) == len(every)
    assert len({one.column("car") for one in every}) == len(every)
    for figure in every:
        assert figure.title and figure.short and figure.question.endswith(".")
        assert figure.better == "neither" or "better" in figure.tip


def test_the_registry_knows_it_for_a_while() -> None:
    assert {TWENTY, UNSEEN} <= set(leading_figures()) and TWENTY in object_figures(("lidar",))
    assert figure_named("made_up") is TWENTY
    with pytest.raises(ValueError, match="already"), registered(TWENTY):
        pass


def test_it_has_a_value_for_each_class_and_for_all(evaluated: Evaluated) -> None:
    assert evaluated.objects is not None
    for figure in (TWENTY, UNSEEN):
        for who in CLASSES_AND_ALL:
            found = figure.of(evaluated, who)
            assert found.exists and 0.0 <= found.value <= 1.0
            assert figure.change(evaluated, evaluated, who).value == 0.0
    points = evaluated.objects.objects.all_points
    assert TWENTY.of(evaluated, ALL).value == pytest.approx((points >= 20).mean())


def test_small_changes_are_no_gain_and_the_direction_decides() -> None:
    assert TWENTY.is_gain(0.01) is None and TWENTY.is_gain(0.03) is True and TWENTY.is_gain(-0.03) is False
    assert UNSEEN.is_gain(0.01) is False and UNSEEN.is_gain(-0.01) is True


def test_the_json_has_it_by_class_ring_and_sector(evaluated: Evaluated) -> None:
    assert evaluated.field is not None and evaluated.objects is not None
    document = evaluation_document(evaluated.field, PAPER_SETTINGS, [evaluated])
    of_car = document["rigs"][0]["classes"]["car"]["figures"]
    assert of_car["made_up"]["value"] == TWENTY.of(evaluated, "car").value
    assert of_car["unseen"] == {
        "value": UNSEEN.of(evaluated, "car").value, "se": 0.0, "state": "exact", "reason": None,
    }  # fmt: skip
    assert document["rigs"][0]["figures"]["blind_m2"]["value"] > 0.0
    objects = objects_document([evaluated.objects])["rigs"][0]["classes"]["car"]
    assert objects["made_up"] == parts_by_class(evaluated.objects, [TWENTY])["car"].total.made_up.value
    assert all("made_up" in part for part in (*objects["rings"], *objects["sectors"]))
    json.dumps(document, allow_nan=False)


def test_a_rig_without_the_sensors_that_make_it_has_a_reason_in_place_of_zero(evaluator: Evaluator) -> None:
    without = evaluator(RIG.model_copy(update={"sensors": RIG.sensors[1:]}))
    found = TWENTY.of(without, "car")
    assert found.state == "none" and "LiDAR" in found.reason
    assert evaluator.field is not None
    document = evaluation_document(evaluator.field, PAPER_SETTINGS, [without])
    assert document["rigs"][0]["classes"]["car"]["figures"]["made_up"]["value"] is None


def test_a_sweep_has_its_column_with_the_direction(evaluator: Evaluator) -> None:
    sweeper = Sweeper(SweepFigures(targets=USUAL), RIG, evaluator.field, evaluator.traffic, 1)
    row = sweeper.row(RIG)
    assert {"car.made_up", "car.made_up_change", "car.made_up_change_se"} <= row.keys()
    assert better_of("car.made_up") == better_of("car.made_up_change") == "more"
    assert better_of("car.unseen") == "less" and better_of("car.made_up_se") == "neither"


GRID = "settings: {voxel_m: 0.5, roi_m: [20, 20, 4]}\n"


@pytest.mark.parametrize(
    ("limit", "status"),
    [
        ("{figure: made_up, class: car, at_least: 0.0}", "met"),
        ("{figure: made_up, class: car, at_least: 1.0, ring_m: [0, 60]}", "not met"),
        ("{figure: unseen, class: car, at_most: 1.0}", "met"),
        ("{figure: unseen, class: car, at_most: 0.0}", "not met"),
    ],
)
def test_a_file_of_requirements_can_limit_it(evaluator: Evaluator, limit: str, status: str) -> None:
    asked = requirements_in(f"riglens_requirements: 1\n{GRID}figures:\n- {limit}\n", "limits.yaml")
    ignored = evaluator.by(EvaluationSettings(MetricSettings(body="ignored")))
    (verdict,) = Check(Subject(RIG, ignored, ()), asked).verdicts()
    assert verdict.status == status and "car" in verdict.text


def test_a_tolerance_spreads_it_with_the_worst_by_its_direction(evaluator: Evaluator) -> None:
    measures = Measures(evaluator, 6, RIG)
    found = tolerance(RIG, PROFILES[1], measures, 4, with_sensitivities=False)
    for cls in CLASSES:
        more, less = found.spreads[f"made_up {cls}"], found.spreads[f"unseen {cls}"]
        assert more.worst == min(more.values) and less.worst == max(less.values)
    assert measures(RIG, Pose())["made_up car"].value == more_of(evaluator)


def more_of(evaluator: Evaluator) -> float:
    return TWENTY.of(evaluator(RIG, ("objects",)), "car").value


def test_a_search_improves_it_without_a_bound(traffic: Traffic, evaluator: Evaluator) -> None:
    added = Additions(("generic-16",), mirrored=False, spots_m=1.2, tilts_deg=(0.0,))
    assert "made_up" in get_args(fields_of(("objective",))["objective"].annotation)
    options = SearchOptions(("generic-16",), objective="made_up", frames=5, held_out=6)
    cars_alone = Weights({"bicycle": 0.0, "pedestrian": 0.0})
    problem = replace(options.problem(RIG, traffic, added), weights=cars_alone)
    found = optimise(problem, 1)
    assert found.bound is None and found.to_dict()["bound"] == {"value": None, "kind": "none", "gap": None}
    assert (
        found.bound is None
        and found.to_dict()["bound"]["kind"] == "none"
        and found.best.guard[0].case == "held-out frames"
    )

    def cars(rig: Rig) -> float:
        return TWENTY.of(evaluator(rig, ("objects",), 5, settings=settings), "car").value

    settings = EvaluationSettings(targets=problem.settings)
    tried = [mounted(RIG, [one]) for one in choices_of(RIG, added).candidates]
    assert found.before == pytest.approx(cars(RIG)) and found.best.value == pytest.approx(
        cars(found.best.rig)
    )
    assert found.best.value == pytest.approx(max(cars(rig) for rig in tried))
    assert found.best.value > found.before


def test_a_search_lowers_what_is_better_when_it_is_less(traffic: Traffic) -> None:
    added = Additions(("generic-16",), mirrored=False, spots_m=1.5, tilts_deg=(0.0,))
    found = optimise(Problem(RIG, traffic, added, "missed", frames=5, held_out=6), 1)
    assert found.best.value < found.before and found.gain >= 0.0


def test_the_page_of_figures_is_made_from_the_registry() -> None:
    assert TWENTY.question in write_figures.page() and UNSEEN.title in write_figures.page()
    shown = write_figures.page().splitlines()
    written = (REPOSITORY / write_figures.TARGET).read_text(encoding="utf-8").splitlines()
    assert [line for line in shown if "`made_up`" not in line and "`unseen`" not in line] == written


# ---------------------------------------------------------------- the window
def test_the_score_table_has_a_column_for_it_with_its_direction(
    qtbot: QtBot, evaluator: Evaluator, evaluated: Evaluated
) -> None:
    panel = ScoresPanel(MetricSettings())
    qtbot.addWidget(panel)
    bare = evaluator(RIG.model_copy(update={"sensors": RIG.sensors[1:]}))
    assert evaluated.voxels is not None and bare.voxels is not None
    panel.show_figures("voxels", compared_scores(bare.voxels.scores, evaluated.voxels.scores))
    assert evaluated.objects is not None and bare.objects is not None
    found = FigureCells.of(TWENTY, evaluated.objects, evaluated.objects)
    panel.show_figures("objects", {TWENTY.key: found.compared()})
    assert panel.table.cell("car", "made_up").text == estimate_text(TWENTY, TWENTY.of(evaluated, "car"))
    assert panel.table.cell("car", "made_up").values[0] == TWENTY.of(evaluated, "car").value
    assert panel.table.cell("car", "unseen").values[0] == UNSEEN.of(bare, "car").value
    change = UNSEEN.change(bare, evaluated, "car")
    assert change.value > 0.0 and panel.table.cell("car", "unseen change").tone == "less"
    assert "unseen by any: less is better" in panel.note and "at least 20 points" in panel.note


def test_the_thread_that_counts_has_it_at_once(evaluated: Evaluated) -> None:
    assert {"made_up", *(one.key for one in object_figures() if one.leads)} <= {
        one.key for one in figures_beside_scores()
    }
    assert evaluated.objects is not None
    assert values_of_objects(evaluated.objects)["made_up"]["car"] == TWENTY.of(evaluated, "car")


def test_compare_shows_and_exports_it(evaluated: Evaluated) -> None:
    assert evaluated.voxels is not None and evaluated.objects is not None
    row = CompareRow(
        "a", "mine", "file", RIG, "", evaluated.voxels.scores, values_of_objects(evaluated.objects)
    )
    for chosen in ("all classes", "car"):
        shown = {(one.class_name, one.figure.key): one for one in columns_for(chosen, ("lidar", "camera"))}
        for figure in (TWENTY, UNSEEN):
            assert shown["car", figure.key].value((row.scores, row.counted)) == figure.of(evaluated, "car")
    (read,) = csv.DictReader(io.StringIO(table_text([row], ",")))
    assert float(read["car at least 20 points (fraction)"]) == TWENTY.of(evaluated, "car").value
    assert float(read["car unseen by any (fraction)"]) == UNSEEN.of(evaluated, "car").value


def test_losses_of_sensors_are_told_in_it(evaluator: Evaluator, evaluated: Evaluated) -> None:
    def known(rig: Evaluated) -> Values:
        assert rig.voxels is not None and rig.objects is not None
        return {**values_of_scores(rig.voxels.scores), **values_of_objects(rig.objects)}

    without = evaluator(with_enabled(RIG, ("top",), False))
    losses = losses_of(known(evaluated), known(without), "lidar")
    assert {"made_up", "unseen"} <= set(losses)
    assert losses["made_up"].size == pytest.approx(100.0 * TWENTY.of(evaluated, ALL).value)
    grown = UNSEEN.of(without, ALL).value - UNSEEN.of(evaluated, ALL).value
    assert losses["unseen"].size == pytest.approx(100.0 * grown) and grown > 0.0
    of_radar = losses_of(known(evaluated), known(without), "radar")
    assert of_radar["predicted"].text == of_radar["s_ms"].text == NONE != losses["predicted"].text
    assert of_radar["missed"].text == losses["missed"].text
    none = losses_of(known(evaluated), known(evaluated), "lidar")
    assert none["predicted"].text == none["made_up"].text == "0.0", "as many digits with an error as without"


def test_the_panel_targets_offers_it(qtbot: QtBot, evaluated: Evaluated) -> None:
    assert evaluated.objects is not None
    panel = TargetsPanel(USUAL)
    qtbot.addWidget(panel)
    panel.show()
    panel.show_counts(evaluated.objects, evaluated.objects, "itself")
    panel.choose("made_up")
    cell = panel.table.figures.cell(CLASSES_AND_ALL.index("car"), 0)
    assert panel.figure is TWENTY and cell.values[0] == TWENTY.of(evaluated, "car").value


def test_the_score_box_of_a_picture_has_it(evaluated: Evaluated) -> None:
    assert evaluated.voxels is not None and evaluated.objects is not None and evaluated.field is not None
    objects = values_of_objects(evaluated.objects)
    found = Findings(RIG, evaluated.voxels.scores, PAPER_SETTINGS, evaluated.field, objects=objects)
    heads, *rows = score_rows(found)
    assert {TWENTY.title, UNSEEN.title} <= set(heads) and len(rows) == len(CLASSES)


def test_the_terminal_has_it_as_a_column(evaluated: Evaluated) -> None:
    table, *lines = leading_table([evaluated])
    assert isinstance(table, Table)
    assert {TWENTY.title, UNSEEN.title} <= {column.header for column in table.columns}
    assert any(TWENTY.question[1:] in str(line) for line in lines)


# ---------------------------------------------------------------- Python and the report


def test_python_has_it_in_results_and_rows(tmp_path: Path) -> None:
    boxes = tmp_path / "boxes.csv"
    boxes.write_text(BOXES, encoding="utf-8")
    scene = rl.load_scene(boxes, 0.5, roi_m=(20, 20, 4))
    found = rl.score(RIG, scene, rl.load_traffic(boxes), threads=1)
    assert found["car"].figures["made_up"].exists and "unseen" in found.rows()[0]
    counted = rl.targets(RIG, rl.load_traffic(boxes), threads=1)
    assert counted["car"].total.made_up.value == found["car"].figures["made_up"].value
    assert "made_up" in counted.rows()[0] and "made_up_se" in counted.by_sector()[0]


def test_a_report_of_two_rigs_has_it_with_the_difference(tmp_path: Path) -> None:
    boxes = tmp_path / "boxes.csv"
    boxes.write_text(BOXES, encoding="utf-8")
    scene = SceneOptions(boxes=boxes, voxel_m=0.5, roi_m=(20.0, 20.0, 4.0))
    rigs = (RIG, RIG.model_copy(update={"name": "other", "sensors": RIG.sensors[:1]}))
    plan = ReportPlan(rigs, scene, ScoreOptions(), draws=0, seed=0)
    page = report_page(document_of(plan, report_of(plan, lambda share, stage: None)))
    for key in ("made_up", "unseen"):
        place = f"evaluation/rigs/%d/classes/car/figures/{key}/value"
        assert f'data-from="{(place % 0).removesuffix("/value")}"' in page
        assert f'data-from="{place % 1}" data-less="{place % 0}"' in page
    assert TWENTY.question in page and "Differences of less than 2.0 pp" in page
