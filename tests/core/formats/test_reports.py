"""Nothing is dropped in silence: the report says what was read, converted, approximated and left out."""

import pytest

from riglens.core.formats.exchange import FORMATS, READABLE, WRITABLE
from riglens.core.formats.mounts import ReadOptions, find_lidar_model
from riglens.core.formats.report import KINDS, Notes, Report
from riglens.core.rig.model import BrownConrady, Camera, EvenAngles, KannalaBrandt, Lidar, Rig, Vehicle
from tests.core.formats.cases import (
    AUTOWARE_KIT,
    CARLA,
    CARLA_TOML,
    DRIVEWORKS,
    KALIBR,
    KITTI,
    KITTI_RAW,
    NUSCENES,
    PANDASET,
    SMALL,
    URDF,
    VEHICLE,
    Files,
    camera,
    lidar,
    read_files,
    rig_of,
)

LEVEL = ((0.5, 0.25, 1.75), (0.0, 0.0, 0.0))
CAR_SAID = ReadOptions(vehicle=VEHICLE, origin_m=(0.0, 0.0, 0.0))


def written(name: str, rig: Rig) -> Report:
    """What is said about writing a rig."""
    write = FORMATS[name].write
    assert write is not None
    return write(rig).report


def has(report: Report, *pieces: str) -> bool:
    """Whether one line of the report holds all the pieces."""
    return any(all(piece in line for piece in pieces) for line in report.lines())


def test_remarks_with_the_same_text_become_one_and_name_only_a_few_parts() -> None:
    notes = Notes()
    for name in ("a", "b", "c", "d", "e", "f"):
        notes.ignored("no place for it", name)
    notes.read("everything")
    notes.ignored("no place for it", "a")
    notes.approximated("a sedan", option="--vehicle")
    assert notes.report("X").lines() == [
        "read: everything",
        "approximated: a sedan; --vehicle changes it",
        "ignored: no place for it (a, b, c, d and 2 more)",
    ]


@pytest.mark.parametrize("case", SMALL)
def test_every_import_says_what_it_read_and_where_the_origin_is(case: str) -> None:
    report = read_files(SMALL[case]).report
    assert report.of_kind("read") and report.of_kind("converted")
    assert [remark.kind for remark in report.remarks] == sorted(
        (remark.kind for remark in report.remarks), key=KINDS.index
    )
    assert all(line.isprintable() for line in report.lines())


@pytest.mark.parametrize(
    ("files", "pieces"),
    [
        (NUSCENES, ("ignored", "RADAR_FRONT")),
        (NUSCENES, ("approximated", "1600 x 900", "CAM_FRONT")),
        (NUSCENES, ("converted", "rear axle on the ground", "-1.35 0 0")),
        (AUTOWARE_KIT, ("ignored", "gnss_link")),
        (AUTOWARE_KIT, ("approximated", "base of the LiDAR", "velodyne_top_base_link")),
        (AUTOWARE_KIT, ("approximated", "70 degrees wide", "camera0/camera_link")),
        (URDF, ("approximated", "movable joint", "(l)")),
        (URDF, ("read", "same branch", "camera_link")),
        (URDF, ("ignored", "meshes")),
        (URDF, ("ignored", "neither camera nor LiDAR", "mount")),
        (CARLA, ("ignored", "(imu)")),
        (CARLA, ("ignored", "not the vehicle", "map")),
        (CARLA_TOML, ("converted", "left-handed", "change sign")),
        (CARLA_TOML, ("read", "radians")),
        (DRIVEWORKS, ("converted", "corrections of the calibration", "camera:front")),
        (DRIVEWORKS, ("approximated", "Kannala-Brandt", "camera:front")),
        (DRIVEWORKS, ("read", "velodyne-vlp-16", "lidar:top")),
        (DRIVEWORKS, ("ignored", "(can)")),
        (PANDASET, ("approximated", "where the Pandar64 stands", "0 0 2 m")),
        (PANDASET, ("read", "lens distortion", "front_camera")),
        (KALIBR, ("approximated", "IMU's axes")),
        (KITTI, ("approximated", "1242 x 375", "cam0")),
        (KITTI, ("ignored", "IMU", "Tr_imu_to_velo")),
        (KITTI_RAW, ("read", "lens distortion", "cam0")),
    ],
)
def test_an_import_names_what_it_changed(files: Files, pieces: tuple[str, ...]) -> None:
    assert has(read_files(files).report, *pieces)


@pytest.mark.parametrize("case", SMALL)
def test_what_the_user_said_is_not_called_approximated(case: str) -> None:
    lines = " ".join(read_files(SMALL[case], options=CAR_SAID).report.lines())
    assert "--vehicle" not in lines and "--origin" not in lines and "--rear-axle-x" not in lines


