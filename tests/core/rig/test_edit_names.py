"""The Edit menu names what a step changed, and only edits of the same numbers go on with each other."""

import pytest

from riglens.core.rig.history import describe
from riglens.core.rig.model import Rig
from riglens.core.rig.presets import preset

START = preset("W+T")
LIDAR = START.sensor("LIDAR_1")


def changed(sensor: str = "LIDAR_1", **fields: object) -> Rig:
    return START.with_sensor(sensor, START.sensor(sensor).replace(**fields))


@pytest.mark.parametrize(
    ("after", "label"),
    [
        (changed(position=(0.0, 0.0, 2.0)), "move LIDAR_1"),
        (changed(rpy_deg=(0.0, 5.0, 0.0)), "turn LIDAR_1"),
        (changed(position=(0.0, 0.0, 2.0), rpy_deg=(0.0, 5.0, 0.0)), "move LIDAR_1"),
        (changed(name="top"), "rename LIDAR_1"),
        (changed(enabled=False), "switch off LIDAR_1"),
        (changed(range_m=(0.0, 50.0)), "edit LIDAR_1"),
        (START.replace(name="other"), "rename the rig"),
        (START.replace(vehicle=START.vehicle.replace(length=5.0)), "edit the car"),
        (START.replace(sensors=START.sensors[1:]), "edit the rig"),
    ],
)
def test_an_edit_is_named_after_what_it_changed(after: Rig, label: str) -> None:
    assert describe(START, after).label == label


@pytest.mark.parametrize("after", [START.replace(self_occlusion=True), START.replace(housings="blocks")])
def test_what_stops_rays_is_named_one_way_and_the_other(after: Rig) -> None:
    there, back = describe(START, after).label, describe(after, START).label
    assert there and back and len({there, back, "edit the rig"}) == 3


def test_two_sensors_are_named_and_more_are_counted() -> None:
    rig = START
    labels = []
    for number in (1, 2, 3):
        sensor = rig.sensor(f"LIDAR_{number}")
        rig = rig.with_sensor(sensor.name, sensor.replace(position=(0.0, 0.5, 2.0)))
        labels.append(describe(START, rig).label)
    assert labels == ["move LIDAR_1", "move LIDAR_1 and LIDAR_2", "move 3 sensors"]


def test_only_edits_of_the_same_numbers_go_on() -> None:
    x, y, z = LIDAR.position
    up = describe(START, changed(position=(x, y, z + 0.1)))
    assert up.continues(describe(START, changed(position=(x, y, z - 0.3))))
    assert not up.continues(describe(START, changed(position=(x + 0.1, y, z))))
    assert not up.continues(describe(START, changed("LIDAR_2", position=(x, y, z))))


def test_switching_and_renaming_never_go_on() -> None:
    off = describe(START, changed(enabled=False))
    assert not off.continues(off)
    named = describe(START, changed(name="top"))
    assert not named.continues(named)
