"""`riglens data` says what box data hold; `--ground auto` puts the ground where the grid begins."""

import json

import numpy as np
import pytest

from tests.app.conftest import SMALL_GRID
from tests.core.argoverse_log import random_columns, write_log
from tests.core.nuscenes_folder import random_boxes, write_tables

HEADER = "seq,frame,cls,x,y,z,length,width,height,yaw\n"


@pytest.fixture
def ahead(tmp_path):
    """Cars in front of a sensor that is 1.7 m above the road, and some names that are no traffic."""
    random = np.random.default_rng(4)
    rows = []
    for frame in range(40):
        x, y = random.uniform([4, -3], [9, 3])
        rows.append(f"s,{frame},car,{x:.2f},{y:.2f},-0.9,4.5,1.9,1.6,0.1\n")
        rows.append(f's,{frame},"lamp [red]post[/red]",3,3,0,1,1,1,0\n')
    path = tmp_path / "ahead.csv"
    path.write_text(HEADER + "".join(rows), encoding="utf-8")
    return path


def test_the_tables_fit_a_terminal_of_100_columns(riglens, ahead, monkeypatch):
    monkeypatch.setattr("riglens.app.terminal.console.PIPE_WIDTH", 100)
    outcome = riglens("data", "show", ahead)
    assert outcome.code == 0
    tables = [line for line in outcome.out.splitlines() if not line.startswith(("Data", "warning"))]
    assert max(map(len, tables)) <= 100
    assert "…" not in "".join(tables)
    assert "40 in 1 sequence, 40 of them with boxes; 1.0 boxes per frame, at most 1" in outcome.out
    assert "lamp [red]post[/red]" in outcome.out
    assert outcome.err == ""


def test_a_side_without_boxes_and_a_ground_off_zero_are_pointed_out(riglens, ahead):
    warnings = [
        line for line in riglens("data", "show", ahead).out.splitlines() if line.startswith("warning")
    ]
    assert len(warnings) == 2
    assert "almost no boxes left (0), rear (0), right (0)" in warnings[0]
    assert "not at z = 0 but at -1.7" in warnings[1]
    assert "--origin 0 0 1.7" in warnings[1] and "--ground auto" in warnings[1]


REQUIREMENTS = """riglens_requirements: 1
settings: {voxel_m: 0.5, roi_m: [20, 20, 4]}
seen:
  - {class: car, at_least: 0.1}
on_target:
  - {class: car, at_least: 0.1}
"""
FIGURES = {
    "evaluate": ["W+T", "--targets"],
    "review": ["W+T", "--only", "audit,redundancy"],
    "check": ["W+T", "--requirements", "required.yaml"],
    "sweep": ["W+T", "--vary", "LIDAR_1.z=1.7:1.9:2", "--out", "out.parquet"],
    "report": ["W+T", "--draws", "0", "--out", "out.html"],
    "data build": ["--out", "out.npz"],
}


@pytest.mark.parametrize("command", FIGURES)
def test_whatever_computes_figures_points_out_once_that_the_ground_is_off(
    riglens, ahead, tmp_path, monkeypatch, command
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "required.yaml").write_text(REQUIREMENTS, encoding="utf-8")
    boxes = [ahead] if command == "data build" else ["--boxes", ahead]
    words = (*command.split(), *FIGURES[command], *boxes, *SMALL_GRID)
    found = riglens(*words)
    assert found.code in (0, 1)
    (line,) = (line for line in found.err.splitlines() if "z = 0" in line)
    assert "ahead.csv" in line and "-1.7" in line and "--origin 0 0 1.7" in line
    lifted = [line for line in riglens(*words, "--ground", "auto").err.splitlines() if "z = 0" in line]
    assert not any("ahead.csv" in line for line in lifted)


def test_a_stored_pog_and_documents_keep_what_was_pointed_out(riglens, ahead, tmp_path):
    assert riglens("data", "build", ahead, "--out", tmp_path / "low.npz", *SMALL_GRID).code == 0
    for words in (("--pog", tmp_path / "low.npz"), ("--boxes", ahead, *SMALL_GRID)):
        found = riglens("evaluate", "W+T", *words, "--json", "-")
        assert "ahead.csv" in found.err and "--origin 0 0 1.7" in found.err
        assert any("-1.7" in line for line in json.loads(found.out)["data"]["notes"])


def test_json_holds_the_same_figures(riglens, ahead, tmp_path):
    document = json.loads(riglens("data", "show", ahead, "--json", "-").out)
    assert document["data"]["frames"] == 40
    assert document["data"]["boxes"] == {"car": 40, "bicycle": 0, "pedestrian": 0}
    assert document["data"]["unmapped"] == {"lamp [red]post[/red]": 40}
    car = document["classes"]["car"]
    assert car["boxes"] == sum(map(sum, car["sectors"].values())) == sum(car["sectors"]["front"]) == 40
    assert len(car["sectors"]["front"]) == len(document["rings_m"]) - 1
    assert document["classes"]["bicycle"]["median_size_m"] == {"length": None, "width": None, "height": None}
    assert document["ground"]["height_m"] == pytest.approx(-1.7, abs=0.02)
    assert len(document["warnings"]) == 2
    target = tmp_path / "out.json"
    assert riglens("data", "show", ahead, "--json", target).code == 0
    assert json.loads(target.read_text(encoding="utf-8")) == document