@pytest.mark.parametrize("name", [name for name in WRITABLE if name != "riglens"])
def test_every_export_says_what_it_leaves_out(name: str) -> None:
    distortion = BrownConrady(k1=0.1, p1=0.01)
    lens = {"fx": 700.0, "fy": 710.0, "cx": 390.0, "cy": 300.0, "distortion": distortion}
    rig = rig_of(
        camera("bent", LEVEL, **lens),
        lidar("uneven", LEVEL, elevations_deg=(-3.0, 0.0, 9.0), azimuth_offsets_deg=(0.0, 1.0, 2.0)),
        lidar("left", LEVEL, model="velodyne-vlp-16", range_m=(0.5, 90.0)),
        lidar("right", LEVEL, mirror_of="left"),
        lidar("off", LEVEL, enabled=False),
    )
    report = written(name, rig)
    assert has(report, "ignored", "lens distortion", "bent")
    assert has(report, "ignored", "switched off", "off")
    assert has(report, "ignored", "mirror pair", "right")
    assert has(report, "written", "left")
    assert any(
        "uneven" in remark.about for remark in report.remarks if remark.kind in ("approximated", "ignored")
    )


def test_lenses_come_in_with_their_distortion() -> None:
    one, other = read_files(KALIBR).rig.cameras()
    assert one.distortion == BrownConrady(k1=-0.28, k2=0.07, p1=0.0002, p2=0.00002)
    assert other.distortion == KannalaBrandt(k1=0.01, k2=-0.02, k3=0.003, k4=0.0)
    (front,) = read_files(PANDASET).rig.cameras()
    assert front.distortion == BrownConrady(k1=-0.5894, k2=0.66, p1=0.0011, p2=-0.001, k3=-1.0088)
    assert read_files(KITTI_RAW).rig.sensor("cam1").distortion is None


def test_an_f_theta_lens_keeps_the_angle_of_every_pixel() -> None:
    """The polynomial of the file at a pixel, and the angle of the ray that the camera casts there."""
    front = read_files(DRIVEWORKS).rig.sensor("camera:front")
    assert isinstance(front, Camera) and isinstance(front.distortion, KannalaBrandt)
    bend = front.distortion
    for distance_px in (50.0, 400.0, 900.0, 1130.0):
        angle = 0.000545421498827636 * distance_px - 1.6e-10 * distance_px**2
        angle += -4.6e-12 * distance_px**3 + 2.8e-16 * distance_px**4
        powers = (angle ** (2 * k + 3) for k in range(4))
        bent = angle + sum(k * p for k, p in zip((bend.k1, bend.k2, bend.k3, bend.k4), powers, strict=True))
        assert front.intrinsics_px()[0] * bent == pytest.approx(distance_px, abs=0.05)


@pytest.mark.parametrize(
    ("words", "model"),
    [
        ("VELO_VLP16", "velodyne-vlp-16"),
        ("VELO_VLP32C", "velodyne-vlp-32c"),
        ("Hesai Pandar64", "hesai-pandar64"),
        ("velodyne-vlp-16", "velodyne-vlp-16"),
        ("OUSTER_OS1_128", "ouster-os1-128"),
        ("lidar_top", None),
        ("velodyne_top", None),
    ],
)
def test_lidar_models_are_found_by_their_product_names(words: str, model: str | None) -> None:
    found = find_lidar_model(words)
    assert (found.name if found else None) == model


def test_a_vehicle_is_what_the_user_says_then_what_the_file_says() -> None:
    assert read_files(DRIVEWORKS).rig.vehicle == Vehicle(
        length=4.872, width=1.852, height=1.473, rear_axle_x=-1.327
    )
    assert read_files(DRIVEWORKS, options=ReadOptions(vehicle=VEHICLE)).rig.vehicle == VEHICLE
    moved = read_files(DRIVEWORKS, options=ReadOptions(rear_axle_x=-1.0)).rig
    assert moved.vehicle.rear_axle_x == -1.0 and moved.sensor("lidar:top").position == (0.0, 0.0, 2.0)


def test_carla_beams_and_turns_are_counted_as_carla_does() -> None:
    found = read_files(CARLA).rig.sensor("lidar")
    assert isinstance(found, Lidar)
    assert found.elevations_deg == EvenAngles(from_=-26.8, to=2.0, count=32)
    assert found.azimuths().size == 320_000 / (20 * 32) and found.range_m == (0.0, 50.0)


def test_the_list_of_formats_is_the_documented_one() -> None:
    both = ["riglens", "nuscenes", "autoware", "urdf", "carla", "carla-toml", "driveworks"]
    assert list(READABLE) == [*both, "pandaset", "argoverse", "kalibr", "opencv", "kitti", "carla-agent"]
    assert list(WRITABLE) == [*both, "osi"]
