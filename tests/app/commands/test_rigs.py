"""`riglens presets`, `convert` and `library`: rigs and sensor models to start from."""

import json
from pathlib import Path

import pytest

import riglens as rl
from riglens.app.commands.list import _table
from riglens.core.rig.library import default_library
from riglens.core.rig.plausible import implausible
from riglens.core.rig.presets import PRESETS, preset
from riglens.core.rig.yaml.file import load_rig, new_rig_file
from riglens.core.sensors.registry import kinds
from tests.app.conftest import SMALL_GRID, Run
from tests.core.formats.cases import SMALL, write_files

# ---------------------------------------------------------------- presets


def test_all_presets_are_listed_with_their_sensors(riglens):
    result = riglens("list", "rigs")
    assert result.code == 0
    lines = [line.strip() for line in result.out.splitlines()]
    assert [name for name in PRESETS if not any(line.startswith(f"{name} ") for line in lines)] == []
    rows = {line.split()[0]: line for line in lines if line}
    assert rows["W+T"].split()[1:3] == ["6", "4"]
    assert rows["Center"].split()[1:3] == ["0", "4"]


@pytest.mark.parametrize("name", ["W+T", "N+C", "Pyramid-roll"])
def test_a_preset_written_to_a_file_is_the_same_rig(riglens, tmp_path, name):
    assert riglens("list", "rigs", name, "--out", tmp_path / "rig.yaml").code == 0
    assert load_rig(tmp_path / "rig.yaml").rig == preset(name)


def test_a_preset_is_printed_as_yaml(riglens, tmp_path):
    result = riglens("list", "rigs", "W+T")
    (tmp_path / "rig.yaml").write_text(result.out, encoding="utf-8")
    assert load_rig(tmp_path / "rig.yaml").rig == preset("W+T")


def test_an_unknown_preset_is_refused_and_the_old_file_stays(riglens, tmp_path):
    (tmp_path / "rig.yaml").write_text("kept", encoding="utf-8")
    assert "W+X" in riglens("list", "rigs", "W+X", "--out", tmp_path / "rig.yaml").refused()
    assert (tmp_path / "rig.yaml").read_text(encoding="utf-8") == "kept"


def test_out_without_a_name_is_refused(riglens, tmp_path):
    assert "NAME" in riglens("list", "rigs", "--out", tmp_path / "rig.yaml").refused()
    assert list(tmp_path.iterdir()) == []


# ---------------------------------------------------------------- convert


def test_the_report_names_every_sensor_on_the_terminal_and_in_a_file(riglens: Run, tmp_path: Path) -> None:
    folder = write_files(tmp_path / "nuscenes", SMALL["nuscenes"])
    report = tmp_path / "report.txt"
    outcome = riglens("convert", folder, tmp_path / "rig.urdf", "--report", report)
    assert outcome.code == 0 and " more)" not in outcome.err
    lines = report.read_text(encoding="utf-8").splitlines()
    assert lines[0] == "nuScenes tables" and "ROS URDF" in lines
    assert "    CAM_FRONT" in lines and "    RADAR_FRONT" in lines
    line = riglens("convert", folder, tmp_path / "a.urdf", "--report", tmp_path / "a.urdf").refused()
    assert "must be another file than OUT" in line and not (tmp_path / "a.urdf").exists()


def test_tables_become_a_rig_file_and_the_report_stands_on_standard_error(
    riglens: Run, tmp_path: Path
) -> None:
    folder = write_files(tmp_path / "tables", SMALL["nuscenes"])
    outcome = riglens("convert", folder, tmp_path / "rig.yaml")
    assert outcome.code == 0
    assert outcome.out.endswith("rig.yaml: 3 sensors as RigLens rig YAML\n")
    for line in (
        "note: nuScenes tables: read: rig 1 of 2, its first row is a1; --token changes it",
        "converted: origin from the rear axle on the ground to the body centre: added -1.35 0 0 m",
        "read: its angles are those of the library model continental-ars408-21 (RADAR_FRONT)",
    ):
        assert line in outcome.err
    camera = load_rig(tmp_path / "rig.yaml").rig.sensor("CAM_FRONT")
    assert camera.position == (0.35, 0.0, 1.5) and camera.rpy_deg == (0.0, 0.0, 0.0)


