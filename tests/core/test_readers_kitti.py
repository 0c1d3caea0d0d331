"""KITTI folders arrive in the vehicle frame through their calibration."""

import csv
import gzip
import math
import re
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from riglens.core.errors import InputError
from riglens.core.scene.boxes import CLASSES, BoxBatch
from riglens.core.scene.readers import open_boxes
from riglens.core.scene.readers.common import join

SHARED = Path(__file__).resolve().parents[3] / "shared" / "data"
CAR = "Car 0 0 -1.5 100 100 200 200 1.5 1.8 4.5 {x} {y} {z} {ry}"
DONT_CARE = "DontCare -1 -1 -10 1 2 3 4 -1000 -1000 -1000 -10 -1 -1 -1"
RECTIFY = Rotation.from_euler("xyz", [0.01, -0.02, 0.03]).as_matrix()
CAMERA_R_VELODYNE = Rotation.from_euler("x", 0.015).as_matrix() @ np.array(
    [[0, -1, 0], [0, 0, -1], [1, 0, 0]]
)
CAMERA_T_VELODYNE = np.array([0.05, -0.08, -0.27])


def numbers(matrix: NDArray[np.float64]) -> str:
    return " ".join(map(repr, matrix.ravel().tolist()))


def calibration(rectify: str = "R0_rect:", velodyne: str = "Tr_velo_to_cam:") -> str:
    transform = np.column_stack([CAMERA_R_VELODYNE, CAMERA_T_VELODYNE])
    return f"P0: 1 2 3\n{rectify} {numbers(RECTIFY)}\n{velodyne} {numbers(transform)}\n"


def kitti_folder(
    folder: Path, labels: dict[str, str], tracking: bool = True, calib: str | None = None
) -> Path:
    label_folder = folder / ("label_02" if tracking else "label_2")
    label_folder.mkdir()
    (folder / "calib").mkdir()
    for name, text in labels.items():
        (label_folder / f"{name}.txt").write_text(text, encoding="utf-8")
        (folder / "calib" / f"{name}.txt").write_text(
            calibration() if calib is None else calib, encoding="utf-8"
        )
    return folder


def boxes_of(path: Path, **options: object) -> BoxBatch:
    return join(list(open_boxes(path, **options).batches()))  # type: ignore[arg-type]


def message(path: Path) -> str:
    with pytest.raises(InputError) as error:
        list(open_boxes(path).batches())
    assert "\n" not in str(error.value)
    return str(error.value)


def corners_in_camera(x: float, y: float, z: float, ry: float) -> NDArray[np.float64]:
    """The eight corners as the development kit draws them: length, height, width about the bottom centre."""
    signs = np.array([[a, b, c] for a in (-0.5, 0.5) for b in (-1, 0) for c in (-0.5, 0.5)])
    return Rotation.from_euler("y", ry).apply(signs * [4.5, 1.5, 1.8]) + np.array([x, y, z])


@pytest.mark.parametrize("ry", [0.0, 0.3, -2.1, math.pi / 2])
def test_corners_lie_where_independent_matrices_put_them(tmp_path: Path, ry: float) -> None:
    place = {"x": -3.25, "y": 1.6, "z": 14.5}
    box = boxes_of(kitti_folder(tmp_path, {"0000": "0 1 " + CAR.format(**place, ry=ry)}), origin_m=(1, 2, 3))
    signs = np.array([[a, b, c] for a in (-0.5, 0.5) for b in (-0.5, 0.5) for c in (-0.5, 0.5)])
    found = (box.rotation[0] @ (signs * box.size_m[0]).T).T + box.centre_m[0] - [1, 2, 3]
    in_camera = (RECTIFY @ (CAMERA_R_VELODYNE @ found.T + CAMERA_T_VELODYNE[:, None])).T
    gaps = np.linalg.norm(in_camera[:, None] - corners_in_camera(**place, ry=ry), axis=2)
    assert sorted(gaps.argmin(axis=1)) == list(range(8))
    assert gaps.min(axis=1).max() < 1e-9
    np.testing.assert_allclose(box.rotation[0] @ box.rotation[0].T, np.eye(3), atol=1e-12)
    assert np.linalg.det(box.rotation[0]) == pytest.approx(1.0)
    forward_in_camera = RECTIFY @ CAMERA_R_VELODYNE @ box.rotation[0] @ [1, 0, 0]
    np.testing.assert_allclose(forward_in_camera, [math.cos(ry), 0, -math.sin(ry)], atol=1e-12)


