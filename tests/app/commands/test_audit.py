"""`riglens audit`: shares that add up, as a table for people and JSON for programs."""

import json

import pytest

from tests.app.conftest import SMALL_GRID


def test_the_json_and_the_table_say_where_rays_go_and_that_the_rig_floats(riglens, boxes):
    found = riglens("audit", "Center", "--boxes", boxes, *SMALL_GRID, "--json", "-")
    assert found.code == 0, found.err
    document = json.loads(found.out)
    assert list(document) == ["riglens", "body", "rig", "sensors"] and document["body"] == "blocks"
    for sensor in document["sensors"]:
        assert sum(sensor["shares"].values()) == pytest.approx(1.0)
        assert sensor["place"]["drop_m"] > 0.5 and "above the body" in sensor["place"]["problem"]
    table = riglens("audit", "Center", "--boxes", boxes, *SMALL_GRID).out
    assert "needs a bracket" in table and "body blocks" in table
