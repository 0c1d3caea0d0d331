"""True points of recordings are read in the order of the boxes, and compared as they should be."""

import json
from dataclasses import replace

import numpy as np
import pytest

from riglens.core.errors import InputError
from riglens.core.scene.boxes import CLASSES
from riglens.core.scene.readers import open_boxes
from riglens.core.study.target_counts import DRAWS, EXPECTED, VARIANTS, Pairs, class_masks, predict
from riglens.core.study.true_points import Recorder, rigs_by_sequence, true_points
from riglens.core.targets.engine import TargetEngine
from riglens.core.targets.settings import TargetSettings
from riglens.core.targets.traffic import read_traffic
from tests.core.argoverse_log import random_columns, write_log

TABLE = """seq,frame,cls,x,y,z,length,width,height,yaw,num_lidar_pts
a,3,car,10,0,0.8,4.5,1.9,1.6,0,50
a,3,barrier,10,3,0.8,4.5,1.9,1.6,0,9
a,4,pedestrian,6,4,0.9,0.6,0.6,1.8,0,20
b,1,bicycle,5,-5,0.9,1.8,0.6,1.7,0,0
b,1,car,-20,0,0.8,4.5,1.9,1.6,0,7
"""
RIGS = {
    name: {
        "LIDAR_TOP": {"translation": [0.9, 0.0, 1.8], "rotation_wxyz": [0.7071, 0.0, 0.0, -0.7071]},
        "CAM_FRONT": {"translation": [1, 0, 1], "rotation_wxyz": [1, 0, 0, 0], "camera_intrinsic": []},
    }
    for name in "ab"
}


@pytest.fixture
def table(tmp_path):
    (tmp_path / "boxes.csv").write_text(TABLE, encoding="utf-8")
    return tmp_path / "boxes.csv"


@pytest.fixture
def rigs(tmp_path):
    (tmp_path / "rigs.json").write_text(json.dumps(RIGS), encoding="utf-8")
    return tmp_path / "rigs.json"


def test_points_of_a_table_are_those_of_its_mapped_rows(table):
    assert true_points(table, {}).tolist() == [50, 20, 0, 7]
    assert true_points(table, {"barrier": "car"}).tolist() == [50, 9, 20, 0, 7]


def test_points_of_a_log_come_sweep_by_sweep(tmp_path):
    columns = random_columns(2, 2)
    columns["timestamp_ns"] = np.array([2, 1, 1, 2])
    columns["category"] = np.array(["PEDESTRIAN", "REGULAR_VEHICLE", "BOLLARD", "BUS"])
    columns["num_interior_pts"] = np.array([4, 5, 6, 7])
    path = write_log(tmp_path, columns)
    points, boxes = true_points(path, {}), read_traffic(open_boxes(path))
    assert points.tolist() == [5, 4, 7]
    of_points = dict(zip([1, 0, 3], points, strict=True))
    for place, row in enumerate(boxes.row):
        (written,) = np.flatnonzero(np.isclose(columns["length_m"], boxes.size_m[place, 0]))
        assert points[row] == of_points[int(written)]


def test_predictions_belong_to_their_boxes_and_rigs(table, rigs):
    traffic = read_traffic(open_boxes(table))
    by_sequence = rigs_by_sequence(rigs, Recorder())
    assert [sensor.name for sensor in by_sequence["a"].sensors] == ["LIDAR_TOP"]
    pairs = predict(traffic, true_points(table, {}), by_sequence)
    assert list(pairs.predicted) == list(VARIANTS) and pairs.sequences == ("a", "b")
    found = {
        (CLASSES[c], round(d)): t for c, d, t in zip(pairs.cls, pairs.distance_m, pairs.true, strict=True)
    }
    assert found == {("car", 10): 50, ("pedestrian", 7): 20, ("bicycle", 7): 0, ("car", 20): 7}
    assert all((points > 0).all() for points in pairs.predicted.values())
    assert (pairs.predicted["class shapes"] <= pairs.predicted["plain boxes"]).all()
    drawn = [
        TargetEngine(traffic).evaluate(by_sequence["b"], TargetSettings(seed=seed)).objects.all_points
        for seed in range(DRAWS)
    ]
    mine = pairs.sequence == 1
    np.testing.assert_array_equal(pairs.predicted[EXPECTED][mine], np.mean(drawn, axis=0)[mine])
    np.testing.assert_array_equal(pairs.predicted["class shapes, range law"][mine], drawn[0][mine])
    assert len(np.unique(drawn, axis=0)) > 1
    alone = predict(traffic, true_points(table, {}), by_sequence["a"])
    np.testing.assert_array_equal(alone.predicted["plain boxes"], pairs.predicted["plain boxes"])


def test_rank_and_ratio():
    pairs = Pairs(
        ("all",), np.zeros(5, np.int64), np.arange(5), np.array([0, 0, 0, 0, 2], np.uint8),
        np.array([5.0, 8.0, 9.0, 15.0, 5.0]), np.array([10, 20, 0, 5, 3]), {"way": np.array([5, 60, 9, 0, 6])},
    )  # fmt: skip
    everything = class_masks(pairs)["all"]
    assert pairs.ratio("way", everything) == (2.0, 3)
    assert pairs.ratio("way", pairs.ring(0, (0.0, 10.0))) == (1.75, 2)
    assert pairs.ratio("way", pairs.ring(1, (0.0, 10.0))) == (None, 0)
    means = replace(pairs, predicted={"way": np.array([5.0, 60.0, 9.0, 0.4, 6.0])})
    assert means.ratio("way", everything) == (2.0, 3)  # a mean below 0.5 is nothing
    assert pairs.rank("way", pairs.ring(2, (0.0, 10.0))) is None
    assert pairs.rank("way", everything) == pytest.approx(0.1)
    assert pairs.sums("way", everything) == 80 / 38 and pairs.sums("way", pairs.ring(1, (0.0, 10.0))) is None
    assert pairs.shares("way", everything, 5) == (0.8, 0.6)
    assert pairs.shares("way", pairs.ring(None, (0.0, 9.0)), 1) == (1.0, 1.0)
    assert pairs.shares("way", pairs.ring(1, (0.0, 10.0)), 1) is None


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (TABLE.replace("num_lidar_pts", "points"), "a column of true points"),
        (TABLE.replace(",50\n", ",-1\n"), "integers ≥ 0 .got -1"),
        (TABLE.replace(",50\n", ",many\n"), "must be integers"),
    ],
)
def test_bad_tables(tmp_path, text, message):
    (tmp_path / "boxes.csv").write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=message):
        true_points(tmp_path / "boxes.csv", {})


@pytest.mark.parametrize(
    "text", ["", "[]", "{", '{"a": 1}', '{"a": {"L": {"translation": [1, 2]}}}',
             '{"a": {"L": {"translation": [1, 2, 3], "rotation_wxyz": [0, 0, 0, 0]}}}']
)  # fmt: skip
def test_bad_rigs(tmp_path, text):
    (tmp_path / "rigs.json").write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=r"must be \{sequence"):
        rigs_by_sequence(tmp_path / "rigs.json", Recorder())
