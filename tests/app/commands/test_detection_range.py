"""`riglens review --only range`: distances as a table, CSV, chart and JSON."""

import csv
import json

RANGE = ("review", "--only", "range", "Center", "--directions", "2", "--range-to", "12")


def test_a_detection_range_as_json_csv_and_chart(riglens, tmp_path):
    files = [tmp_path / name for name in ("range.csv", "range.png", "range.svg", "range.json")]
    table, png, svg, text = files
    result = riglens(*RANGE, "--range-csv", table, "--range-chart", png, "--json", text)
    assert result.code == 0
    assert "first distance in metres with too little" in result.out and "stops within (m)" in result.out
    assert ">12" in result.out and "never" in result.out  # LiDARs see that far, and there is no camera
    document = json.loads(text.read_text(encoding="utf-8"))["range"]
    assert (document["body"], document["min_points"], document["to_m"]) == ("blocks", 5, 12.0)
    rows = document["rigs"][0]["rows"]
    assert {(row["class"], row["heading_deg"]) for row in rows} == {
        ("car", 0.0), ("car", 90.0), ("bicycle", 0.0), ("bicycle", 90.0), ("pedestrian", 0.0),
    }  # fmt: skip
    assert {row["bearing_deg"] for row in rows} == {0.0, 180.0}
    assert all("stops_from_kmh" in row["lidar"] for row in rows if row["bearing_deg"] == 0.0)
    with open(table, encoding="utf-8", newline="") as stream:
        lines = list(csv.DictReader(stream))
    assert len(lines) == 2 * len(rows) and lines[0]["kind"] == "lidar" and lines[0]["threshold"] == "5"
    assert png.read_bytes().startswith(b"\x89PNG")
    assert riglens(*RANGE, "--range-chart", svg, "--json", "-").out == text.read_text(encoding="utf-8")
    assert b"pedestrian" in svg.read_bytes() or svg.read_bytes().startswith(b"<?xml")
