"""DriveWorks rigs: where the rear axle is, how wide the car is, and names by file."""

import json
from pathlib import Path

import pytest

from riglens.core.formats.exchange import read_rig
from riglens.core.rig.model import Rig
from tests.core.formats.cases import read_files, write_files
from tests.core.formats.test_reports import has

POSE = {"roll-pitch-yaw": [0.0, 0.0, 0.0], "t": [1.0, 0.0, 2.0]}
SENSOR = {"name": "top", "protocol": "lidar.custom", "nominalSensor2Rig_FLU": POSE, "parameter": ""}
BODY = {"length": 4.9, "width": 2.1, "widthWithoutMirrors": 1.87, "height": 1.5}


def text_of(vehicle: object) -> str:
    return json.dumps(
        {"rig": {"sensors": [SENSOR], "vehicle": {"valid": True, "value": vehicle}}, "version": 7}
    )


@pytest.mark.parametrize("box", [[-1.127, 0.0, 0.0], {"x": -1.127, "y": 0.0, "z": 0.0}])
def test_the_rear_axle_follows_from_the_box_of_the_body(box: object) -> None:
    """The box starts 1.127 m behind the axle and is 4.9 m long: its middle is 1.323 m before the axle."""
    imported = read_files({"car.json": text_of({"body": BODY | {"boundingBoxPosition": box}})})
    assert imported.rig.vehicle.rear_axle_x == pytest.approx(1.127 - 2.45)
    assert imported.rig.sensors[0].position == pytest.approx((1.0 + 1.127 - 2.45, 0.0, 2.0))
    assert has(imported.report, "converted", "boundingBoxPosition", "-1.323 m")
    assert not has(imported.report, "rear_axle_x")


def test_the_body_is_as_wide_as_without_mirrors() -> None:
    imported = read_files({"car.json": text_of({"body": BODY})})
    assert imported.rig.vehicle.width == 1.87
    assert has(imported.report, "converted", "width without mirrors: 1.87 m, 2.1 m with them")
    assert has(imported.report, "approximated", "rear axle at x = -1.35 m")
    plain = {key: value for key, value in BODY.items() if key != "widthWithoutMirrors"}
    assert read_files({"car.json": text_of({"body": plain})}).rig.vehicle.width == 2.1
    zero = read_files({"car.json": text_of({"body": BODY | {"widthWithoutMirrors": 0.0}})})
    assert zero.rig.vehicle.width == 2.1


def test_bumper_rear_comes_before_the_box_and_a_box_beside_the_axis_is_told() -> None:
    both = BODY | {"boundingBoxPosition": [-1.127, 0.1, 0.0]}
    imported = read_files({"car.json": text_of(both | {"bumperRear": 1.0})})
    assert imported.rig.vehicle.rear_axle_x == pytest.approx(1.0 - 2.45)
    assert has(read_files({"car.json": text_of({"body": both})}).report, "ignored", "0.1 m off")


@pytest.mark.parametrize(
    ("file", "name"),
    [("front.v2.json", "front.v2"), ("rig.json", "car7 rig"), ("hyperion.json", "hyperion")],
)
def test_rigs_are_named_by_their_file(tmp_path: Path, file: str, name: str) -> None:
    write_files(tmp_path / "car7", {file: text_of({"body": BODY})})
    rig: Rig = read_rig(tmp_path / "car7" / file).rig
    assert rig.name == name
