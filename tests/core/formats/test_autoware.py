"""Autoware kits: which frames are sensors, empty kits, the vehicle beside a kit, and names that differ."""

from pathlib import Path

import pytest

from riglens.core.errors import InputError
from riglens.core.formats.exchange import detect, read_rig
from riglens.core.formats.frames import kind_of
from riglens.core.formats.mounts import ReadOptions
from riglens.core.formats.report import OpenedRig
from riglens.core.formats.source import Source
from riglens.core.rig.model import Vehicle
from tests.core.formats.cases import SMALL, VEHICLE, lidar, rig_of, write_files
from tests.core.formats.test_reports import has
from tests.core.formats.test_round_trips import again

LEVEL = ((0.5, 0.25, 1.75), (0.0, 0.0, 0.0))
ZERO = "{x: 0.0, y: 0.0, z: 0.5, roll: 0.0, pitch: 0.0, yaw: 0.0}"
ON_BASE = f"base_link:\n  sensor_kit_base_link: {ZERO}\n"
INFO = """\
/**:
  ros__parameters:
    wheel_radius: 0.383
    wheel_base: 2.8
    wheel_tread: 1.6
    front_overhang: 0.9
    rear_overhang: 1.1
    left_overhang: 0.15
    right_overhang: 0.15
    vehicle_height: 1.7
"""


def kit(folder: Path, *frames: str, base: str = ON_BASE, **more: str) -> OpenedRig:
    """A kit with those frames, and other files by names in which double underscores stand for slashes."""
    rows = "".join(f"  {frame}: {ZERO}\n" for frame in frames)
    files = {
        "sensors_calibration.yaml": base,
        "sensor_kit_calibration.yaml": f"sensor_kit_base_link:\n{rows}",
    }
    return read_rig(write_files(folder, files), **more)  # type: ignore[arg-type]


def sensors(imported: OpenedRig) -> dict[str, str]:
    return {sensor.name: sensor.kind for sensor in imported.rig.sensors}


@pytest.mark.parametrize(
    "frame",
    [
        "gnss_base_link",
        "front_unit_base_link",
        "top_base_link",
        "rack_base_link",
    ],
)
def test_a_base_link_of_something_else_is_no_lidar(tmp_path: Path, frame: str) -> None:
    imported = kit(tmp_path, "velodyne_top_base_link", frame)
    assert sensors(imported) == {"velodyne_top": "lidar"}
    assert has(imported.report, "ignored", "neither camera nor LiDAR", frame)


@pytest.mark.parametrize(
    ("frame", "name", "model"),
    [
        ("at128_front_base_link", "at128_front", "hesai-at128"),
        ("xt32_left_base_link", "xt32_left", "hesai-xt32"),
        ("mid360_base_link", "mid360", "livox-mid-360"),
        ("rs_m1_front_base_link", "rs_m1_front", "robosense-m1"),
        ("rs_bpearl_left_base_link", "rs_bpearl_left", "robosense-bpearl"),
        ("falcon_top_base_link", "falcon_top", "generic-16"),
        ("scala_rear_link", "scala_rear", "generic-16"),
        ("top/lidar_link", "top", "generic-16"),
    ],
)
def test_known_product_names_are_lidars(tmp_path: Path, frame: str, name: str, model: str) -> None:
    imported = kit(tmp_path, frame)
    assert sensors(imported) == {name: "lidar"} and imported.rig.sensors[0].model == model


@pytest.mark.parametrize(
    ("frame", "kind"),
    [
        ("imu_side/camera_link", "camera"),
        ("radar_front/lidar_link", "lidar"),
        ("velodyne/radar_link", "radar"),
        ("camera0/camera_optical_link", "camera"),
        ("lidar/", "lidar"),
        ("zed_left", "camera"),
        ("blackfly_s_front", "camera"),
        ("d435_base_link", "camera"),
        ("rsbp_left_base_link", "lidar"),
        ("quanergy_m8", "lidar"),
        ("p128_top", "lidar"),
        ("seized_link", None),
    ],
)
def test_what_comes_after_the_slash_decides(frame: str, kind: str | None) -> None:
    assert kind_of(frame) == kind


def test_the_xacro_of_a_kit_says_what_stands_where(tmp_path: Path) -> None:
    xacro = """<robot xmlns:xacro="http://ros.org/wiki/xacro"><xacro:macro name="kit_macro" params="parent">
      <xacro:VLP-16 name="roof" parent="x"><origin xyz="${1/0}"/></xacro:VLP-16>
      <xacro:PandarQT name="side" parent="x"/>
      <xacro:radar_macro name="velodyne_old" parent="x"/>
      <xacro:radar_macro name="ars408_front" parent="x"/>
      <xacro:monocular_camera_macro name="eye/view" parent="x"/>
      <xacro:Pandar40P name="${prefix}_rear" parent="x"/>
    </xacro:macro></robot>"""
    config = tmp_path / "car_description" / "config"
    write_files(config.parent / "urdf", {"kit.xacro": xacro, "broken.xacro": "<robot>"})
    frames = (
        "roof_base_link", "side_base_link", "velodyne_old_base_link", "ars408_front_base_link", "eye/view_link",
        "left_base_link",
    )  # fmt: skip
    imported = kit(config, *frames)
    radars = {"velodyne_old": "radar", "ars408_front": "radar"}
    assert sensors(imported) == {"roof": "lidar", "side": "lidar", "eye/view": "camera"} | radars
    assert imported.rig.sensor("ars408_front").model == "continental-ars408-21"
    assert has(imported.report, "approximated", "taken by its name", "ars408_front")
    assert [sensor.model for sensor in imported.rig.enabled_lidars()] == ["velodyne-vlp-16", "hesai-qt64"]
    assert has(imported.report, "approximated", "assumed those of generic-radar", "velodyne_old")
    assert has(imported.report, "ignored", "cannot be read as XML", "broken.xacro")
    assert imported.rig == read_rig(config.parent).rig
    apart = tmp_path / "individual_params" / "default"
    assert "roof" not in sensors(kit(apart, *frames))
    for described in (config.parent, config.parent / "urdf"):
        read = read_rig(apart, options=ReadOptions(kit=described))
        assert [sensor.model for sensor in read.rig.enabled_lidars()] == ["velodyne-vlp-16", "hesai-qt64"]
    with pytest.raises(InputError, match=r"^kit must be a folder with xacro files"):
        read_rig(apart, options=ReadOptions(kit=tmp_path))
    write_files(tmp_path / "other", SMALL["kalibr"])
    with pytest.raises(InputError, match=r"^kit applies to an Autoware kit only"):
        read_rig(tmp_path / "other" / "camchain.yaml", options=ReadOptions(kit=config))


