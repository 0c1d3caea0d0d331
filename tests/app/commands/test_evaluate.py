"""`riglens evaluate`: a table for people, JSON for programs, and nothing else on standard output."""

import json
import math
import re
import subprocess
import sys

import pytest

from tests.app.conftest import REPOSITORY, SMALL_GRID
from tests.waiting import TIMEOUT_S


def test_the_json_holds_every_key_of_the_promise(riglens, boxes):
    result = riglens("evaluate", "W+T", "Center", "--boxes", boxes, *SMALL_GRID, "--json", "-")
    assert result.code == 0
    document = json.loads(result.out)
    scored = ["riglens", "grid", "data", "method", "reading", "lambda", "body", "rigs"]
    assert list(document) == [*scored, "targets"]
    assert document["riglens"] == 1
    assert document["grid"]["shape"] == [40, 40, 8]
    assert document["grid"]["origin_m"] == [-10, -10, 0]
    assert document["data"]["frames"] == 3
    assert document["data"]["boxes"] == {"car": 2, "bicycle": 1, "pedestrian": 1}
    assert len(document["data"]["sha256"]) == 64
    assert document["body"] == "ignored"  # as in the paper, whose rigs these are
    wide, center = document["rigs"]
    assert (wide["name"], center["name"]) == ("W+T", "Center")
    assert len(wide["sha256"]) == 64
    assert wide["sha256"] != center["sha256"]
    assert set(wide["covered_voxels"]) == {"camera", "lidar", "any"}
    for scores in wide["classes"].values():
        assert list(scores) == ["h_total", "camera", "lidar", "any", "s_ms", "figures"]
        assert scores["figures"]["s_ms"]["value"] == scores["s_ms"]
        assert scores["figures"]["share_5"].keys() == {"value", "se", "state", "reason", "weakest"}
        assert scores["figures"]["predicted"]["parts"].keys() == {"lidar", "camera"}
    assert center["classes"]["car"]["figures"]["share_25px"]["value"] is None
    assert "camera" in center["classes"]["car"]["figures"]["share_25px"]["reason"]


def test_the_json_figures_fit_together(riglens, boxes, small_rig):
    result = riglens("evaluate", small_rig, "--boxes", boxes, *SMALL_GRID, "--lambda", "0.25", "--json", "-")
    document = json.loads(result.out)
    assert document["lambda"] == 0.25
    for scores in document["rigs"][0]["classes"].values():
        camera, lidar = scores["camera"], scores["lidar"]
        assert scores["h_total"] > 0.0
        assert camera["seen"] == pytest.approx(-camera["s_mig"] / scores["h_total"], rel=1e-12)
        assert scores["s_ms"] == pytest.approx(0.25 * camera["s_mig"] + lidar["s_mig"], rel=1e-12)
        assert max(camera["seen"], lidar["seen"]) <= scores["any"]["seen"] <= 1.0


def test_a_rig_without_sensors_or_a_class_without_boxes_gives_zeros_not_nan(riglens, tmp_path):
    (tmp_path / "empty.yaml").write_text("riglens: 1\nname: empty\nsensors: []\n", encoding="utf-8")
    (tmp_path / "cars.csv").write_text(
        "seq,frame,cls,x,y,z,length,width,height,yaw\ns,0,car,0,0,1,4,2,1.5,0\ns,1,car,9,9,1,4,2,1.5,0\n",
        encoding="utf-8",
    )
    result = riglens(
        "evaluate", tmp_path / "empty.yaml", "--boxes", tmp_path / "cars.csv", *SMALL_GRID, "--json", "-"
    )
    assert "NaN" not in result.out
    classes = json.loads(result.out)["rigs"][0]["classes"]
    assert classes["pedestrian"]["h_total"] == 0.0
    assert classes["pedestrian"]["any"]["seen"] == 0.0
    assert classes["car"]["s_ms"] == 0.0
    assert math.copysign(1.0, classes["car"]["s_ms"]) == 1.0


def test_standard_output_is_json_alone_and_notes_go_to_standard_error(riglens, boxes):
    result = riglens("evaluate", "W+T", "--boxes", boxes, *SMALL_GRID, "--json", "-")
    json.loads(result.out)
    boxes_note, *places = result.err.splitlines()
    assert boxes_note == "note: 1 box belongs to no class and does not count: shopping_cart 1"
    assert all(line.startswith("note: W+T: ") and "needs a bracket" in line for line in places)


