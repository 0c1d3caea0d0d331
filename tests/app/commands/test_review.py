"""`riglens review`: one document whose parts do not depend on which others run."""

import json

from riglens.app.commands.review import PARTS
from tests.app.conftest import SMALL_GRID

DRAWS = ("--draws", "4", "--sample", "2")


def test_each_part_is_the_same_alone(riglens, boxes, small_rig, tmp_path):
    out = tmp_path / "review.json"
    found = riglens("review", small_rig, "--boxes", boxes, *SMALL_GRID, *DRAWS, "--json", out)
    assert found.code == 0, found.err
    document = json.loads(out.read_text(encoding="utf-8"))
    assert list(document) == ["riglens", *PARTS]
    for part in PARTS:
        words = ("review", small_rig, "--only", part, "--boxes", boxes, *SMALL_GRID, *DRAWS)
        alone = riglens(*words)
        assert alone.code == 0 and alone.out.strip() in found.out, part
        assert riglens(*words, "--json", "-").part(part) == document[part], part
    mounts = document["mounts"]
    assert [mount["name"] for mount in mounts["sensors"]] == [
        one["name"] for one in document["audit"]["sensors"]
    ]
    apart = [
        mount["name"]
        for mount in mounts["sensors"]
        if mount["inside"] or mount["gap_m"] > mounts["gap_limit_m"]
    ]
    assert set(apart) <= {problem["sensor"] for problem in mounts["problems"]}


def test_only_some_parts_need_no_scene(riglens, small_rig):
    found = json.loads(riglens("review", small_rig, "--only", "mounts,range", "--json", "-").out)
    assert list(found) == ["riglens", "range", "mounts"]


def test_damage_is_tried_without_changing_the_rig(riglens, small_rig):
    words = ("review", small_rig, "--only", "range,mounts", "--json", "-")
    whole = json.loads(riglens(*words).out)
    name, other = (mount["name"] for mount in whole["mounts"]["sensors"][:2])
    half = json.loads(riglens(*words, "--damaged", f"{name}=left").out)
    assert half["range"]["rigs"][0] != whole["range"]["rigs"][0]
    without = json.loads(riglens(*words, "--damaged", name, "--damaged", other).out)
    names = [mount["name"] for mount in without["mounts"]["sensors"]]
    assert names == [mount["name"] for mount in whole["mounts"]["sensors"]][2:]
    assert json.loads(riglens(*words).out) == whole
