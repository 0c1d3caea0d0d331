"""Boxes of ONCE, ZOD, DAIR-V2X and OPV2V, against the equations of their own devkits."""

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from riglens.core.errors import InputError
from riglens.core.scene.boxes import CLASSES, BoxBatch, DataReport
from riglens.core.scene.readers import open_boxes
from riglens.core.scene.readers.common import join
from tests.core.formats.test_datasets import carla_matrix
from tests.core.sound_boxes import DAIR, ONCE, OPV2V, ZOD, dair_v2x, once, opv2v, zod


def read(path: Path) -> tuple[BoxBatch, DataReport]:
    source = open_boxes(path)
    boxes = join(list(source.batches()))
    whole, parts = source.report(), [list(part.batches()) for part in source.parts()]
    assert sum(batch.cls.size for part in parts for batch in part) == boxes.cls.size
    return boxes, whole


def heading_deg(boxes: BoxBatch, row: int = 0) -> float:
    return float(np.degrees(np.arctan2(*boxes.rotation[row, [1, 0], 0])))


def test_once_has_x_to_the_left_and_y_backwards(tmp_path: Path) -> None:
    boxes, report = read(once(tmp_path).path)
    assert [CLASSES[code] for code in boxes.cls] == ["car", "bicycle"] and report.frames == 1
    np.testing.assert_allclose(boxes.centre_m, [[9, 1, -1], [-3, 2, -1]])  # 9 m ahead, 1 m to the left
    np.testing.assert_allclose(boxes.size_m[0], [4.5, 1.8, 1.5])
    assert heading_deg(boxes) == pytest.approx(90 + np.degrees(0.5))


@pytest.mark.parametrize("inner", [".", "000027", "000027/000027.json"])
def test_once_is_found_from_the_data_set_the_sequence_and_its_file(tmp_path: Path, inner: str) -> None:
    once(tmp_path)
    assert read(tmp_path / inner)[1].boxes == {"car": 1, "bicycle": 1, "pedestrian": 0}


@pytest.mark.parametrize("inner", [".", "000001"])
def test_zod_comes_through_the_lidar_to_the_car(tmp_path: Path, inner: str) -> None:
    zod(tmp_path)
    boxes, report = read(tmp_path / inner)
    np.testing.assert_allclose(
        boxes.centre_m, [[21.5, 2, 0.75]]
    )  # y of the LiDAR is forward, 2 m to the left
    turned = Rotation.from_quat([0, 0, 0.6, 0.8]).as_euler("xyz", degrees=True)[2] - 90
    assert heading_deg(boxes) == pytest.approx(turned)
    assert report.boxes["car"] == 1 and "1 objects have no box in space and do not count" in report.notes


def test_dair_v2x_boxes_are_those_of_the_lidar(tmp_path: Path) -> None:
    boxes, _ = read(dair_v2x(tmp_path).path)
    np.testing.assert_allclose(boxes.centre_m, [[12.5, -3, -1]])
    np.testing.assert_allclose(boxes.size_m, [[4.5, 1.8, 1.5]])
    assert heading_deg(boxes) == pytest.approx(np.degrees(0.5))


@pytest.mark.parametrize("inner", [".", "641"])
def test_opv2v_boxes_are_those_of_carla_mirrored(tmp_path: Path, inner: str) -> None:
    opv2v(tmp_path)
    boxes, report = read(tmp_path / inner)
    mirror = np.diag([1.0, -1.0, 1.0, 1.0])
    own = carla_matrix([102.0, 70.0, 0.85, 0.0, 60.0, 0.0])
    ego = carla_matrix([100.0, 50.0, 0.1, 0.0, 90.0, 0.0])
    expected = mirror @ np.linalg.inv(ego) @ own @ mirror
    np.testing.assert_allclose(boxes.centre_m[0], expected[:3, 3], atol=1e-9)
    np.testing.assert_allclose(boxes.rotation[0], expected[:3, :3], atol=1e-12)
    np.testing.assert_allclose(boxes.size_m, [[4.5, 1.8, 1.5]])
    assert boxes.centre_m[0, 0] == pytest.approx(20.0) and heading_deg(boxes) == pytest.approx(30.0)
    assert report.frames == 1


@pytest.mark.parametrize(
    ("make", "sound", "broken", "complaint"),
    [
        (once, (ONCE, b'["Car", "Cyclist"]'), b'["Car"]', "as many names as boxes"),
        (once, (ONCE, b"4.5,1.8"), b"NaN,1.8", "boxes_3d: must be a finite number"),
        (once, (ONCE, b"4.5,1.8"), b"-4.5,1.8", "frame 1: object 1: length"),
        (zod, (ZOD, b'"orientation_3d_qw": 0.8'), b'"orientation_3d_qw": 8', "orientation_3d: quaternion"),
        (zod, (ZOD, b'"size_3d_width": 1.8,'), b"", "size_3d_width: must be a finite number"),
        (zod, (ZOD, b'"class": "Vehicle", "object_type": "Car"'), b'"class": 5', "name of an object"),
        (dair_v2x, (DAIR, b'"rotation": "0.5"'), b'"rotation": "east"', r"rotation: must be .*'east'"),
        (dair_v2x, (DAIR, b"}]"), b"}", "must be JSON"),
        (opv2v, (OPV2V, b"true_ego_pos"), b"ego_pos", "true_ego_pos: must be a list"),
        (opv2v, (OPV2V, b"extent: [2.25, 0.9, 0.75]"), b"extent: [2.25]", "extent: must be 3 numbers"),
    ],
)
def test_broken_files_are_refused_with_their_place(make, sound, broken, complaint, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    made = make(tmp_path)
    whole, part = sound
    assert whole.count(part) == 1 or part == b"}]"
    made.files[0].write_bytes(whole.replace(part, broken))
    with pytest.raises(InputError, match=complaint) as caught:
        list(open_boxes(made.path).batches())
    assert made.files[0].name in str(caught.value) and str(caught.value).isprintable()


def test_zod_without_its_calibration_is_refused(tmp_path: Path) -> None:
    made = zod(tmp_path)
    made.files[1].unlink()
    with pytest.raises(InputError, match=r"calibration\.json: missing"):
        list(open_boxes(made.path).batches())


def test_the_hash_depends_on_the_calibration(tmp_path: Path) -> None:
    made = zod(tmp_path)
    before = open_boxes(made.path).content_hash
    made.files[1].write_bytes(made.files[1].read_bytes().replace(b"1.5]", b"1.6]"))
    assert open_boxes(made.path).content_hash != before
