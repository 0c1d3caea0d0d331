"""`riglens study accuracy`: the table, the chart and the CSV, and what it says to bad input."""

import csv

from tests.app.conftest import SMALL_GRID


def test_it_writes_chart_and_csv_and_prints_every_point(riglens, boxes, tmp_path):
    folder = tmp_path / "deep" / "study"
    result = riglens("study", "accuracy", "--boxes", boxes, *SMALL_GRID, "--quick", "--out", folder)
    assert result.code == 0
    assert sorted(path.name for path in folder.iterdir()) == ["accuracy.csv", "accuracy.png", "accuracy.svg"]
    assert (folder / "accuracy.png").read_bytes().startswith(b"\x89PNG")
    assert (folder / "accuracy.svg").read_text().startswith("<?xml")
    rows = list(csv.DictReader((folder / "accuracy.csv").read_text().splitlines()))
    assert {row["method"] for row in rows} >= {"exact", "plain", "bresenham", "rectangles", "centres"}
    assert {float(row["voxel_m"]) for row in rows} == {0.5, 1.0, 2.0}
    for name in ("exact, δ 0.50 m, 352 × 128", "plain DDA", "Bresenham", "exact, 1/2 of the rays"):
        assert name in result.out
    assert "Pareto front" in result.out
    table = result.out.split("The setting asked for")[0]
    assert max(len(line.rstrip()) for line in table.splitlines()) <= 120


def test_a_voxel_edge_that_does_not_divide_the_roi_is_left_out_with_a_note(riglens, boxes, tmp_path):
    roi = ("--voxel", "0.5", "--roi", "21", "20", "3")
    result = riglens("study", "accuracy", "--boxes", boxes, *roi, "--quick", "--out", tmp_path)
    assert result.code == 0
    assert "note: δ 2.00 m is left out" in result.err
    assert "exact, δ 1.00 m" in result.out
    assert "exact, δ 2.00 m" not in result.out


def test_a_stored_pog_is_studied_on_its_own_grid(riglens, boxes, tmp_path):
    pog = tmp_path / "scene.npz"
    assert riglens("pog", boxes, "--out", pog, *SMALL_GRID).code == 0
    result = riglens("study", "accuracy", "Trapezoid", "--pog", pog, "--quick", "--out", tmp_path / "out")
    assert result.code == 0
    assert "holds one grid only" in result.err
    assert "exact, δ 1.00 m" not in result.out


def test_bad_input_is_refused_before_anything_is_measured(riglens, boxes, tmp_path):
    file = tmp_path / "file"
    file.write_text("")
    common = ("--boxes", boxes, *SMALL_GRID, "--quick")
    assert "--out" in riglens("study", "accuracy", *common, "--out", file).refused()
    assert "--threads" in riglens("study", "accuracy", *common, "--threads", "0").refused()
    assert "--lambda" in riglens("study", "accuracy", *common, "--lambda", "-1").refused()
    assert "nowhere" in riglens("study", "accuracy", "nowhere", *common, "--out", tmp_path).refused()
    missing = riglens("study", "accuracy", "--boxes", tmp_path / "none.csv", "--quick", "--out", tmp_path)
    assert "none.csv" in missing.refused()


def test_a_rig_without_sensors_is_refused(riglens, boxes, tmp_path):
    rig = tmp_path / "bare.yaml"
    rig.write_text("riglens: 1\nname: bare\nsensors: []\n")
    result = riglens("study", "accuracy", rig, "--boxes", boxes, *SMALL_GRID, "--quick", "--out", tmp_path)
    assert "no sensor is switched on" in result.refused()
