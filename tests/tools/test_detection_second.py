"""Tables of the second study are gathered part by part."""

from __future__ import annotations

from pathlib import Path

from tools.detection_second import TABLES, gather, lines


def write(path: Path, *rows: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join(rows) + "\n", encoding="utf-8")


def test_a_part_that_ran_is_renewed_and_the_others_stay(tmp_path: Path) -> None:
    for table in TABLES:
        write(tmp_path / f"detection2{table}.csv", "part,class,ap", "pillars,mean,50.0", "range,mean,1.0")
        write(tmp_path / "range" / f"detection{table}.csv", "class,ap", "mean,40.0")
    write(tmp_path / "range" / "detection.json", "{}")
    write(tmp_path / "painted" / "detection.csv", "class,ap", "mean,9.0")  # has not ended
    gather(tmp_path, tmp_path)
    for table in TABLES:
        found = [(line["part"], line["ap"]) for line in lines(tmp_path / f"detection2{table}.csv")]
        assert found == [("pillars", "50.0"), ("range", "40.0")]
