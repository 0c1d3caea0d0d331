"""Several box data sets as one: a folder of tables, or paths named together."""

from pathlib import Path

import numpy as np
import pytest

from riglens.core.errors import InputError
from riglens.core.scene.boxes import BoxBatch
from riglens.core.scene.readers import default_origin_m, open_boxes
from riglens.core.scene.readers.common import join

HEADER = "seq,frame,cls,x,y,z,length,width,height,yaw\n"


def table(path: Path, frames: range, cls: str = "car") -> Path:
    rows = (f"s,{frame},{cls},{frame}.5,1,1,4,2,1.5,0.1\n" for frame in frames)
    path.write_text(HEADER + "".join(rows), encoding="utf-8")
    return path


def read(*paths: Path, **options: object) -> tuple[BoxBatch, object]:
    source = open_boxes(paths, **options)  # type: ignore[arg-type]
    return join(list(source.batches())), source.report()


def test_tables_of_a_folder_are_read_by_name_and_hidden_ones_are_not(tmp_path: Path) -> None:
    table(tmp_path / "b.csv", range(10, 12))
    table(tmp_path / "a.csv", range(3))
    table(tmp_path / ".c.csv", range(50))
    (tmp_path / "notes.txt").write_text("not a table", encoding="utf-8")
    found, report = read(tmp_path)
    assert found.frame.tolist() == [0, 1, 2, 3, 4]
    assert found.centre_m[:, 0].tolist() == [0.5, 1.5, 2.5, 10.5, 11.5]
    assert (report.frames, report.sequences, report.boxes["car"]) == (5, 2, 5)


def test_paths_named_together_add_up_with_their_unmapped_names(tmp_path: Path) -> None:
    first = table(tmp_path / "one.csv", range(4))
    second = table(tmp_path / "two.csv", range(3), cls="cow")
    _, report = read(first, second)
    assert report.frames == 7
    assert report.unmapped == {"cow": 3}
    assert report.source.endswith("one.csv + 1 more")


def test_frames_count_for_the_whole(tmp_path: Path) -> None:
    both = [table(tmp_path / f"{name}.csv", range(3)) for name in "ab"]
    assert read(*both, frames=10)[1].frames == 10
    with pytest.raises(InputError, match=r"^frames must be at least 6"):
        read(*both, frames=5)
    with pytest.raises(InputError, match="frames must be an integer"):
        open_boxes(both, frames=0)


def test_a_bad_member_is_named(tmp_path: Path) -> None:
    good, bad = table(tmp_path / "good.csv", range(3)), tmp_path / "bad.csv"
    bad.write_text(HEADER + "s,0,car,abc,1,1,4,2,1.5,0\n", encoding="utf-8")
    with pytest.raises(InputError, match=r"bad\.csv:2: column 'x'"):
        read(good, bad)


def test_progress_rises_through_all_members(tmp_path: Path) -> None:
    both = [table(tmp_path / f"{name}.csv", range(3)) for name in "ab"]
    heard: list[float] = []
    list(open_boxes(both).batches(heard.append))
    assert heard == sorted(heard) and heard[-1] == 1.0
    assert any(0.4 < fraction < 0.6 for fraction in heard)


def test_the_origin_is_added_to_every_member_and_lifted(tmp_path: Path) -> None:
    both = [table(tmp_path / f"{name}.csv", range(2)) for name in "ab"]
    (plain, _), (moved, _) = read(*both), read(*both, origin_m=(1.0, 2.0, 3.0), lift_m=0.5)
    np.testing.assert_allclose(moved.centre_m - plain.centre_m, np.tile([1.0, 2.0, 3.5], (4, 1)))


def test_the_origin_of_a_source_is_told_without_reading_it(tmp_path: Path) -> None:
    (tmp_path / "kitti" / "label_02").mkdir(parents=True)
    (tmp_path / "av2").mkdir()
    (tmp_path / "av2" / "annotations.feather").write_bytes(b"broken")
    (tmp_path / "nuscenes" / "v1.0-mini").mkdir(parents=True)
    (tmp_path / "nuscenes" / "v1.0-mini" / "sample_annotation.json").write_bytes(b"broken")
    assert default_origin_m(tmp_path / "kitti") == (0.4, 0.0, 1.73)
    assert default_origin_m(tmp_path / "av2") == (-1.34, 0.0, 0.33)
    assert default_origin_m(tmp_path / "av2" / "annotations.feather") == (-1.34, 0.0, 0.33)
    assert default_origin_m(tmp_path / "nuscenes") == (-1.35, 0.0, 0.0)
    assert default_origin_m(table(tmp_path / "a.csv", range(2))) == (0.0, 0.0, 0.0)
    with pytest.raises(InputError, match="no such file or folder"):
        default_origin_m(tmp_path / "nothing")
