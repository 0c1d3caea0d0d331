"""`riglens evaluate --targets`: a table for people, JSON for programs, and one row per road user."""

import csv
import json

import pyarrow.parquet
import pytest

from riglens.app.terminal.objects import _text
from riglens.core.figures.figure import Estimate
from riglens.core.figures.hits import ON_TARGET
from riglens.core.figures.text import estimate_text
from tests.app.conftest import SMALL_GRID

TARGETS = ("evaluate", "--targets", *SMALL_GRID)
EXACT = ("--phase", "0")


def rows_of(path):
    with open(path, encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))


def test_the_json_holds_every_key_of_the_promise(riglens, boxes):
    result = riglens(*TARGETS, "W+T", "Center", "--boxes", boxes, "--json", "-")
    document = result.part("targets")
    assert {"riglens", "body", "shape", "range_law", "phase", "seed", "data", "rigs"} <= set(document)
    data = document["data"]
    assert (data["frames"], data["frames_used"]) == (3, 3)
    assert data["objects"] == {"car": 2, "bicycle": 1, "pedestrian": 1} and len(data["sha256"]) == 64
    assert [rig["name"] for rig in document["rigs"]] == ["W+T", "Center"]
    car = document["rigs"][0]["classes"]["car"]
    assert {"objects", "lidar", "camera", "both", "neither", "rings"} <= set(car)
    assert {"on_target", "on_target_se", "share_1", "share_5", "median_points"} <= set(car["lidar"])
    assert {"visible", "share_25px", "median_height_px"} <= set(car["camera"])
    assert {"from_m", "to_m", "objects", "on_target", "share_5", "visible"} <= set(car["rings"][0])
    assert sum(ring["objects"] for ring in car["rings"]) == car["objects"] == 2
    assert car["lidar"]["share_1"] == 1.0 and car["lidar"]["on_target_se"] == 0.0
    held = {part["sector"]: part["objects"] for part in car["sectors"] if part["objects"]}
    assert held == {"front": 1, "rear-left": 1}
    assert set(car["sectors"][0]) - {"sector"} == set(car["rings"][0]) - {"from_m", "to_m"}


def test_the_table_of_one_rig_has_rings_or_sectors(riglens, boxes):
    shown = {by: riglens(*TARGETS, "Center", "--boxes", boxes, "--by", by).out for by in ("ring", "sector")}
    assert "0 to 10 m" in shown["ring"] and "front-left" not in shown["ring"]
    assert "front-left" in shown["sector"] and "0 to 10 m" not in shown["sector"]
    assert (
        "--by is for one rig"
        in riglens(*TARGETS, "Center", "W+T", "--boxes", boxes, "--by", "sector").refused()
    )


def test_the_object_table_has_a_row_for_each_road_user_in_the_order_of_the_data(riglens, boxes, tmp_path):
    out = tmp_path / "objects.csv"
    assert riglens(*TARGETS, "W+T", "--boxes", boxes, *EXACT, "--objects", out).code == 0
    rows = rows_of(out)
    assert list(rows[0])[:10] == ["seq", "frame", "cls", "x", "y", "z", "length", "width", "height", "yaw"]
    assert [(row["seq"], row["frame"], row["cls"], row["x"]) for row in rows] == [
        ("s", "0", "car", "6.0"), ("s", "0", "bicycle", "3.0"),
        ("s", "1", "car", "-6.0"), ("s", "2", "pedestrian", "2.0"),
    ]  # fmt: skip
    assert float(rows[0]["yaw"]) == 0.3
    for row in rows:
        lidars = [int(row[f"points_LIDAR_{number}"]) for number in range(1, 5)]
        assert sum(lidars) == int(row["points"]) >= int(row["cells"]) > 0
        assert any(float(value) > 0.0 for name, value in row.items() if name.startswith("pixels_CAM"))
    parquet = tmp_path / "objects.parquet"
    assert riglens(*TARGETS, "W+T", "--boxes", boxes, *EXACT, "--objects", parquet).code == 0
    table = pyarrow.parquet.read_table(parquet).to_pydict()
    assert list(table) == list(rows[0]) and table["points"] == [int(row["points"]) for row in rows]


def test_origin_and_distance_decide_what_counts(riglens, boxes, tmp_path):
    out = tmp_path / "objects.csv"
    words = ("--boxes", boxes, "--origin", "2", "0", "0", "--within", "6", "--objects", out)
    assert riglens(*TARGETS, "Center", *words).code == 0
    assert [row["x"] for row in rows_of(out)] == ["-4.0"]


