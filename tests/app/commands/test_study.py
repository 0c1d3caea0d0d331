"""`riglens study table1`, `accuracy` and `stability`: tables, charts and files, and what they say to bad input."""

import contextlib
import csv
import io

import pytest

from riglens.app.commands import main
from riglens.app.terminal.console import PIPE_WIDTH
from riglens.core.metric.scores import ClassScores, KindScore, MetricSettings, Scores
from riglens.core.scene.boxes import CLASSES
from riglens.core.study.table1 import compare
from riglens.studies.table1 import table1_csv
from tests.app.conftest import BOXES, SMALL_GRID

# ---------------------------------------------------------------- table1


PAPER_RIGS = ["W+C", "W+P", "W+L", "W+T", "N+C", "N+P", "N+L", "N+T"]


def rows_after(text, title):
    """The lines of the block that starts with a title, up to an empty line."""
    lines = [line.strip() for line in text.splitlines()]
    start = lines.index(title) + 1
    return [line.split() for line in lines[start : lines.index("", start)]]


@pytest.fixture(scope="module")
def table1(tmp_path_factory):
    """Standard output, and the two CSV files of the table on a small scene."""
    folder = tmp_path_factory.mktemp("table1")
    (folder / "boxes.csv").write_text(BOXES, encoding="utf-8")
    files = ("--csv", folder / "table1.csv", "--detection-csv", folder / "table2.csv")
    sheet = folder / "groups.png"
    arguments = ("study", "table1", "--boxes", folder / "boxes.csv", *SMALL_GRID, *files, "--sheet", sheet)
    with contextlib.redirect_stdout(io.StringIO()) as out:
        assert main([str(argument) for argument in arguments]) == 0
    assert sheet.read_bytes().startswith(b"\x89PNG")
    return out.getvalue(), *(
        [*csv.DictReader(path.read_text(encoding="utf-8").splitlines())] for path in files[1::2]
    )


def test_published_figures_stand_beside_ours_in_the_three_blocks_of_the_paper(table1):
    out, rows, _ = table1
    for title, first_rig in {
        "Camera S-MIG": ["−73.08", "−14.15", "−13.13"],
        "LiDAR S-MIG": ["−6.45", "−1.07", "−1.08"],
        "S-MS": ["−13.75", "−2.48", "−2.39"],
    }.items():
        block = rows_after(out, title)
        assert [row[0] for row in block] == PAPER_RIGS
        assert block[0][2::2] == first_rig
    assert max(len(line.rstrip()) for line in out.splitlines()) <= 100
    assert [row["rig"] for row in rows[::3]] == PAPER_RIGS
    assert float(rows[0]["published_s_ms"]) == pytest.approx(-13750.0)
    weighted = 0.1 * float(rows[0]["camera_s_mig"]) + float(rows[0]["lidar_s_mig"])
    assert float(rows[0]["s_ms"]) == pytest.approx(weighted, rel=1e-12)


def test_each_class_says_whether_its_orders_agree(table1):
    out = table1[0]
    orders = out[out.index("lowest first") :]
    assert orders.count("LiDAR groups") == orders.count("camera groups") == orders.count("rigs, S-MS") == 3
    agree, disagree = orders.count(" yes "), orders.count(" no ")
    assert agree + disagree == 9
    assert orders.count("paper: ") == disagree
    assert f"{agree} of 9 orders" in orders


def test_published_detection_stands_beside_our_figures(table1):
    out, _, rows = table1
    lines = [line.split() for line in out.splitlines()]
    assert next(line for line in lines if line[:2] == ["W+T", "83.5"])[:5] == [
        "W+T",
        "83.5",
        "77.5",
        "53.0",
        "71.3",
    ]
    assert next(line for line in lines if line[:2] == ["Square", "50.0"])
    assert "Line 49.6 < Trapezoid 50.9 < Pyramid 52.2 < Center 52.5" in out
    assert len(rows) == (8 + 5) * 4 and {row["paper"] for row in rows} == {"ICRA, Table II", "Place3D"}
    assert all(0.0 <= float(row["on_target"]) <= 1.0 for row in rows)


def test_claims_of_the_paper_stand_beside_what_its_tables_say(table1):
    out = table1[0]
    assert "28.7 points" in out and "48 of 48" in out
    lines = [line.split() for line in out.splitlines()]
    assert ["mean", "of", "detectors", "+0.98", "+1.00", "+0.98"] in lines
    for title in ("seen, cam.", "≥ 1 pt", "perception entropy"):
        assert sum(line.strip().startswith(title) for line in out.splitlines()) == 2  # a line for each paper
    edges = [float(line[1]) for line in lines if line[:1] == ["voxel"] and line[2:] == ["m"]]
    assert len(edges) == 2 and edges[1] == 2.0 * edges[0]


def test_a_pog_has_no_road_users_to_count_points_on(riglens, boxes, tmp_path):
    pog = tmp_path / "small.npz"
    assert riglens("data", "build", boxes, "--out", pog, *SMALL_GRID).code == 0
    result = riglens("study", "table1", "--pog", pog)
    assert result.code == 0 and "figures of objects are left out" in result.err
    ranks = next(line for line in result.out.splitlines() if line.strip().startswith("on target"))
    assert ranks.split()[2:] == ["–"] * 4
    assert any(
        line.split()[0] == "W+T" and line.count("—") >= 3 for line in result.out.splitlines() if line.strip()
    )


