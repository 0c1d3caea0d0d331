"""The stability study for a reader: its findings in words, its CSV files, its page."""

import csv
import io
from dataclasses import replace

import numpy as np
import pytest

from riglens.core.scene.boxes import CLASSES
from riglens.core.study.stability_metric import MetricStudy, Ranking, Setting, study_metric
from riglens.studies.stability import caption, methods_csv, metric_csv, order_lines, page_of
from riglens.studies.stability_findings import conclusion, findings, methods_verdict
from tests.core.builders import field_of, grid_of
from tests.core.study.small_studies import HAND, PLAN, judged_cases, ranking, small_metric_study


@pytest.fixture(scope="module")
def rows():
    return judged_cases()


@pytest.fixture(scope="module")
def metric() -> MetricStudy:
    return small_metric_study()


def test_the_verdict_says_where_simple_methods_fail(rows):
    plain, bresenham = list(methods_verdict([*rows.values()]))[1:]
    assert "plain method: fails in" in plain and "rays through corners" in plain
    assert "Bresenham: fails in" in bresenham


def test_findings_say_that_no_sensors_score_best(metric):
    found = {finding.claim: finding for finding in findings(metric)}
    assert found["a rig without sensors is not the best"].verdict == "fails"
    assert found["more sensors never lower the score"].verdict == "fails"
    assert found["a copy of a sensor in the same place changes nothing"].verdict == "ok"
    assert found["the reading residual gives the order of covered, reversed"].verdict == "ok"


def test_a_finding_about_orders_fails_exactly_when_a_pair_of_rigs_changes_places(metric):
    same = replace(metric, others=tuple(v._replace(ranking=metric.reference) for v in metric.others))
    verdicts = {finding.claim: finding.verdict for finding in findings(same)}
    assert {verdicts[claim] for claim in verdicts if claim.startswith("the order does not depend")} == {"ok"}
    moved = dict(metric.reference.s_mig)
    moved["C"], moved["T"] = moved["T"], moved["C"]
    drawn = Setting("frames", 1, Ranking(moved, PLAN.camera_weight))
    other = replace(same, others=(*same.others, drawn))
    verdicts = {finding.claim: finding.verdict for finding in findings(other)}
    assert verdicts["the order does not depend on which frames were sampled"] == "fails"
    assert verdicts["the order does not depend on δ"] == "ok"


def test_the_conclusion_names_pairs_that_never_change_places():
    reference_ = ranking(**HAND)
    other = ranking(**{**HAND, "P": -45.0})
    study = MetricStudy(
        PLAN, "made up", 5, reference_, (Setting("frames", 1, other),), {0.5: dict.fromkeys(CLASSES, 1.0)}
    )
    lidars, cameras = conclusion(study)
    assert "Center before Line" in lidars and "Center before Pyramid" not in lidars
    assert "25.0 % apart" in lidars
    assert "Narrow before Wide." in cameras


def test_a_scene_without_entropy_has_no_orders_and_makes_no_trouble(rows):
    field = field_of(grid_of(6, 6, 4), np.zeros((6, 6, 4), np.bool_))
    empty = study_metric(field, lambda *_: None, None, replace(PLAN, voxel_m=1.0, threads=1))
    assert [finding.verdict for finding in findings(empty)] == ["n.a."]
    assert list(conclusion(empty)) == []
    assert all(cell.tau is None for _, cells in order_lines(empty) for cell in cells)
    assert "nothing" in page_of(tuple(rows.values()), empty, "nothing")


def test_the_csv_files_have_a_line_per_case_and_per_setting_and_class(rows, metric):
    methods = list(csv.DictReader(io.StringIO(methods_csv(tuple(rows.values())))))
    assert [line["case"] for line in methods] == list(rows)
    assert int(methods[2]["plain_extra"]) == rows["rays through corners"].outcomes["plain"].extra
    orders = list(csv.DictReader(io.StringIO(metric_csv(metric))))
    assert len(orders) == 3 * (1 + len(metric.others))
    assert float(orders[0]["s_ms_W+T"]) == metric.reference.s_ms["W+T"]["car"]
    assert orders[0]["kendall_tau"] == "1.0"
    assert orders[0]["order_rigs"].split(" < ") == list(metric.reference.order("rigs", "car"))


def test_of_resampled_frames_the_least_agreement_is_told_beside_the_median(metric):
    lines = {setting.rpartition(": ")[2]: cells for setting, cells in order_lines(metric)}
    assert lines["least"][0].tau < lines["median"][0].tau <= 1.0


def test_the_page_shows_every_case_and_setting_and_escapes_names(rows, metric):
    html = page_of(tuple(rows.values()), metric, caption(metric, "<boxes> & more"))
    assert "&lt;boxes&gt; &amp; more" in html and "<boxes>" not in html
    for name in rows:
        assert name.replace("'", "&#x27;") in html
    for setting, _ in order_lines(metric):
        assert setting in html
    assert "<script" not in html and "http" not in html.replace("http-equiv", "")
