"""The accuracy study of sensors for a reader: its findings in words, its CSV and JSON, its chart."""

import csv
import io
import json
from dataclasses import replace

import pytest

from riglens.core.study.sensor_methods import SensorStudy
from riglens.studies.accuracy_chart import percent_text
from riglens.studies.pictures import picture
from riglens.studies.sensor_methods import FILES, as_json, caption, verdicts
from riglens.studies.sensor_methods_chart import STYLES, chart
from tests.app.conftest import SMALL_GRID
from tests.core.study.small_studies import small_sensor_study


@pytest.fixture(scope="module")
def study() -> SensorStudy:
    return small_sensor_study()


def with_point(study, method, **changes):
    """The first result's study with a way changed, all others slower than RigLens."""
    result = study.results[0]
    slow = {"times_ms": (9.0,)}
    points = tuple(replace(p, **(slow | changes if p.method == method else slow)) for p in result.points)
    return replace(study, results=(replace(result, points=points),))


def test_findings_name_what_is_quicker_and_what_it_costs(study):
    assert next(verdicts(with_point(study, "fast", times_ms=(1.0,)))).endswith("nothing is faster.")
    right = with_point(study, "plain", times_ms=(1.0,), missed=0.0, extra=0.0)
    assert next(verdicts(right)).endswith("plain DDA is faster and equally correct here.")
    wrong = with_point(study, "bresenham", times_ms=(1.0,), missed=0.25, extra=0.0)
    assert next(verdicts(wrong)).endswith("Bresenham has the fewest errors: 25 %.")


def test_a_fast_way_that_errs_is_shouted_about(study):
    assert "RigLens 9 ms, the voxels of the exact walk" in next(verdicts(with_point(study, "fast")))
    assert "RigLens 9 ms, WRONG in 50 % of the voxels" in next(verdicts(with_point(study, "fast", extra=0.5)))


def test_the_chart_has_a_panel_per_sensor_and_pose_and_a_mark_for_every_point(study):
    figure = chart(study, caption(study, "made-up boxes"))
    assert [axes.get_title(loc="left") for axes in figure.axes] == [
        "velodyne-vlp-16, 28,800 rays, upright",
        "velodyne-vlp-16, 28,800 rays, tilted by 2° and −3°",
        "bent, 20,736 rays, upright",
        "bent, 20,736 rays, tilted by 2° and −3°",
    ]
    for axes, result in zip(figure.axes, study.results, strict=True):
        marks = [line for line in axes.lines if line.get_marker() not in ("None", "")]
        assert sum(len(line.get_xdata()) for line in marks) == len(result.points)
        low, high = axes.get_xlim()
        assert all(low < x < high for line in marks for x in line.get_xdata())
    assert len(figure.legends[0].get_texts()) == len(STYLES)
    assert picture(figure, "svg") == picture(chart(study, caption(study, "made-up boxes")), "svg")


def test_ticks_of_small_errors_are_powers_of_ten():
    assert [percent_text(p) for p in (50.0, 0.001, 1e-4, 1e-12)] == ["50", "0.001", "10⁻⁴", "10⁻¹²"]


def test_the_json_holds_everything(study):
    document = json.loads(json.dumps(as_json(study)))
    assert document["sensors"][1]["rpy_deg"] == [2.0, -3.0, 8.0]
    assert document["data"]["frames"] == study.frames
    for written, result in zip(document["sensors"], study.results, strict=True):
        assert [m["median_ms"] for m in written["methods"]] == [p.median_ms for p in result.points]
        assert [m["missed"] for m in written["methods"]] == [p.missed for p in result.points]


def test_the_command_writes_chart_csv_and_json_for_models_of_own_libraries_too(riglens, boxes, tmp_path):
    own = tmp_path / "own.yaml"
    own.write_text(
        "my-lidar:\n  kind: lidar\n  title: A sensor of ours\n  source: our own data sheet\n"
        "  elevations_deg: [-10, 0]\n  azimuths_deg: {from: -180, to: 180, count: 90}\n",
        encoding="utf-8",
    )
    options = ("--library", own, "--boxes", boxes, *SMALL_GRID, "--quick", "--out", tmp_path / "out")
    result = riglens("study", "accuracy", "--sensor", "my-lidar", *options)
    assert result.code == 0
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == sorted(FILES)
    rows = list(
        csv.DictReader(io.StringIO((tmp_path / "out" / "accuracy-sensors.csv").read_text(encoding="utf-8")))
    )
    assert {(row["model"], row["pose"]) for row in rows} == {("my-lidar", "upright"), ("my-lidar", "tilted")}
    assert "my-lidar, tilted: RigLens" in result.out
    assert max(len(line.rstrip()) for line in result.out.split("my-lidar, upright: ")[0].splitlines()) <= 120
    assert (
        "unknown sensor model 'nonsense'"
        in riglens("study", "accuracy", "--sensor", "nonsense", *options).refused()
    )