def test_ground_auto_lifts_the_boxes_and_says_so(riglens, ahead):
    found = json.loads(riglens("data", "show", ahead, "--ground", "auto", "--json", "-").out)
    assert found["ground"]["height_m"] == pytest.approx(0, abs=0.02)
    assert found["data"]["origin_m"] == [0, 0, pytest.approx(1.7, abs=0.02)]
    assert not any("ground" in line for line in found["warnings"])
    assert any("moved to z = 0" in line for line in found["data"]["notes"])


def test_ground_auto_scores_as_the_origin_it_found(riglens, ahead):
    def scores(*options):
        document = json.loads(
            riglens("evaluate", "W+T", "--boxes", ahead, *options, *SMALL_GRID, "--json", "-").out
        )
        return document["data"], document["rigs"][0]["classes"]

    lifted = json.loads(riglens("data", "show", ahead, "--ground", "auto", "--json", "-").out)["data"][
        "origin_m"
    ]
    auto, by_auto = scores("--ground", "auto")
    given, by_hand = scores("--origin", *lifted)
    plain, low = scores()
    assert by_auto == by_hand != low
    assert auto["sha256"] == given["sha256"] != plain["sha256"]
    assert any("moved to z = 0" in line for line in auto["notes"])


def test_ground_auto_is_refused_where_nobody_can_tell(riglens, boxes, tmp_path):
    assert "--ground needs 20 boxes" in riglens("data", "show", boxes, "--ground", "auto").refused()
    assert "--origin" in riglens("evaluate", "W+T", "--boxes", boxes, "--ground", "auto").refused()
    assert "--ground" in riglens("evaluate", "W+T", "--ground", "auto").refused()
    assert "GROUND" in riglens("data", "show", boxes, "--ground", "0.3").refused().upper()


def test_data_sets_named_together_are_described_as_one(riglens, ahead, boxes):
    document = json.loads(riglens("data", "show", ahead, boxes, "--json", "-").out)
    assert document["data"]["frames"] == 43
    assert document["data"]["sequences"] == 2


def test_folders_of_other_sources_say_where_their_origin_is(riglens, tmp_path):
    write_tables(tmp_path / "nuscenes" / "v1.0-mini", random_boxes(2, 3, 30), scenes=2, samples=3)
    write_log(tmp_path / "argoverse" / "log", random_columns(4, 50))
    nuscenes = json.loads(riglens("data", "show", tmp_path / "nuscenes", "--json", "-").out)
    assert (nuscenes["data"]["frames"], nuscenes["data"]["sequences"]) == (6, 2)
    assert nuscenes["data"]["origin_m"] == [-1.35, 0, 0]
    argoverse = json.loads(riglens("data", "show", tmp_path / "argoverse", "--json", "-").out)
    assert argoverse["data"]["origin_m"] == [-1.34, 0, 0.33]
    assert argoverse["ground"]["height_m"] == pytest.approx(0, abs=0.02)
    assert argoverse["data"]["unmapped"].keys() == {"BOLLARD", "EGO_VEHICLE"}


def test_bad_data_and_usage_end_in_one_line(riglens, tmp_path):
    assert "no such file or folder" in riglens("data", "show", tmp_path / "no").refused()
    assert "BOXES" in riglens("data", "show").refused()
    assert "--json" in riglens("data", "show", tmp_path, "--json", "-x").refused()
    (tmp_path / "x.csv").write_text(HEADER + "s,0,car,1,2,3,4,5\n", encoding="utf-8")
    assert "x.csv:2" in riglens("data", "show", tmp_path / "x.csv").refused()


def test_one_frame_is_told_to_have_no_entropy(riglens, tmp_path):
    path = tmp_path / "one.csv"
    path.write_text(HEADER + "s,0,car,5,1,0.8,4.5,1.9,1.6,0.1\n", encoding="utf-8")
    outcome = riglens("evaluate", "W+T", "--boxes", path, *SMALL_GRID)
    assert outcome.code == 0 and "one frame only" in outcome.err and "without entropy" in outcome.err
    path.write_text(
        HEADER + "s,0,car,5,1,0.8,4.5,1.9,1.6,0.1\ns,1,car,5,1,0.8,4.5,1.9,1.6,0.1\n", encoding="utf-8"
    )
    assert "one frame only" not in riglens("evaluate", "W+T", "--boxes", path, *SMALL_GRID).err


def test_a_known_origin_is_kept_where_the_estimate_differs(riglens, tmp_path):
    columns = random_columns(4, 60)
    columns["tz_m"] = columns["tz_m"] - 0.3
    write_log(tmp_path / "log", columns)
    found = json.loads(riglens("data", "show", tmp_path / "log", "--json", "-").out)
    assert found["ground"]["height_m"] == pytest.approx(-0.3, abs=0.02)
    assert not any("ground" in line for line in found["warnings"])
    printed = " ".join(riglens("data", "show", tmp_path / "log").out.split())
    assert "the data's own origin is kept" in printed
    said = json.loads(
        riglens("data", "show", tmp_path / "log", "--origin", "-1.34", "0", "0.33", "--json", "-").out
    )
    assert any("--ground auto" in line for line in said["warnings"])
