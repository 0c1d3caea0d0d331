"""`riglens check`: exit codes for machines, one line per requirement, every figure as the other commands say it."""

import hashlib
import json
from datetime import date, timedelta
from xml.etree import ElementTree

import pytest

from riglens.assets import asset_path
from tests.app.conftest import SMALL_GRID

HEAD = "riglens_requirements: 1\n"
SOON = (date.today() + timedelta(days=30)).isoformat()
"""A day on which a waiver may end."""
EASY = HEAD + (
    "settings: {body: ignored, blind_voxel_m: 0.25, voxel_m: 0.5, roi_m: [20, 20, 4]}\n"
    "seen: [{class: car, at_least: 0.0}, {class: car, by: camera, at_least: 0.0}]\n"
    "on_target: [{class: car, at_least: 0.0}, {class: pedestrian, ring_m: [0, 20], figure: share_5, at_least: 0.0}]\n"
    "blind_areas: [{height_m: 1.15, at_most_m2: 10000}, {height_m: 0.3, sector: rear, within_m: 5, at_most_m2: 9999}]\n"
    "blind_objects: [{profile: adults-around, at_most_unseen: 4}]\n"
    "losses: [{of: voxels, class: car, failure: pair, share_of: all, at_most: 1.0},"
    " {of: objects, class: car, at_most: 1.0}]\n"
    "covered: [{of: voxels, class: car, sensors: 2, at_least: 0.0},"
    " {of: objects, class: car, sensors: two kinds, at_least: 0}]\n"
    "tolerance: [{profile: assembly, class: car, limit: 0.0, draws: 8, at_most: 0.4}]\n"
    "mounts: {height_m: [0.1, 4.0], keep_out: []}\n"
)


def required(tmp_path, text: str):
    path = tmp_path / "required.yaml"
    path.write_text(text, encoding="utf-8")
    return path


def test_what_is_met_ends_with_0_and_every_figure_is_that_of_its_command(riglens, boxes, tmp_path):
    asked = required(tmp_path, EASY)
    found = riglens("check", "W+T", "--requirements", asked, "--boxes", boxes, *SMALL_GRID, "--json", "-")
    assert found.code == 0, found.err
    document = json.loads(found.out)
    assert document["passes"] and all(verdict["passes"] for verdict in document["verdicts"])
    assert [verdict["section"] for verdict in document["verdicts"]].count("mounts") == 1
    by_text = {verdict["text"]: verdict["found"] for verdict in document["verdicts"]}
    scene = ("--boxes", boxes, *SMALL_GRID)
    scores = json.loads(riglens("evaluate", "W+T", *scene, "--json", "-").out)["rigs"][0]["classes"]["car"]
    assert by_text["seen of car by any"] == scores["any"]["seen"]
    assert by_text["seen of car by camera"] == scores["camera"]["seen"]
    words = ("evaluate", "W+T", "--targets", *scene, "--body", "ignored", "--json", "-")
    car = riglens(*words).part("targets")["rigs"][0]["classes"]["car"]
    assert by_text["on target of car (2 objects)"] == pytest.approx(car["lidar"]["on_target"])
    words = ("review", "W+T", "--only", "blind", "--blind-voxel", "0.25", "--json", "-")
    blind = riglens(*words).part("blind")
    zone = blind["zones"][0]["heights"]
    assert by_text["ground where 1.15 m is unseen by any sensor"] == pytest.approx(zone[3]["unseen_m2"])
    rear = sum(zone[1]["by_sector_and_band_m2"][4][:3])
    assert by_text["ground where 0.3 m is unseen by any sensor within 5 m, rear"] == pytest.approx(rear)
    lost = riglens("review", "W+T", "--only", "redundancy", *scene, "--json", "-").part("redundancy")
    pair = lost["voxels"]["classes"]["car"]["worst"]["pair"]
    assert by_text[f"voxels of car lost when {pair['name']} fails"] == pair["lost"]
    assert (
        by_text["objects of car covered by two kinds"]
        == (lost["objects"]["classes"]["car"]["covered"]["two kinds"])
    )


def test_what_is_not_met_ends_with_1_and_says_by_how_much(riglens, tmp_path):
    asked = required(
        tmp_path,
        HEAD + "settings: {blind_voxel_m: 0.25}\nblind_areas: [{height_m: 0.3, at_most_m2: 0.5}]\n"
        "mounts: {gap_m: 0.05, beyond_m: {top: 0.2}}\n",
    )
    out = tmp_path / "check.json"
    found = riglens("check", "Center", "--requirements", asked, "--json", out)
    assert found.code == 1 and found.err == ""
    assert "NOT MET" in found.out and "at most 0.50 m²" in found.out and "over the skin" in found.out
    document = json.loads(out.read_text(encoding="utf-8"))
    area, mounts = document["verdicts"]
    assert not document["passes"] and (area["status"], mounts["status"]) == ("not met", "not met")
    assert any("overhang" in line for line in mounts["details"])
    assert (
        mounts["found"] == len(mounts["details"]) > 1
    )  # however many violations, mounts are one requirement


