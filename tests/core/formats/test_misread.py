"""Fields that other programs write in ways of their own are read as they mean them."""

import json
import math
from typing import Any

import numpy as np
import pytest

from riglens.core.errors import InputError
from riglens.core.formats.lens_export import extent
from riglens.core.formats.mounts import ReadOptions, find_model
from riglens.core.rig.model import BrownConrady, Camera, KannalaBrandt, Lidar, Rig, Sensor
from riglens.core.sensors.camera import project_px
from riglens.core.sensors.ultrasonic import Ultrasonic
from tests.core.formats.cases import SMALL, Files, lidar, read_files, rig_of, written
from tests.core.formats.test_reports import has

MATRIX = "camera_matrix: {rows: 3, cols: 3, data: [500, 0, 640, 0, 500, 360, 0, 0, 1]}\n"
SIZE = "image_width: 1280\nimage_height: 720\n"
BEND = "[-0.25, 0.125, 0.001, -0.002]"


def opencv(*lines: str) -> Camera:
    """The camera of a YAML file."""
    (camera,) = read_files({"front.yaml": SIZE + MATRIX + "\n".join(lines) + "\n"}).rig.sensors
    assert isinstance(camera, Camera)
    return camera


@pytest.mark.parametrize(
    "name", ["dist_coeffs", "dist_coeff", "distCoeffs", "distortion", "distortion_coeffs", "D", "d"]
)
def test_coefficients_are_found_under_usual_names(name: str) -> None:
    for value in (BEND, f"{{rows: 1, cols: 4, data: {BEND}}}"):
        assert opencv(f"{name}: {value}").distortion == BrownConrady(k1=-0.25, k2=0.125, p1=0.001, p2=-0.002)


def test_opencvs_flag_of_a_fisheye_is_heeded() -> None:
    found = opencv("fisheye_model: 1", f"distortion_coefficients: {BEND}")
    assert found.distortion == KannalaBrandt(k1=-0.25, k2=0.125, k3=0.001, k4=-0.002)
    assert isinstance(opencv("fisheye_model: 0", f"distortion_coefficients: {BEND}").distortion, BrownConrady)


@pytest.mark.parametrize(
    ("lines", "image", "numbers"),
    [
        ("roi: {x_offset: 320, y_offset: 60, width: 640, height: 600}", (640, 600), (500, 500, 320, 300)),
        ("roi: {x_offset: 0, y_offset: 0, width: 0, height: 0}", (1280, 720), (500, 500, 640, 360)),
        ("binning_x: 2\nbinning_y: 4", (640, 180), (250, 125, 320, 90)),
        (
            "roi: {x_offset: 320, y_offset: 60, width: 640, height: 600}\nbinning_x: 2\nbinning_y: 2",
            (320, 300),
            (250, 250, 160, 150),
        ),
    ],
)
def test_window_and_binning_are_those_of_the_picture(
    lines: str, image: tuple[int, int], numbers: tuple[float, ...]
) -> None:
    """Rays of a pixel stay: sensor_msgs/CameraInfo says that the matrix is that of the whole sensor."""
    found = opencv(lines)
    assert found.image == image and found.intrinsics_px() == numbers


def gazebo(inner: str, link: str = "eye") -> list[Sensor]:
    """The sensors of Gazebo on a link 1 m ahead of base_link and 1 m up."""
    robot = (
        f'<robot name="bot"><link name="base_link"/><link name="{link}"/><joint name="j" type="fixed">'
        f'<parent link="base_link"/><child link="{link}"/><origin xyz="1 0 1"/></joint>'
        f'<gazebo reference="{link}">{inner}</gazebo></robot>'
    )
    return list(read_files({"bot.urdf": robot}, options=ReadOptions(origin_m=(0.0, 0.0, 0.0))).rig.sensors)


VIEW = "<horizontal_fov>1.2</horizontal_fov><image><width>800</width><height>600</height></image>"
FAN = (
    "<ray><scan><horizontal><samples>5</samples><min_angle>-0.1</min_angle><max_angle>0.1</max_angle></horizontal>"
    "<vertical><samples>3</samples><min_angle>-0.05</min_angle><max_angle>0.05</max_angle></vertical></scan>"
    "<range><min>0.02</min><max>4</max></range></ray>"
)


