"""Radars and ultrasonic sensors of other programs, and in their files."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from riglens.core.errors import InputError
from riglens.core.formats.exchange import FORMATS, read_rig
from riglens.core.formats.osi import WHEEL_RADIUS_M
from riglens.core.rig.model import Camera, KannalaBrandt, Lidar, LinearAngles, Rig
from riglens.core.rig.presets import preset
from riglens.core.sensors.radar import Radar, RadarScan
from riglens.core.sensors.ultrasonic import Ultrasonic
from tests.core.formats.cases import SMALL, assert_same_pose, read_files, sensor_matrix, written
from tests.core.formats.test_reports import has
from tests.core.formats.test_round_trips import again

WIDE = RadarScan(azimuth_deg=(-45.0, 45.0), elevation_deg=(-10.0, 10.0), range_m=70.0)
POSE: dict[str, Any] = {"position": (2.0, 0.5, 0.5), "rpy_deg": (1.0, -2.0, 30.0)}
RADAR = Radar(name="bumper radar", scans=(WIDE,), **POSE)
SONAR = Ultrasonic(name="bumper sonar", **POSE)


def test_all_twelve_sensors_of_nuscenes_come_back() -> None:
    rig = preset("nuScenes car with radars")
    back = again("nuscenes", rig)
    assert len(rig.sensors) == len(back.sensors) == 12
    for sensor in rig.sensors:
        assert_same_pose(sensor_matrix(back.sensor(sensor.name)), sensor_matrix(sensor))
    radars = [sensor for sensor in back.sensors if isinstance(sensor, Radar)]
    assert [radar.scans for radar in radars] == [s.scans for s in rig.sensors if isinstance(s, Radar)]


@pytest.mark.parametrize("name", ["autoware", "driveworks"])
def test_poses_of_both_kinds_come_back(name: str) -> None:
    rig = Rig(sensors=(RADAR, SONAR))
    back = again(name, rig)
    assert [type(sensor) for sensor in back.sensors] == [Radar, Ultrasonic]
    for one, other in zip(back.sensors, rig.sensors, strict=True):
        assert one.name == other.name
        assert_same_pose(sensor_matrix(one), sensor_matrix(other))


def test_driveworks_keeps_the_library_model() -> None:
    rig = preset("production car")
    back = again("driveworks", rig)
    assert {s.name: s.model for s in back.sensors if s.kind != "camera"} == {
        s.name: s.model for s in rig.sensors if s.kind != "camera"
    }


def test_carlas_radar_has_one_symmetric_scan() -> None:
    (back,) = again("carla", Rig(sensors=(RADAR,))).sensors
    assert isinstance(back, Radar) and back.scans[0].range_m == 70.0
    assert (back.scans[0].azimuth_deg, back.scans[0].elevation_deg) == ((-45.0, 45.0), (-10.0, 10.0))
    more = RADAR.replace(scans=(WIDE.replace(azimuth_deg=(-10.0, 30.0), range_m=90.0), WIDE))
    report = FORMATS["carla"].write(Rig(sensors=(more, SONAR))).report
    assert has(report, "approximated", "symmetric", "bumper radar") and has(
        report, "1 scans of shorter range"
    )
    assert has(report, "ignored", "ultrasonic sensor", "bumper sonar")
    spawn = {"type": "sensor.other.radar", "id": "r"}
    ego = {"type": "vehicle.tesla.model3", "id": "ego", "sensors": [spawn]}
    (plain,) = read_files({"objects.json": json.dumps({"objects": [ego]})}, "carla").rig.sensors
    assert isinstance(plain, Radar)
    assert (plain.scans[0].azimuth_deg, plain.scans[0].range_m) == ((-15.0, 15.0), 100.0)


def test_osi_has_a_view_of_each() -> None:
    radar, sonar = json.loads(written("osi", Rig(sensors=(RADAR, SONAR)))["osi.json"])[
        "sensor_view_configuration"
    ]
    (view,) = radar["radar_sensor_view_configuration"]
    assert radar["range"] == 70.0 and view["number_of_rays_horizontal"] == 46
    assert view["field_of_view_horizontal"] == pytest.approx(1.570796)
    assert sonar["ultrasonic_sensor_view_configuration"] and sonar["range"] == 2.5


def test_osi_brings_every_kind_back_as_far_as_it_can_hold_it() -> None:
    turn, rows = LinearAngles(from_=-180.0, to=180.0, count=900), LinearAngles(from_=-15.0, to=15.0, count=16)
    top = Lidar(name="top", elevations_deg=rows, azimuths_deg=turn, range_m=(0.0, 120.0), **POSE)
    view = Camera(name="view", image=(800, 600), hfov_deg=80.0, **POSE)
    rig = Rig(sensors=(RADAR, SONAR, top, view))
    back = again("osi", rig)
    for one, other in zip(back.sensors, rig.sensors, strict=True):
        assert one.name == other.name
        assert_same_pose(sensor_matrix(one), sensor_matrix(other))
    radar, sonar, lidar, camera = back.sensors
    assert isinstance(radar, Radar) and radar.scans[0].range_m == 70.0
    assert radar.scans[0].azimuth_deg == pytest.approx((-45.0, 45.0), abs=1e-8)
    assert radar.scans[0].elevation_deg == pytest.approx((-10.0, 10.0), abs=1e-8)
    assert isinstance(sonar, Ultrasonic) and (sonar.pole_range_m, sonar.wall_range_m) == (2.5, 5.5)
    assert isinstance(lidar, Lidar) and lidar.range_m == (0.0, 120.0)
    assert lidar.elevations() == pytest.approx(top.elevations(), abs=1e-8)
    assert lidar.azimuths() == pytest.approx(top.azimuths(), abs=1e-8)
    assert isinstance(camera, Camera) and camera.image == (800, 600)
    assert camera.hfov_deg == pytest.approx(80.0, abs=1e-8)


def test_osi_as_protobufs_printers_write_it() -> None:
    """Names in lowerCamelCase, 64-bit integers as texts, zeros left out; what a message lacks is its holder's."""
    found = read_files(SMALL["osi"])
    assert [sensor.name for sensor in found.rig.sensors] == [
        "radar 7", "lidar 8", "camera 9", "camera 2", "ultrasonic 1",
    ]  # fmt: skip
    radar, lidar, camera, wide, _ = found.rig.sensors
    x = found.rig.vehicle.rear_axle_x
    assert isinstance(radar, Radar) and radar.scans[0].range_m == 150.0
    assert radar.position == pytest.approx((x + 3.1, 0.0, WHEEL_RADIUS_M + 0.2))
    assert radar.rpy_deg == pytest.approx((0.0, np.degrees(-0.1), np.degrees(0.5)))
    assert radar.scans[0].azimuth_deg == pytest.approx((-np.degrees(0.5), np.degrees(0.5)))
    assert isinstance(lidar, Lidar) and (len(lidar.elevations()), len(lidar.azimuths())) == (32, 1800)
    assert isinstance(camera, Camera) and camera.image == (1920, 1080)
    assert isinstance(wide, Camera) and isinstance(wide.distortion, KannalaBrandt)
    assert wide.fx == pytest.approx(1600 / 3.3)
    assert has(found.report, "ignored", "generic sensor")
    assert has(found.report, "approximated", "equidistant", "camera 2")


def test_osi_is_told_from_other_json(tmp_path: Path) -> None:
    for text in ("{}", "[]", '{"sensor_view_configuration": []}', "[1, {}]"):
        (tmp_path / "a.json").write_text(text, encoding="utf-8")
        with pytest.raises(InputError):
            read_rig(tmp_path / "a.json")
        with pytest.raises(InputError, match="a message SensorViewConfiguration"):
            read_rig(tmp_path / "a.json", "osi")
