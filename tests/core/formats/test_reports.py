"""Nothing is dropped in silence: the report says what was read, converted, approximated and left out."""

import json
import math
import re
from pathlib import Path

import numpy as np
import pytest

from riglens.core.errors import InputError
from riglens.core.formats.carla_lidar import rays_to_write
from riglens.core.formats.exchange import read_rig, readable, writable
from riglens.core.formats.mounts import ReadOptions, find_model
from riglens.core.formats.report import KINDS, Notes, Report
from riglens.core.rig.model import BrownConrady, Camera, KannalaBrandt, Lidar, LinearAngles, Vehicle
from tests.core.formats.cases import (
    SMALL,
    VEHICLE,
    Files,
    camera,
    lidar,
    read_files,
    report_on,
    rig_of,
    write_files,
)

LEVEL = ((0.5, 0.25, 1.75), (0.0, 0.0, 0.0))
CAR_SAID = ReadOptions(vehicle=VEHICLE, origin_m=(0.0, 0.0, 0.0))


def has(report: Report, *pieces: str) -> bool:
    """Whether one line of the report holds all the pieces."""
    return any(all(piece in line for piece in pieces) for line in report.lines())


def test_remarks_with_the_same_text_become_one_and_name_all_of_its_parts() -> None:
    notes = Notes()
    for name in ("a", "b", "c", "d", "e", "f"):
        notes.ignored("no place for it", name)
    notes.read("everything")
    notes.ignored("no place for it", "a")
    notes.approximated("a sedan", field="vehicle")
    assert notes.report("X").lines() == [
        "read: everything",
        "approximated: a sedan; vehicle changes it",
        "ignored: no place for it (a, b, c, d, e, f)",
    ]
    (left_out,) = notes.report("X").of_kind("ignored")
    assert left_out.folded() == "no place for it (a, b, c, d …: all 6 are in the details)"
    assert notes.report("X").text().splitlines()[-7:] == [
        "  no place for it",
        *(f"    {name}" for name in "abcdef"),
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
        (SMALL["nuscenes"], ("read", "continental-ars408-21", "RADAR_FRONT")),
        (SMALL["nuscenes"], ("approximated", "1600 x 900", "CAM_FRONT")),
        (SMALL["nuscenes"], ("converted", "rear axle on the ground", "-1.35 0 0")),
        (SMALL["autoware"], ("ignored", "gnss_link")),
        (SMALL["autoware"], ("approximated", "base of the LiDAR", "velodyne_top_base_link")),
        (SMALL["autoware"], ("approximated", "70 degrees wide", "camera0")),
        (SMALL["urdf"], ("approximated", "movable joint", "(l)")),
        (SMALL["urdf"], ("read", "same branch", "camera_link")),
        (SMALL["urdf"], ("ignored", "meshes")),
        (SMALL["urdf"], ("ignored", "suggest no sensor", "mount")),
        (SMALL["carla"], ("ignored", "(imu)")),
        (SMALL["carla"], ("ignored", "not the vehicle", "map")),
        (SMALL["carla-toml"], ("converted", "left-handed", "change sign")),
        (SMALL["carla-toml"], ("read", "radians")),
        (SMALL["driveworks"], ("converted", "corrections of the calibration", "camera:front")),
        (SMALL["driveworks"], ("approximated", "Kannala-Brandt", "camera:front")),
        (SMALL["driveworks"], ("read", "velodyne-vlp-16", "lidar:top")),
        (SMALL["driveworks"], ("ignored", "(can)")),
        (SMALL["pandaset"], ("approximated", "position of the Pandar64", "0 0 2 m")),
        (SMALL["pandaset"], ("read", "lens distortion", "front_camera")),
        (SMALL["kalibr"], ("approximated", "IMU's axes")),
        (SMALL["kitti"], ("approximated", "1242 x 375", "cam0")),
        (SMALL["kitti"], ("ignored", "IMU", "Tr_imu_to_velo")),
        (SMALL["kitti-raw"], ("read", "lens distortion", "cam0")),
    ],
)
def test_an_import_names_what_it_changed(files: Files, pieces: tuple[str, ...]) -> None:
    assert has(read_files(files).report, *pieces)


@pytest.mark.parametrize("case", SMALL)
def test_what_the_user_said_is_not_called_approximated(case: str) -> None:
    lines = " ".join(read_files(SMALL[case], options=CAR_SAID).report.lines())
    assert not any(f"; {field} changes it" in lines for field in ("vehicle", "origin_m", "rear_axle_x"))


@pytest.mark.parametrize("name", [name for name in writable() if name != "riglens"])
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
    report = report_on(name, rig)
    assert has(report, "ignored", "lens distortion", "bent") == (name not in ("autoware", "urdf"))
    assert has(report, "ignored", "disabled", "off")
    assert has(report, "ignored", "mirror pair", "right")
    assert has(report, "written", "left")
    assert any(remark.kind == "written" and "bent" in remark.about for remark in report.remarks)
    assert any(
        "uneven" in remark.about for remark in report.remarks if remark.kind in ("approximated", "ignored")
    )