SMALL_FILE = (
    HEAD + "settings: {blind_voxel_m: 0.5}\nmounts: {height_m: [0.1, 4.0], keep_out: []}\nblind_areas:\n"
    '  - {height_m: 0.3, at_most_m2: 0.5, id: near, name: "children, 100 %", why: R7}\n'
    f"  - {{height_m: 0.8, at_most_m2: 0.5, waived: {{reason: new mast, until: {SOON}}}}}\n"
    "  - {height_m: 0.4, at_most_m2: 0.5, waived: {reason: old mast, until: 2000-01-01}}\n"
)


def test_impossible_mounts_are_named_where_no_requirement_judges_them(riglens, small_rig, tmp_path):
    text = small_rig.read_text(encoding="utf-8")
    small_rig.write_text(text.replace("[0.1, 0.2, 1.9]", "[0.1, 0.2, 0.8]"), encoding="utf-8")
    area = HEAD + "settings: {blind_voxel_m: 0.5}\nblind_areas: [{height_m: 0.8, at_most_m2: 10000}]\n"
    found = riglens("check", small_rig, "--requirements", required(tmp_path, area))
    assert found.code == 0 and "inside the body" in found.err
    found = riglens("check", small_rig, "--requirements", required(tmp_path, area + "mounts: {}\n"))
    assert found.code == 1 and "inside the body" in found.out and "inside the body" not in found.err


def test_several_rigs_are_checked_each_with_hashes_of_all_that_counts(riglens, tmp_path):
    asked, junit = required(tmp_path, SMALL_FILE), tmp_path / "check.xml"
    words = ("check", "Center", "Line", "--requirements", asked, "--junit", junit)
    found = riglens(*words, "--json", tmp_path / "check.json", "--github")
    assert found.code == 1 and found.err == ""
    document = json.loads((tmp_path / "check.json").read_text(encoding="utf-8"))
    assert not document["passes"] and [one["rig"]["name"] for one in document["rigs"]] == ["Center", "Line"]
    for one in document["rigs"]:
        assert one["requirements"]["sha256"] == hashlib.sha256(asked.read_bytes()).hexdigest()
        (profiles,) = one["profiles"]
        assert profiles["sha256"] == hashlib.sha256(asset_path("review/blind.yaml").read_bytes()).hexdigest()
        assert one["data"] is None and (one["seed"], one["blind_voxel_m"]) == (0, 0.5)
        ids = [verdict["id"] for verdict in one["verdicts"]]
        assert ids == ["near", "blind_areas-0.8", "blind_areas-0.4", "mounts"]
        assert [v["waived"]["counts"] for v in one["verdicts"][1:3]] == [True, False]
    suites = ElementTree.parse(junit).getroot().findall("testsuite")
    counted = ("name", "tests", "failures", "skipped")
    assert [[suite.get(key) for key in counted] for suite in suites] == [
        ["Center", "4", "2", "1"],
        ["Line", "4", "2", "1"],
    ]
    lines = [line for line in found.out.splitlines() if line.startswith("::")]
    assert len(lines) == 6
    assert lines[0].startswith(f"::error file={asked},line=5,title=Center%3A near not met::")
    assert "why: R7" in lines[0] and "%0A" in lines[0] and lines[1].startswith("::warning ")
    assert found.out.count("children, 100 %") == 2 and "the waiver expired on 2000-01-01" in found.out


def test_rigs_of_one_name_are_told_apart_in_every_output(riglens, small_rig, tmp_path):
    other = tmp_path / "other.yaml"
    other.write_text(small_rig.read_text(encoding="utf-8"), encoding="utf-8")
    asked, junit = required(tmp_path, SMALL_FILE), tmp_path / "check.xml"
    words = ("check", small_rig, other, "--requirements", asked, "--junit", junit, "--github")
    found = riglens(*words, "--json", tmp_path / "check.json")
    titles = [
        one["title"] for one in json.loads((tmp_path / "check.json").read_text(encoding="utf-8"))["rigs"]
    ]
    assert len(set(titles)) == 2
    suites = ElementTree.parse(junit).getroot().findall("testsuite")
    cases = [
        (case.get("classname"), case.get("name")) for suite in suites for case in suite.findall("testcase")
    ]
    assert [suite.get("name") for suite in suites] == titles and len(set(cases)) == len(cases) == 8
    for title in titles:
        assert f"{title}: 4 requirements" in found.out and f"title={title}%3A near" in found.out