def test_without_an_origin_the_velodyne_stands_where_it_stands_on_the_kitti_car(tmp_path: Path) -> None:
    path = kitti_folder(tmp_path, {"0000": "0 1 " + CAR.format(x=0, y=1, z=9, ry=0)})
    shift = boxes_of(path).centre_m - boxes_of(path, origin_m=(0.0, 0.0, 0.0)).centre_m
    np.testing.assert_allclose(shift, [[0.4, 0.0, 1.73]], atol=1e-12)
    source = open_boxes(path)
    list(source.batches())
    assert "Velodyne is at 0.4 0 1.73 m" in source.report().notes[0]


def test_gaps_in_a_sequence_are_frames_without_boxes(tmp_path: Path) -> None:
    car = CAR.format(x=0, y=1, z=9, ry=0)
    labels = {"0000": f"3 1 {car}\n7 -1 {DONT_CARE}\n", "0001": f"2 1 {car}\n0 2 {car}"}
    source = open_boxes(kitti_folder(tmp_path, labels))
    boxes = join(list(source.batches()))
    assert boxes.frame.tolist() == [3, 8, 10]
    assert source.report().frames == 8 + 3
    assert source.report().unmapped == {"DontCare": 1}


def test_every_object_file_is_a_frame_even_an_empty_one(tmp_path: Path) -> None:
    car = CAR.format(x=0, y=1, z=9, ry=0)
    labels = {"000000": "", "000001": f"{car}\n{car} 0.97\n", "000002": DONT_CARE, "000003": car}
    source = open_boxes(kitti_folder(tmp_path, labels, tracking=False))
    boxes = join(list(source.batches()))
    assert (source.report().frames, boxes.frame.tolist()) == (4, [1, 1, 3])


def test_types_are_mapped_or_counted(tmp_path: Path) -> None:
    rest = CAR.format(x=0, y=1, z=9, ry=0).removeprefix("Car")
    names = ["Car", "Van", "Truck", "Cyclist", "Pedestrian", "Person_sitting", "Person", "Tram", "Misc"]
    path = kitti_folder(tmp_path, {"0000": "\n".join(f"0 1 {name}{rest}" for name in names)})
    source = open_boxes(path)
    boxes = join(list(source.batches()))
    assert [CLASSES[code] for code in boxes.cls] == ["car"] * 3 + ["bicycle"] + ["pedestrian"] * 3
    assert source.report().unmapped == {"Tram": 1, "Misc": 1}


@pytest.mark.parametrize(
    ("rectify", "velodyne"), [("R_rect", "Tr_velo_cam"), ("R0_rect:", "Tr_velo_to_cam:")]
)
def test_both_spellings_of_the_calibration_say_the_same(tmp_path: Path, rectify: str, velodyne: str) -> None:
    label = {"0000": "0 1 " + CAR.format(x=1, y=2, z=9, ry=1)}
    (tmp_path / "one").mkdir()
    (tmp_path / "two").mkdir()
    reference = boxes_of(kitti_folder(tmp_path / "one", label))
    other = boxes_of(kitti_folder(tmp_path / "two", label, calib=calibration(rectify, velodyne)))
    np.testing.assert_array_equal(reference.centre_m, other.centre_m)


def test_a_missing_calibration_is_named(tmp_path: Path) -> None:
    path = kitti_folder(tmp_path, {"0000": "", "0001": ""})
    missing = path / "calib" / "0001.txt"
    missing.unlink()
    assert message(path).startswith(f"{missing}: missing")


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("0 1 Car 1 2 3", "17 or 18 .*got 6"),
        ("x 1 " + CAR.format(x=0, y=1, z=9, ry=0), "frame: .*got 'x'"),
        ("-1 1 " + CAR.format(x=0, y=1, z=9, ry=0), "frame: .*got '-1'"),
        ("999999999 1 " + CAR.format(x=0, y=1, z=9, ry=0), "frame: .*got '999999999'"),
        ("0 1 " + CAR.format(x="abc", y=1, z=9, ry=0), "x: .*got 'abc'"),
        ("0 1 " + CAR.format(x=0, y=1, z="nan", ry=0), "z: .*got 'nan'"),
        ("0 1 " + CAR.format(x=0, y=1, z=9, ry=0).replace("4.5", "-1"), "length: .*got -1"),
        ("0 1 " + CAR.format(x=0, y=1, z=9, ry=0) + "\N{DEGREE SIGN}", "ASCII text"),
    ],
)
def test_a_broken_label_is_named_with_its_line(tmp_path: Path, line: str, expected: str) -> None:
    path = kitti_folder(tmp_path, {"0000": f"0 -1 {DONT_CARE}\n\n{line}\n"})
    text = message(path)
    assert text.startswith(f"{path / 'label_02' / '0000.txt'}:3: ")
    assert re.search(expected, text)


