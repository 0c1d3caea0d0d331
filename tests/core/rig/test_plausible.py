"""Rigs that cannot be meant are told, with what to look at; good ones never."""

from pathlib import Path
from typing import Any

import pytest

from riglens.core.errors import InputError
from riglens.core.formats.exchange import read_rig
from riglens.core.rig.model import BrownConrady, Camera, Lidar, LinearAngles, Rig, Sensor
from riglens.core.rig.plausible import implausible
from riglens.core.rig.presets import PRESETS, preset
from tests.core.formats.cases import SMALL, read_files

LENS = {"image": (1600, 900), "fx": 1200.0, "fy": 1200.0, "cx": 800.0, "cy": 450.0}
RING = LinearAngles(from_=-180.0, to=180.0, count=900)
ROWS = LinearAngles(from_=-15.0, to=15.0, count=16)


def camera(name: str = "cam", xyz: Any = (1.0, 0.0, 1.5), rpy: Any = (0.0, 0.0, 0.0), **lens: Any) -> Camera:
    return Camera(name=name, position=xyz, rpy_deg=rpy, **({**LENS, **lens}))


def lidar(name: str = "top", xyz: Any = (0.0, 0.0, 2.0), **rays: Any) -> Lidar:
    return Lidar(name=name, position=xyz, **({"elevations_deg": ROWS, "azimuths_deg": RING} | rays))


BAD: dict[str, tuple[tuple[Sensor, ...], str]] = {
    "an optical frame taken for a body": ((camera(rpy=(-90.0, 0.0, -90.0)),), "on the side"),
    "on its side": ((camera(rpy=(88.0, 0.0, 30.0)),), "on the side"),
    "upside down": ((camera(rpy=(180.0, 0.0, 0.0)),), "upside down"),
    "looks at the sky": ((camera(rpy=(0.0, -60.0, 0.0)),), "above the horizon"),
    "radians as degrees": ((camera(xyz=(1.0, 0.0, -1.5)),), "below the ground"),
    "millimetres": ((lidar(xyz=(1200.0, 0.0, 1900.0)),), "more than 14 m from the car"),
    "left on the right": ((lidar("lidar_left", (0.0, -0.9, 1.9)),), "other side than the name"),
    "y to the right": (
        tuple(
            camera(name, (1.0, y, 1.5), (0.0, 0.0, yaw))
            for name, y, yaw in (
                ("cam_front_left", -0.5, -55.0),
                ("cam_front_right", 0.5, 55.0),
                ("cam_back_left", -0.5, -110.0),
                ("cam_back_right", 0.5, 110.0),
            )
        ),
        "the rig is mirrored",
    ),
    "a rear camera that looks ahead": ((camera("camera_rear", (-2.0, 0.0, 1.0)),), "looking ahead"),
    "a front camera that looks back": ((camera("front", (-2.0, 0.0, 1.0), (0, 0, 180)),), "looking back"),
    "another image than the lens": ((camera(image=(4000, 900)),), "far from the middle"),
    "focal lengths": ((camera(fy=300.0),), "focal lengths 1200 and 300 px"),
    "focal length in mm": ((camera(fx=6.0, fy=6.0),), "whether the focal length is in pixels"),
    "a sonar as a LiDAR": (
        (
            lidar(
                elevations_deg=LinearAngles(from_=-5.0, to=5.0, count=3),
                azimuths_deg=LinearAngles(from_=-10.0, to=10.0, count=5),
                range_m=(0.02, 4.0),
            ),
        ),
        "ultrasonic",
    ),
    "one row": ((lidar(elevations_deg=(0.0,)),), "one row"),
}


@pytest.mark.parametrize("case", BAD)
def test_what_cannot_be_meant_is_one_line(case: str) -> None:
    sensors, said = BAD[case]
    (line,) = implausible(Rig(sensors=sensors))
    assert said in line and "\n" not in line and line.startswith(sensors[0].name)
    off = tuple(sensor.replace(enabled=False) for sensor in sensors)
    assert implausible(Rig(sensors=off)) == []


@pytest.mark.parametrize(
    "sensors",
    [
        (camera("stereo_left", (1.0, 0.6, 1.5)), camera("stereo_right", (1.0, 0.2, 1.5))),
        (
            camera("rear_left", (-2.0, -0.2, 1.0), (0, 0, 180)),
            camera("rear_right", (-2.0, 0.2, 1.0), (0, 0, 180)),
        ),
        (camera("surround_front", (2.2, 0.0, 0.7), (0.0, 50.0, 0.0), distortion=BrownConrady(k1=-0.1)),),
        (camera("front_left_fender", (1.5, 0.9, 0.9), (0.0, 0.0, 150.0)),),
        (camera("bright", (1.0, 0.5, 1.5)), lidar("back_office", (-1.0, 0.0, 2.0))),
        (camera("tele", (1.0, 0.0, 1.5), fx=9000.0, fy=9000.0),),
    ],
)
def test_unusual_but_sensible_rigs_are_not_told(sensors: tuple[Sensor, ...]) -> None:
    assert implausible(Rig(sensors=sensors)) == []


@pytest.mark.parametrize("name", PRESETS)
def test_presets_are_plausible(name: str) -> None:
    assert implausible(preset(name)) == []


@pytest.mark.parametrize("case", SMALL)
def test_small_files_of_all_formats_are_plausible(case: str) -> None:
    assert implausible(read_files(SMALL[case]).rig) == []


def test_published_rigs_are_plausible(shared_data: Path) -> None:
    tried = 0
    for path in sorted((shared_data / "rigs").rglob("*")):
        if path.suffix in (".json", ".yaml") or path.is_dir():
            try:
                rig = read_rig(path).rig
            except InputError:
                continue
            tried += 1
            assert implausible(rig) == [], path
    if not tried:
        pytest.skip("the published rigs are not on this machine")