def test_every_output_names_grid_data_and_seed(riglens, boxes, tmp_path):
    text = HEAD + "settings: {voxel_m: 0.5, roi_m: [20, 20, 4], seed: 7}\nseen: [{class: car, at_least: 1}]"
    asked, junit, out = required(tmp_path, text), tmp_path / "check.xml", tmp_path / "check.json"
    words = ("check", "Center", "--requirements", asked, "--boxes", boxes, "--junit", junit, "--json", out)
    found = riglens(*words, "--github")
    document = json.loads(out.read_text(encoding="utf-8"))
    data = document["data"]
    assert (document["voxel_m"], document["roi_m"], document["seed"]) == (0.5, [20, 20, 4], 7)
    assert data["source"] == "boxes.csv" and str(tmp_path) not in out.read_text(encoding="utf-8")
    said = ("0.5 m", "20 × 20 × 4 m", "boxes.csv", data["sha256"][:12], "seed 7")
    (note,) = (line for line in found.out.splitlines() if line.startswith("::error"))
    table = found.out.replace(note, "")
    assert all(word in table and word in note for word in said)
    properties = {one.get("name"): one.get("value") for one in ElementTree.parse(junit).iter("property")}
    assert all(word in properties["settings"] for word in said)
    assert properties["data sha256"] == data["sha256"] and properties["voxel_m"] == "0.5"


@pytest.mark.parametrize("text", ["", "settings: {voxel_m: 0.25}\n"])
def test_options_that_contradict_the_file_are_refused(riglens, boxes, tmp_path, text):
    asked = required(tmp_path, HEAD + text + "seen: [{class: car, at_least: 0}]")
    grid = ("--boxes", boxes, "--roi", "20", "20", "4")
    for voxel in ("0.5", "auto"):
        words = ("check", "W+T", "--requirements", asked, *grid, "--voxel", voxel)
        assert f"--voxel must be {'0.25' if text else '0.1'} m, as" in riglens(*words).refused()
    words = ("check", "W+T", "--requirements", asked, *grid)
    assert "--roi must be 60 × 40 × 4 m, as" in riglens(*words).refused()
    pog = tmp_path / "a.npz"
    assert riglens("data", "build", boxes, "--out", pog, *SMALL_GRID).code == 0
    found = riglens("check", "W+T", "--requirements", asked, "--pog", pog)
    assert found.code == 2 and "--voxel must be" in found.err.splitlines()[-1]


def test_a_profile_that_differs_from_the_bundled_one_of_its_name_is_refused(riglens, tmp_path):
    own = tmp_path / "own.yaml"
    bundled = asset_path("review/blind.yaml").read_text(encoding="utf-8")
    asked = required(tmp_path, HEAD + "blind_objects: [{profile: un-r158-detection}]")
    words = ("check", "Center", "--requirements", asked, "--profile", own)
    own.write_text(bundled, encoding="utf-8")
    assert riglens(*words).code == 1
    own.write_text(
        bundled.replace("object: {height: 0.8, diameter: 0.3}", "object: {height: 1.8, diameter: 0.9}", 1),
        encoding="utf-8",
    )
    assert "'un-r158-detection' differs from the bundled one" in riglens(*words).refused()
    words = ("review", "Center", "--only", "blind", "--profile", own)
    assert "'un-r158-detection' differs from the bundled one" in riglens(*words).refused()


def test_what_is_waived_or_may_be_missing_ends_with_0(riglens, tmp_path):
    text = HEAD + "settings: {blind_voxel_m: 0.5}\nblind_areas:\n  - {height_m: 0.3, at_most_m2: 0, WAIVER}\n"
    text += "  - {height_m: 0.3, at_most_m2: 0, by: camera, allow_missing: true}\n"
    for until, code in ((SOON, 0), ("2000-01-01", 1), ("9999-12-31", 1)):
        asked = required(tmp_path, text.replace("WAIVER", f"waived: {{reason: a, until: {until}}}"))
        assert riglens("check", "Center", "--requirements", asked).code == code
    gone = text.replace("WAIVER", "allow_missing: true").replace("camera, allow_missing: true", "camera")
    found = riglens("check", "Center", "--requirements", required(tmp_path, gone))
    assert found.code == 1 and "NOT APPLICABLE" in found.out