def test_sensors_that_are_not_on_the_cars_surface_are_noted_and_leave_the_json_as_it_is(
    riglens, boxes, tmp_path
):
    rig = "riglens: 1\nname: three\nsensors:\n"
    for name, place in (("high", "[0, 0, 2.2]"), ("roof", "[0.1, 0, 1.5]"), ("seat", "[0, 0, 0.9]")):
        rig += f"  - {{name: {name}, kind: camera, position: {place}, image: [64, 48], cast: [8, 6], hfov_deg: 60}}\n"
    (tmp_path / "three.yaml").write_text(rig, encoding="utf-8")
    result = riglens("evaluate", tmp_path / "three.yaml", "--boxes", boxes, *SMALL_GRID, "--json", "-")
    notes = [line for line in result.err.splitlines() if "three: " in line]
    assert [line.split(":")[2] for line in notes] == [" high", " seat"]
    assert notes[0].endswith("m above the body: needs a bracket") and notes[1].endswith("inside the body")
    assert "bracket" not in result.out


def test_nothing_is_said_of_places_on_a_body_that_is_not_read(riglens, boxes, tmp_path):
    rig = "riglens: 1\nname: one\nvehicle: {body: car.ply}\nsensors:\n"
    rig += (
        "  - {name: high, kind: camera, position: [0, 0, 2.2], image: [64, 48], cast: [8, 6], hfov_deg: 60}\n"
    )
    (tmp_path / "one.yaml").write_text(rig, encoding="utf-8")
    options = ("--boxes", boxes, *SMALL_GRID, "--body", "ignored")
    result = riglens("evaluate", tmp_path / "one.yaml", *options)
    assert result.code == 0 and "high" not in result.err


def test_a_json_file_is_written_beside_the_table(riglens, boxes, tmp_path):
    target = tmp_path / "scores.json"
    result = riglens("evaluate", "W+T", "--boxes", boxes, *SMALL_GRID, "--json", target)
    assert result.code == 0
    assert json.loads(target.read_text(encoding="utf-8"))["rigs"][0]["name"] == "W+T"
    for word in ("S-MIG", "S-MS", "seen", "W+T", "pedestrian, H(Ω)", "3 frames", "reading covered"):
        assert word in result.out


def test_rigs_of_one_name_have_numbers_in_every_table(riglens, boxes):
    result = riglens("evaluate", "W+T", "W+C", "W+T", "--boxes", boxes, *SMALL_GRID)
    assert result.code == 0
    lines = [line.strip() for line in result.out.splitlines()]
    rows = [line.split("  ")[0] for line in lines if re.match(r"W\+[TC]( \(\d\))?  ", line)]
    assert set(rows) == {"W+T (1)", "W+C", "W+T (2)"}
    assert rows.count("W+T (1)") == rows.count("W+T (2)") == rows.count("W+C")


def test_the_table_fits_a_terminal_of_100_columns(riglens, boxes):
    result = riglens("evaluate", "W+C", "N+T", "--boxes", boxes, *SMALL_GRID)
    tables = [line for line in result.out.splitlines() if line.startswith(" ")]
    assert len(tables) > 20 and max(len(line.rstrip()) for line in tables) <= 100


def test_negative_numbers_are_values_not_options(riglens, boxes, small_rig):
    moved = riglens(
        "evaluate", small_rig, "--origin", "-1.35", "0", "-1e-3", "--boxes", boxes, *SMALL_GRID, "--json", "-"
    )
    assert moved.code == 0
    here = riglens("evaluate", small_rig, "--boxes", boxes, *SMALL_GRID, "--json", "-")
    assert json.loads(moved.out)["data"]["sha256"] != json.loads(here.out)["data"]["sha256"]


def test_each_reading_and_method_says_its_name(riglens, boxes):
    for extra in (("--reading", "residual"), ("--reading", "hits"), ("--method", "bresenham")):
        document = json.loads(
            riglens("evaluate", "Line", "--boxes", boxes, *SMALL_GRID, *extra, "--json", "-").out
        )
        assert document[extra[0].lstrip("-")] == extra[1]


def test_a_class_can_be_mapped_or_ignored_by_the_user(riglens, boxes, small_rig):
    mapped = ("--classes", "shopping_cart=pedestrian", "--classes", "bicycle=ignore")
    result = riglens("evaluate", small_rig, "--boxes", boxes, *SMALL_GRID, *mapped, "--json", "-")
    assert json.loads(result.out)["data"]["boxes"] == {"car": 2, "bicycle": 0, "pedestrian": 2}


