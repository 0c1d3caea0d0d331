"""`riglens simulate`: data sets of several rigs, what it says, and one line for what it cannot do."""

import json
import shutil
import sys
from pathlib import Path

import pytest

from riglens.core.pieces.folder import LOCK, sole_run
from riglens.core.simulate.dataset import DatasetFolder
from tests.core.simulate import carla_stand_in


@pytest.fixture
def small_rig(tmp_path: Path) -> Path:
    path = tmp_path / "small.yaml"
    path.write_text(
        "riglens: 1\nname: small\nsensors:\n"
        "  - {name: roof, kind: lidar, position: [0.0, 0.0, 2.0], elevations_deg: {from: -20, to: 2, count: 8},\n"
        "     azimuths_deg: {from: -180, to: 180, count: 180}}\n"
        "  - {name: front, kind: camera, position: [1.0, 0.0, 1.6], image: [80, 60], hfov_deg: 90, cast: [40, 30]}\n",
        encoding="utf-8",
    )
    return path


def files(folder: Path) -> list[str]:
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file())


def table(folder: Path, name: str) -> list[dict[str, object]]:
    found = json.loads((folder / "v1.0-trainval" / f"{name}.json").read_text(encoding="utf-8"))
    assert isinstance(found, list)
    return found


def test_a_data_set_of_own_boxes(riglens, boxes, tmp_path, small_rig):
    out = tmp_path / "set"
    result = riglens(
        "simulate", small_rig, "--boxes", boxes, "--out", out, "--points", "parquet", "--workers", "1"
    )
    assert result.code == 0
    assert "3 frames" in result.out and "channels LIDAR_TOP, CAM_FRONT" in result.out
    assert "1 sequence only" in result.err and "riglens_val" in result.err
    assert len(table(out, "sample")) == 3 and len(table(out, "sample_annotation")) == 4
    assert sum(name.startswith("samples/") for name in files(out)) == 6
    assert sum(name.endswith(".parquet") for name in files(out)) == 3
    again = riglens("simulate", small_rig, "--boxes", boxes, "--out", out, "--points", "parquet")
    assert again.code == 0 and "already complete" in again.out


def test_several_rigs_get_folders_of_their_names(riglens, boxes, tmp_path, small_rig):
    words = ("--boxes", boxes, "--pictures", "off", "--workers", "1", "--every", "2")
    assert riglens("simulate", small_rig, "Center", *words, "--out", tmp_path / "sets").code == 0
    assert sorted(path.name for path in (tmp_path / "sets").iterdir()) == ["Center", "small"]
    assert not any("CAM" in name for name in files(tmp_path / "sets"))
    assert len(table(tmp_path / "sets" / "Center", "sensor")) == 5
    twice = riglens("simulate", small_rig, small_rig, *words, "--out", tmp_path / "twice")
    assert twice.code == 2 and "would share the folder 'small'" in twice.err


@pytest.mark.parametrize(("one", "other"), [("x", "x."), ("x", "X"), ("a/b", "a:b"), ("...", "rig")])
def test_rigs_whose_names_give_the_same_folder_are_refused(riglens, boxes, tmp_path, small_rig, one, other):
    paths = [tmp_path / "one.yaml", tmp_path / "other.yaml"]
    for path, name in zip(paths, (one, other), strict=True):
        path.write_text(
            small_rig.read_text(encoding="utf-8").replace("name: small", f"name: '{name}'"), encoding="utf-8"
        )
    result = riglens("simulate", *paths, "--boxes", boxes, "--out", tmp_path / "sets")
    one_line(result, f"the rigs '{one}' and '{other}' would share the folder")
    assert not (tmp_path / "sets").exists()


def test_two_runs_in_one_folder_are_refused(riglens, boxes, tmp_path, small_rig):
    out = tmp_path / "set"
    with sole_run(out / ".riglens"):
        one_line(
            riglens("simulate", small_rig, "--boxes", boxes, "--out", out), "another run uses this folder"
        )


def test_a_class_without_objects_and_frames_without_boxes(riglens, tmp_path, small_rig):
    cars = tmp_path / "cars.csv"
    cars.write_text(
        "seq,frame,cls,x,y,z,length,width,height,yaw\na,0,car,8,0,0.8,4,1.8,1.6,0\n", encoding="utf-8"
    )
    words = ("--boxes", cars, "--frames", "2", "--workers", "1")
    result = riglens("simulate", small_rig, *words, "--out", tmp_path / "set")
    assert result.code == 0
    assert "no boxes of class bicycle, pedestrian" in result.err
    assert "1 frame without boxes" in result.err
    assert len(table(tmp_path / "set", "sample")) == 1


def test_the_bundled_town_knows_where_the_car_is(riglens, tmp_path, small_rig):
    words = ("--every", "40", "--sequences", "5", "--pictures", "off", "--workers", "1")
    assert riglens("simulate", small_rig, *words, "--out", tmp_path / "set").code == 0
    places = {tuple(pose["translation"]) for pose in table(tmp_path / "set", "ego_pose")}
    assert len(places) == len(table(tmp_path / "set", "sample")) > 5
    splits = json.loads((tmp_path / "set" / "v1.0-trainval" / "splits.json").read_text(encoding="utf-8"))
    assert [len(splits[name]) for name in ("riglens_train", "riglens_val")] == [4, 1]


def one_line(result, *parts):
    lines = [line for line in result.err.strip().splitlines() if not line.startswith("note: ")]
    assert result.code == 2 and len(lines) == 1, result.err
    for part in parts:
        assert part in result.err


