"""Fields by the paths of the rig file: which number they mean, and what is refused in one line."""

from __future__ import annotations

import math

import pytest

from riglens.core.errors import InputError
from riglens.core.rig.edits import mirrored_pose, with_mirror_image
from riglens.core.rig.model import Camera, Lidar, LinearAngles, Rig
from riglens.core.rig.yaml.file import rig_sha256, valid_rig_sha256
from riglens.core.sweep.fields import field_called, fields_called, with_values

BEAMS = LinearAngles(from_=-15.0, to=15.0, count=16)
RIG = Rig(
    sensors=(
        Lidar(name="top", position=(0.0, 0.0, 1.9), elevations_deg=BEAMS, range_m=(0.5, 100.0)),
        Lidar(name="top.rear", position=(-1.0, 0.4, 1.8), elevations_deg=(-3.0, 0.0, 3.0)),
        Camera(name="front", position=(1.0, 0.0, 1.4), hfov_deg=90.0, image=(160, 90), cast=(16, 9)),
    )
)


@pytest.mark.parametrize(
    ("name", "value", "unit", "read"),
    [
        ("top.z", 2.1, "m", lambda rig: rig.sensor("top").position[2]),
        ("top.pitch", -4.0, "°", lambda rig: rig.sensor("top").rpy_deg[1]),
        ("top.rpy_deg.2", 7.0, "°", lambda rig: rig.sensor("top").rpy_deg[2]),
        ("top.range_m.1", 60.0, "m", lambda rig: rig.sensor("top").range_m[1]),
        ("top.elevations_deg.from", -20.0, "°", lambda rig: rig.sensor("top").elevations_deg.from_),
        ("top.elevations_deg.count", 8.0, "", lambda rig: rig.sensor("top").elevations_deg.count),
        ("top.rear.elevations_deg.0", -5.0, "°", lambda rig: rig.sensor("top.rear").elevations_deg[0]),
        ("front.hfov_deg", 60.0, "°", lambda rig: rig.sensor("front").hfov_deg),
        ("front.enabled", 0.0, "", lambda rig: rig.sensor("front").enabled),
        ("vehicle.height", 1.7, "m", lambda rig: rig.vehicle.height),
    ],
)
def test_a_field_means_one_number(name, value, unit, read):
    field = field_called(RIG, name)
    changed = with_values(RIG, {field: value})
    assert field.unit == unit
    assert read(changed) == value and read(RIG) != value
    assert with_values(changed, {field: read(RIG)}) == RIG
    assert type(read(changed)) is type(read(RIG))


@pytest.mark.parametrize(
    ("name", "part"),
    [
        ("tpo.z", "no sensor 'tpo' (did you mean 'top'?)"),
        ("top.elevation_deg.from", "no field 'elevation_deg' (did you mean 'elevations_deg'?)"),
        ("top.picth", "no field 'picth' (did you mean 'pitch'?)"),
        ("top.position", "must be a number"),
        ("top.position.3", "0 to 2"),
        ("top.z.1", "no field 'z'"),
        ("top.name", "must be a number"),
        ("top", "no sensor 'top'"),
    ],
)
def test_what_is_no_number_is_refused(name, part):
    with pytest.raises(InputError) as caught:
        field_called(RIG, name)
    assert part in str(caught.value)


@pytest.mark.parametrize(
    ("name", "value", "part"),
    [
        ("front.hfov_deg", 400.0, "'front.hfov_deg' cannot be 400: must be"),
        ("top.elevations_deg.count", 2.5, "'top.elevations_deg.count' cannot be 2.5: must be"),
        ("top.range_m.1", 0.1, "min < max"),
        ("vehicle.height", math.inf, "cannot be inf"),
    ],
)
def test_a_value_that_does_not_fit_is_refused(name, value, part):
    with pytest.raises(InputError) as caught:
        with_values(RIG, {field_called(RIG, name): value})
    assert part in str(caught.value)


def test_the_image_of_a_mirror_pair_follows_and_cannot_be_varied_too():
    rig = with_mirror_image(RIG, "top.rear", "image")
    changed = with_values(
        rig, {field_called(rig, "top.rear.y"): 0.7, field_called(rig, "top.rear.yaw"): 20.0}
    )
    assert changed.sensor("image").pose == mirrored_pose(changed.sensor("top.rear").pose)
    with pytest.raises(InputError, match="mirror pair"):
        fields_called(rig, ["image.y", "top.rear.z"])
    with pytest.raises(InputError, match="named twice"):
        fields_called(rig, ["top.z", "top.position.2"])


def test_hashes_in_a_row_are_those_of_each_rig():
    field = field_called(RIG, "top.z")
    rigs = [with_values(RIG, {field: 1.9 + 0.1 * step}) for step in range(4)]
    assert [valid_rig_sha256(rig) for rig in rigs] == [rig_sha256(rig) for rig in rigs]
    assert len({rig_sha256(rig) for rig in rigs}) == 4