def test_a_class_map_for_names_that_no_box_has_is_told(riglens, boxes, tmp_path):
    mapped = (
        "--classes",
        "nosuch=car",
        "--classes",
        "bicyle=ignore",
        "--classes",
        "Shopping_Cart=pedestrian",
    )
    words = ("evaluate", "Line", "--boxes", boxes, *SMALL_GRID)
    for result in (riglens(*words, *mapped), riglens(*words, *mapped)):  # the second from the cache
        told = [line for line in result.err.splitlines() if "class map" in line]
        assert told == [
            "note: class map: no box is called 'nosuch'",
            "note: class map: no box is called 'bicyle'",
        ]
    for idle in ((), ("--classes", "CAR=car")):
        assert "class map" not in riglens(*words, *idle).err
    folder = tmp_path / "logs"
    folder.mkdir()
    text = boxes.read_text(encoding="utf-8")
    (folder / "one.csv").write_text(text, encoding="utf-8")
    (folder / "two.csv").write_text(
        text.replace("shopping_cart", "dog").replace("\ns,", "\nt,"), encoding="utf-8"
    )
    result = riglens("data", "show", folder, *mapped)
    assert "no box is called 'nosuch'" in result.err and "cart" not in result.err


def test_a_rig_name_is_printed_as_it_is(riglens, boxes, tmp_path):
    (tmp_path / "odd.yaml").write_text("riglens: 1\nname: '[red]odd[/]'\nsensors: []\n", encoding="utf-8")
    result = riglens("evaluate", tmp_path / "odd.yaml", "--boxes", boxes, *SMALL_GRID)
    assert "[red]odd[/]" in result.out


def test_names_classes_and_files_never_steer_the_terminal(riglens, tmp_path):
    boxes = tmp_path / "boxes\x1b[2J.csv"
    boxes.write_text(
        "seq,frame,cls,x,y,z,length,width,height,yaw\n"
        "s,0,car,6,0,0.8,4.5,1.9,1.6,0.3\n"
        "s,0,\x1b]0;owned\x07cart\x9b1m,6,0,0.8,4.5,1.9,1.6,0.3\n",
        encoding="utf-8",
    )
    rig = tmp_path / "odd.yaml"
    rig.write_text('riglens: 1\nname: "\\x1b[31modd\\nnote: all is well"\nsensors: []\n', encoding="utf-8")
    for words in (("evaluate", rig), ("data", "show")):
        boxes_words = (boxes,) if words[0] == "data" else ("--boxes", boxes, *SMALL_GRID)
        result = riglens(*words, *boxes_words)
        assert result.code == 0
        said = result.out + result.err
        assert "cart" in said
        assert not set(said) & {"\x1b", "\x07", "\x9b"}
        assert not any(line.startswith("note: all is well") for line in said.splitlines())
    refused = riglens("evaluate", tmp_path / "\x1b[31mnowhere.yaml").refused()
    assert "\\x1b[31mnowhere.yaml" in refused


def test_a_reader_that_goes_away_early_is_no_error(riglens_process):
    process = riglens_process("list", "sensors", "--json", "-")
    assert process.stdout is not None
    process.stdout.close()
    _, err = process.communicate(timeout=TIMEOUT_S)
    assert "Traceback" not in err
    assert "BrokenPipe" not in err
    assert process.returncode == 0


def test_a_full_disk_is_told_in_one_line(riglens, boxes):
    result = riglens("data", "show", boxes, "--json", "/dev/full")
    assert result.code == 3
    assert result.err.splitlines()[-1] == "riglens: No space left on device"
    assert "Traceback" not in result.err


def test_a_command_that_draws_nothing_loads_neither_qt_nor_vtk(boxes):
    script = (
        "import sys; from riglens.app.commands import main; code = main(sys.argv[1:]);"
        "loaded = [m for m in sys.modules if m.split('.')[0] in ('PySide6', 'vtkmodules', 'pyvista')];"
        "sys.exit(f'loaded {loaded}' if loaded else code)"
    )
    command = [sys.executable, "-c", script, "evaluate", "W+T", "--boxes", str(boxes), *SMALL_GRID]
    result = subprocess.run(command, cwd=REPOSITORY, capture_output=True, encoding="utf-8", timeout=TIMEOUT_S)
    assert result.returncode == 0, result.stderr