def test_the_csv_of_table1_holds_every_figure_in_full_precision():
    def scores_of(lidar: float) -> Scores:
        one = ClassScores(
            900.0, {"camera": KindScore(-670.7, 0.5), "lidar": KindScore(lidar, 0.2)}, 0.6, -67.07 + lidar
        )
        return Scores(dict.fromkeys(CLASSES, one), {"camera": 1, "lidar": 1, "any": 1})

    table = compare({rig: scores_of(-1 / 3) for rig in PAPER_RIGS}, MetricSettings())
    lines = list(csv.DictReader(io.StringIO(table1_csv(table))))
    assert [(line["rig"], line["class"]) for line in lines] == [(r, c) for r in PAPER_RIGS for c in CLASSES]
    assert float(lines[0]["lidar_s_mig"]) == -1 / 3
    assert float(lines[0]["published_lidar_s_mig"]) == -6450.0
    assert list(lines[0])[2:5] == ["camera_s_mig", "lidar_s_mig", "s_ms"]


# ---------------------------------------------------------------- accuracy


ONE_LIDAR = (
    "riglens: 1\nname: one\nsensors: [{name: a, kind: lidar, model: generic-16, position: [0, 0, 2]}]\n"
)


def test_it_writes_chart_and_csv_and_prints_every_point(riglens, boxes, tmp_path):
    folder = tmp_path / "deep" / "study"
    result = riglens("study", "accuracy", "--boxes", boxes, *SMALL_GRID, "--quick", "--out", folder)
    assert result.code == 0
    assert sorted(path.name for path in folder.iterdir()) == ["accuracy.csv", "accuracy.png", "accuracy.svg"]
    assert (folder / "accuracy.png").read_bytes().startswith(b"\x89PNG")
    assert (folder / "accuracy.svg").read_text(encoding="utf-8").startswith("<?xml")
    rows = list(csv.DictReader((folder / "accuracy.csv").read_text(encoding="utf-8").splitlines()))
    assert {row["method"] for row in rows} >= {"exact", "plain", "bresenham", "rectangles", "centres"}
    assert {float(row["voxel_m"]) for row in rows} == {0.5, 1.0, 2.0}
    for name in ("exact, δ 0.50 m, 352 × 128", "plain DDA", "Bresenham", "exact, 1/2 of the rays"):
        assert name in result.out
    assert "Pareto front" in result.out
    table = result.out.split("The requested setting")[0]
    assert max(len(line.rstrip()) for line in table.splitlines()) <= 120


def test_a_voxel_edge_that_does_not_divide_the_roi_is_left_out_with_a_note(riglens, boxes, tmp_path):
    roi, rig = ("--voxel", "0.5", "--roi", "21", "20", "3"), tmp_path / "one.yaml"
    rig.write_text(ONE_LIDAR, encoding="utf-8")
    result = riglens("study", "accuracy", rig, "--boxes", boxes, *roi, "--quick", "--out", tmp_path / "out")
    assert result.code == 0
    assert "note: δ 2.00 m is left out" in result.err
    assert "exact, δ 1.00 m" in result.out
    assert "exact, δ 2.00 m" not in result.out


def test_a_stored_pog_is_studied_on_its_own_grid(riglens, boxes, tmp_path):
    pog = tmp_path / "scene.npz"
    assert riglens("data", "build", boxes, "--out", pog, *SMALL_GRID).code == 0
    rig = tmp_path / "one.yaml"
    rig.write_text(ONE_LIDAR, encoding="utf-8")
    result = riglens("study", "accuracy", rig, "--pog", pog, "--quick", "--out", tmp_path / "out")
    assert result.code == 0
    assert "holds one grid only" in result.err
    assert "exact, δ 1.00 m" not in result.out


def test_bad_input_is_refused_before_anything_is_measured(riglens, boxes, tmp_path):
    file = tmp_path / "file"
    file.write_text("", encoding="utf-8")
    common = ("--boxes", boxes, *SMALL_GRID, "--quick")
    assert "--out" in riglens("study", "accuracy", *common, "--out", file).refused()
    assert "--threads" in riglens("study", "accuracy", *common, "--threads", "0").refused()
    assert "--lambda" in riglens("study", "accuracy", *common, "--lambda", "-1").refused()
    assert "nowhere" in riglens("study", "accuracy", "nowhere", *common, "--out", tmp_path).refused()
    missing = riglens("study", "accuracy", "--boxes", tmp_path / "none.csv", "--quick", "--out", tmp_path)
    assert "none.csv" in missing.refused()


def test_a_rig_without_sensors_is_refused(riglens, boxes, tmp_path):
    rig = tmp_path / "bare.yaml"
    rig.write_text("riglens: 1\nname: bare\nsensors: []\n", encoding="utf-8")
    result = riglens("study", "accuracy", rig, "--boxes", boxes, *SMALL_GRID, "--quick", "--out", tmp_path)
    assert "no sensor is enabled" in result.refused()


