"""Derived figures of sensors and rows of the compare table, as they read."""

import csv
import io
import math
from dataclasses import replace

import pytest

from riglens.core.figures.figure import ALL, Estimate, Figure
from riglens.core.figures.hits import MISSED, ON_TARGET, POINTS
from riglens.core.figures.predicted import PREDICTED
from riglens.core.figures.registry import figures, leading_figures
from riglens.core.figures.text import change_estimate_text, estimate_text, parts_text
from riglens.core.rig.model import Camera, Lidar, LinearAngles, Sensor
from riglens.core.rig.presets import preset
from riglens.core.scene.boxes import CLASSES
from riglens.widgets.panels.compare.model import (
    ALL_CLASSES,
    FIRST_FIGURE,
    MEAN,
    CompareModel,
    CompareRow,
    columns_for,
    table_text,
)
from riglens.widgets.panels.sensors.rows import derived_rows, short_type

LIDAR = Lidar(
    name="top",
    position=(0.0, 0.0, 2.0),
    elevations_deg=LinearAngles(from_=-15.0, to=15.0, count=16),
    azimuths_deg=LinearAngles(from_=-180.0, to=180.0, count=1800),
)
CAMERA = Camera(name="front", position=(1.0, 0.0, 1.4), image=(1600, 900), hfov_deg=90.0, cast=(400, 225))


def test_a_lidar_is_summed_up_as_in_its_data_sheet() -> None:
    rows = dict(derived_rows(LIDAR))
    assert rows["Rays"] == "28,800  =  16 beams × 1,800"
    assert rows["Field of view"] == "360° × 30°"
    assert rows["Resolution"] == "0.2° × 2°"


def test_uneven_beams_are_given_from_the_closest_to_the_widest() -> None:
    uneven = LIDAR.replace(elevations_deg=(5.0, -10.0, 0.0))
    assert dict(derived_rows(uneven))["Resolution"] == "0.2° × 5–10°"
    assert dict(derived_rows(LIDAR.replace(elevations_deg=(0.0,))))["Resolution"] == "0.2° × —"


def test_a_camera_is_summed_up_by_its_lens() -> None:
    rows = dict(derived_rows(CAMERA))
    high = 2 * math.degrees(math.atan(450 / 800))
    assert rows["Field of view"] == f"90.0° × {high:.1f}°"
    assert rows["Focal length"] == "800.0 px"
    assert rows["Resolution"] == "0.0716°/px, 0.286°/ray"


@pytest.mark.parametrize(("sensor", "text"), [(LIDAR, "16 ch"), (CAMERA, "90°")])
def test_a_sensor_has_a_type_of_a_few_characters(sensor: Sensor, text: str) -> None:
    assert short_type(sensor) == text


def test_a_rig_without_scores_has_empty_numbers_in_the_file() -> None:
    row = CompareRow("k", 'odd, "name"', "file", preset("W+T"), "a.yaml")
    (read,) = csv.DictReader(io.StringIO(table_text([row], ",")))
    assert (read["rig"], read["LiDARs"], read["cameras"]) == ('odd, "name"', "4", "6")
    assert read["car S-MS (nat)"] == ""


@pytest.mark.parametrize("delimiter", [",", "\t"])
def test_a_name_is_no_formula_in_the_file(delimiter: str) -> None:
    row = CompareRow("k", '=HYPERLINK("http://x")', "file", preset("W+T"), "@home.yaml")
    (read,) = csv.DictReader(io.StringIO(table_text([row], delimiter)), delimiter=delimiter)
    assert (read["rig"], read["where"]) == ('\'=HYPERLINK("http://x")', "'@home.yaml")


