"""Corner files of the published CARLA code become oriented boxes; nothing in them is ever unpickled."""

import itertools
import pickle
import warnings
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from riglens.core.errors import InputError
from riglens.core.scene.boxes import CLASSES
from riglens.core.scene.readers import open_boxes
from riglens.core.scene.readers.carla import boxes_from_corners
from riglens.core.scene.readers.common import join

SIGNS = np.array(list(itertools.product((-0.5, 0.5), repeat=3)))
CAR_M = np.array([4.5, 1.8, 1.5])


def corners(
    size_m: NDArray[np.float64] = CAR_M, centre: object = (5, -3, 0.8), yaw: float = 0.4
) -> NDArray[np.float64]:
    """Corners (8, 3) of an upright box, in the order of CARLA's get_world_vertices."""
    return Rotation.from_euler("z", yaw).apply(SIGNS * size_m) + np.asarray(centre, dtype=float)


def save(folder: Path, name: str, array: object) -> Path:
    path = folder / name
    path.parent.mkdir(exist_ok=True)
    np.save(path, array, allow_pickle=True)  # type: ignore[arg-type]
    return path


def message(path: Path) -> str:
    with pytest.raises(InputError) as error:
        list(open_boxes(path).batches())
    assert "\n" not in str(error.value)
    return str(error.value)


def test_y_is_flipped_and_the_folder_says_the_class(tmp_path: Path) -> None:
    for index, name in enumerate(("vehicle", "cyclist", "pedestrian")):
        save(tmp_path, f"{name}/101_{index}.npy", corners().T)
    source = open_boxes(tmp_path)
    boxes = join(list(source.batches()))
    assert [CLASSES[code] for code in boxes.cls] == ["car", "bicycle", "pedestrian"]
    np.testing.assert_allclose(boxes.centre_m, [[5, 3, 0.8]] * 3)
    np.testing.assert_allclose(boxes.size_m, [CAR_M] * 3)
    np.testing.assert_allclose(boxes.rotation[0] @ [1, 0, 0], [np.cos(0.4), -np.sin(0.4), 0], atol=1e-12)


@pytest.mark.parametrize("shape", ["3x8", "4x8", "8x3", "8x4"])
@pytest.mark.parametrize("kind", [np.float32, np.float64])
def test_corners_in_rows_or_columns_and_with_ones_are_read(tmp_path: Path, shape: str, kind: type) -> None:
    array = corners() if "3" in shape else np.column_stack([corners(), np.ones(8)])
    save(tmp_path, "vehicle/1_1.npy", (array if shape[0] == "8" else array.T).astype(kind))
    (batch,) = open_boxes(tmp_path).batches()
    np.testing.assert_allclose(batch.centre_m, [[5, 3, 0.8]], atol=1e-5)
    np.testing.assert_allclose(batch.size_m, [CAR_M], atol=1e-5)


@pytest.mark.parametrize(
    ("scale", "message"), [(1e-200, "above 0"), (1e-310, "above 0"), (1e200, "within"), (1e6, "within")]
)
def test_corners_of_no_real_box_are_refused_without_warnings(
    tmp_path: Path, scale: float, message: str
) -> None:
    save(tmp_path, "vehicle/1_1.npy", corners() * scale)
    with warnings.catch_warnings(), pytest.raises(InputError, match=message):
        warnings.simplefilter("error")
        list(open_boxes(tmp_path).batches())


@given(
    size=st.tuples(*[st.floats(0.1, 20)] * 3),
    angles=st.tuples(st.floats(-3.2, 3.2), st.floats(-0.7, 0.7), st.floats(-0.7, 0.7)),
    order=st.permutations(range(8)),
)
def test_any_order_of_corners_gives_the_same_box(
    size: tuple[float, ...], angles: tuple[float, ...], order: list[int]
) -> None:
    points = Rotation.from_euler("zyx", angles).apply(SIGNS * size) + np.array([1.0, 2.0, 3.0])
    centre, size_m, rotation, sound = boxes_from_corners(points[None, order])
    assert sound[0]
    again = (rotation[0] @ (SIGNS * size_m[0]).T).T + centre[0]
    gaps = np.linalg.norm(again[:, None] - points, axis=2)
    assert sorted(gaps.argmin(axis=1)) == list(range(8))
    assert gaps.min(axis=1).max() < 1e-6
    np.testing.assert_allclose(rotation[0] @ rotation[0].T, np.eye(3), atol=1e-6)
    assert np.linalg.det(rotation[0]) > 0.999
    assert rotation[0, 2, 2] > 0.0
    assert size_m[0, 0] >= size_m[0, 1]