@pytest.mark.parametrize(
    "empty", ["", "# nothing\n", "{}\n", "sensor_kit_base_link:\n", "sensor_kit_base_link: {}\n"]
)
def test_an_empty_kit_is_read(tmp_path: Path, empty: str) -> None:
    files = {"sensors_calibration.yaml": ON_BASE, "sensor_kit_calibration.yaml": empty}
    imported = read_rig(write_files(tmp_path, files))
    assert imported.rig.sensors == ()
    alone = {"sensors_calibration.yaml": f"{ON_BASE}  velodyne_top_base_link: {ZERO}\n"}
    assert sensors(read_rig(write_files(tmp_path, alone))) == {"velodyne_top": "lidar"}
    if ":" in empty:
        assert detect(Source(tmp_path / "sensor_kit_calibration.yaml")).name == "autoware"


def test_a_kit_of_other_sensors_is_still_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="at least one sensor"):
        kit(tmp_path, "front/imu_link")


@pytest.mark.parametrize(
    "place",
    ["kit", "kit/config", ".", "car_vehicle_description/config", "vehicle_description/config"],
)
def test_vehicle_info_gives_size_and_axle(tmp_path: Path, place: str) -> None:
    """2.8 + 0.9 + 1.1 m long; the axle 1.1 m before the rear end, which is 2.4 m behind the middle."""
    write_files(tmp_path / place, {"vehicle_info.param.yaml": INFO})
    imported = kit(tmp_path / "kit", "velodyne_top_base_link")
    assert imported.rig.vehicle == Vehicle(length=4.8, width=1.9, height=1.7, rear_axle_x=-1.3)
    assert imported.rig.sensors[0].position == (-1.3, 0.0, 1.0)
    assert has(imported.report, "read", "vehicle_info.param.yaml", "-1.3 m")
    assert not has(imported.report, "vehicle not in the files")
    said = read_rig(tmp_path / "kit", options=ReadOptions(vehicle=VEHICLE))
    assert said.rig.vehicle == VEHICLE


def test_vehicle_info_without_a_length_is_told_and_a_wrong_one_refused(tmp_path: Path) -> None:
    write_files(tmp_path, {"vehicle_info.param.yaml": INFO.replace("wheel_base", "wheelbase")})
    imported = kit(tmp_path, "velodyne_top_base_link")
    assert imported.rig.vehicle == Vehicle() and has(
        imported.report, "ignored", "a length is missing", "vehicle_info"
    )
    for changes in (
        {"2.8": "50.0", "0.9": "50.0"},
        {"1.6": "50.0", "0.15": "26.0"},
    ):  # alone too long, or too wide
        wrong = INFO
        for length, other in changes.items():
            wrong = wrong.replace(length, other)
        write_files(tmp_path, {"vehicle_info.param.yaml": wrong})
        with pytest.raises(InputError, match=r"lengths of a vehicle from 0\.1 to 100 m"):
            read_rig(tmp_path)
    write_files(tmp_path, {"vehicle_info.param.yaml": INFO.replace("2.8", "-2.8")})
    with pytest.raises(InputError, match=r"vehicle_info.param.yaml: .*wheel_base: .*got -2.8"):
        read_rig(tmp_path)


def test_of_several_vehicles_none_is_taken(tmp_path: Path) -> None:
    for name in ("a_vehicle_description", "b_vehicle_description"):
        write_files(tmp_path / name / "config", {"vehicle_info.param.yaml": INFO})
    imported = kit(tmp_path / "kit", "velodyne_top_base_link")
    assert imported.rig.vehicle == Vehicle() and has(imported.report, "ignored", "2 files of that name")


@pytest.mark.parametrize(
    ("folder", "name"),
    [
        ("aip_x2_description/config", "aip_x2"),
        ("params/config/default/sample_sensor_kit", "sample_sensor_kit"),
        ("params/config/car7/sample_sensor_kit", "sample_sensor_kit car7"),
        ("my_kit", "my_kit"),
    ],
)
def test_kits_are_named_by_kit_and_vehicle(tmp_path: Path, folder: str, name: str) -> None:
    assert kit(tmp_path / folder, "velodyne_top_base_link").rig.name == name
    assert read_rig(tmp_path / folder / "sensors_calibration.yaml").rig.name == name


@pytest.mark.parametrize(
    "name", ["top", "radar", "kit", "sensor_kit", "velodyne_top", "a/b", "camera", "imu"]
)
def test_lidars_of_any_name_come_back(name: str) -> None:
    assert [
        (sensor.name, sensor.kind) for sensor in again("autoware", rig_of(lidar(name, LEVEL))).sensors
    ] == [(name, "lidar")]
