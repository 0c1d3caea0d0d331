"""Real traffic from the command line: the bundled scenario, and published data where they are at hand."""

import json

import pytest

PAPER_RIGS = ("W+C", "W+P", "W+L", "W+T", "N+C", "N+P", "N+L", "N+T")
# S-MIG of the class car in 10³ nat, from the project's description of the metric.
SKETCH = {"C": -187.9, "P": -183.0, "L": -134.7, "T": -134.2, "W": -670.7, "N": -686.5}


def test_the_bundled_scenario_is_the_default_and_has_all_classes(riglens):
    result = riglens("evaluate", "W+T", "--voxel", "0.2", "--json", "-")
    document = json.loads(result.out)
    assert result.err == ""
    assert document["data"]["source"] == "bundled scenario town"
    assert document["data"]["frames"] >= 2000
    for scores in document["rigs"][0]["classes"].values():
        assert 0.0 < scores["lidar"]["seen"] < scores["any"]["seen"] < 1.0


def test_nuscenes_boxes_give_the_published_orders_and_the_figures_of_the_sketch(riglens, shared_data):
    table = shared_data / "boxes" / "nuscenes_mini_val_ego.csv.gz"
    result = riglens("evaluate", *PAPER_RIGS, "--boxes", table, "--origin", "-1.35", "0", "0", "--json", "-")
    rigs = {rig["name"]: rig["classes"] for rig in json.loads(result.out)["rigs"]}
    assert rigs["W+C"]["car"]["h_total"] == pytest.approx(855.8e3, rel=0.01)
    for name, classes in rigs.items():
        assert classes["car"]["camera"]["s_mig"] == pytest.approx(SKETCH[name[0]] * 1e3, rel=0.01)
        assert classes["car"]["lidar"]["s_mig"] == pytest.approx(SKETCH[name[2]] * 1e3, rel=0.01)
    for cls in ("car", "bicycle", "pedestrian"):
        lidar = [rigs[f"W+{group}"][cls]["lidar"]["s_mig"] for group in "CPLT"]
        assert lidar == sorted(lidar)
        assert rigs["N+C"][cls]["camera"]["s_mig"] < rigs["W+C"][cls]["camera"]["s_mig"]


def test_kitti_tracking_labels_are_read_through_their_calibration(riglens, shared_data, tmp_path):
    result = riglens(
        "pog", shared_data / "kitti" / "tracking", "--out", tmp_path / "kitti.npz", "--voxel", "0.2"
    )
    assert result.code == 0, result.err
    assert "frames" in result.out
    assert "belong to no class" in result.err