def test_lenses_come_in_with_their_distortion() -> None:
    one, other = read_files(SMALL["kalibr"]).rig.enabled_cameras()
    assert one.distortion == BrownConrady(k1=-0.28, k2=0.07, p1=0.0002, p2=0.00002)
    assert other.distortion == KannalaBrandt(k1=0.01, k2=-0.02, k3=0.003, k4=0.0)
    (front,) = read_files(SMALL["pandaset"]).rig.enabled_cameras()
    assert front.distortion == BrownConrady(k1=-0.5894, k2=0.66, p1=0.0011, p2=-0.001, k3=-1.0088)
    cam1 = read_files(SMALL["kitti-raw"]).rig.sensor("cam1")
    assert isinstance(cam1, Camera) and cam1.distortion is None


def test_an_f_theta_lens_keeps_the_angle_of_every_pixel() -> None:
    """The polynomial of the file at a pixel, and the angle of the ray that the camera casts there."""
    front = read_files(SMALL["driveworks"]).rig.sensor("camera:front")
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
        ("rsbp_left", "robosense-bpearl"),
        ("rs16_top", "robosense-rs-lidar-16"),
        ("helios_front", "robosense-helios-5515"),
        ("Helios-1615", "robosense-helios-1615"),
        ("lidar_top", None),
        ("velodyne_top", None),
    ],
)
def test_lidar_models_are_found_by_their_product_names(words: str, model: str | None) -> None:
    found = find_model(words)
    assert (found.name if found else None) == model


def test_a_vehicle_is_what_the_user_says_then_what_the_file_says() -> None:
    assert read_files(SMALL["driveworks"]).rig.vehicle == Vehicle(
        length=4.872, width=1.852, height=1.473, rear_axle_x=-1.327
    )
    assert read_files(SMALL["driveworks"], options=ReadOptions(vehicle=VEHICLE)).rig.vehicle == VEHICLE
    moved = read_files(SMALL["driveworks"], options=ReadOptions(rear_axle_x=-1.0)).rig
    assert moved.vehicle.rear_axle_x == -1.0 and moved.sensor("lidar:top").position == (0.0, 0.0, 2.0)


def test_carla_beams_and_turns_are_counted_as_carla_does() -> None:
    found = read_files(SMALL["carla"]).rig.sensor("lidar")
    assert isinstance(found, Lidar)
    assert found.elevations_deg == LinearAngles(from_=-26.8, to=2.0, count=32)
    assert found.azimuths().size == 320_000 / (20 * 32) and found.range_m == (0.0, 50.0)


def test_the_list_of_formats_is_the_documented_one() -> None:
    page = (Path(__file__).parents[3] / "docs" / "formats-exchange.md").read_text(encoding="utf-8")
    read, axes = (
        dict(re.findall(r"^\| `([a-z0-9-]+)` \|.*\|(.*)\|$", part, re.MULTILINE))
        for part in page.split("\n## ")[:2]
    )
    assert read.keys() == axes.keys() == set(readable())
    assert {name for name, written in read.items() if written.strip()} == set(writable())


def test_what_pandaset_files_lack_is_told_of_each_sensor() -> None:
    calibration = SMALL["pandaset"]["calibration.yaml"]
    files = {"calibration.yaml": calibration.replace("main_pandar64", "front_gt")}
    report = read_files(files, "pandaset").report
    assert has(report, "approximated", "image size not in the file: 1920 x 1080 pixels", "(front_camera)")
    assert has(report, "converted", "its own x right and y forward", "(front_gt)")


def test_unknown_types_and_single_beams_of_carla_are_told() -> None:
    lidar = {"type": "sensor.lidar.hss", "id": "l", "channels": 1, "lower_fov": -30.0, "upper_fov": 10.0}
    odd = {"type": "sensor.camera.x_ray", "id": "c", "image_size_x": 800, "image_size_y": 600}
    gnss = {"type": "sensor.other.gnss", "id": "g"}
    ego = {"type": "vehicle.tesla.model3", "id": "ego", "sensors": [lidar, odd, gnss]}
    read = read_files({"objects.json": json.dumps({"objects": [ego]})}, "carla")
    assert has(read.report, "approximated", "unknown type 'sensor.lidar.hss'", "(l)")
    assert has(read.report, "approximated", "unknown type 'sensor.camera.x_ray'", "(c)")
    assert has(read.report, "ignored", "neither camera nor LiDAR: sensor.other.gnss")
    assert has(read.report, "read", "one beam, which CARLA casts at upper_fov", "(l)")
    (found,) = read.rig.enabled_lidars()
    assert found.elevations().tolist() == [10.0]


RECTIFIED = """\
S_02: 1392 512
R_rect_00: 1 0 0 0 1 0 0 0 1
S_rect_02: 1242 375
P_rect_02: 721.5 0 609.6 44.86 0 721.5 172.9 0.2 0 0 1 0.003
P_rect_03: 721.5 0 609.6 -339.5 0 721.5 172.9 2.2 0 0 1 0.003
"""