def test_a_table_that_calls_its_frames_by_far_numbers_gets_them_back(riglens, tmp_path):
    (tmp_path / "boxes.csv").write_text(
        "seq,frame,cls,x,y,z,length,width,height,yaw\n"
        "b,7,car,9,0,1,4,2,2,0\nb,900,tree,9,9,1,4,2,2,0\na,3,car,9,9,1,4,2,2,0\n=a,5,car,9,9,1,4,2,2,0\n",
        encoding="utf-8",
    )
    out = tmp_path / "objects.csv"
    assert riglens(*TARGETS, "Center", "--boxes", tmp_path / "boxes.csv", "--objects", out).code == 0
    assert [(row["seq"], row["frame"]) for row in rows_of(out)] == [("b", "7"), ("a", "3"), ("'=a", "5")]


def test_a_sample_says_so_and_gives_two_standard_errors(riglens, boxes):
    words = (*TARGETS, "Center", "--sample", "20")
    result, document = riglens(*words), riglens(*words, "--json", "-").part("targets")
    assert result.code == 0 and "errors of the sample" in result.out
    for one in document["rigs"][0]["classes"].values():
        assert one["lidar"]["on_target_se"] > 0.001
        assert f"±{200 * one['lidar']['on_target_se']:.1f}" in result.out
    whole = riglens(*TARGETS, "Center", "--boxes", boxes, "--sample", "9")
    assert "3 frames" in whole.out and "errors of the sample" not in whole.out


@pytest.mark.parametrize("se", [0.001, 0.0123])
def test_what_follows_a_plus_minus_is_the_same_in_the_terminal_and_in_the_window(se):
    found = Estimate(0.5, se)
    in_terminal, in_window = _text(ON_TARGET, found), estimate_text(ON_TARGET, found)
    assert in_terminal.partition("±")[2] == in_window.partition("±")[2].removesuffix(" %") != ""


def test_the_table_tells_rings_for_one_rig_and_rigs_beside_each_other(riglens, boxes):
    one = riglens(*TARGETS, "W+T", "--boxes", boxes).out
    assert "0 to 10 m" in one and "50 to 60 m" in one and "spin phase random (seed 0)" in one
    two = riglens(*TARGETS, "W+T", "Center", "--boxes", boxes, *EXACT).out
    assert "0 to 10 m" not in two and "Center" in two and "spin phase as listed" in two


def test_the_table_has_a_column_for_each_further_kind_of_the_rigs(riglens, boxes):
    assert "radar" not in riglens(*TARGETS, "nuScenes car", "--boxes", boxes).out
    found = riglens(*TARGETS, "nuScenes car", "nuScenes car with radars", "--boxes", boxes).out
    assert "radars" in found and "missed" in found and "ultrasonic" not in found


def cells_of(out, rig):
    """The cells of the rows of a rig."""
    return [words[1:] for line in out.splitlines() if (words := line.split())[:1] == [rig]]


@pytest.mark.parametrize("order", [(0, 1, 2), (2, 1, 0)])
def test_a_rig_without_a_kind_of_sensor_has_dashes_not_zeros(riglens, boxes, tmp_path, order):
    sensors = (
        "{name: rear, kind: camera, position: [-2.3, 0, 1.0], rpy_deg: [0, 20, 180], hfov_deg: 120}",
        "{name: roof, kind: lidar, model: generic-16, position: [0, 0, 1.6]}",
        "{name: grille, kind: radar, model: generic-radar, position: [2.2, 0, 0.5]}",
    )
    held = {"eyes": sensors[:1], "points": sensors[1:2], "everything": sensors}
    for name, those in held.items():
        text = "\n".join(["riglens: 1", f"name: {name}", "sensors:", *(f"  - {one}" for one in those)])
        (tmp_path / f"{name}.yaml").write_text(text, encoding="utf-8")
    rigs = [tmp_path / f"{tuple(held)[place]}.yaml" for place in order]
    document = json.loads(riglens(*TARGETS, *rigs, "--boxes", boxes, *EXACT, "--json", "-").out)
    lacking = {
        "eyes": {"share_5", "seen_lidar", "radar"},
        "points": {"seen_by_cameras", "seen_camera", "radar"},
    }
    for rig in document["rigs"]:
        for of_class in rig["classes"].values():
            none = {key for key, one in of_class["figures"].items() if one["value"] is None}
            none |= {"radar", "seen_radar"} - of_class["figures"].keys()
            expected = lacking.get(rig["name"], set())
            assert {key for key in ("share_5", "seen_by_cameras", "radar") if key in none} == {
                key for key in ("share_5", "seen_by_cameras", "radar") if key in expected
            }
    shown = riglens(*TARGETS, *rigs, "--boxes", boxes, *EXACT).out
    for name in held:
        rows = cells_of(shown, name)
        assert len(rows) == 4 + 3 + 3  # mean of the classes and each class, objects, the paper's scores
        assert any("—" in row for row in rows) == (name != "everything")


