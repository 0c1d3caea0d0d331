"""Whatever a user names as a rig is found: a preset, a rig file, a file of another program."""

import os
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from riglens.core.errors import InputError
from riglens.core.formats import exchange
from riglens.core.formats.exchange import FORMATS
from riglens.core.formats.opening import open_rig
from riglens.core.rig.presets import preset
from riglens.core.rig.yaml.file import load_rig, new_rig_file
from tests.core.formats.cases import SMALL, write_files


def test_a_preset_is_found_in_any_spelling() -> None:
    opened = open_rig("wide + trapezoid")
    assert (opened.rig, opened.file, opened.report) == (preset("W+T"), None, None)


def test_an_unknown_name_is_refused_with_the_nearest_preset() -> None:
    with pytest.raises(InputError, match=r"rig 'Trapezod': neither a rig file .*; did you mean Trapezoid"):
        open_rig("Trapezod")
    with pytest.raises(InputError) as caught:
        open_rig("line\nbreak" * 30)
    assert "\n" not in str(caught.value) and len(str(caught.value)) < 200


def test_a_rig_file_is_found_by_its_path_and_comes_with_its_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    new_rig_file(preset("N+S")).save("mine")
    new_rig_file(preset("Line")).save("W+T")
    opened = open_rig("mine")
    assert opened.rig == preset("N+S") and opened.file is not None and opened.file.path == Path("mine")
    assert open_rig("W+T").rig == preset("W+T") and open_rig("./W+T").rig == preset("Line")
    assert open_rig(tmp_path / "mine").rig == load_rig("mine").rig
    with pytest.raises(InputError, match=r"^w\+t\.yaml: no such file"):
        open_rig("w+t.yaml")


def test_a_rig_file_is_read_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Also that of another program: what recognises a format and what reads it share the text."""
    new_rig_file(preset("Line")).save(tmp_path / "mine.yaml")
    exchange.write_rig(preset("Line"), tmp_path / "line.urdf")
    opened: list[str] = []
    open_file = os.open

    def counted(path: str, *rest: Any) -> int:
        opened.append(os.fspath(path))
        return open_file(path, *rest)

    monkeypatch.setattr(os, "open", counted)
    for path in (tmp_path / "mine.yaml", tmp_path / "line.urdf"):
        open_rig(path)
        assert opened.count(str(path)) == 1


def test_a_file_of_another_program_comes_with_a_report_and_without_a_file(tmp_path: Path) -> None:
    folder = write_files(tmp_path / "kit", SMALL["autoware"])
    for named in (folder, folder / "sensors_calibration.yaml"):
        opened = open_rig(named)
        assert opened.file is None and opened.report is not None
        assert opened.report.title == "Autoware sensor kit calibration"
        assert [sensor.name for sensor in opened.rig.sensors] == ["camera0", "velodyne_top"]


def test_what_is_no_rig_is_refused_in_one_line(tmp_path: Path) -> None:
    (tmp_path / "a.json").write_text("[1, 2]", encoding="utf-8")
    (tmp_path / "empty").mkdir()
    (tmp_path / "c.yaml").write_text("lidars: [front]\n", encoding="utf-8")
    for name in ("a.json", "c.yaml", "empty"):
        with pytest.raises(InputError, match=r"not a rig in a known format .known: riglens, nuscenes"):
            open_rig(tmp_path / name)
    (tmp_path / "b.yaml").write_text("name: my rig\nsensors: []\n", encoding="utf-8")
    with pytest.raises(InputError, match=r"b\.yaml:1: riglens is missing"):
        open_rig(tmp_path / "b.yaml")


def test_a_folder_that_holds_a_rig_is_refused_with_the_name_of_its_file(tmp_path: Path) -> None:
    (tmp_path / "notes.yaml").write_text("lidars: [front]\n", encoding="utf-8")
    (tmp_path / "own.yaml").write_text("riglens: 1\nname: own\nsensors: []\n", encoding="utf-8")
    with pytest.raises(InputError, match=r"name the rig in it, such as own\.yaml"):
        open_rig(tmp_path)


def test_a_robot_whose_mounts_are_elsewhere_is_refused_with_the_way_to_its_places(tmp_path: Path) -> None:
    """Clearpath's robot.yaml: its parents are frames of descriptions in ROS packages."""
    (tmp_path / "robot.yaml").write_text(
        "serial_number: a200-0000\nversion: 0\nmounts: {bracket: [{parent: top_plate_mount_d1}]}\nsensors:\n"
        "  lidar3d: [{model: velodyne_lidar, parent: bracket_0_mount, xyz: [0, 0, 0], rpy: [0, 0, 0]}]\n",
        encoding="utf-8",
    )
    with pytest.raises(InputError, match=r"robot\.yaml: .*generate_description"):
        open_rig(tmp_path / "robot.yaml")


def test_a_missing_file_is_missing_whatever_format_it_would_have(monkeypatch):
    added = replace(FORMATS["urdf"], suffixes=(".mounts",))
    monkeypatch.setattr(exchange, "formats", lambda: {**FORMATS, "mounts": added})
    for name in ("nowhere.yaml", "nowhere.urdf", "nowhere.mounts"):
        with pytest.raises(InputError, match="no such file or folder"):
            open_rig(name)
