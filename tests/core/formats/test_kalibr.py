"""Kalibr's chains in all the forms that programs write: OpenCV's YAML, either direction of the IMU, 16 numbers."""

import json
from pathlib import Path

import numpy as np
import pytest

from riglens.core.errors import InputError
from riglens.core.formats.exchange import detect, read_rig
from riglens.core.formats.kalibr import KALIBR
from riglens.core.formats.mounts import ReadOptions
from riglens.core.formats.source import Source
from tests.core.formats.cases import (
    VEHICLE,
    Matrix,
    assert_same_pose,
    optical,
    pose_matrix,
    read_files,
    sensor_matrix,
)
from tests.core.formats.test_reports import has

AT_ORIGIN = ReadOptions(vehicle=VEHICLE, origin_m=(0.0, 0.0, 0.0))
LENS = "  intrinsics: [458.6, 457.3, 367.2, 248.4]\n  resolution: [752, 480]\n"
ONE = optical(pose_matrix(((0.2, 0.1, -0.3), (3.0, -5.0, 20.0))))
OTHER = optical(pose_matrix(((0.2, -0.4, -0.3), (1.0, 4.0, -30.0))))
STEP = np.linalg.inv(OTHER) @ ONE
"""From the first camera to the second, cam1_SE3_cam0."""


def rows(matrix: Matrix) -> str:
    return json.dumps(matrix.tolist())


def opencv(matrix: Matrix) -> str:
    numbers = ", ".join(repr(float(value)) for value in matrix.ravel())
    return f"!!opencv-matrix\n    rows: 4\n    cols: 4\n    dt: d\n    data: [ {numbers} ]"


def chain(one: str, other: str, header: str = "") -> dict[str, str]:
    return {"camchain.yaml": f"{header}cam0:\n{one}{LENS}cam1:\n{other}{LENS}"}


def assert_both_stand(files: dict[str, str], one: Matrix, other: Matrix) -> None:
    first, second = read_files(files, options=AT_ORIGIN).rig.sensors
    assert_same_pose(optical(sensor_matrix(first)), one)
    assert_same_pose(optical(sensor_matrix(second)), other)


@pytest.mark.parametrize(
    "header", ["%YAML:1.0\n", "%YAML:1.0\n---\n", "%YAML:1.0 \r\n\n", "%YAML:1.0 # first\n", ""]
)
def test_opencv_yaml_with_the_imu_from_the_camera(header: str) -> None:
    files = chain(f"  T_imu_cam: {opencv(ONE)}\n", f"  T_imu_cam: {opencv(OTHER)}\n", header)
    assert_both_stand(files, ONE, OTHER)
    report = read_files(files, options=AT_ORIGIN).report
    assert has(report, "approximated", "the IMU's axes") and not has(report, "no IMU in the file")


@pytest.mark.parametrize("form", [rows, lambda matrix: rows(matrix.ravel()), opencv])
def test_a_matrix_is_four_rows_16_numbers_or_an_opencv_matrix(form) -> None:  # type: ignore[no-untyped-def]
    files = chain(f"  T_cam_imu: {form(np.linalg.inv(ONE))}\n", f"  T_cn_cnm1: {form(STEP)}\n")
    assert_both_stand(files, ONE, OTHER)
    assert_both_stand(chain(f"  T_imu_cam: {form(ONE)}\n", f"  T_cn_cnm1: {form(STEP)}\n"), ONE, OTHER)


def test_an_imu_of_a_later_camera_places_those_before_it() -> None:
    """They stood straight ahead before, beside cameras that stood by the IMU."""
    assert_both_stand(chain("", f"  T_imu_cam: {rows(OTHER)}\n  T_cn_cnm1: {rows(STEP)}\n"), ONE, OTHER)


def test_cameras_are_chained_by_their_number_not_by_their_place_in_the_file() -> None:
    text = f"cam1:\n  T_cn_cnm1: {rows(STEP)}\n{LENS}cam0:\n  T_imu_cam: {rows(ONE)}\n{LENS}"
    assert_both_stand({"camchain.yaml": text}, ONE, OTHER)