@pytest.mark.parametrize(
    ("calib", "expected"),
    [
        ("", "a line R_rect or R0_rect"),
        (f"R_rect {numbers(np.eye(3))}\n", "a line Tr_velo_cam or Tr_velo_to_cam"),
        ("R0_rect: 1 2 3\n", ":1: R0_rect: .*got 3"),
        (calibration().replace("R0_rect: ", "R0_rect: abc "), "R0_rect: .*got 10"),
        (
            f"R0_rect: {numbers(2 * np.eye(3))}\nTr_velo_cam {numbers(np.eye(4)[:3])}",
            "R_rect: .*a rotation",
        ),
        (
            f"R0_rect: {numbers(np.eye(3))}\nTr_velo_cam {numbers(np.eye(4)[:3] + np.array([0, 0, 0, 9e18]))}",
            "the shift",
        ),
        (f"R0_rect: {numbers(np.eye(3) * [1, 1, -1])}\nTr_velo_cam {numbers(np.eye(4)[:3])}", "a rotation"),
    ],
)
def test_a_broken_calibration_is_named(tmp_path: Path, calib: str, expected: str) -> None:
    path = kitti_folder(tmp_path, {"0000": "0 1 " + CAR.format(x=0, y=1, z=9, ry=0)}, calib=calib)
    text = message(path)
    assert text.startswith(str(path / "calib" / "0000.txt"))
    assert re.search(expected, text)


def test_a_folder_without_labels_or_with_both_kinds_is_refused(tmp_path: Path) -> None:
    path = kitti_folder(tmp_path, {})
    assert "label files" in message(path)
    (path / "label_2").mkdir()
    assert "label_02 or label_2" in message(path)


needs_shared = pytest.mark.skipif(
    not (SHARED / "kitti").is_dir(), reason="needs the real data beside the project"
)


@needs_shared
def test_real_sequences_agree_with_the_published_velodyne_table_to_its_rounding() -> None:
    with gzip.open(SHARED / "boxes" / "kitti_tracking_velo.csv.gz", "rt", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    wanted: dict[str, list[list[float]]] = {}
    for row in rows:
        if row["cls"] not in ("Misc", "Tram"):
            values = [
                float(row[name]) for name in ("frame", "x", "y", "z", "length", "width", "height", "yaw")
            ]
            wanted.setdefault(row["seq"], []).append(values)
    source = open_boxes(SHARED / "kitti" / "tracking", origin_m=(0.0, 0.0, 0.0))
    for sequence, batch in zip(("0000", "0003", "0012", "0014"), source.batches(), strict=True):
        table = np.array(wanted[sequence])
        np.testing.assert_array_equal(np.diff(batch.frame), np.diff(table[:, 0]))
        np.testing.assert_allclose(batch.centre_m, table[:, 1:4], atol=5.01e-4)
        np.testing.assert_allclose(batch.size_m, table[:, 4:7], atol=5.01e-4)
        yaw = np.arctan2(batch.rotation[:, 1, 0], batch.rotation[:, 0, 0])
        turn = np.angle(np.exp(1j * (yaw - table[:, 7])))
        assert np.abs(turn).max() < 5.01e-4
    assert source.report().boxes == {"car": 1594, "bicycle": 195, "pedestrian": 208}
    assert source.report().frames == 482


@needs_shared
def test_real_object_frames_are_read() -> None:
    source = open_boxes(SHARED / "kitti" / "object")
    boxes = join(list(source.batches()))
    assert source.report().boxes == {"car": 3, "bicycle": 1, "pedestrian": 1}
    assert source.report().unmapped == {"DontCare": 4, "Misc": 1}
    bottom = boxes.centre_m[:, 2] - boxes.size_m[:, 2] / 2
    assert np.abs(bottom).max() < 1.0