@pytest.mark.parametrize(
    "plugin",
    [
        '<plugin name="p" filename="libgazebo_ros_ray_sensor.so"><output_type>sensor_msgs/Range</output_type></plugin>',
        '<plugin name="p" filename="libhector_gazebo_ros_sonar.so"/>',
        '<plugin name="p" filename="libgazebo_ros_range.so"/>',
    ],
)
def test_a_fan_whose_plugin_publishes_one_distance_is_a_sonar(plugin: str) -> None:
    (sonar,) = gazebo(f'<sensor name="s" type="ray">{FAN}{plugin}</sensor>')
    assert isinstance(sonar, Ultrasonic) and sonar.pole_range_m == 4.0
    assert sonar.azimuth_deg == pytest.approx((-math.degrees(0.1), math.degrees(0.1)))
    scan = plugin.replace("Range", "LaserScan").replace("ros_range", "ros_laser").replace("sonar", "laser")
    (laser,) = gazebo(f'<sensor name="s" type="ray">{FAN}{scan}</sensor>')
    assert isinstance(laser, Lidar)


@pytest.mark.parametrize(
    ("pose", "rpy_deg"),
    [
        ("<pose>0.5 0 0 0 0.2 0</pose>", (0.0, math.degrees(0.2), 0.0)),
        ('<pose degrees="true">0.5 0 0 0 10 90</pose>', (0.0, 10.0, 90.0)),
        (
            '<pose rotation_format="quat_xyzw">0.5 0 0 0 0 0.7071067811865476 0.7071067811865476</pose>',
            (0, 0, 90),
        ),
    ],
)
def test_poses_of_gazebo_are_radians_degrees_or_quaternions(pose: str, rpy_deg: Any) -> None:
    (camera,) = gazebo(f'<sensor name="s" type="camera">{pose}<camera>{VIEW}</camera></sensor>')
    assert camera.position == pytest.approx((1.5, 0.0, 1.0)) and camera.rpy_deg == pytest.approx(rpy_deg)


def test_a_multicamera_is_several_cameras_each_with_its_pose() -> None:
    pair = (
        f'<camera name="left">{VIEW}</camera><camera name="right"><pose>0 -0.07 0 0 0 0</pose>{VIEW}</camera>'
    )
    left, right = gazebo(f'<sensor name="stereo" type="multicamera">{pair}</sensor>')
    assert (left.name, right.name) == ("stereo_left", "stereo_right")
    assert np.subtract(right.position, left.position) == pytest.approx((0.0, -0.07, 0.0))


def test_a_camera_link_that_stands_like_an_optical_frame_is_one() -> None:
    robot = (
        '<robot name="car"><link name="body"/><link name="camera_a"/><joint name="j" type="fixed"><parent link="body"/>'
        '<child link="camera_a"/><origin xyz="1 0 1" rpy="-1.5707963267948966 0 -1.5707963267948966"/></joint></robot>'
    )
    read = read_files({"car.urdf": robot})
    assert read.rig.sensors[0].rpy_deg == pytest.approx((0.0, 0.0, 0.0), abs=1e-9)
    assert has(read.report, "approximated", "optical frame", "camera_a")


def tables(rows: list[dict[str, Any]], **fields: Any) -> Files:
    """Tables of nuScenes with cameras."""
    sensors = [
        {"token": row["sensor_token"], "channel": row["sensor_token"], "modality": "camera"} for row in rows
    ]
    pose = {"translation": [1.5, 0, 1.6], "rotation": [0.5, -0.5, 0.5, -0.5]}
    return {
        "calibrated_sensor.json": json.dumps([{**pose, **row, **fields} for row in rows]),
        "sensor.json": json.dumps(sensors),
    }


def test_distortion_in_tables_of_nuimages_is_the_lens() -> None:
    k = [[850.0, 0.0, 800.0], [0.0, 850.0, 450.0], [0.0, 0.0, 1.0]]
    row = {"token": "c", "sensor_token": "FRONT", "camera_intrinsic": k}
    (bent,) = read_files(tables([row], camera_distortion=[-0.34, 0.15, 0.0002, -0.0003, -0.03])).rig.sensors
    assert isinstance(bent, Camera)
    assert bent.distortion == BrownConrady(k1=-0.34, k2=0.15, p1=0.0002, p2=-0.0003, k3=-0.03)
    (plain,) = read_files(tables([row], camera_distortion=[])).rig.sensors
    assert isinstance(plain, Camera) and plain.distortion is None


def test_an_assumed_image_gives_way_to_a_principal_point_that_does_not_fit() -> None:
    k = [[850.0, 0.0, 960.0], [0.0, 850.0, 640.0], [0.0, 0.0, 1.0]]
    read = read_files(tables([{"token": "c", "sensor_token": "FRONT", "camera_intrinsic": k}]))
    (camera,) = read.rig.sensors
    assert isinstance(camera, Camera) and camera.image == (1920, 1280)
    assert has(read.report, "approximated", "1920 x 1280", "twice the principal point", "FRONT")
    assert extent(camera).up_deg == pytest.approx(extent(camera).down_deg)