def test_transforms_that_are_not_taken_are_told_with_their_size() -> None:
    shifted = OTHER.copy()
    shifted[0, 3] += 0.25
    one = (
        f"  T_cam_imu: {rows(np.linalg.inv(ONE))}\n  T_imu_cam: {rows(shifted)}\n  T_cn_cnm1: {rows(STEP)}\n"
    )
    other = f"  T_imu_cam: {rows(shifted)}\n  T_cn_cnm1: {rows(STEP)}\n  T_other: {rows(STEP)}\n  gain: 3\n"
    report = read_files(chain(one, other), options=AT_ORIGIN).report
    assert has(report, "ignored", "T_imu_cam is not the inverse of T_cam_imu", "deg apart", "cam0")
    assert has(report, "ignored", "T_cn_cnm1 leads elsewhere", "0.25 m", "cam1")
    assert has(report, "ignored", "T_cn_cnm1 of the first camera", "cam0")
    assert has(report, "ignored", "field 'T_other' is not used", "cam1")
    assert has(report, "ignored", "other fields are not used", "gain")


def test_transforms_that_agree_are_not_told() -> None:
    one = f"  T_cam_imu: {rows(np.linalg.inv(ONE))}\n  T_imu_cam: {rows(ONE)}\n"
    files = chain(one, f"  T_imu_cam: {rows(OTHER)}\n  T_cn_cnm1: {rows(STEP)}\n")
    assert not read_files(files, options=AT_ORIGIN).report.of_kind("ignored")


def test_a_file_without_cameras_is_refused(tmp_path: Path) -> None:
    (tmp_path / "a.yaml").write_text("imu0: {rate: 200}\n", encoding="utf-8")
    with pytest.raises(InputError, match="at least one sensor"):
        read_rig(tmp_path / "a.yaml", "kalibr")


def test_a_chain_with_a_gap_is_refused(tmp_path: Path) -> None:
    (tmp_path / "a.yaml").write_text(chain("", "")["camchain.yaml"], encoding="utf-8")
    with pytest.raises(InputError, match=r"cam1\.T_cn_cnm1: missing"):
        read_rig(tmp_path / "a.yaml")


@pytest.mark.parametrize(
    ("matrix", "complaint"),
    [
        ("[1, 2, 3]", "T_imu_cam: .*got a list of 3"),
        ("{rows: 3, cols: 4, data: [1]}", "T_imu_cam.rows: .*got 3"),
        ("{rows: 4, cols: 4, data: [1]}", "T_imu_cam.data: .*got a list of 1"),
        ("!!opencv-other [1]", "tags are not accepted"),
    ],
)
def test_matrices_of_other_forms_are_refused_with_their_place(
    tmp_path: Path, matrix: str, complaint: str
) -> None:
    (tmp_path / "a.yaml").write_text(f"%YAML:1.0\ncam0:\n  T_imu_cam: {matrix}\n{LENS}", encoding="utf-8")
    with pytest.raises(InputError, match=complaint.replace("[", r"\[")):
        read_rig(tmp_path / "a.yaml", "kalibr")


def test_opencv_yaml_is_told_by_itself_and_errors_keep_their_line(tmp_path: Path) -> None:
    path = tmp_path / "kalibr_imucam_chain.yaml"
    path.write_text(
        chain(f"  T_imu_cam: {opencv(ONE)}\n", f"  T_cn_cnm1: {rows(STEP)}\n", "%YAML:1.0\n")[
            "camchain.yaml"
        ],
        encoding="utf-8",
    )
    assert detect(Source(path)) is KALIBR
    path.write_text("%YAML:1.0\n---\ncam0:\n  intrinsics: &a [1]\n", encoding="utf-8")
    with pytest.raises(InputError, match=r"kalibr_imucam_chain.yaml:4"):
        read_rig(path, "kalibr")