def test_a_raw_drive_with_rectified_projections_alone_is_read() -> None:
    files = {
        "calib_cam_to_cam.txt": RECTIFIED,
        "calib_velo_to_cam.txt": SMALL["kitti-raw"]["calib_velo_to_cam.txt"],
    }
    read = read_files(files)
    assert [sensor.name for sensor in read.rig.sensors] == ["cam2", "cam3", "velodyne"]
    left, right = read.rig.enabled_cameras()
    assert (left.fx, left.image) == (721.5, (1242, 375))
    apart = np.linalg.norm(np.subtract(left.position, right.position))
    assert apart == pytest.approx((44.86 + 339.5) / 721.5, abs=0.005)  # the published stereo basis, 0.53 m
    assert has(read.report, "approximated", "K_02 not in the file: the rectified camera of P_rect_02")
    assert has(read.report, "approximated", "image size not in the file", "(cam3)")


def test_a_raw_drive_without_any_camera_says_so() -> None:
    files = {
        "calib_cam_to_cam.txt": "calib_time: 1\n",
        "calib_velo_to_cam.txt": SMALL["kitti-raw"]["calib_velo_to_cam.txt"],
    }
    assert has(read_files(files).report, "ignored", "no camera in it")


def tables(channels: tuple[str, str], size: tuple[int, int] | None) -> dict[str, str]:
    """The tables of a car with one LiDAR and one camera."""
    lidar_name, camera_name = channels
    sensor = [
        {"token": "s1", "channel": camera_name, "modality": "camera"},
        {"token": "s2", "channel": lidar_name, "modality": "lidar"},
    ]
    k = [[900.0, 0, 500], [0, 900.0, 300], [0, 0, 1]]
    common = {"translation": [0, 0, 1], "rotation": [1, 0, 0, 0]}
    calibrated = [
        {"token": "c1", "sensor_token": "s1", "camera_intrinsic": k} | common,
        {"token": "c2", "sensor_token": "s2", "camera_intrinsic": []} | common,
    ]
    files = {"sensor.json": json.dumps(sensor), "calibrated_sensor.json": json.dumps(calibrated)}
    if size is not None:
        rows = [
            {"calibrated_sensor_token": "c2", "width": 0, "height": 0},
            {"calibrated_sensor_token": "c1", "width": size[0], "height": size[1]},
        ]
        files["sample_data.json"] = json.dumps(rows)
    return files


def test_image_sizes_of_other_cars_are_those_of_sample_data() -> None:
    read = read_files(tables(("LIDAR_TOP", "CAM_FRONT"), (1920, 1080)))
    (found,) = read.rig.enabled_cameras()
    assert found.image == (1920, 1080) and not has(read.report, "image size not in the file")
    assert has(read_files(tables(("LIDAR_TOP", "CAM_FRONT"), None)).report, "image size not in the file")


@pytest.mark.parametrize(
    ("channels", "size", "model"),
    [
        (("LIDAR_TOP", "CAM_FRONT"), None, "nuscenes-lidar-top"),
        (("LIDAR_TOP", "CAM_FRONT"), (1600, 900), "nuscenes-lidar-top"),
        (("LIDAR_TOP", "CAM_FRONT"), (1920, 1080), "generic-16"),
        (("LIDAR_LEFT", "CAM_FRONT"), None, "generic-16"),
        (("LIDAR_TOP", "CAMERA_LEFT_FRONT"), None, "generic-16"),
    ],
)
def test_only_the_car_of_nuscenes_has_its_lidar(
    channels: tuple[str, str], size: tuple[int, int] | None, model: str
) -> None:
    read = read_files(tables(channels, size))
    assert read.rig.enabled_lidars()[0].model == model
    assert has(read.report, "unknown beams", "assumed those of generic-16", channels[0]) == (
        model == "generic-16"
    )


@pytest.mark.parametrize("inner", ["v1.0-mini", "v1.01-train", "data/v1.0-trainval"])
def test_tables_in_a_folder_inside_are_found(tmp_path: Path, inner: str) -> None:
    write_files(tmp_path / inner, tables(("LIDAR_TOP", "CAM_FRONT"), None))
    assert len(read_rig(tmp_path).rig.sensors) == 2


def test_a_folder_with_one_of_the_tables_says_which_is_missing(tmp_path: Path) -> None:
    files = tables(("LIDAR_TOP", "CAM_FRONT"), None)
    write_files(tmp_path, {"calibrated_sensor.json": files["calibrated_sensor.json"]})
    with pytest.raises(InputError, match=r"sensor\.json is missing in it: calibrated_sensor and sensor"):
        read_rig(tmp_path)


@pytest.mark.parametrize("high_m", [80.0, math.inf])
def test_a_range_without_end_is_all_that_carla_approximates(high_m: float) -> None:
    notes = Notes()
    rays_to_write(lidar("roof", LEVEL).replace(range_m=(0.0, high_m)), notes)
    assert has(notes.report("CARLA"), "no largest range") == math.isinf(high_m)
