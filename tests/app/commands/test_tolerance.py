"""`riglens review --only tolerance`: a table for people, JSON for programs, the same draws for the same seed."""

import json

import pytest

from tests.app.conftest import SMALL_GRID

TOLERANCE = ("review", "--only", "tolerance", "Center")
FEW = ("--draws", "4", "--sample", "2", "--no-sensitivities")


def test_the_json_holds_what_the_table_shows_and_a_seed_repeats_it(riglens, boxes):
    scene = ("--boxes", boxes, *SMALL_GRID)
    found = riglens(*TOLERANCE, *scene, *FEW, "--json", "-")
    document = found.part("tolerance")
    assert found.out == riglens(*TOLERANCE, *scene, *FEW, "--json", "-").out
    assert document["profile"]["source"] == "our choice" and document["draws"] == 4
    scores = json.loads(riglens("evaluate", "Center", *scene, "--json", "-").out)["rigs"][0]["classes"]
    for name in ("car", "bicycle", "pedestrian"):
        spread = document["figures"][f"seen {name}"]
        assert spread["nominal"] == scores[name]["any"]["seen"]
        assert spread["worst"] <= spread["p05"] <= spread["median"] <= spread["p95"]
    table = riglens(*TOLERANCE, *scene, *FEW).out
    assert (
        "noise floor" in table
        and "our choice" in table
        and f"{100 * document['figures']['seen car']['worst']:.2f}" in table
    )


@pytest.mark.parametrize("profile", ["service", "load"])
def test_the_rig_of_the_worst_draw_scores_what_the_table_says(riglens, boxes, tmp_path, profile):
    scene, worst = ("--boxes", boxes, *SMALL_GRID), tmp_path / "worst.yaml"
    told = riglens(*TOLERANCE, *scene, *FEW, "--errors", profile, "--worst", worst, "--json", "-")
    spread = told.part("tolerance")["figures"]["seen car"]
    found = riglens("evaluate", worst, *scene, "--body", "ignored", "--json", "-")
    (rig,) = json.loads(found.out)["rigs"]
    assert rig["classes"]["car"]["any"]["seen"] == spread["worst"]
    assert rig["name"] == f"Center, {profile}, draw {spread['worst_draw']}"
