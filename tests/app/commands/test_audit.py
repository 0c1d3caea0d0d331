"""`riglens review --only audit`: shares that add up, as a table for people and JSON for programs."""

import pytest

from tests.app.conftest import SMALL_GRID


def test_the_json_and_the_table_say_where_rays_go_and_that_the_rig_floats(riglens, boxes):
    words = ("review", "--only", "audit", "Center", "--boxes", boxes, *SMALL_GRID)
    document = riglens(*words, "--json", "-").part("audit")
    assert list(document) == ["riglens", "body", "rig", "sensors"] and document["body"] == "blocks"
    for sensor in document["sensors"]:
        assert sum(sensor["shares"].values()) == pytest.approx(1.0)
        assert sensor["place"]["drop_m"] > 0.5 and "above the body" in sensor["place"]["problem"]
    table = riglens(*words).out
    assert "needs a bracket" in table and "body blocks" in table
