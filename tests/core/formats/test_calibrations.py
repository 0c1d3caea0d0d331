"""Calibrations of vision and driving research: poses by SciPy from each convention, fitted lenses, refusals."""

import json
import textwrap
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from riglens.core.errors import InputError
from riglens.core.formats.exchange import read_rig
from riglens.core.formats.mounts import ReadOptions
from riglens.core.rig.model import BrownConrady, Camera, KannalaBrandt, Lidar
from tests.core.formats.cases import (
    OPTICAL_IN_BODY,
    SMALL,
    VEHICLE,
    Files,
    assert_same_pose,
    optical,
    read_files,
    sensor_matrix,
    transform,
    write_files,
)
from tests.core.formats.test_reports import has

AT_ORIGIN = ReadOptions(vehicle=VEHICLE, origin_m=(0.0, 0.0, 0.0))
LEVEL = Rotation.identity()


def poses(files: Files, options: ReadOptions = AT_ORIGIN) -> dict[str, np.ndarray]:
    return {sensor.name: sensor_matrix(sensor) for sensor in read_files(files, options=options).rig.sensors}


def test_kimera_and_maplab_place_cameras_and_lidars_by_their_matrices() -> None:
    found = poses(SMALL["euroc"])
    assert_same_pose(found["left_cam"], transform(LEVEL, (0.3, 0.05, 0.2)))
    assert_same_pose(found["right_cam"], transform(LEVEL, (0.3, -0.05, 0.2)))
    imported = read_files(SMALL["euroc-raw"], options=AT_ORIGIN)
    camera, lidar = imported.rig.sensors
    assert_same_pose(sensor_matrix(camera), transform(LEVEL, (0.8, 0.1, 0.2)))
    assert_same_pose(sensor_matrix(lidar), transform(LEVEL, (0.0, 0.0, 0.7)))
    assert isinstance(camera, Camera) and camera.distortion == KannalaBrandt(
        k1=0.01, k2=0.02, k3=-0.03, k4=0.01
    )
    assert camera.name == "cam0" and isinstance(lidar, Lidar) and lidar.name == "os0_128"
    assert has(imported.report, "ignored", "neither camera nor LiDAR: IMU")
    listed = textwrap.dedent(
        "    cameras:"
        + SMALL["euroc-raw"]["sensors.yaml"].partition("cameras:")[2].partition("  - {id: c0")[0]
    )
    (camera,) = read_files({"ncamera.yaml": listed}, options=AT_ORIGIN).rig.sensors
    assert_same_pose(sensor_matrix(camera), transform(LEVEL, (0.3, 0.1, 0.2)))


def test_a_folder_of_euroc_names_cameras_by_their_folders(tmp_path: Path) -> None:
    for name, text in zip(("cam0", "cam1"), SMALL["euroc"].values(), strict=True):
        write_files(tmp_path / "mav0" / name, {"sensor.yaml": text.replace("camera_id", "comment")})
    write_files(tmp_path / "mav0" / "imu0", {"sensor.yaml": "T_BS: {data: [1]}\nrate_hz: 200\n"})
    for path in (tmp_path, tmp_path / "mav0"):
        assert [sensor.name for sensor in read_rig(path).rig.sensors] == ["cam0", "cam1"]
    assert read_rig(tmp_path / "mav0" / "cam1" / "sensor.yaml").rig.sensors[0].name == "cam1"


def test_fast_livo_places_the_camera_through_the_lidar(tmp_path: Path) -> None:
    imported = read_files(SMALL["fast-livo"], options=AT_ORIGIN)
    camera, lidar = imported.rig.sensors
    lidar_in_imu = transform(LEVEL, (0.04, 0.02, -0.03))
    camera_T_lidar = transform(OPTICAL_IN_BODY.inv(), (0.02, 0.1, -0.03))
    assert_same_pose(sensor_matrix(lidar), lidar_in_imu)
    assert_same_pose(optical(sensor_matrix(camera)), lidar_in_imu @ np.linalg.inv(camera_T_lidar))
    assert lidar.model == "hesai-xt32" and has(
        imported.report, "approximated", "lens and image not in one file"
    )
    lens = "cam_model: Pinhole\ncam_width: 640\ncam_height: 512\nscale: 0.5\ncam_fx: 400\ncam_fy: 401\ncam_cx: 320\n"
    other = (
        lens.replace("640", "720").replace("Pinhole", "EquidistantCamera") + "k1: 0.1\nk2: 0\nk3: 0\nk4: 0\n"
    )
    write_files(tmp_path, {**SMALL["fast-livo"], "camera_pinhole.yaml": f"{lens}cam_cy: 256\ncam_d0: -0.1\n"})
    (camera, _) = read_rig(tmp_path / "avia.yaml").rig.sensors
    assert isinstance(camera, Camera) and (camera.image, camera.fy) == ((640, 512), 401.0)
    assert camera.distortion == BrownConrady(k1=-0.1)
    write_files(tmp_path, {"camera_fisheye_avia.yaml": f"{other}cam_cy: 256\n"})
    (camera, _) = read_rig(tmp_path / "avia.yaml").rig.sensors
    assert isinstance(camera, Camera) and camera.image == (720, 512)
    assert camera.distortion == KannalaBrandt(k1=0.1)


