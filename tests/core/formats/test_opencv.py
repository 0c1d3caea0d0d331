"""Cameras as OpenCV, ROS and VINS write them: lens models, extrinsics of a VINS configuration, and what is refused."""

import json

import numpy as np
import pytest
from ruamel.yaml import YAML

from riglens.core.errors import InputError
from riglens.core.formats.mounts import ReadOptions
from riglens.core.formats.opencv_yaml import camera_info_text
from riglens.core.rig.model import BrownConrady, Camera, KannalaBrandt
from tests.core.formats.cases import (
    SMALL,
    VEHICLE,
    Files,
    assert_same_pose,
    optical,
    pose_matrix,
    read_files,
    sensor_matrix,
)
from tests.core.formats.test_kalibr import opencv
from tests.core.formats.test_reports import has

AT_ORIGIN = ReadOptions(vehicle=VEHICLE, origin_m=(0.0, 0.0, 0.0))
ROS = SMALL["opencv"]["front.yaml"]


def camera(files: Files, name: str | None = None) -> Camera:
    (found,) = read_files(files, name, AT_ORIGIN).rig.sensors
    assert isinstance(found, Camera)
    return found


def test_camera_info_file_of_ros() -> None:
    read = read_files(SMALL["opencv"], options=AT_ORIGIN)
    (front,) = read.rig.sensors
    assert isinstance(front, Camera)
    assert (front.name, front.image) == ("front_camera", (1280, 720))
    assert (front.fx, front.fy, front.cx, front.cy) == (1000.5, 1001.5, 640.25, 360.75)
    assert front.distortion == BrownConrady(k1=-0.3, k2=0.1, p1=0.001, p2=-0.002, k3=0.01)
    assert_same_pose(sensor_matrix(front), np.eye(4))
    assert has(read.report, "approximated", "pose of the camera not in the file")


STORAGE_XML = """\
<?xml version="1.0"?>
<opencv_storage>
<calibration_time>"Sat Nov 28 2026"</calibration_time>
<image_width>1280</image_width>
<image_height>720</image_height>
<camera_matrix type_id="opencv-matrix">
  <rows>3</rows><cols>3</cols><dt>d</dt>
  <data>1000.5 0. 640.25 0. 1001.5
    360.75 0. 0. 1.</data></camera_matrix>
<distortion_coefficients type_id="opencv-matrix">
  <rows>5</rows><cols>1</cols><dt>d</dt>
  <data>-3.0e-01 1.0e-01 1.0e-03 -2.0e-03 1.0e-02</data></distortion_coefficients>
<grid_points><_>0. 0. 0.</_><_>1. 0. 0.</_></grid_points>
</opencv_storage>
"""


def storage_json() -> str:
    matrix = {"type_id": "opencv-matrix", "rows": 3, "cols": 3, "dt": "d"}
    return json.dumps(
        {
            "image_width": 1280,
            "image_height": 720,
            "camera_matrix": matrix | {"data": [1000.5, 0.0, 640.25, 0.0, 1001.5, 360.75, 0.0, 0.0, 1.0]},
            "distortion_coefficients": matrix
            | {"rows": 5, "cols": 1, "data": [-0.3, 0.1, 0.001, -0.002, 0.01]},
        }
    )


@pytest.mark.parametrize("files", [{"front_camera.xml": STORAGE_XML}, {"front_camera.json": storage_json()}])
def test_xml_and_json_of_opencv_are_the_same_camera(files: Files) -> None:
    assert camera(files) == camera(SMALL["opencv"])
    assert not any("is not used" in line for line in read_files(files).report.lines())


@pytest.mark.parametrize(
    "text",
    ["<package/>", "<opencv_storage/>", "<opencv_storage><image_width>a</image_width></opencv_storage>"],
)
def test_other_xml_is_refused_in_one_line(text: str) -> None:
    with pytest.raises(InputError, match="not a rig in a known format"):
        read_files({"a.xml": text})
    with pytest.raises(InputError):
        read_files({"a.xml": text}, "opencv")


def test_the_projection_of_a_written_camera_is_its_matrix() -> None:
    (front,) = read_files(SMALL["opencv"], options=AT_ORIGIN).rig.sensors
    assert isinstance(front, Camera)
    written = YAML(typ="safe").load(camera_info_text(front))
    matrix, projection = (
        np.reshape(written[name]["data"], (3, -1)) for name in ("camera_matrix", "projection_matrix")
    )
    assert matrix.tolist() == [[1000.5, 0.0, 640.25], [0.0, 1001.5, 360.75], [0.0, 0.0, 1.0]]
    assert np.array_equal(projection, np.column_stack([matrix, np.zeros(3)]))


@pytest.mark.parametrize("keys", ["DK", "dk"])
def test_message_camera_info(keys: str) -> None:
    d, k = keys
    text = (
        "header: {seq: 1, frame_id: left}\nheight: 480\nwidth: 640\ndistortion_model: equidistant\n"
        f"{d}: [0.1, 0.2, 0.3, 0.4]\n{k}: [400, 0, 320, 0, 401, 240, 0, 0, 1]\n"
    )
    found = camera({"info.yaml": text})
    assert found.distortion == KannalaBrandt(k1=0.1, k2=0.2, k3=0.3, k4=0.4)
    assert (found.image, found.fx, found.fy) == ((640, 480), 400.0, 401.0)