def test_what_stands_around_hides_road_users(riglens, boxes, tmp_path):
    """A wall right around the car leaves nothing to see; it belongs to the frames of sequence s."""
    walls, poses = tmp_path / "walls.csv", tmp_path / "poses.csv"
    rows = ["m,wall,101.5,50,2,0.1,3,4,0", "m,wall,98.5,50,2,0.1,3,4,0", "m,wall,100,51.5,2,3,0.1,4,0"]
    rows += ["m,wall,100,48.5,2,3,0.1,4,0"]
    walls.write_text("\n".join(["map,cls,x,y,z,length,width,height,yaw", *rows]) + "\n", encoding="utf-8")
    poses.write_text(
        "seq,frame,map,x,y,z,yaw\n" + "".join(f"s,{k},m,100,50,0,{k}\n" for k in range(3)), encoding="utf-8"
    )
    plain = riglens(*TARGETS, "Center", "--boxes", boxes, "--json", "-").part("targets")
    hidden = riglens(*TARGETS, "Center", "--boxes", boxes, "--occluders", walls, poses, "--json", "-")
    document = hidden.part("targets")
    assert (plain["surroundings"], document["surroundings"]) == ("ignored", "block")
    assert plain["data"]["surroundings_sha256"] == "" and len(document["data"]["surroundings_sha256"]) == 64
    assert plain["data"]["objects"] == document["data"]["objects"]
    assert plain["rigs"][0]["classes"]["car"]["lidar"]["share_1"] == 1.0
    assert document["rigs"][0]["classes"]["car"]["lidar"]["share_1"] == 0.0


def test_surroundings_of_the_town_take_points_and_no_object(riglens):
    words = (*TARGETS, "Center", "--sample", "20", "--json", "-")
    plain = riglens(*words).part("targets")
    blocked = riglens(*words, "--surroundings", "block").part("targets")
    assert plain["data"]["objects"] == blocked["data"]["objects"]
    share = [document["rigs"][0]["classes"]["car"]["lidar"]["share_1"] for document in (plain, blocked)]
    assert 0.1 < share[1] < share[0]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (
            ("--surroundings", "block"),
            "--surroundings cannot block: occluders are unknown; specify them with --occluders",
        ),
        (("--surroundings", "ignored", "--occluders", "a.csv", "b.csv"), "--occluders hide nothing when"),
        (("--occluders", "a.csv", "b.csv"), "a.csv: cannot be read"),
    ],
)
def test_surroundings_that_are_not_there_are_told(riglens, boxes, words, message):
    result = riglens(*TARGETS, "Center", "--boxes", boxes, *words)
    assert result.code == 2 and message in result.err


def test_occluders_belong_to_boxes(riglens):
    result = riglens(*TARGETS, "Center", "--occluders", "a.csv", "b.csv")
    assert result.code == 2 and "specify it with --boxes" in result.err


def test_an_edited_rig_keeps_its_body_mode_unless_another_is_said_for_this_run(riglens, boxes, tmp_path):
    own = tmp_path / "own.yaml"
    assert riglens("list", "rigs", "W+T", "--out", own).code == 0
    own.write_text(own.read_text(encoding="utf-8").replace("W+T", "mine", 1), encoding="utf-8")
    for arguments, body in (
        (["W+T"], "ignored"),
        ([own], "ignored"),
        (["W+T", "--body", "blocks"], "blocks"),
        ([own, "--body", "blocks"], "blocks"),
        (["nuScenes car"], "blocks"),
        (["nuScenes car", "--body", "ignored"], "ignored"),
        (["W+T", "nuScenes car"], None),
    ):
        result = riglens(*TARGETS, *arguments, "--boxes", boxes, "--json", "-")
        assert result.part("targets")["body"] == body, arguments
    assert "body ignored" in riglens(*TARGETS, own, "--boxes", boxes).out