def test_odometry_of_kitti_has_the_velodyne_in_rectified_camera_0() -> None:
    text = (
        SMALL["kitti"]["000000.txt"]
        .replace("Tr_velo_to_cam", "Tr")
        .replace("R0_rect: 1 0 0 0 1 0 0 0 1\n", "")
    )
    odometry = read_files({"calib.txt": text.replace("Tr_imu_to_velo", "Tr_other")})
    assert odometry.rig.sensors == read_files(SMALL["kitti"]).rig.sensors
    assert not has(odometry.report, "IMU")


def transform(parent: str, child: str, x: float) -> str:
    return (
        f"header: {{frame_id: {parent}}}\nchild_frame_id: {child}\ntransform:\n"
        f"  translation: {{x: {x}, y: 0.25, z: 1.5}}\n  rotation: {{x: -0.5, y: 0.5, z: -0.5, w: 0.5}}\n"
    )


def test_base_link_of_a_transform_has_the_axes_of_ros() -> None:
    read = read_files({"tf.yaml": transform("base_link", "front_camera", 1.8)})
    (camera,) = read.rig.sensors
    assert camera.position == pytest.approx((1.8 + read.rig.vehicle.rear_axle_x, 0.25, 1.5))
    assert camera.rpy_deg == pytest.approx((0.0, 0.0, 0.0), abs=1e-9)
    other = read_files({"tf.yaml": transform("chassis", "front_camera", 1.8)}).report
    assert has(other, "approximated", "axes of chassis, x right, y forward")


def test_of_two_transforms_of_a_frame_the_first_is_taken_and_both_are_named() -> None:
    files = {
        f"velodyne16_{name}_extrinsics.yaml": transform("novatel", "velodyne16", x)
        for name, x in (("a", 1), ("b", 2))
    }
    read = read_files(files)
    assert read.rig.sensors[0].position[1] == -1.0
    assert has(
        read.report, "ignored", "velodyne16_a_extrinsics.yaml is taken", "velodyne16_b_extrinsics.yaml"
    )


def test_a_planar_lidar_comes_back_from_osi() -> None:
    rig = rig_of(lidar("planar", ((2.0, 0.0, 0.5), (0.0, 0.0, 0.0)), elevations_deg=(0.0,)))
    (back,) = read_files(written("osi", rig)).rig.sensors
    assert isinstance(back, Lidar) and back.elevations().tolist() == [0.0]


@pytest.mark.parametrize(
    "words", ["helios_16p", "mid_360s", "lidar_top", "helios_32", "navia", "cam1", "os1_64_rev7", "ftx140"]
)
def test_a_name_that_goes_on_is_not_another_model(words: str) -> None:
    assert find_model(words) is None


@pytest.mark.parametrize(
    ("words", "model"),
    [
        ("alpha_prime", "velodyne-vls-128"),
        ("puck_hires", "velodyne-vlp-16-hires"),
        ("ultra_puck", "velodyne-vlp-32c"),
        ("left_puck", "velodyne-vlp-16"),
        ("XT32M2X", "hesai-xt32m"),
        ("os0_64", "ouster-os0-64"),
        ("os0_64_rev6", "ouster-os0-64"),
        ("OS1-128 rev7", "ouster-os1-128-rev7"),
        ("velodyne_hdl64", "velodyne-hdl-64e"),
        ("pandar128", "hesai-pandar128e4x"),
        ("ruby_plus", "robosense-ruby-plus"),
        ("front_airy", "robosense-airy"),
        ("atx_1", "hesai-atx"),
        ("livox_avia", "livox-avia"),
        ("rs_e1", "robosense-e1"),
        ("rs_emx", "robosense-emx"),
        ("FTX180", "hesai-ftx-180"),
        ("RS-LiDAR-M1", "robosense-m1"),
        ("VLP16Front", "velodyne-vlp-16"),
    ],
)
def test_models_are_found_by_usual_spellings(words: str, model: str) -> None:
    found = find_model(words)
    assert found is not None and found.name == model


def test_autoware_keeps_the_rear_axle() -> None:
    rig = rig_of(lidar("top", ((0.5, 0.0, 1.9), (0.0, 0.0, 0.0))))
    for rear_axle_x in (-1.1, -1.35, -1.6):
        own = rig.replace(vehicle=rig.vehicle.replace(rear_axle_x=rear_axle_x))
        back: Rig = read_files(written("autoware", own)).rig
        assert back.vehicle.rear_axle_x == pytest.approx(rear_axle_x, abs=1e-8)
        assert back.sensors[0].position == pytest.approx((0.5, 0.0, 1.9), abs=1e-8)


