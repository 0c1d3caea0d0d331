"""What a format can say comes back from it: poses always, lenses, rays and the vehicle where it has words for them."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from riglens.core.formats.exchange import FORMATS
from riglens.core.formats.mounts import ReadOptions
from riglens.core.rig.model import BrownConrady, Camera, KannalaBrandt, Lidar, LinearAngles, Rig
from tests.core.formats.cases import (
    POSES,
    VEHICLE,
    Pose,
    assert_same_pose,
    camera,
    lidar,
    read_files,
    report_on,
    rig_of,
    sensor_matrix,
    written,
)

BOTH_WAYS = [name for name, format_ in FORMATS.items() if format_.reads and format_.writes]
NAMES = st.sampled_from(
    ["front", "rear left", "a/b", "ö", 'x"<&>y', "no", "1.5", "it's", "base", "# c", "a: b"]
)
LEVEL: Pose = ((0.5, 0.25, 1.75), (0.0, 0.0, 0.0))


def again(name: str, rig: Rig) -> Rig:
    """The rig after it was written and read, on the same vehicle."""
    return read_files(written(name, rig), name, ReadOptions(vehicle=rig.vehicle)).rig


@pytest.mark.parametrize("name", BOTH_WAYS)
@settings(max_examples=20)
@given(st.lists(st.tuples(NAMES, POSES), min_size=1, max_size=4, unique_by=lambda item: item[0]))
def test_names_and_poses_come_back(name: str, placed: list[tuple[str, Pose]]) -> None:
    makers = (camera, lidar)
    rig = rig_of(*(makers[index % 2](who, pose) for index, (who, pose) in enumerate(placed)))
    back = again(name, rig)
    found = {sensor.name: sensor for sensor in back.sensors}
    for index, sensor in enumerate(rig.sensors):
        if name == "carla-toml" and isinstance(sensor, Lidar):
            continue  # this format numbers LiDARs and has no yaw for them
        assert_same_pose(sensor_matrix(found[sensor.name]), sensor_matrix(sensor))
        assert type(found[sensor.name]) is type(rig.sensors[index])
    assert len(back.sensors) == len(rig.sensors)


@settings(max_examples=20)
@given(POSES)
def test_carla_toml_brings_lidars_back_in_order_but_for_their_yaw(pose: Pose) -> None:
    (x, y, z), (roll, pitch, _) = pose
    level = ((x, y, z), (roll, pitch if abs(pitch) < 89.0 else 0.0, 0.0))
    back = again("carla-toml", rig_of(lidar("a", level), lidar("b", LEVEL)))
    assert [sensor.name for sensor in back.sensors] == ["lidar_0", "lidar_1"]
    assert_same_pose(sensor_matrix(back.sensors[0]), sensor_matrix(lidar("a", level)))


@pytest.mark.parametrize("name", ["autoware", "nuscenes", "driveworks", "urdf"])
def test_a_lens_matrix_comes_back_bit_for_bit(name: str) -> None:
    lens = {"fx": 700.1, "fy": 710.2, "cx": 399.3, "cy": 301.4}
    (back,) = again(name, rig_of(camera("a", LEVEL, **lens))).sensors
    assert isinstance(back, Camera)
    assert back.intrinsics_px() == (700.1, 710.2, 399.3, 301.4)
    assert back.image == (800, 600)


@pytest.mark.parametrize(
    "distortion",
    [
        BrownConrady(k1=-0.3, k2=0.1, p1=1e-4, p2=-2e-4, k3=0.01),
        BrownConrady(k1=0.1, k4=0.02, k6=-0.003),
        KannalaBrandt(k1=0.01, k4=-1e-3),
        KannalaBrandt(),
    ],
)
def test_a_lens_comes_back_from_an_autoware_kit_bit_for_bit(distortion: BrownConrady | KannalaBrandt) -> None:
    lens = {"fx": 400.1, "fy": 400.2, "cx": 399.3, "cy": 301.4, "distortion": distortion}
    (back,) = again("autoware", rig_of(camera("a", LEVEL, **lens))).sensors
    assert isinstance(back, Camera) and back.distortion == distortion


@pytest.mark.parametrize("name", ["carla", "carla-toml", "urdf", "osi"])
def test_a_field_of_view_comes_back(name: str) -> None:
    (back,) = again(name, rig_of(lidar("l", LEVEL), camera("a", LEVEL))).sensors[-1:]
    assert isinstance(back, Camera)
    assert back.hfov_deg == pytest.approx(80.0, abs=1e-12)


@pytest.mark.parametrize("name", ["carla", "carla-toml", "urdf"])
def test_even_beams_azimuths_and_range_come_back(name: str) -> None:
    turn = LinearAngles(from_=-180.0, to=180.0, count=900)
    sent = lidar("l", LEVEL, azimuths_deg=turn, range_m=(0.0, 120.0))
    (back,) = again(name, rig_of(sent)).sensors
    assert isinstance(back, Lidar)
    assert back.elevations() == pytest.approx(sent.elevations(), abs=1e-9)
    assert back.azimuths() == pytest.approx(sent.azimuths(), abs=1e-9)
    assert back.range_m == (0.0, 120.0)


def test_an_endless_range_and_part_of_a_turn_come_back_from_urdf() -> None:
    front = LinearAngles(from_=-60.0, to=60.0, count=240)
    (back,) = again("urdf", rig_of(lidar("l", LEVEL, azimuths_deg=front, range_m=(0.5, math.inf)))).sensors
    assert isinstance(back, Lidar)
    assert back.azimuths() == pytest.approx(front.open_end_deg(), abs=1e-9)
    assert back.range_m == (0.5, math.inf)


def test_driveworks_brings_back_vehicle_library_model_and_radial_distortion() -> None:
    distortion = BrownConrady(k1=-0.1, k2=0.02, k3=0.003)
    lens = {"fx": 700.0, "fy": 700.0, "cx": 400.0, "cy": 300.0, "distortion": distortion}
    rig = rig_of(lidar("l", LEVEL, model="velodyne-vlp-32c"), camera("c", LEVEL, **lens))
    back = read_files(written("driveworks", rig)).rig
    assert back.vehicle == VEHICLE
    one, other = back.sensors
    assert one.model == "velodyne-vlp-32c"
    assert isinstance(other, Camera) and other.distortion == distortion


def test_the_own_format_brings_back_everything() -> None:
    rig = rig_of(lidar("a", LEVEL, enabled=False), camera("b", LEVEL))
    assert again("riglens", rig) == rig


@pytest.mark.parametrize("name", BOTH_WAYS)
def test_a_vehicle_comes_back_or_is_reported_as_lost(name: str) -> None:
    rig = Rig(vehicle=VEHICLE, sensors=(lidar("a", LEVEL), camera("b", LEVEL)))
    back = read_files(written(name, rig), name).rig.vehicle
    sizes, held = ((one.length, one.width, one.height, one.rear_axle_x) for one in (back, VEHICLE))
    if name in ("riglens", "autoware", "driveworks"):
        assert sizes == pytest.approx(held, abs=1e-9)
    else:
        report = report_on(name, rig)
        lost = (*report.of_kind("ignored"), *report.of_kind("approximated"))
        assert any("vehicle" in one.text for one in lost)


@pytest.mark.parametrize("rear_axle_x", [-2.46, 2.46])
def test_an_axle_off_the_vehicle_is_not_written_for_autoware(rear_axle_x: float) -> None:
    rig = Rig(vehicle=VEHICLE.replace(rear_axle_x=rear_axle_x), sensors=(lidar("a", LEVEL),))
    assert not any("vehicle_info" in file for file in written("autoware", rig))
