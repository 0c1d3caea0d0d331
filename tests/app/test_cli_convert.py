"""`riglens convert`: formats are told by the files, everything is reported, nothing is half written."""

import json
from pathlib import Path

import pytest

from riglens.core.rig.presets import preset
from riglens.core.rig.yaml.file import load_rig
from tests.app.conftest import SMALL_GRID, Run
from tests.core.rig.formats.cases import AUTOWARE_KIT, DRIVEWORKS, NUSCENES, write_files


def test_tables_become_a_rig_file_and_the_report_stands_on_standard_error(
    riglens: Run, tmp_path: Path
) -> None:
    folder = write_files(tmp_path / "tables", NUSCENES)
    outcome = riglens("convert", folder, tmp_path / "rig.yaml")
    assert outcome.code == 0
    assert outcome.out.endswith("rig.yaml: 2 sensors as RigLens rig YAML\n")
    for line in (
        "note: nuScenes tables: read: rig 1 of 2, its first row is a1; --token changes it",
        "converted: origin from the rear axle on the ground to the body centre: added -1.35 0 0 m",
        "ignored: RigLens has no radars (RADAR_FRONT)",
    ):
        assert line in outcome.err
    camera = load_rig(tmp_path / "rig.yaml").rig.sensor("CAM_FRONT")
    assert camera.position == (0.35, 0.0, 1.5) and camera.rpy_deg == (0.0, 0.0, 0.0)


def test_options_say_what_the_file_does_not(riglens: Run, tmp_path: Path) -> None:
    folder = write_files(tmp_path / "tables", NUSCENES)
    riglens("presets", "Line", "--out", tmp_path / "line.yaml")
    target = tmp_path / "rig.yaml"
    options = ("--token", "b2", "--vehicle", tmp_path / "line.yaml", "--rear-axle-x", "-1.0")
    assert riglens("convert", folder, target, *options).code == 0
    rig = load_rig(target).rig
    assert rig.sensor("CAM_FRONT").position == (0.6, 0.0, 1.4)
    assert (rig.vehicle.length, rig.vehicle.rear_axle_x) == (preset("Line").vehicle.length, -1.0)
    assert riglens("convert", folder, target, "--origin", "0", "0", "0.5").code == 0
    assert load_rig(target).rig.sensor("CAM_FRONT").position == (1.7, 0.0, 2.0)


def test_a_preset_goes_out_in_every_format(riglens: Run, tmp_path: Path) -> None:
    for name in ("nuscenes", "autoware", "urdf", "carla", "carla-toml", "driveworks", "osi", "riglens"):
        outcome = riglens("convert", "W+T", tmp_path / name, "--to", name)
        assert outcome.code == 0 and f"{name}: 10 sensors as " in outcome.out
    assert sorted(path.name for path in (tmp_path / "autoware").iterdir()) == [
        "sensor_kit_calibration.yaml",
        "sensors_calibration.yaml",
    ]
    back = riglens("convert", tmp_path / "autoware", tmp_path / "back.yaml")
    assert back.code == 0 and load_rig(tmp_path / "back.yaml").rig.sensor("CAM_BACK").position == (
        -1.5,
        0.0,
        1.8,
    )


def test_every_command_that_takes_a_rig_takes_a_foreign_one(riglens: Run, tmp_path: Path) -> None:
    path = write_files(tmp_path, DRIVEWORKS) / "rig.json"
    outcome = riglens("evaluate", path, *SMALL_GRID, "--json", "-")
    assert outcome.code == 0
    assert json.loads(outcome.out)["rigs"][0]["name"] == "rig"
    assert "note: NVIDIA DriveWorks rig JSON: read: 1 camera, 1 LiDAR" in outcome.err


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (
            ("rig.json", "out.json"),
            "out.json: the format does not follow from its ending; name it with --to: riglens,",
        ),
        (("rig.json", "out.yaml", "--to", "nuscene"), "found 'nuscene'; did you mean nuscenes?"),
        (("rig.json", "out.yaml", "--from", "osi"), "format: found 'osi'; accepted are riglens, nuscenes"),
        (("no.json", "out.yaml"), "no.json: no such file or folder"),
        (("rig.json", "no/out.yaml"), "out.yaml: cannot be written: no such folder"),
        (("rig.json", "out.yaml", "--from", "kalibr"), "rig.json"),
        (("rig.json", "out.yaml", "--origin", "1", "nan", "0"), "accepted are finite numbers in metres"),
        (("W+T", "here", "--to", "autoware"), "here: cannot be written: the folder holds a.txt"),
    ],
)
def test_what_cannot_be_done_is_said_in_one_line(
    riglens: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, arguments: tuple[str, ...], complaint: str
) -> None:
    monkeypatch.chdir(write_files(tmp_path, DRIVEWORKS))
    write_files(tmp_path / "here", {"a.txt": "mine"})
    assert complaint in riglens("convert", *arguments).refused()
    assert not (tmp_path / "out.yaml").exists()


def test_an_xacro_file_is_refused_with_the_way_to_expand_it(riglens: Run, tmp_path: Path) -> None:
    kit = tmp_path / "kit.xacro"
    kit.write_text(
        '<robot name="kit" xmlns:xacro="http://ros.org/wiki/xacro"><xacro:include filename="a"/></robot>'
    )
    line = riglens("convert", kit, tmp_path / "rig.yaml").refused()
    assert line.endswith("this is xacro, not expanded URDF; expand it first: xacro kit.xacro > rig.urdf")


def test_an_autoware_kit_can_be_drawn_on_another_car(riglens: Run, tmp_path: Path) -> None:
    folder = write_files(tmp_path / "kit", AUTOWARE_KIT)
    for axle, x in (("-1.0", -0.1), ("-2.0", -1.1)):
        assert riglens("convert", folder, tmp_path / "a.yaml", "--rear-axle-x", axle).code == 0
        assert load_rig(tmp_path / "a.yaml").rig.sensor("velodyne_top").position == pytest.approx(
            (x, 0.0, 2.0)
        )