@pytest.mark.parametrize(
    ("words", "part"),
    [
        (("--every", "0"), "--every must be an integer ≥ 1 (got 0)"),
        (("--sequences", "0"), "--sequences must be an integer ≥ 1 (got 0)"),
        (("--clutter", "-1"), "--clutter must be"),
        (("--noise", "-1"), "--noise must be between 0 and"),
        (("--noise", "nan"), "--noise must be between 0 and"),
        (("--dropout", "1"), "--dropout must be at least 0"),
        (("--seed", "-3"), "--seed must be an integer from 0"),
        (("--workers", "0"), "--workers must be between 1"),
        (("--workers", "2", "--dask", "tcp://h:1"), "--workers cannot be combined with"),
        (("--surroundings", "block"), "--surroundings cannot block"),
    ],
)
def test_what_makes_no_sense_is_one_line_and_leaves_nothing(riglens, boxes, tmp_path, small_rig, words, part):
    out = tmp_path / "set"
    one_line(riglens("simulate", small_rig, "--boxes", boxes, "--out", out, *words), part)
    assert not out.exists()


def test_no_room_is_one_line_and_leaves_nothing(riglens, boxes, tmp_path, small_rig, monkeypatch):
    usage = shutil.disk_usage(tmp_path)._replace(free=1000)
    monkeypatch.setattr(shutil, "disk_usage", lambda _: usage)
    out = tmp_path / "set"
    one_line(riglens("simulate", small_rig, "--boxes", boxes, "--out", out), "needs about", "0.0 MB are free")
    assert not out.exists()


def test_rigs_that_measure_nothing_are_refused_before_boxes_are_read(riglens, tmp_path):
    nothing = tmp_path / "nothing.yaml"
    nothing.write_text("riglens: 1\nname: bare\nsensors: []\n", encoding="utf-8")
    words = ("--boxes", tmp_path / "absent.csv", "--out", tmp_path / "set")
    one_line(riglens("simulate", nothing, *words), "enabled LiDAR")
    one_line(riglens("simulate", "Wide", *words, "--pictures", "off"), "no LiDAR while no pictures are drawn")


def test_another_folder_is_left_alone(riglens, boxes, tmp_path, small_rig):
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.tex").write_text("x", encoding="utf-8")
    result = riglens("simulate", small_rig, "--boxes", boxes, "--out", tmp_path / "mine")
    one_line(result, "must be a new or an empty folder (holds 'thesis.tex')")


def test_ctrl_c_does_not_say_that_no_file_was_changed(riglens, boxes, tmp_path, small_rig, monkeypatch):
    def stopped(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("riglens.core.pieces.work.results", stopped)
    words = ("simulate", small_rig, "--boxes", boxes, "--out", tmp_path / "set", "--workers", "1")
    found = riglens(*words)
    assert found.code == 130 and (tmp_path / "set" / "riglens.json").exists()
    assert "no file was changed" not in found.err and "run the same command again" in found.err


def test_what_is_missing_is_worked_out_behind_the_lock(riglens, boxes, tmp_path, small_rig, monkeypatch):
    locked = []

    def missing(self, progress):
        locked.append((self.work / LOCK).exists())
        return []

    monkeypatch.setattr(DatasetFolder, "missing", missing)
    riglens("simulate", small_rig, "--boxes", boxes, "--out", tmp_path / "set", "--workers", "1")
    assert locked == [True]


# ---------------------------------------------------------------- --carla


def test_a_data_set_from_carla(riglens, tmp_path, small_rig, monkeypatch):
    monkeypatch.setitem(sys.modules, "carla", carla_stand_in.module(carla_stand_in.town()))
    words = ("--carla", "localhost:2000", "--frames", "2", "--out", tmp_path / "set")
    result = riglens("simulate", small_rig, *words)
    assert result.code == 0 and "2 frames of Town10HD" in result.out
    assert len(table(tmp_path / "set", "sample_annotation")) == 6
    times = [one["timestamp"] for one in table(tmp_path / "set", "sample")]
    assert times[1] - times[0] == 500_000
    boxes = tmp_path / "set" / "boxes.csv"
    assert (
        riglens("simulate", small_rig, "--boxes", boxes, "--out", tmp_path / "again", "--workers", "1").code
        == 0
    )
    one_line(riglens("simulate", small_rig, *words), "must be a new or an empty folder")


@pytest.mark.parametrize(
    ("words", "part"),
    [
        (("--carla", "nowhere"), "--carla must be HOST:PORT"),
        (("--carla", "h:1", "--frames", "0"), "--frames must be an integer from 1 to 1,000,000 (got 0)"),
        (("--carla", "h:1", "--every", "0"), "--every must be an integer ≥ 1 (got 0)"),
        (("--carla", "h:1", "--dask", "tcp://h:1"), "--dask does not apply"),
        (("--carla", "h:1", "--noise", "-1"), "--noise must be between 0 and"),
    ],
)
def test_what_makes_no_sense_with_carla_is_one_line(riglens, tmp_path, small_rig, monkeypatch, words, part):
    monkeypatch.setitem(sys.modules, "carla", carla_stand_in.module(carla_stand_in.town()))
    one_line(riglens("simulate", small_rig, *words, "--out", tmp_path / "set"), part)
    assert not (tmp_path / "set").exists()


def test_carla_takes_one_rig_and_needs_its_package(riglens, boxes, tmp_path, small_rig, monkeypatch):
    words = ("--out", tmp_path / "set", "--carla", "localhost:2000")
    one_line(riglens("simulate", small_rig, "Center", *words), "--carla is for one rig (got 2 rigs)")
    one_line(riglens("simulate", small_rig, *words, "--boxes", boxes), "--boxes does not apply")
    monkeypatch.setitem(sys.modules, "carla", None)
    one_line(riglens("simulate", small_rig, *words), "pip install 'riglens[carla]'")