def test_what_is_implausible_about_a_rig_is_told_by_commands_and_python(riglens: Run, tmp_path: Path) -> None:
    deep = preset("Line").sensors[0].replace(position=(0.0, 0.0, -1.0))
    new_rig_file(preset("Line").replace(sensors=(deep,))).save(tmp_path / "deep.yaml")
    (fact,) = implausible(load_rig(tmp_path / "deep.yaml").rig)
    assert fact in riglens("convert", tmp_path / "deep.yaml", tmp_path / "out.yaml").err
    outcome = riglens("evaluate", tmp_path / "deep.yaml", "Line", *SMALL_GRID, "--json", "-")
    assert fact in outcome.err
    document = json.loads(outcome.out)
    for deep_one, good_one in (document["rigs"], document["targets"]["rigs"]):
        assert deep_one["notes"] == [fact] and "notes" not in good_one
    with pytest.warns(rl.RigLensWarning) as told:
        rl.open_rig(tmp_path / "deep.yaml")
    assert any(fact in str(one.message) for one in told)


def test_options_say_what_the_file_does_not(riglens: Run, tmp_path: Path) -> None:
    folder = write_files(tmp_path / "tables", SMALL["nuscenes"])
    riglens("list", "rigs", "Line", "--out", tmp_path / "line.yaml")
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
    written = {path.name for path in (tmp_path / "autoware").iterdir()}
    assert {"sensor_kit_calibration.yaml", "sensors_calibration.yaml", "CAM_BACK_camera_info.yaml"} < written
    back = riglens("convert", tmp_path / "autoware", tmp_path / "back.yaml")
    assert back.code == 0 and load_rig(tmp_path / "back.yaml").rig.sensor("CAM_BACK").position == (
        -1.5,
        0.0,
        1.8,
    )


def test_every_command_that_takes_a_rig_takes_a_foreign_one(riglens: Run, tmp_path: Path) -> None:
    path = write_files(tmp_path, SMALL["driveworks"]) / "rig.json"
    outcome = riglens("evaluate", path, *SMALL_GRID, "--json", "-")
    assert outcome.code == 0
    assert json.loads(outcome.out)["rigs"][0]["name"].endswith(" rig")
    assert "note: NVIDIA DriveWorks rig JSON: read: 1 camera, 1 LiDAR" in outcome.err


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (
            ("rig.json", "out.json"),
            "--to must name the format, which the ending of out.json does not: riglens,",
        ),
        (("rig.json", "out.yaml", "--to", "nuscene"), "unknown format 'nuscene' (did you mean nuscenes?"),
        (("rig.json", "out.yaml", "--from", "xyz"), "unknown format 'xyz' (known: riglens, nuscenes"),
        (("no.json", "out.yaml"), "no.json: no such file or folder"),
        (("rig.json", "no/out.yaml"), "out.yaml: cannot be written: no such folder"),
        (("rig.json", "out.yaml", "--from", "kalibr"), "rig.json"),
        (("rig.json", "out.yaml", "--origin", "1", "nan", "0"), "--origin must be finite, in metres"),
        (
            ("W+T", "here", "--to", "autoware"),
            "here: cannot be written: must be a new or an empty folder",
        ),
    ],
)
def test_what_cannot_be_done_is_said_in_one_line(
    riglens: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, arguments: tuple[str, ...], complaint: str
) -> None:
    monkeypatch.chdir(write_files(tmp_path, SMALL["driveworks"]))
    write_files(tmp_path / "here", {"a.txt": "mine"})
    assert complaint in riglens("convert", *arguments).refused()
    assert not (tmp_path / "out.yaml").exists()


def test_an_xacro_file_without_anything_is_refused_in_one_line(riglens: Run, tmp_path: Path) -> None:
    kit = tmp_path / "kit.xacro"
    kit.write_text(
        '<robot name="kit" xmlns:xacro="http://ros.org/wiki/xacro"><xacro:include filename="a"/></robot>',
        encoding="utf-8",
    )
    assert (
        "kit.xacro:1: <robot>: a robot needs at least one <link>"
        in riglens("convert", kit, tmp_path / "rig.yaml").refused()
    )


def test_an_autoware_kit_can_be_drawn_on_another_car(riglens: Run, tmp_path: Path) -> None:
    folder = write_files(tmp_path / "kit", SMALL["autoware"])
    for axle, x in (("-1.0", -0.1), ("-2.0", -1.1)):
        assert riglens("convert", folder, tmp_path / "a.yaml", "--rear-axle-x", axle).code == 0
        assert load_rig(tmp_path / "a.yaml").rig.sensor("velodyne_top").position == pytest.approx(
            (x, 0.0, 2.0)
        )