@pytest.mark.parametrize(
    ("figure", "change", "tone"),
    [
        (ON_TARGET, 0.004, "text"),
        (ON_TARGET, 0.02, "more"),
        (ON_TARGET, -0.02, "less"),
        (MISSED, 0.02, "less"),
        (MISSED, -0.02, "more"),
    ],
)
def test_compared_rigs_are_better_or_worse_only_where_a_change_tells_them_apart(
    figure: Figure, change: float, tone: str
) -> None:
    model = CompareModel()
    model.set_rows(
        [
            CompareRow(
                str(share),
                "rig",
                "file",
                preset("W+T"),
                counted={figure.key: dict.fromkeys(CLASSES, Estimate(share))},
            )
            for share in (0.5, 0.5 + change)
        ]
    )
    model.set_class("car")
    model.set_shown("first")
    place = FIRST_FIGURE + [column.figure for column in model.columns].index(figure)
    assert model.cell(1, place).tone == tone


def test_bars_are_of_the_whole_for_shares_and_of_the_largest_value_for_other_figures() -> None:
    rows = [
        CompareRow(
            str(share),
            "rig",
            "file",
            preset("W+T"),
            counted={ON_TARGET.key: {"car": Estimate(share)}, POINTS.key: {"car": Estimate(points)}},
        )
        for share, points in ((0.2, 30.0), (0.4, 120.0))
    ]
    model = CompareModel()
    model.set_rows(rows)
    model.set_class("car")
    places = [
        FIRST_FIGURE + [column.figure for column in model.columns].index(one) for one in (ON_TARGET, POINTS)
    ]
    assert [[model.cell(row, place).bar for row in range(2)] for place in places] == [[0.2, 0.4], [0.25, 1.0]]


def test_one_class_has_all_its_scores_and_all_classes_the_main_ones() -> None:
    one, every = columns_for("car", ("lidar", "radar")), columns_for(ALL_CLASSES)
    known = [figure for figure in figures(("lidar", "radar")) if figure.per_class]
    assert [column.figure.key for column in one] == [figure.key for figure in known]
    assert [(column.class_name, column.figure) for column in every] == [
        (name, figure) for name in CLASSES for figure in leading_figures()
    ]
    assert len({column.title for column in every}) == len(every)


def test_the_means_of_the_classes_are_a_choice_with_errors_and_stand_in_the_file() -> None:
    found = Estimate(0.5, 0.02, "sampled", runs=(0.01, -0.01), parts={"lidar": 0.4, "camera": 0.1})
    row = CompareRow("k", "rig", "file", preset("W+T"), counted={PREDICTED.key: {ALL: found}})
    less = replace(row, counted={PREDICTED.key: {ALL: replace(found, value=0.4, runs=(0.0, 0.0))}})
    model = CompareModel()
    model.set_rows([less, row])
    model.set_class(MEAN)
    assert [one.figure for one in model.columns] == [
        one for one in leading_figures() if one.needs == "objects"
    ]
    place = FIRST_FIGURE + [one.figure for one in model.columns].index(PREDICTED)
    cell = model.cell(1, place)
    assert cell.text == estimate_text(PREDICTED, found) and parts_text(PREDICTED, found) in cell.tip
    model.set_shown("first")
    assert model.cell(1, place).text == change_estimate_text(
        PREDICTED, found.minus(less.counted["predicted"][ALL])
    )
    (read,) = csv.DictReader(io.StringIO(table_text([row], ",")))
    assert read["class mean predicted AP (fraction)"] == "0.5"


def test_a_camera_says_what_it_resolves_and_what_it_shares_with_its_neighbours():
    left = CAMERA.replace(name="left", rpy_deg=(0.0, 0.0, 60.0))
    rows = dict(derived_rows(CAMERA, (CAMERA, left)))
    focal_px = CAMERA.intrinsics_px()[1]
    heights = [f"{focal_px * 1.72 / distance:.0f}" for distance in (10, 30, 50, 100)]
    assert rows["Pedestrian"] == " / ".join(heights)
    assert rows["Overlap"] == "left: 30.0°, left"
    assert set(rows) == set(dict(derived_rows(left)))