def test_fast_livo_of_ros_2_is_the_same_with_its_camera_beside_or_inside(tmp_path: Path) -> None:
    lens = "cam_model: Pinhole\ncam_width: 640\ncam_height: 512\ncam_fx: 400\ncam_fy: 401\ncam_cx: 320\ncam_cy: 256\n"
    plain = {**SMALL["fast-livo"], "camera_avia.yaml": lens}
    nodes = {
        name: f"/**:\n  ros__parameters:\n{textwrap.indent(text, '    ')}" for name, text in plain.items()
    }
    inside = {"avia.yaml": SMALL["fast-livo"]["avia.yaml"] + lens}
    expected, *others = (
        read_rig(write_files(tmp_path / str(number), files) / "avia.yaml", options=AT_ORIGIN).rig.sensors
        for number, files in enumerate((plain, nodes, inside))
    )
    assert isinstance(expected[0], Camera) and expected[0].image == (640, 512)
    assert all(sensors == expected for sensors in others)


def test_apollo_chains_frames_with_x_right_and_y_forward(tmp_path: Path) -> None:
    root = transform(Rotation.from_euler("z", -90.0, degrees=True), (0.0, 0.0, 0.0))
    lidar = root @ transform(Rotation.from_euler("z", 90.0, degrees=True), (-0.1, 1.2, 1.8))
    camera = lidar @ transform(Rotation.from_quat((-0.5, 0.5, -0.5, 0.5)), (0.6, 0.1, -0.2))
    found = poses(SMALL["apollo"])
    assert_same_pose(found["lidar64"], lidar)
    assert_same_pose(optical(found["front_6mm"]), camera)
    np.testing.assert_allclose(found["lidar64"][:3, 3], (1.2, 0.1, 1.8), atol=1e-12)
    for name, text in SMALL["apollo"].items():
        write_files(tmp_path / f"{'velodyne' if 'novatel' in name else 'camera'}_params", {name: text})
    radar = SMALL["apollo"]["front_6mm_extrinsics.yaml"].replace("front_6mm", "ahead")
    write_files(tmp_path / "radar_params", {"ahead_extrinsics.yaml": radar})
    for path in (tmp_path, tmp_path / "camera_params" / "front_6mm_extrinsics.yaml"):
        imported = read_rig(path, options=AT_ORIGIN)
        assert {s.name: s.kind for s in imported.rig.sensors} == {"front_6mm": "camera", "lidar64": "lidar"}
        assert has(imported.report, "ignored", "judging by its folder", "ahead")


def test_a_file_of_apollo_without_a_transform_leaves_the_others(tmp_path: Path) -> None:
    write_files(tmp_path, {**SMALL["apollo"], "a_imu_extrinsics.yaml": " \n"})
    imported = read_rig(tmp_path, options=AT_ORIGIN)
    assert imported.rig == read_files(SMALL["apollo"], options=AT_ORIGIN).rig.replace(name=imported.rig.name)
    assert has(imported.report, "ignored", "it does not name its frames", "a_imu_extrinsics.yaml")


def test_boreas_and_kitti_360_lead_through_the_lidar_and_the_imu() -> None:
    found = poses(SMALL["boreas"])
    assert_same_pose(found["lidar"], transform(LEVEL, (0.2, 0.0, 0.45)))
    camera_T_lidar = transform(OPTICAL_IN_BODY.inv(), (-0.04, -0.8, -0.2))
    assert_same_pose(optical(found["camera"]), found["lidar"] @ np.linalg.inv(camera_T_lidar))
    found = poses(SMALL["kitti-360"])
    assert_same_pose(found["image_00"], transform(LEVEL, (1.5, 0.3, 1.1)))
    assert_same_pose(
        found["image_02"], transform(Rotation.from_euler("z", 90.0, degrees=True), (0.7, 0.15, 1.07))
    )
    lens = "S_rect_00: 1408 376\nR_rect_00: 0 -1 0 1 0 0 0 0 1\nP_rect_00: 552 0 682 0 0 553 238 0 0 0 1 0\n"
    rectified = read_files({**SMALL["kitti-360"], "perspective.txt": lens}, options=AT_ORIGIN).rig.sensor(
        "image_00"
    )
    assert isinstance(rectified, Camera) and (rectified.image, rectified.fy) == ((1408, 376), 553.0)
    turn = transform(Rotation.from_euler("z", 90.0, degrees=True), (0.0, 0.0, 0.0))
    assert_same_pose(optical(sensor_matrix(rectified)), optical(found["image_00"]) @ np.linalg.inv(turn))
    velo_T_camera = transform(OPTICAL_IN_BODY, (0.75, 0.05, -0.3))
    assert_same_pose(found["velodyne"], optical(found["image_00"]) @ np.linalg.inv(velo_T_camera))


