"""The accuracy study for a reader: its findings in words, its CSV, its chart."""

import csv
from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
from matplotlib.text import Annotation

from riglens.core.study.accuracy import AccuracyStudy, study_accuracy
from riglens.studies.accuracy_chart import chart
from riglens.studies.accuracy_text import accuracy_csv, point_text, verdicts
from riglens.studies.pictures import picture
from tests.core.builders import field_of, grid_of, rig_of, spinning
from tests.core.study.small_studies import QUICK, small_accuracy_study


@pytest.fixture(scope="module")
def study() -> AccuracyStudy:
    return small_accuracy_study()


def test_the_csv_has_a_line_per_point_in_full_precision(study):
    rows = list(csv.DictReader(accuracy_csv(study).splitlines()))
    assert len(rows) == len(study.points)
    for row, point in zip(rows, study.points, strict=True):
        assert row["method"] == point.method
        assert float(row["s_ms_car"]) == point.s_ms["car"]
        assert row["missed"] == ("" if point.wrong is None else str(point.wrong.missed))


def test_the_findings_say_whether_the_setting_lies_on_the_front(study):
    voxels, scores, grid = verdicts(study)
    assert ("does not lie on" in voxels) is not study.own.on_voxel_front
    assert ("does not" in scores) is not study.own.on_score_front
    assert "δ 1.00 m" in grid and "δ 0.50 m" in grid


def test_the_chart_names_every_point_and_no_name_covers_another(study):
    figure = chart(study, "made-up boxes")
    for axes, shown in zip(figure.axes, (lambda p: p.wrong is not None, lambda p: True), strict=True):
        names = {text.get_text(): text for text in axes.texts if isinstance(text, Annotation)}
        assert set(names) == {point_text(point, study) for point in study.points if shown(point)}
        boxes = [text.get_window_extent() for text in names.values()]
        assert not any(a.overlaps(b) for a, b in combinations(boxes, 2))
    words = " ".join(text.get_text() for text in figure.texts)
    assert "made-up boxes, 50 frames" in words and all(line in words for line in verdicts(study))


def test_the_chart_is_saved_as_png_and_svg_with_the_same_bytes_each_time(study):
    figure = chart(study, "made-up boxes")
    assert picture(figure, "png").startswith(b"\x89PNG")
    assert picture(figure, "svg").startswith(b"<?xml")
    assert picture(chart(study, "made-up boxes"), "svg") == picture(figure, "svg")
    assert b"Matplotlib" not in picture(figure, "png")


def test_dollar_signs_in_names_are_no_mathematics(study):
    named = replace(study, rig=study.rig.replace(name="$\\frac{$ and $x_1$"))
    figure = chart(named, "boxes $\\bad$")
    assert not any(text.get_parse_math() for text in figure.texts)
    assert picture(figure, "png").startswith(b"\x89PNG")


def test_one_class_without_boxes_and_one_kind_of_sensor_can_be_drawn():
    field = field_of(grid_of(8, 8, 4), np.zeros((8, 8, 4), np.bool_))
    study = study_accuracy({1.0: field}, 1.0, rig_of(spinning((0.3, 0.2, 2.2))), QUICK)
    assert picture(chart(study, "nothing"), "png")