def test_annotations_and_json_do_not_share_standard_output(riglens, tmp_path):
    words = ("check", "Center", "--requirements", required(tmp_path, SMALL_FILE))
    assert "--github cannot share standard output" in riglens(*words, "--github", "--json", "-").refused()
    assert riglens("check", "--requirements", required(tmp_path, SMALL_FILE)).code == 2


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("riglens_requirements: 1", "nothing is required"),
        (HEAD + "seen: [{class: lorry, at_least: 0.5}]", "required.yaml:2: seen[0].class must be"),
        (HEAD + "seen: [{class: car, at_least: 2}]", "seen[0].at_least must be at most 1 (got 2)"),
        (HEAD + "\nblind_areas:\n  - {height_m: 0.3, within_m: 3, at_most_m2: 1}", "4: blind_areas[0]"),
        (HEAD + "on_target: [{class: car, ring_m: [0, 15], at_least: 0}]", "whole tens of metres"),
        (
            HEAD + "tolerance: [{profile: magic, class: car, limit: 0.5}]",
            "2: tolerance[0].profile: tolerance profile 'magic'",
        ),
        (HEAD + "blind_areas: [{height_m: 1, under: asembly, at_most_m2: 1}]", "(did you mean 'assembly'?)"),
        (
            HEAD + "blind_objects: [{profile: un-r158-detecton}]",
            "2: blind_objects[0].profile: profile 'un-r158-detecton' "
            "is unknown (did you mean 'un-r158-detection'?)",
        ),
        (HEAD + "on_target: [{class: car, ring_m: [50, 70], at_least: 0}]", "at most 60"),
        (
            HEAD + "seen:\n  - {class: car,\n     at_lest: 0.5}",
            "4: seen[0].at_lest is not a known field (did you mean 'at_least'?)",
        ),
        (
            HEAD + "mounts:\n  beyond_m: {frnt: 0}",
            "3: mounts.beyond_m.frnt is not a known field (did you mean 'front'?)",
        ),
        (
            HEAD + "mounts: {keep_out: [{name: a, boxes: [{z: [1.0, 0.4]}]}]}",
            "z must be [from, to] with from <= to",
        ),
        (HEAD + "mounts: {gap_m: -0.1}", "mounts.gap_m must be at least 0 (got -0.1)"),
        (HEAD + "mounts: {spacing_m: -0.1}", "mounts.spacing_m must be at least"),
        (HEAD + "mounts: {height_m: [2, 1]}", "lowest <= highest"),
        (HEAD + "mount: {}", "2: mount is not a known field (did you mean 'mounts'?)"),
    ],
)
def test_a_wrong_file_ends_with_2_and_one_line(riglens, tmp_path, text, said):
    assert said in riglens("check", "Center", "--requirements", required(tmp_path, text)).refused()


def test_what_the_rig_or_the_scene_has_not_is_told(riglens, boxes, tmp_path):
    loss = "losses:\n  - {of: voxels, class: car, failure: group, name: ecu, at_most: 0}"
    asked = required(tmp_path, HEAD + loss)
    nowhere = ("--boxes", tmp_path / "none.csv")  # names are wrong before anything is loaded
    said = riglens("check", "Center", "--requirements", asked, *nowhere).refused()
    assert "required.yaml:3: losses[0].name: rig 'Center' has no group 'ecu' (none; fails_with of" in said
    asked = required(tmp_path, HEAD + loss.replace("group", "sensor"))
    said = riglens("check", "Center", "--requirements", asked, *nowhere).refused()
    assert "has no sensor 'ecu' (LIDAR_1, LIDAR_2, LIDAR_3, LIDAR_4)" in said
    grid = "settings: {voxel_m: 0.5, roi_m: [20, 20, 4]}\n"
    asked = required(tmp_path, HEAD + grid + loss.replace("at_most: 0", "at_most: 0, allow_missing: true"))
    found = riglens("check", "Center", "--requirements", asked, "--boxes", boxes, *SMALL_GRID)
    assert found.code == 0 and "not applicable" in found.out
    pog = tmp_path / "a.npz"
    assert riglens("data", "build", boxes, "--out", pog, *SMALL_GRID).code == 0
    asked = required(tmp_path, HEAD + "on_target: [{class: car, at_least: 0.5}]")
    found = riglens("check", "Center", "--requirements", asked, "--pog", pog)
    assert found.code == 2 and "a stored POG has none" in found.err
    assert "no such file" in riglens("check", "Center", "--requirements", tmp_path / "none.yaml").refused()


def test_a_body_that_contradicts_the_file_is_refused(riglens, boxes, tmp_path):
    asked = required(tmp_path, EASY)
    scene = ("--requirements", asked, "--boxes", boxes, *SMALL_GRID, "--body", "blocks")
    assert "--body must be ignored, as" in riglens("check", "W+T", *scene).refused()
    words = ("report", "W+T", *scene, "--out", tmp_path / "a.html")
    assert "--body must be ignored, as" in riglens(*words).refused()


@pytest.mark.parametrize("part", ["blind", "audit", "range", "mounts"])
def test_blind_zones_audit_and_detection_range_are_of_a_solid_car(riglens, part):
    assert "always solid" in riglens("review", "W+T", "--only", part, "--body", "ignored").refused()
