"""`riglens check`: exit codes for machines, one line per requirement, every figure as the other commands say it."""

import json

import pytest

from tests.app.conftest import SMALL_GRID

HEAD = "riglens_requirements: 1\n"
EASY = HEAD + (
    "body: ignored\nblind_voxel_m: 0.25\n"
    "seen: [{class: car, at_least: 0.0}, {class: car, by: camera, at_least: 0.0}]\n"
    "on_target: [{class: car, at_least: 0.0}, {class: pedestrian, ring_m: [0, 20], figure: share_5, at_least: 0.0}]\n"
    "blind_areas: [{height_m: 1.15, at_most_m2: 10000}, {height_m: 0.3, sector: rear, within_m: 5, at_most_m2: 9999}]\n"
    "blind_objects: [{profile: adults-around, at_most_unseen: 4}]\n"
    "losses: [{of: voxels, class: car, failure: pair, at_most: 1.0}, {of: road_users, class: car, at_most: 1.0}]\n"
    "covered: [{of: voxels, class: car, sensors: 2, at_least: 0.0},"
    " {of: road_users, class: car, sensors: two kinds, at_least: 0}]\n"
    "tolerance: [{profile: assembly, class: car, limit: 0.0, draws: 8}]\n"
    "mounts: {height_m: [0.1, 4.0], keep_out: []}\n"
)


def required(tmp_path, text: str):
    path = tmp_path / "required.yaml"
    path.write_text(text)
    return path


def test_what_is_met_ends_with_0_and_every_figure_is_that_of_its_command(riglens, boxes, tmp_path):
    asked = required(tmp_path, EASY)
    found = riglens("check", "W+T", "--requirements", asked, "--boxes", boxes, *SMALL_GRID, "--json", "-")
    assert found.code == 0, found.err
    document = json.loads(found.out)
    assert document["passes"] and all(verdict["passes"] for verdict in document["verdicts"])
    by_text = {verdict["text"]: verdict["found"] for verdict in document["verdicts"]}
    scene = ("--boxes", boxes, *SMALL_GRID)
    scores = json.loads(riglens("evaluate", "W+T", *scene, "--json", "-").out)["rigs"][0]["classes"]["car"]
    assert by_text["seen of car by any"] == scores["any"]["seen"]
    assert by_text["seen of car by camera"] == scores["camera"]["seen"]
    targets = json.loads(riglens("targets", "W+T", "--boxes", boxes, "--body", "ignored", "--json", "-").out)
    car = targets["rigs"][0]["classes"]["car"]
    assert by_text["on_target of car (2 road users)"] == pytest.approx(car["lidar"]["on_target"])
    blind = json.loads(riglens("blind", "W+T", "--voxel", "0.25", "--json", "-").out)
    zone = blind["zones"][0]["heights"]
    assert by_text["ground where 1.15 m is unseen by any sensor"] == pytest.approx(zone[3]["unseen_m2"])
    rear = sum(zone[1]["by_sector_and_band_m2"][4][:3])
    assert by_text["ground where 0.3 m is unseen by any sensor within 5 m, rear"] == pytest.approx(rear)
    lost = json.loads(riglens("redundancy", "W+T", *scene, "--json", "-").out)
    pair = lost["voxels"]["classes"]["car"]["worst"]["pair"]
    assert by_text[f"voxels of car lost when {pair['name']} fails"] == pair["lost"]
    assert (
        by_text["road_users of car covered by two kinds"]
        == (lost["road_users"]["classes"]["car"]["covered"]["two kinds"])
    )


def test_what_is_not_met_ends_with_1_and_says_by_how_much(riglens, tmp_path):
    asked = required(
        tmp_path,
        HEAD + "blind_voxel_m: 0.25\nblind_areas: [{height_m: 0.3, at_most_m2: 0.5}]\n"
        "mounts: {gap_m: 0.05, beyond_m: {top: 0.2}}\n",
    )
    out = tmp_path / "check.json"
    found = riglens("check", "Center", "--requirements", asked, "--json", out)
    assert found.code == 1 and found.err == ""
    assert "NOT MET" in found.out and "at most 0.50 m²" in found.out and "over the skin" in found.out
    document = json.loads(out.read_text())
    assert not document["passes"] and any("sticks out" in verdict["text"] for verdict in document["verdicts"])


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("riglens_requirements: 1", "nothing is required"),
        (HEAD + "seen: [{class: lorry, at_least: 0.5}]", "required.yaml:2: seen[0].class: found lorry"),
        (HEAD + "seen: [{class: car, at_least: 2}]", "seen[0].at_least: found 2"),
        (HEAD + "\nblind_areas:\n  - {height_m: 0.3, within_m: 3, at_most_m2: 1}", "4: blind_areas[0]"),
        (HEAD + "on_target: [{class: car, ring_m: [0, 15], at_least: 0}]", "whole tens of metres"),
        (
            HEAD + "tolerance: [{profile: magic, class: car, limit: 0.5}]",
            "tolerance profile 'magic' is unknown",
        ),
        (
            HEAD + "blind_objects: [{profile: magic}]",
            "found profile 'magic', accepted is one of un-r158-detection",
        ),
        (HEAD + "mount: {}", "mount: "),
    ],
)
def test_a_wrong_file_ends_with_2_and_one_line(riglens, tmp_path, text, said):
    assert said in riglens("check", "Center", "--requirements", required(tmp_path, text)).refused()


def test_what_the_rig_or_the_scene_has_not_is_told(riglens, boxes, tmp_path):
    named = HEAD + "losses: [{of: voxels, class: car, failure: group, name: ecu, at_most: 0}]"
    asked = required(tmp_path, named)
    found = riglens("check", "Center", "--requirements", asked, "--boxes", boxes, *SMALL_GRID)
    assert (
        found.code == 2 and "found no group 'ecu' in the rig, accepted is none, for the rig has" in found.err
    )
    wrong = HEAD + "losses: [{of: voxels, class: car, failure: sensor, name: roof, at_most: 0}]"
    found = riglens(
        "check", "Center", "--requirements", required(tmp_path, wrong), "--boxes", boxes, *SMALL_GRID
    )
    assert "found no sensor 'roof' in the rig, accepted is LIDAR_1, LIDAR_2, LIDAR_3, LIDAR_4" in found.err
    pog = tmp_path / "a.npz"
    assert riglens("pog", boxes, "--out", pog, *SMALL_GRID).code == 0
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


@pytest.mark.parametrize("command", ["blind", "audit", "card"])
def test_blind_zones_audit_and_card_are_of_a_solid_car(riglens, command):
    assert "always solid" in riglens(command, "W+T", "--body", "ignored").refused()
