"""`riglens study table1`: the paper's Table I beside our figures, and whether the orders agree."""

import csv

import pytest

SMALL = ("--voxel", "0.5", "--roi", "20", "20", "4")
PAPER_RIGS = ["W+C", "W+P", "W+L", "W+T", "N+C", "N+P", "N+L", "N+T"]


def rows_after(text, title):
    """The lines of the block that starts with a title, up to an empty line."""
    lines = [line.strip() for line in text.splitlines()]
    start = lines.index(title) + 1
    return [line.split() for line in lines[start : lines.index("", start)]]


def test_published_figures_stand_beside_ours_in_the_three_blocks_of_the_paper(riglens, boxes):
    result = riglens("study", "table1", "--boxes", boxes, *SMALL)
    assert result.code == 0
    for title, first_rig in {
        "Camera S-MIG": ["-73.08", "-14.15", "-13.13"],
        "LiDAR S-MIG": ["-6.45", "-1.07", "-1.08"],
        "S-MS": ["-13.75", "-2.48", "-2.39"],
    }.items():
        rows = rows_after(result.out, title)
        assert [row[0] for row in rows] == PAPER_RIGS
        assert rows[0][2::2] == first_rig


def test_the_csv_holds_full_precision_in_nats(riglens, boxes, tmp_path):
    target = tmp_path / "table1.csv"
    assert riglens("study", "table1", "--boxes", boxes, *SMALL, "--csv", target).code == 0
    rows = list(csv.DictReader(target.read_text().splitlines()))
    assert [row["rig"] for row in rows[::3]] == PAPER_RIGS
    assert float(rows[0]["published_s_ms"]) == pytest.approx(-13750.0)
    weighted = 0.1 * float(rows[0]["camera_s_mig"]) + float(rows[0]["lidar_s_mig"])
    assert float(rows[0]["s_ms"]) == pytest.approx(weighted, rel=1e-12)


def test_each_class_says_whether_its_orders_agree(riglens, boxes):
    out = riglens("study", "table1", "--boxes", boxes, *SMALL).out
    orders = out[out.index("lowest first") :]
    assert orders.count("LiDAR groups") == orders.count("camera groups") == orders.count("rigs, S-MS") == 3
    agree, disagree = orders.count(" yes "), orders.count(" no ")
    assert agree + disagree == 9
    assert orders.count("paper: ") == disagree
    assert f"{agree} of 9 orders" in orders


def test_it_fits_a_terminal_of_100_columns(riglens, boxes):
    lines = riglens("study", "table1", "--boxes", boxes, *SMALL).out.splitlines()
    assert max(len(line.rstrip()) for line in lines) <= 100


def test_nuscenes_boxes_order_the_groups_as_the_paper_does(riglens, shared_data):
    table = shared_data / "boxes" / "nuscenes_mini_val_ego.csv.gz"
    out = riglens("study", "table1", "--boxes", table, "--origin", "-1.35", "0", "0").out
    groups = [line for line in out.splitlines() if "LiDAR groups" in line or "camera groups" in line]
    assert len(groups) == 6
    assert all(" yes " in line for line in groups)