# ---------------------------------------------------------------- lens distortion


BARREL = """\
riglens: 1
name: bent
sensors:
  - name: cam
    kind: camera
    position: [0.5, 0, 1.8]
    image: [1280, 960]
    fx: 300
    fy: 300
    cx: 640
    cy: 480
    distortion: {model: brown_conrady, k1: -0.35}
    cast: [64, 48]
"""


def test_rays_that_the_lens_has_not_are_counted_in_a_note(riglens, boxes, tmp_path):
    (tmp_path / "bent.yaml").write_text(BARREL, encoding="utf-8")
    result = riglens("evaluate", tmp_path / "bent.yaml", "--boxes", boxes, *SMALL_GRID)
    assert result.code == 0
    assert "bent: cam: 2,772 of 3,072 rays are outside the valid range of its lens model" in result.err
    (tmp_path / "mild.yaml").write_text(BARREL.replace("-0.35", "-0.01"), encoding="utf-8")
    assert "lens" not in riglens("evaluate", tmp_path / "mild.yaml", "--boxes", boxes, *SMALL_GRID).err


@pytest.mark.slow
def test_the_accuracy_study_leaves_out_rough_methods_that_do_not_know_a_lens(riglens, boxes, tmp_path):
    (tmp_path / "bent.yaml").write_text(BARREL, encoding="utf-8")
    options = ("--boxes", boxes, *SMALL_GRID, "--quick", "--out", tmp_path / "out")
    result = riglens("study", "accuracy", tmp_path / "bent.yaml", *options)
    assert result.code == 0
    assert "note: cam: lens distortion or azimuth offsets" in result.err
    assert "plain DDA" in result.out
    assert "bounding rectangles" not in result.out


def test_the_bundled_scenario_is_the_default_and_has_all_classes(riglens):
    result = riglens("evaluate", "W+T", "--voxel", "0.2", "--json", "-")
    document = json.loads(result.out)
    assert all(line.endswith("needs a bracket") for line in result.err.splitlines())
    assert document["data"]["source"] == "bundled scenario town"
    assert document["data"]["frames"] >= 2000
    for scores in document["rigs"][0]["classes"].values():
        assert 0.0 < scores["lidar"]["seen"] < scores["any"]["seen"] < 1.0


LOW = """riglens: 1
name: low
vehicle: {body: BODY}
sensors:
  - {name: a, kind: lidar, position: [0.0, 0.0, 1.0], elevations_deg: {from: -25, to: 25, count: 16}}
"""


def seen(result):
    assert result.code == 0, result.err
    document = json.loads(result.out)
    return document["body"], [rig["classes"]["car"]["any"]["seen"] for rig in document["rigs"]]


def test_rays_end_at_the_car_as_the_rig_says_or_as_is_said_for_this_run(riglens, boxes, tmp_path):
    rig = tmp_path / "low.yaml"
    rig.write_text(LOW.replace("BODY", "sedan"), encoding="utf-8")
    scene = ("--boxes", boxes, *SMALL_GRID, "--json", "-")
    usual, blocks, ignored = (
        seen(riglens("evaluate", rig, *scene, *options))
        for options in ((), ("--body", "blocks"), ("--body", "ignored"))
    )
    assert usual == blocks and usual[0] == "blocks" and ignored[0] == "ignored"
    assert usual[1][0] < 0.5 * ignored[1][0]
    assert seen(riglens("evaluate", "W+T", *scene))[0] == "ignored"
    assert seen(riglens("evaluate", "W+T", *scene, "--body", "blocks"))[0] == "blocks"
    mixed = seen(riglens("evaluate", "W+T", rig, *scene))
    alone = seen(riglens("evaluate", "W+T", *scene))
    assert mixed[0] is None and mixed[1] == [*alone[1], *usual[1]], (
        "no figure depends on what it is shown with"
    )


def test_the_table_says_what_the_body_does(riglens, boxes, tmp_path):
    for options, said in (((), "ignored"), (("--body", "blocks"), "blocks")):
        out = riglens("evaluate", "W+T", "--boxes", boxes, *SMALL_GRID, *options).out
        assert next(line for line in out.splitlines() if line.startswith("Body")).split()[1] == f"{said}:"