def test_frames_run_from_the_first_to_the_last_number_in_its_own_step(tmp_path: Path) -> None:
    for frame in (100, 110, 140):
        save(tmp_path, f"vehicle/7_{frame}.npy", corners())
    save(tmp_path, "pedestrian/walker_3_110.npy", corners())
    source = open_boxes(tmp_path)
    boxes = join(list(source.batches()))
    assert boxes.frame.tolist() == [0, 1, 1, 4]
    assert source.report().frames == 5
    assert source.report().notes == ("frames 100 to 140 in steps of 10; those without a file are empty",)
    more = open_boxes(tmp_path, frames=9)
    list(more.batches())
    assert more.report().frames == 9


def test_an_ignored_folder_is_counted(tmp_path: Path) -> None:
    save(tmp_path, "vehicle/1_0.npy", corners())
    save(tmp_path, "cyclist/2_0.npy", corners())
    source = open_boxes(tmp_path, class_map={"cyclist": "ignore"})
    list(source.batches())
    assert source.report().unmapped == {"cyclist": 1}


class Bomb:
    """Leaves a file behind when it is unpickled."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def __reduce__(self) -> tuple[object, ...]:
        return (Path.touch, (self.path,))


def test_pickled_objects_are_refused_and_never_unpickled(tmp_path: Path) -> None:
    trace = tmp_path / "unpickled"
    array = np.empty(8, dtype=object)
    array[0] = Bomb(trace)
    path = save(tmp_path, "vehicle/1_1.npy", array)
    assert message(tmp_path) == f"{path}: must be a .npy file of numbers (got pickled objects)"
    path.write_bytes(pickle.dumps(Bomb(trace)))
    assert message(tmp_path) == f"{path}: must be a .npy file of numbers (got pickled objects)"
    assert not trace.exists()


@pytest.mark.parametrize(
    ("array", "expected"),
    [
        (np.zeros((7, 3)), "(got (7, 3))"),
        (np.zeros(24), "(got (24,))"),
        (np.zeros((8, 3), dtype=complex), "a .npy file of numbers"),
        (np.full((8, 3), "a"), "a .npy file of numbers"),
        (np.full((8, 3), np.nan), "a finite number in metres"),
        (np.arange(24.0).reshape(8, 3), "the corners of a rectangular box"),
        (corners() + np.eye(8, 3), "the corners of a rectangular box"),
        (corners(np.array([4.5, 0.0, 1.5])), "(got 0)"),
        (corners(centre=(1e9, 0, 0)), "must be a finite number in metres"),
        (np.zeros((8, 3)), "a number in metres above 0"),
        (np.zeros((100_000, 3)), "at most 64 KiB"),
    ],
)
def test_arrays_that_are_no_box_are_refused_by_name(tmp_path: Path, array: object, expected: str) -> None:
    save(tmp_path, "vehicle/1_1.npy", corners())
    path = save(tmp_path, "vehicle/1_2.npy", array)
    text = message(tmp_path)
    assert text.startswith(f"{path}: ")
    assert expected in text


def test_cut_files_archives_and_bad_names_are_refused(tmp_path: Path) -> None:
    path = save(tmp_path, "vehicle/1_1.npy", corners())
    whole = path.read_bytes()
    for broken in (b"", whole[:-1], whole[:40], whole.replace(b"(8, 3)", b"(9, 3)")):
        path.write_bytes(broken)
        assert message(tmp_path).startswith(f"{path}: ")
    np.savez(path.with_suffix(""), corners())
    path.with_suffix(".npz").rename(path)
    assert "a .npy file of numbers" in message(tmp_path)
    path.rename(path.with_name("frame.npy"))
    assert "<actor>_<frame>.npy" in message(tmp_path)


def test_folders_without_files_are_refused(tmp_path: Path) -> None:
    (tmp_path / "vehicle").mkdir()
    assert "<actor>_<frame>.npy" in message(tmp_path)
