"""`riglens review --only blind`: a table for people, JSON for programs, a map as CSV and PNG."""

import csv
import json

import pytest

BLIND = ("review", "--only", "blind")
COARSE = ("--blind-voxel", "0.25", "--blind-within", "5")


def test_table_json_and_map_tell_the_same(riglens, tmp_path):
    csv_map, picture, stored = tmp_path / "map.csv", tmp_path / "map.png", tmp_path / "blind.json"
    found = riglens(*BLIND, "Center", *COARSE, "--blind-map", csv_map, "--json", stored)
    assert found.code == 0, found.err
    document = json.loads(stored.read_text(encoding="utf-8"))["blind"]
    assert document == riglens(*BLIND, "Center", *COARSE, "--blind-map", picture, "--json", "-").part("blind")
    assert document["note"] == "geometry only, no approval" and document["note"] in found.out
    assert picture.read_bytes()[:4] == b"\x89PNG"
    zone = next(z for z in document["zones"] if (z["by"], z["sensors"]) == ("any", 1))
    adult = zone["heights"][-1]
    assert f"{adult['unseen_m2']:.1f}" in found.out
    rows = list(csv.DictReader(csv_map.read_text(encoding="utf-8").splitlines()))
    unseen = sum(float(row["lowest_1_any_m"]) > adult["height_m"] + 1e-6 for row in rows)
    assert unseen * 0.25**2 == pytest.approx(adult["unseen_m2"])
    assert len(rows) * 0.25**2 == pytest.approx(sum(map(sum, document["ground_m2"])))
    for profile in document["profiles"]:
        assert profile["source"][:30] in found.out
        assert profile["passes"] == all(one["seen"] for one in profile["objects"])


def test_objects_do_not_depend_on_the_voxels(riglens, small_rig):
    one, other = (
        riglens(*BLIND, small_rig, "--blind-voxel", voxel, "--blind-within", "2", "--json", "-").part("blind")
        for voxel in ("0.5", "0.25")
    )
    assert one["profiles"] == other["profiles"] and one["zones"] != other["zones"]


def test_a_profile_of_ones_own_takes_the_place_of_the_others(riglens, tmp_path):
    mine = tmp_path / "mine.yaml"
    mine.write_text(
        "riglens_profiles: 1\nprofiles:\n  - name: post\n    title: A post <b>\n    source: our choice\n"
        "    object: {height: 1.0, diameter: 0.2}\n    at: [{x: 8.0, y: 0.0}]\n",
        encoding="utf-8",
    )
    document = riglens(*BLIND, "W+T", *COARSE, "--profile", mine, "--json", "-").part("blind")
    assert [profile["name"] for profile in document["profiles"]] == ["post"] and document["profiles"][0][
        "passes"
    ]