# ---------------------------------------------------------------- stability


NAMES = ["stability-methods.csv", "stability-metric.csv", "stability.html"]


@pytest.fixture(scope="module")
def studied(tmp_path_factory):
    """Exit code, standard output and folder of a quick study of a small scene."""
    folder = tmp_path_factory.mktemp("stability")
    boxes = folder / "boxes.csv"
    boxes.write_text(BOXES, encoding="utf-8")
    arguments = ["study", "stability", "--boxes", boxes, *SMALL_GRID, "--quick", "--edits", 8]
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        code = main([str(argument) for argument in (*arguments, "--out", folder / "deep" / "study")])
    return code, out.getvalue(), folder / "deep" / "study"


def test_it_writes_the_page_and_both_tables(studied):
    code, _, folder = studied
    assert code == 0
    assert sorted(path.name for path in folder.iterdir()) == NAMES
    assert (folder / "stability.html").read_text(encoding="utf-8").startswith("<!DOCTYPE html>")
    methods = list(
        csv.DictReader((folder / "stability-methods.csv").read_text(encoding="utf-8").splitlines())
    )
    assert {line["fast_verdict"] for line in methods} == {"ok"}
    assert "8 random edits" in {line["case"] for line in methods}
    orders = list(csv.DictReader((folder / "stability-metric.csv").read_text(encoding="utf-8").splitlines()))
    assert {line["varied"] for line in orders} == {"default", "δ", "rays", "reading", "λ", "frames"}


def test_it_prints_cases_orders_and_findings(studied):
    _, out, _ = studied
    for text in ("rays through corners", "1, 2 and 8 threads", "default: δ 0.50 m", "reading hits"):
        assert text in out
    assert "a rig without sensors is not the best" in out
    assert "fast engine: right in all" in out


def test_it_fits_a_pipe_and_cuts_nothing(studied):
    _, out, _ = studied
    tables = out.split("τ (Kendall)")[0]
    assert "…" not in tables
    assert max(len(line.rstrip()) for line in tables.splitlines()) <= PIPE_WIDTH


def test_bad_input_is_refused_before_anything_is_tried(riglens, boxes, tmp_path):
    file = tmp_path / "file"
    file.write_text("", encoding="utf-8")
    common = ("study", "stability", "--boxes", boxes, *SMALL_GRID, "--quick")
    assert "--out" in riglens(*common, "--out", file).refused()
    assert "--edits" in riglens(*common, "--edits", "0", "--out", tmp_path).refused()
    assert "EDITS" in riglens(*common, "--edits", "1.5", "--out", tmp_path).refused().upper()
    assert "--threads" in riglens(*common, "--threads", "0", "--out", tmp_path).refused()
    assert "--lambda" in riglens(*common, "--lambda", "-1", "--out", tmp_path).refused()


TRUE_POINTS = """seq,frame,cls,x,y,z,length,width,height,yaw,num_lidar_pts
a,0,car,10,0,0.8,4.5,1.9,1.6,0,50
a,0,car,25,6,0.8,4.5,1.9,1.6,0,9
a,1,pedestrian,6,4,0.9,0.6,0.6,1.8,0,20
"""


def test_the_targets_study_writes_tables_and_a_chart(riglens, tmp_path):
    (tmp_path / "boxes.csv").write_text(TRUE_POINTS, encoding="utf-8")
    out = tmp_path / "study"
    result = riglens("study", "targets", tmp_path / "boxes.csv", "--rig", "Center", "--out", out)
    assert result.code == 0, result.err
    for way in ("class shapes, range law", "class shapes, range law, mean of 16 draws"):
        assert f"\n{way}: Spearman" in result.out
    assert "no class has" in result.out and "0 of 0" not in result.out
    assert "car, 2" in result.out
    lines = (out / "targets-objects.csv").read_text(encoding="utf-8").splitlines()
    ways = 'plain boxes,class shapes,"class shapes, range law","class shapes, range law, mean of 16 draws"'
    assert lines[0] == f"seq,frame,cls,distance_m,true,{ways}"
    rows = [line.split(",") for line in lines[1:]]
    assert sorted((row[1], row[4]) for row in rows) == [("0", "50"), ("0", "9"), ("1", "20")]
    assert (
        (out / "targets.csv")
        .read_text(encoding="utf-8")
        .startswith("sequence,variant,class,from_m,to_m,spearman,median_ratio,n")
    )
    assert (out / "targets.png").read_bytes().startswith(b"\x89PNG")


def test_the_targets_study_refuses_what_does_not_fit(riglens, tmp_path):
    boxes = tmp_path / "boxes.csv"
    boxes.write_text(TRUE_POINTS, encoding="utf-8")
    assert "--rig is needed, or --rigs" in riglens("study", "targets", boxes, "--out", tmp_path).refused()
    (tmp_path / "rigs.json").write_text('{"b": {}}', encoding="utf-8")
    words = ("study", "targets", boxes, "--rigs", tmp_path / "rigs.json", "--out", tmp_path)
    assert "a rig for sequence 'a'" in riglens(*words).refused()