def test_airsim_has_y_right_and_z_down() -> None:
    imported = read_files(SMALL["airsim"], options=AT_ORIGIN)
    camera, lidar = imported.rig.sensors
    ned = Rotation.from_euler("ZYX", (30.0, 10.0, 0.0), degrees=True)
    flip = np.diag([1.0, -1.0, -1.0])
    expected = transform(Rotation.from_matrix(flip @ ned.as_matrix() @ flip), (1.0, -0.5, 1.5))
    assert_same_pose(sensor_matrix(camera), expected)
    assert isinstance(camera, Camera) and (camera.image, camera.hfov_deg) == ((640, 480), 100.0)
    assert isinstance(lidar, Lidar) and lidar.range_m == (0.0, 80.0) and lidar.position[2] == 2.0
    azimuths, beams = lidar.azimuths(), lidar.elevations()
    assert (beams[0], beams[-1], len(beams), len(azimuths)) == (-25.0, 15.0, 16, 1000)
    assert azimuths[0] == -90.0 and 19.0 < azimuths[-1] < 20.0
    with pytest.raises(InputError, match="must be the name of a vehicle"):
        read_files(SMALL["airsim"], options=ReadOptions(token="Car3"))


def test_mmdet3d_leads_to_the_ego_frame_directly_or_through_the_lidar() -> None:
    found = poses(SMALL["mmdet3d"])
    info = json.loads(SMALL["mmdet3d"]["infos.json"])["data_list"][0]
    lidar = np.array(info["lidar_points"]["lidar2ego"], dtype=float)
    assert_same_pose(found["lidar"], lidar)
    assert_same_pose(
        optical(found["CAM_FRONT"]), np.array(info["images"]["CAM_FRONT"]["cam2ego"], dtype=float)
    )
    back = np.array(info["images"]["CAM_BACK"]["lidar2cam"], dtype=float)
    assert_same_pose(optical(found["CAM_BACK"]), lidar @ np.linalg.inv(back))


def test_a_full_turn_of_airsim_is_one_wherever_it_begins() -> None:
    settings = json.loads(SMALL["airsim"]["settings.json"])
    """Its defaults end at 359 degrees."""
    for start, end, first in ((0.0, 360.0, -180.0), (0.0, 359.0, -180.0), (0.0, 358.0, -358.0)):
        for vehicle in settings["Vehicles"].values():
            for sensor in vehicle.get("Sensors", {}).values():
                sensor |= {"HorizontalFOVStart": start, "HorizontalFOVEnd": end}
        (lidar,) = read_files({"settings.json": json.dumps(settings)}, options=AT_ORIGIN).rig.enabled_lidars()
        assert lidar.azimuths()[0] == first


DELFT_P = "".join(
    f"P{index}: 1495.468642 0.0 961.272442 0.0 0.0 1495.468642 624.89592 0.0 0.0 0.0 1.0 0.0\n"
    for index in range(4)
)
DELFT = {
    "lidar": f"""\
{DELFT_P}R0_rect: 1.0 0.0 0.0 0.0 1.0 0.0 0.0 0.0 1.0
Tr_velo_to_cam: -0.0079802 -0.9998541 0.0151049 0.151 0.118497 -0.0159445 -0.9928264 -0.461 0.9929224 -0.0061331 \
0.1186069 -0.915
Tr_imu_to_velo:
""",
    "radar": f"""\
{DELFT_P}R0_rect: 1.0 0.0 0.0 0.0 1.0 0.0 0.0 0.0 1.0
Tr_velo_to_cam: -0.013857 -0.9997468 0.01772762 0.05283124 0.10934269 -0.01913807 -0.99381983 0.98100483 0.99390751 \
-0.01183297 0.1095802 1.44445002
Tr_imu_to_velo:
""",
}
"""As in the example set of View of Delft."""


@pytest.mark.parametrize("kinds", [("lidar", "radar"), ("lidar",), ("radar",), ()])
def test_view_of_delft_is_one_camera_with_its_lidar_and_radar(kinds: tuple[str, ...], tmp_path: Path) -> None:
    """It was four cameras in one place, and its radar a Velodyne."""
    for kind in kinds or ("elsewhere",):
        text = DELFT[kind if kinds else "lidar"]
        write_files(tmp_path, {f"{kind}/training/calib/00549.txt": text})
    read = read_rig(next(tmp_path.rglob("*.txt")))
    found = {sensor.kind: sensor for sensor in read.rig.sensors}
    assert len(found) == len(read.rig.sensors)
    assert set(found) == {"camera", *(kinds or ("lidar",))}
    camera = found["camera"]
    assert isinstance(camera, Camera) and camera.image == ((1936, 1216) if kinds else (1923, 1250))
    if len(kinds) == 2:
        apart = np.subtract(found["radar"].position, found["lidar"].position)
        assert apart == pytest.approx((2.5144, 0.0607, -1.1533), abs=1e-4)