def test_urdf_has_a_frame_of_every_kind() -> None:
    pose: dict[str, Any] = {"position": (2.0, 0.5, 0.5), "rpy_deg": (0.0, 0.0, 30.0)}
    sonar = Ultrasonic(name="bumper", azimuth_deg=(-50.0, 50.0), pole_range_m=2.0, wall_range_m=2.0, **pose)
    radar = {"name": "corner", "kind": "radar", **pose}
    from riglens.core.sensors.radar import Radar, RadarScan

    scan = RadarScan(azimuth_deg=(-45.0, 45.0), elevation_deg=(-10.0, 10.0), range_m=70.0)
    rig = Rig(sensors=(sonar, Radar(scans=(scan,), **{key: radar[key] for key in ("name", *pose)})))
    back = read_files(written("urdf", rig)).rig
    assert [(one.kind, one.position) for one in back.sensors] == [
        ("ultrasonic", pytest.approx((2.0, 0.5, 0.5))), ("radar", pytest.approx((2.0, 0.5, 0.5))),
    ]  # fmt: skip
    assert isinstance(back.sensors[0], Ultrasonic)
    assert back.sensors[0].azimuth_deg == pytest.approx((-50.0, 50.0)) and back.sensors[0].pole_range_m == 2.0


@pytest.mark.parametrize(
    "words", ["x forward, y right", "axes are left-handed", "y axis to the right", "z points down", "NED"]
)
def test_a_comment_that_speaks_of_other_axes_is_told(words: str) -> None:
    kit = dict(SMALL["autoware"])
    kit["sensor_kit_calibration.yaml"] = f"# {words}\n" + kit["sensor_kit_calibration.yaml"]
    assert has(read_files(kit).report, "approximated", "a comment says", words.split()[-1])
    robot = {"car.urdf": f'<robot name="a"><!-- {words} --><link name="top_lidar"/></robot>'}
    assert has(read_files(robot).report, "approximated", "a comment says", words.split()[-1])
    plain = "# right camera, y in metres; z up, drawn down there"
    kit["sensor_kit_calibration.yaml"] = f"{plain}\n" + SMALL["autoware"]["sensor_kit_calibration.yaml"]
    assert not has(read_files(kit).report, "a comment says")


def test_tables_sorted_by_sensor_are_divided_by_their_samples() -> None:
    k = [[850.0, 0.0, 800.0], [0.0, 850.0, 450.0], [0.0, 0.0, 1.0]]
    rows = [
        {
            "token": f"{channel}{car}",
            "sensor_token": channel,
            "camera_intrinsic": k,
            "translation": [car, 0, 1.6],
        }
        for channel, cars in (("FRONT", (1, 2, 3)), ("BACK", (1, 2, 3)), ("SIDE", (2, 3)))
        for car in cars
    ]
    files = dict(tables(rows))
    apart = read_files(files)
    assert has(apart.report, "approximated", "which sensors are on one car")
    samples = [{"calibrated_sensor_token": row["token"], "sample_token": row["token"][-1]} for row in rows]
    files["sample_data.json"] = json.dumps(samples)
    for car, names in (
        (1, ["FRONT", "BACK"]),
        (2, ["FRONT", "BACK", "SIDE"]),
        (3, ["FRONT", "BACK", "SIDE"]),
    ):
        read = read_files(files, options=ReadOptions(token=f"FRONT{car}", origin_m=(0.0, 0.0, 0.0)))
        assert [sensor.name for sensor in read.rig.sensors] == names
        assert {sensor.position[0] for sensor in read.rig.sensors} == {float(car)}


def test_autoware_ai_has_the_camera_on_the_lidar() -> None:
    """CameraExtrinsicMat takes points of the camera to the LiDAR: here 1 m ahead of it, turned to the left."""
    text = (
        "%YAML:1.0\n---\nCameraExtrinsicMat: !!opencv-matrix\n   rows: 4\n   cols: 4\n   dt: d\n"
        "   data: [ 1, 0, 0, 1, 0, 0, 1, 0, 0, -1, 0, -0.5, 0, 0, 0, 1 ]\n"
        "CameraMat: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: [ 500, 0, 640, 0, 500, 360, 0, 0, 1 ]\n"
        f"DistCoeff: !!opencv-matrix\n   rows: 1\n   cols: 4\n   dt: d\n   data: {BEND}\n"
        "ImageSize: [1280, 720]\nReprojection Error: 0.1\nDistModel: plumb_bob\n"
    )
    (camera,) = read_files({"cam.yaml": text}, options=ReadOptions(origin_m=(0.0, 0.0, 0.0))).rig.sensors
    assert isinstance(camera, Camera) and camera.image == (1280, 720)
    assert camera.position == (1.0, 0.0, -0.5) and camera.rpy_deg == pytest.approx((0.0, 0.0, 90.0), abs=1e-9)
    assert camera.distortion == BrownConrady(k1=-0.25, k2=0.125, p1=0.001, p2=-0.002)