def test_rational_polynomial_keeps_its_eight_coefficients_and_tells_the_rest() -> None:
    numbers = "[0.1, 0.2, 0.001, 0.002, 0.3, 0.4, 0.5, 0.6, 0.01, 0, 0, 0]"
    text = ROS.replace("plumb_bob", "rational_polynomial").replace(
        "[-0.3, 0.1, 0.001, -0.002, 0.01]", numbers
    )
    read = read_files({"a.yaml": text}, options=AT_ORIGIN)
    (found,) = read.rig.sensors
    assert isinstance(found, Camera)
    assert found.distortion == BrownConrady(
        k1=0.1, k2=0.2, p1=0.001, p2=0.002, k3=0.3, k4=0.4, k5=0.5, k6=0.6
    )
    assert has(read.report, "ignored", "thin prism")


def test_calibration_of_opencv_itself() -> None:
    matrix = (
        "!!opencv-matrix\n  rows: 3\n  cols: 3\n  dt: d\n  data: [ 7e2, 0., 320., 0., 7e2, 240., 0., 0., 1. ]"
    )
    lens = "!!opencv-matrix\n  rows: 5\n  cols: 1\n  dt: d\n  data: [ -1e-1, 0., 0., 0., 0. ]"
    text = (
        '%YAML:1.0\n---\ncalibration_time: "Mon"\nimage_width: 640\nimage_height: 480\n'
        f"camera_matrix: {matrix}\ndistortion_coefficients: {lens}\navg_reprojection_error: 0.2\n"
    )
    found = camera({"out_camera_data.yml": text})
    assert (found.name, found.fx, found.distortion) == ("out_camera_data", 700.0, BrownConrady(k1=-0.1))


PINHOLE = """\
%YAML:1.0
---
model_type: PINHOLE
camera_name: camera
image_width: 752
image_height: 480
distortion_parameters: {k1: -0.28, k2: 0.07, p1: 0.0002, p2: 0.00002}
projection_parameters: {fx: 461.6, fy: 460.3, cx: 363.0, cy: 248.1}
"""
FISHEYE = """\
%YAML:1.0
model_type: KANNALA_BRANDT
camera_name: camera
image_width: 752
image_height: 480
projection_parameters: {k2: 0.01, k3: -0.02, k4: 0.003, k5: -0.004, mu: 300, mv: 301, u0: 370, v0: 240}
"""
MEI = """\
model_type: MEI
image_width: 752
image_height: 480
mirror_parameters: {xi: 1.9}
distortion_parameters: {k1: 0, k2: 0, p1: 0, p2: 0}
projection_parameters: {gamma1: 1200, gamma2: 1201, u0: 370, v0: 240}
"""


def test_vins_knows_the_lens_of_each_model() -> None:
    assert camera({"cam.yaml": PINHOLE}).distortion == BrownConrady(k1=-0.28, k2=0.07, p1=0.0002, p2=0.00002)
    fisheye = camera({"cam.yaml": FISHEYE})
    assert fisheye.distortion == KannalaBrandt(k1=0.01, k2=-0.02, k3=0.003, k4=-0.004)
    assert (fisheye.fx, fisheye.cy) == (300.0, 240.0)
    read = read_files({"cam.yaml": MEI}, options=AT_ORIGIN)
    assert has(
        read.report, "approximated", "lens of model 'mei' as the nearest Kannala-Brandt lens", "pixels off"
    )


def test_opencv_needs_no_space_behind_a_key() -> None:
    close = PINHOLE.replace("image_width: 752", "image_width:752").replace(
        "---\n", "estimate_extrinsic:0  # a:b\n"
    )
    assert camera({"cam.yaml": close}) == camera({"cam.yaml": PINHOLE})
    with pytest.raises(InputError, match="not valid YAML"):
        camera({"cam.yaml": close.partition("\n")[2]})


ONE = optical(pose_matrix(((0.2, 0.1, -0.3), (3.0, -5.0, 20.0))))
OTHER = optical(pose_matrix(((0.2, -0.4, -0.3), (1.0, 4.0, -30.0))))


def test_vins_configuration_places_its_cameras_by_the_imu(tmp_path_factory: pytest.TempPathFactory) -> None:
    from riglens.core.formats.exchange import read_rig

    folder = tmp_path_factory.mktemp("vins")
    text = (
        '%YAML:1.0\n\nimu: 1\ncam0_calib: "left.yaml"\ncam1_calib: "right.yaml"\ncam2_calib: "none.yaml"\n'
        f"body_T_cam0: {opencv(ONE)}\nbody_T_cam1: {opencv(OTHER)}\nbody_T_cam2: {opencv(OTHER)}\n"
    )
    for name, content in (("config.yaml", text), ("left.yaml", PINHOLE), ("right.yaml", FISHEYE)):
        (folder / name).write_text(content, encoding="utf-8")
    read = read_rig(folder / "config.yaml", options=AT_ORIGIN)
    first, second = read.rig.sensors
    assert [first.name, second.name] == ["cam0", "cam1"]
    assert_same_pose(optical(sensor_matrix(first)), ONE)
    assert_same_pose(optical(sensor_matrix(second)), OTHER)
    assert has(read.report, "ignored", "'cam2_calib' names no file")


@pytest.mark.parametrize("name", ["../left.yaml", "/etc/passwd", "a/b.yaml", "..", "a\\b"])
def test_a_configuration_reads_files_beside_it_only(
    name: str, tmp_path_factory: pytest.TempPathFactory
) -> None:
    from riglens.core.formats.exchange import read_rig

    folder = tmp_path_factory.mktemp("vins") / "inner"
    folder.mkdir()
    (folder.parent / "left.yaml").write_text(PINHOLE, encoding="utf-8")
    (folder / "config.yaml").write_text(
        f"cam0_calib: '{name}'\nbody_T_cam0: {opencv(ONE)}\n", encoding="utf-8"
    )
    with pytest.raises(InputError, match=r"cam0_calib: .*a file in the same folder"):
        read_rig(folder / "config.yaml")