# ---------------------------------------------------------------- library


OWN = """\
my-cam:
  kind: camera
  maker: Yard
  title: Camera of our own
  source: Calibrated in the yard in March
  image: [800, 600]
  fx: 400
  fy: 400
  cx: 400
  cy: 300
  distortion: {model: brown_conrady, k1: -0.1}
"""


def test_the_list_fits_100_columns_and_groups_by_maker(riglens):
    result = riglens("list", "sensors")
    assert result.code == 0
    lines = [line.rstrip() for line in result.out.splitlines()]
    assert max(map(len, lines)) <= 100
    assert lines.index("Velodyne") < lines.index("Ouster") < lines.index("Hesai")
    row = next(line for line in lines if line.startswith("hesai-pandar64 "))
    assert row.split() == ["hesai-pandar64", "Pandar64", "64", "360°", "×", "39.8°", "0.3–200", "m"]


def test_what_is_unverified_is_marked_without_brackets_of_markup(riglens):
    out = riglens("list", "sensors", "--kind", "radar").out
    assert "(unverified: " in out and "[" not in out


def test_a_kind_lists_that_kind_alone(riglens):
    lidars, cameras = (riglens("list", "sensors", "--kind", kind).out for kind in ("lidar", "camera"))
    assert "generic-16" in lidars and "paper-camera-70" not in lidars
    assert "paper-camera-70" in cameras and "generic-16" not in cameras


def test_a_model_is_shown_with_beams_offsets_and_source(riglens):
    out = riglens("list", "sensors", "velodyne-vlp-32c").out
    assert "ROS driver (BSD licence)" in out and "-15.64" in out and "positive turns left" in out
    assert max(len(line.rstrip()) for line in out.splitlines()) <= 100


def test_json_holds_every_figure(riglens):
    document = json.loads(riglens("list", "sensors", "--json", "-").out)
    models = {model["name"]: model for model in document["models"]}
    assert document["riglens"] == 1 and len(models) > 40
    assert len(models["velodyne-vlp-32c"]["azimuth_offsets_deg"]) == 32
    assert models["generic-16"]["elevations_deg"] == {"from": -25.0, "to": 25.0, "count": 16}
    assert models["kitti-colour"]["distortion"]["k1"] == -0.3691
    assert all(len(model["source"]) > 30 for model in models.values())
    (one,) = json.loads(riglens("list", "sensors", "generic-16", "--json", "-").out)["models"]
    assert one == models["generic-16"]


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (("vlp-64",), "unknown sensor model 'vlp-64'"),
        (("generic-16", "--kind", "lidar"), "--kind chooses what is listed"),
        (("--library", "/nowhere/own.yaml"), "/nowhere/own.yaml: no such file"),
    ],
)
def test_what_is_not_there_is_said_in_one_line(riglens, arguments, complaint):
    result = riglens("list", "sensors", *arguments)
    assert (result.code, result.out) == (2, "")
    assert complaint in result.err and result.err.count("\n") == 1


@pytest.mark.parametrize("kind", kinds(), ids=lambda kind: kind.name)
def test_every_figure_of_a_list_of_models_has_a_heading(kind):
    shown = _table(default_library(), kind)
    assert shown.row_count > 1 and all(column.header for column in shown.columns)


def test_rigs_find_the_models_of_a_library_of_ones_own(riglens, boxes, tmp_path):
    (tmp_path / "own.yaml").write_text(OWN, encoding="utf-8")
    (tmp_path / "rig.yaml").write_text(
        "riglens: 1\nname: own\nsensors:\n"
        "  - {name: a, kind: camera, model: my-cam, position: [0, 0, 2], cast: [16, 12]}\n",
        encoding="utf-8",
    )
    small = ("--boxes", boxes, "--voxel", "0.5", "--roi", "20", "20", "4")
    assert riglens("evaluate", tmp_path / "rig.yaml", *small).code == 2
    own = ("--library", tmp_path / "own.yaml")
    assert riglens("evaluate", tmp_path / "rig.yaml", *small, *own).code == 0
    assert "my-cam" in riglens("list", "sensors", *own).out
