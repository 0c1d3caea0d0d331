"""`riglens review --only redundancy`: what failures cost, as the scores of rigs without the sensors say."""

import json

import pytest

from tests.app.conftest import SMALL_GRID

REDUNDANCY = ("review", "--only", "redundancy")


def test_the_json_agrees_with_the_scores_of_rigs_without_the_sensors(riglens, boxes, tmp_path):
    whole, less = tmp_path / "rig.yaml", tmp_path / "less.yaml"
    assert riglens("list", "rigs", "Wide", "--out", whole).code == 0
    text = whole.read_text(encoding="utf-8")
    first = text.index("  - name: CAM_FRONT_LEFT")
    second = text.index("  - name:", first + 5)
    less.write_text(text[:first] + text[second:], encoding="utf-8")
    whole.write_text(
        text.replace("    kind: camera", "    kind: camera\n    fails_with: [ecu]"), encoding="utf-8"
    )
    words = (*REDUNDANCY, whole, "--boxes", boxes, *SMALL_GRID, "--json", "-")
    document = riglens(*words).part("redundancy")
    assert document["note"].startswith("a count of views, no evidence")
    scores = [
        json.loads(riglens("evaluate", rig, "--boxes", boxes, *SMALL_GRID, "--json", "-").out)["rigs"][0][
            "classes"
        ]
        for rig in (whole, less)
    ]
    lost = next(f for f in document["voxels"]["failures"] if f["name"] == "CAM_FRONT_LEFT")["lost"]
    for name in ("car", "bicycle", "pedestrian"):
        seen = [found[name]["any"]["seen"] for found in scores]
        assert lost[name] == pytest.approx(seen[0] - seen[1], abs=1e-15)
        assert document["voxels"]["classes"][name]["covered"]["1"] == seen[0]
    group = next(f for f in document["voxels"]["failures"] if f["what"] == "group")
    assert group["name"] == "ecu" and len(group["sensors"]) == 6
    assert group["lost"]["car"] == document["voxels"]["classes"]["car"]["covered"]["1"]


def test_the_table_names_what_it_is_not_and_a_stored_grid_has_no_road_users(riglens, boxes, tmp_path):
    pog = tmp_path / "a.npz"
    assert riglens("data", "build", boxes, "--out", pog, *SMALL_GRID).code == 0
    found = riglens(*REDUNDANCY, "Center", "--pog", pog)
    assert found.code == 0 and "(ASIL)" in found.out and "objects are not counted" in found.err
    assert "worst 5 pairs" in found.out and "objects, in %" not in found.out
    with_users = riglens(*REDUNDANCY, "Center", "--boxes", boxes, *SMALL_GRID)
    assert "objects, in %" in with_users.out
    without = riglens(*REDUNDANCY, "Center", "--boxes", boxes, *SMALL_GRID, "--no-objects")
    assert "objects, in %" not in without.out


def test_half_blocked_sensors_are_listed_only_on_request(riglens, boxes):
    arguments = ("--boxes", boxes, *SMALL_GRID, "--json", "-")
    plain, found = (
        riglens(*REDUNDANCY, "Center", *arguments, *more).part("redundancy") for more in ((), ("--halves",))
    )
    assert not any(one["what"] == "half" for one in plain["voxels"]["failures"])
    for of in ("voxels", "objects"):
        halves = [one for one in found[of]["failures"] if one["what"] == "half"]
        assert len(halves) == 16  # of four LiDARs
        rest = [one for one in found[of]["failures"] if one["what"] != "half"]
        assert rest == plain[of]["failures"]
        whole = {one["name"]: one["lost"]["car"] for one in rest}
        assert all(one["lost"]["car"] <= whole[one["sensors"][0]] for one in halves)
    shown = riglens("review", "Center", "--only", "redundancy", "--boxes", boxes, *SMALL_GRID, "--halves")
    assert shown.code == 0 and "half-blocked" in shown.out and "=left" in shown.out
