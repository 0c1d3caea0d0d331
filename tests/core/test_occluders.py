"""What stands still is read from two tables, comes in the frame of the car, and never touches a POG."""

from __future__ import annotations

import gzip
import math
import os
from pathlib import Path

import numpy as np
import pyarrow.parquet
import pytest

from riglens.core.errors import InputError
from riglens.core.files import read_csv
from riglens.core.scene.boxes import rotations_from_yaw
from riglens.core.scene.occluders import Occluders
from riglens.core.scene.readers import bundled_occluders, bundled_source
from riglens.core.scene.readers import occluders as reader
from riglens.core.scene.readers.occluders import open_occluders

OCCLUDERS = """map,cls,x,y,z,length,width,height,yaw
yard,wall,10,0,1,4,0.2,2,0
street,house,100,50,5,20,10,10,0.5
yard,pole,0,7,3,0.2,0.2,6,0
"""
POSES = """seq,frame,map,x,y,z,yaw
a,0,yard,0,0,0,0
a,3,yard,10,-5,0.5,1.5707963267948966
b,0,street,100,0,0,0
b,1,nowhere,0,0,0,0
"""


def read(folder: Path, occluders: str = OCCLUDERS, poses: str = POSES) -> Occluders:
    (folder / "occluders.csv").write_text(occluders, encoding="utf-8")
    (folder / "poses.csv").write_text(poses, encoding="utf-8")
    return open_occluders(folder / "occluders.csv", folder / "poses.csv")


def test_a_box_comes_in_the_frame_of_the_car(tmp_path: Path) -> None:
    """The car stands at (10, -5), half a metre up, and looks along y: the wall is 5 m ahead, across its way."""
    near = read(tmp_path).around(("a", 3), 20.0)
    assert near.row.tolist() == [0, 2]
    np.testing.assert_allclose(near.centre_m[0], [5, 0, 0.5], atol=1e-12)
    np.testing.assert_allclose(near.centre_m[1], [12, 10, 2.5], atol=1e-12)
    np.testing.assert_allclose(near.rotation[0], rotations_from_yaw(np.array([-math.pi / 2]))[0], atol=1e-12)
    assert near.size_m[0].tolist() == [4, 0.2, 2]


def test_only_what_is_within_reach_comes_and_only_that_of_the_frames_map(tmp_path: Path) -> None:
    """The wall's footprint begins 2 m before its centre at most, so that it may begin within 8 m."""
    occluders = read(tmp_path)
    assert occluders.around(("a", 0), 8.0).row.tolist() == [0, 2]
    assert occluders.around(("a", 0), 7.9).row.tolist() == [2]
    assert occluders.around(("b", 0), 100.0).row.tolist() == [1]
    assert occluders.around(("b", 1), 1e6).row.tolist() == []


def test_the_origin_of_the_boxes_is_that_of_the_occluders_too(tmp_path: Path) -> None:
    read(tmp_path)
    moved = open_occluders(tmp_path / "occluders.csv", tmp_path / "poses.csv", (-1.35, 0.0, 0.25))
    np.testing.assert_allclose(moved.around(("a", 0), 50.0).centre_m[0], [8.65, 0, 1.25])


def test_a_search_along_x_finds_what_a_look_at_each_finds(tmp_path: Path) -> None:
    """Against every box moved into the frame of every pose, without sorting."""
    random = np.random.default_rng(3)
    boxes = np.column_stack(
        [random.uniform(-80, 80, (400, 3)), random.uniform(0.1, 30, (400, 3)), random.uniform(-9, 9, 400)]
    )
    poses = np.column_stack([random.uniform(-60, 60, (30, 3)), random.uniform(-9, 9, 30)])
    occluders = read(
        tmp_path,
        OCCLUDERS.split("\n")[0]
        + "\n"
        + "".join(f"m,x,{','.join(map(repr, map(float, row)))}\n" for row in boxes),
        POSES[:23]
        + "\n"
        + "".join(f"s,{k},m,{','.join(map(repr, map(float, row)))}\n" for k, row in enumerate(poses)),
    )
    for k, (x, y, z, yaw) in enumerate(poses):
        cos, sin = math.cos(yaw), math.sin(yaw)
        found = occluders.around(("s", k), 25.0)
        expected = []
        for row, (bx, by, bz, length, width, _, _) in enumerate(boxes):
            dx, dy = bx - x, by - y
            if math.hypot(dx, dy) - math.hypot(length, width) / 2 <= 25.0:
                expected.append((row, cos * dx + sin * dy, cos * dy - sin * dx, bz - z))
        assert len(expected) > 20
        assert found.row.tolist() == [row for row, *_ in expected]
        np.testing.assert_allclose(found.centre_m, [place for _, *place in expected], atol=1e-9)


