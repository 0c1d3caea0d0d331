"""Radars and ultrasonic sensors of other programs, and in their files."""

import json
from typing import Any

import pytest

from riglens.core.formats.exchange import FORMATS
from riglens.core.rig.model import Rig
from riglens.core.rig.presets import preset
from riglens.core.sensors.radar import Radar, Scan
from riglens.core.sensors.ultrasonic import Ultrasonic
from tests.core.formats.cases import assert_same_pose, read_files, sensor_matrix
from tests.core.formats.test_poses_written import written
from tests.core.formats.test_reports import has
from tests.core.formats.test_round_trips import again

WIDE = Scan(azimuth_deg=(-45.0, 45.0), elevation_deg=(-10.0, 10.0), range_m=70.0)
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
    write = FORMATS["carla"].write
    assert write is not None
    report = write(Rig(sensors=(more, SONAR))).report
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