def test_a_body_whose_mesh_is_missing_or_broken_is_one_line_and_no_score(riglens, boxes, tmp_path):
    rig = tmp_path / "low.yaml"
    rig.write_text(LOW.replace("BODY", "car.glb"), encoding="utf-8")
    for _ in ("missing", "broken"):
        result = riglens("evaluate", rig, "--boxes", boxes, *SMALL_GRID)
        assert result.code == 2 and not result.out
        assert "vehicle.body" in result.err and len(result.err.strip().splitlines()) == 1
        assert riglens("evaluate", rig, "--boxes", boxes, *SMALL_GRID, "--body", "ignored").code == 0
        (tmp_path / "car.glb").write_bytes(b"no mesh")


def test_a_body_in_millimetres_is_told_with_the_scale_that_it_needs(riglens, boxes, tmp_path):
    corners = [f"v {x} {y} {z}" for x in (0, 4600) for y in (0, 1900) for z in (0, 1450)]
    faces = ("1 3 4 2", "5 6 8 7", "1 2 6 5", "3 7 8 4", "1 5 7 3", "2 4 8 6")
    (tmp_path / "car.obj").write_text(
        "\n".join([*corners, *(f"f {face}" for face in faces)]) + "\n", encoding="utf-8"
    )
    rig = tmp_path / "low.yaml"
    rig.write_text(LOW.replace("BODY", "car.obj"), encoding="utf-8")
    said = (
        "vehicle.body: car.obj: the mesh is 4,600.00 × 1,900.00 × 1,450.00 m; set vehicle.mesh.scale: 0.001"
    )
    for command in (["evaluate"], ["review", "--only", "audit"]):
        result = riglens(*command, rig, "--boxes", boxes, *SMALL_GRID)
        assert result.code == 0 and said in result.err
    rig.write_text(LOW.replace("BODY", "car.obj, mesh: {scale: 0.001}"), encoding="utf-8")
    assert "vehicle.mesh.scale" not in riglens("evaluate", rig, "--boxes", boxes, *SMALL_GRID).err


# ---------------------------------------------------------------- --targets


def without_times(document):
    for rig in (*document["rigs"], *document.get("targets", {"rigs": ()})["rigs"]):
        del rig["elapsed_ms"]
    return document


def test_targets_come_with_the_same_scores(riglens, boxes, tmp_path):
    count = ("--sample", "2", "--min-points", "3", "--seed", "4", "--within", "50")
    words = ("Center", "--boxes", boxes, *count)
    both = json.loads(riglens("evaluate", *words, *SMALL_GRID, "--targets", "--json", "-").out)
    default = json.loads(riglens("evaluate", *words, *SMALL_GRID, "--json", "-").out)
    assert without_times(both) == without_times(default)
    scores = riglens("evaluate", "Center", "--boxes", boxes, *SMALL_GRID, "--no-targets", "--json", "-")
    without = json.loads(scores.out)
    objects = both.pop("targets")
    assert "targets" not in without
    for name, of_class in without["rigs"][0]["classes"].items():
        mine = both["rigs"][0]["classes"][name]
        assert {key: mine[key] for key in mine if key != "figures"} == {
            key: of_class[key] for key in of_class if key != "figures"
        }
        assert of_class["figures"]["on_target"]["state"] == "none"
        has_objects = objects["rigs"][0]["classes"][name]["objects"] > 0
        assert (mine["figures"]["on_target"]["state"] != "none") == has_objects
    table = tmp_path / "objects.csv"
    shown = riglens("evaluate", *words, *SMALL_GRID, "--targets", "--objects", table)
    assert shown.code == 0 and table.exists() and "0 to 10 m" in shown.out
    assert "0 to 10 m" not in riglens("evaluate", *words, *SMALL_GRID).out


def test_options_of_targets_need_them_and_they_need_boxes(riglens, boxes, tmp_path):
    for option in (("--sample", "2"), ("--by", "sector"), ("--surroundings", "block")):
        refused = riglens("evaluate", "Center", "--no-targets", *option).refused()
        assert option[0] in refused and "--no-targets" in refused
    riglens("data", "build", boxes, *SMALL_GRID, "--out", tmp_path / "a.npz")
    found = riglens("evaluate", "Center", "--pog", tmp_path / "a.npz", "--targets")
    assert found.code == 2 and "--targets needs a box data set" in found.err and found.out == ""