def test_static_transforms_of_ros_are_chained() -> None:
    one, other = (
        {
            "header": {"frame_id": parent},
            "child_frame_id": child,
            "transform": {"translation": place, "rotation": turn},
        }
        for parent, child, place, turn in (
            ("base_link", "roof", {"x": 1.0, "y": 0.0, "z": 1.5}, {"x": 0.0, "y": 0.0, "z": 1.0, "w": 0.0}),
            ("roof", "top_lidar", {"x": 0.25, "y": 0.0, "z": 0.5}, {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}),
        )
    )
    read = read_files({"tf.yaml": json.dumps({"transforms": [one, other]})})
    (lidar,) = read.rig.sensors
    assert lidar.position == pytest.approx((0.75 + read.rig.vehicle.rear_axle_x, 0.0, 2.0))
    assert abs(lidar.rpy_deg[2]) == pytest.approx(180.0)


def test_basalts_cameras_stand_around_the_imu() -> None:
    left, right = read_files(SMALL["basalt"], options=ReadOptions(origin_m=(0.0, 0.0, 0.0))).rig.sensors
    assert isinstance(left, Camera) and isinstance(right, Camera)
    assert left.position == pytest.approx((0.05, 0.1, 0.02)) and right.position == pytest.approx(
        (0.05, -0.1, 0.02)
    )
    for camera in (left, right):
        assert camera.rpy_deg == pytest.approx((0.0, 0.0, 0.0), abs=1e-9)
    assert left.distortion == KannalaBrandt(k1=0.01, k2=-0.005, k3=0.004, k4=-0.001)
    xi, alpha, theta = -0.17, 0.6, 0.5  # the double sphere of Usenko et al., 3DV 2018, eq. 40
    x, z = math.sin(theta), math.cos(theta)
    u = 158.0 * x / (alpha * math.hypot(x, xi + z) + (1.0 - alpha) * (xi + z)) + 508.0
    found = project_px(right, np.array([[math.cos(theta), -math.sin(theta), 0.0]]))
    assert found[0] == pytest.approx((u, 506.0), abs=0.5)


def test_a2d2_has_views_in_a_box_around_the_rear_axle() -> None:
    read = read_files(SMALL["a2d2"])
    front, side, lidar = read.rig.sensors
    car = read.rig.vehicle
    assert (car.length, car.width, car.height, car.rear_axle_x) == (5.0625, 2.0, 1.75, -1.40625)
    assert front.position == pytest.approx((1.75 - 1.40625, 0.0, 1.25)) and front.rpy_deg == (0.0, 0.0, 0.0)
    assert side.rpy_deg == pytest.approx((0.0, 0.0, 90.0), abs=1e-9)
    assert lidar.rpy_deg == pytest.approx((0.0, 0.0, math.degrees(math.atan2(0.6, 0.8))))
    assert isinstance(front, Camera) and front.fx == 1750.0
    assert front.distortion == BrownConrady(k1=-0.25, k2=0.125, p1=0.001, p2=-0.002, k3=0.01)
    assert isinstance(side, Camera) and side.distortion == KannalaBrandt(k1=-0.04, k2=0.02, k3=-0.03, k4=0.01)


def test_links_of_a_model_are_chained_to_its_frame() -> None:
    read = read_files(SMALL["sdf"])
    top, view = read.rig.sensors
    assert top.position == pytest.approx((0.25, 0.5, 1.625)) and top.rpy_deg == pytest.approx(
        (0.0, 0.0, 90.0)
    )
    assert view.position == (1.75, 0.0, 1.0) and view.rpy_deg == pytest.approx((0.0, 5.0, 0.0))
    assert has(read.report, "ignored", "navsat", "gps")
    two = SMALL["sdf"]["car.sdf"].replace("</sdf>", '<model name="wall"><link name="w"/></model></sdf>')
    assert has(read_files({"car.sdf": two}).report, "ignored", "another model", "wall")
    with pytest.raises(InputError, match=r"must be the name of a model .known: car, wall"):
        read_files({"car.sdf": two}, options=ReadOptions(token="lorry"))