def test_a_frame_without_a_pose_is_told(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"poses.csv: frame 2 of sequence 'a' .*no pose"):
        read(tmp_path).around(("a", 2), 10.0)


@pytest.mark.parametrize("ending", [".csv.gz", ".parquet"])
def test_tables_may_be_packed(tmp_path: Path, ending: str) -> None:
    plain = read(tmp_path)
    paths = []
    for name in ("occluders", "poses"):
        path = tmp_path / f"{name}{ending}"
        if ending == ".parquet":
            pyarrow.parquet.write_table(read_csv(tmp_path / f"{name}.csv"), path)
        else:
            path.write_bytes(gzip.compress((tmp_path / f"{name}.csv").read_bytes()))
        paths.append(path)
    packed = open_occluders(paths[0], paths[1])
    assert packed.poses == plain.poses
    assert packed.cls == plain.cls == ["wall", "house", "pole"]
    assert packed.around(("a", 3), 99.0).centre_m.tolist() == plain.around(("a", 3), 99.0).centre_m.tolist()


@pytest.mark.parametrize(
    ("table", "old", "new", "message"),
    [
        (
            "occluders",
            "20,10,10",
            "20,0,10",
            r"occluders.csv:3: column 'width': .*got 0",
        ),
        ("occluders", "yard,pole,0", "yard,pole,inf", r"occluders.csv:4: column 'x': .*got inf"),
        ("occluders", "0.5", "nan", r"occluders.csv:3: column 'yaw': .*got nan"),
        (
            "occluders",
            "wall,10",
            "wall,ten",
            r"occluders.csv:2: column 'x': .*got 'ten'",
        ),
        (
            "occluders",
            "map,",
            "town,",
            r"occluders.csv: column 'map' missing",
        ),
        (
            "occluders",
            "wall",
            "w" * 201,
            r"column 'cls': .*got 201",
        ),
        ("poses", "a,3,", "a,-3,", r"poses.csv:3: column 'frame': .*got -3"),
        (
            "poses",
            "a,3,",
            "a,0,",
            r"poses.csv:3: frame 0 of sequence 'a' .*one pose",
        ),
        ("poses", "1.5707963267948966", "nan", r"poses.csv:3: column 'yaw': .*got nan"),
        ("poses", "100,0,0,0", "1e9,0,0,0", r"poses.csv:4: column 'x': .*got 1e\+09"),
        ("poses", ",yaw", ",angle", r"poses.csv: column 'yaw' missing"),
    ],
)
def test_bad_rows_are_refused_in_one_line(
    tmp_path: Path, table: str, old: str, new: str, message: str
) -> None:
    tables = {"occluders": OCCLUDERS, "poses": POSES}
    tables[table] = tables[table].replace(old, new, 1)
    with pytest.raises(InputError, match=message) as caught:
        read(tmp_path, **tables)
    assert str(caught.value).isprintable()


@pytest.mark.parametrize("victim", ["occluders.csv", "poses.csv"])
def test_a_pipe_or_device_is_refused(tmp_path: Path, victim: str) -> None:
    read(tmp_path)
    (tmp_path / victim).unlink()
    os.mkfifo(tmp_path / victim)
    with pytest.raises(InputError, match="got a pipe"):
        open_occluders(tmp_path / "occluders.csv", tmp_path / "poses.csv")
    with pytest.raises(InputError, match=r"nowhere.csv: cannot be read"):
        open_occluders(tmp_path / "nowhere.csv", tmp_path / "poses.csv")


def test_there_are_limits(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reader, "MAX_OCCLUDERS", 2)
    with pytest.raises(InputError, match=r"occluders.csv: too many occluders"):
        read(tmp_path)
    monkeypatch.setattr(reader, "MAX_OCCLUDERS", 3)
    monkeypatch.setattr(reader, "MAX_POSES", 3)
    with pytest.raises(InputError, match=r"poses.csv: too many poses"):
        read(tmp_path)


def test_every_frame_of_the_town_has_its_surroundings() -> None:
    source, occluders = bundled_source(), bundled_occluders()
    frame = max(int(batch.frame.max()) for batch in source.batches())
    labels = source.report().labels
    assert labels is not None and len(labels.frame) == frame + 1
    counts = [
        occluders.around(labels.of(number), 100.0).row.size for number in range(0, len(labels.frame), 25)
    ]
    assert min(counts) >= 1 and max(counts) < 400 and np.mean(counts) > 50
