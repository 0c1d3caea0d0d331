"""Cases that no other test held when small mistakes were made on purpose (`python -m tests.mutation`), by room."""

from __future__ import annotations

import io
import os
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from riglens.core.errors import InputError
from riglens.core.files import atomic_folder
from riglens.core.formats.frames import FrameTree
from riglens.core.formats.lenses import brown_conrady
from riglens.core.formats.report import Notes
from riglens.core.formats.source import Source, Value
from riglens.core.geometry import rotation_from_rpy_deg, rpy_deg_near
from riglens.core.rig.history import History, Marks
from riglens.core.rig.model import BrownConrady, Camera, KannalaBrandt, Rig
from riglens.core.rig.pose_text import parse_pose
from riglens.core.rig.presets import preset
from riglens.core.rig.yaml.file import dumps, same_rig
from riglens.core.scene import pog_store
from riglens.core.scene.boxes import BoxBatch, FrameLabels, rotations_from_quaternions, rotations_from_yaw
from riglens.core.scene.grid import VoxelGrid
from riglens.core.scene.pog import Pog, PogSum, build_pog
from riglens.core.scene.pog_store import read_pog, write_pog
from riglens.core.scene.readers import common, frames
from riglens.core.scene.readers.classes import ClassTable
from riglens.core.scene.readers.common import first_bad_number
from riglens.core.scene.readers.frames import FrameCounter, WholeFrames
from riglens.core.scene.sectors import SECTORS, sector_of
from riglens.core.sensing.rays import lattice, missing_ray_count
from riglens.core.sensors.lens import distorted
from tests.core.builders import camera, rig_of
from tests.core.test_pog_store import BOXES, GRID

RANDOM = np.random.default_rng(17)


# ---------------------------------------------------------------- geometry, files


def test_angles_that_are_as_before_keep_their_bits_and_others_do_not() -> None:
    before = (10.0, -20.0, 180.0)
    assert rpy_deg_near(rotation_from_rpy_deg((10.0, -20.0, -180.0)), before) == before
    for change in (-1e-11, 1e-11):
        assert (
            rpy_deg_near(rotation_from_rpy_deg((10.0 + change, -20.0 - change, 180.0 + change)), before)
            == before
        )
    roll, pitch, yaw = rpy_deg_near(rotation_from_rpy_deg((10.000001, -20.0, 179.0)), before)
    assert (roll != 10.0, pitch, yaw) == (True, -20.0, pytest.approx(179.0))


def test_an_old_folder_comes_back_when_the_new_one_cannot_take_its_place(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    target, rename = tmp_path / "kit", os.rename
    atomic_folder(target, {"a.yaml": b"old"})

    def failing(one: Path, other: Path) -> None:
        if Path(other) == target and Path(one).suffix == ".tmp":
            raise OSError("no")
        rename(one, other)

    monkeypatch.setattr(os, "rename", failing)
    with pytest.raises(InputError):
        atomic_folder(target, {"a.yaml": b"new"})
    assert (target / "a.yaml").read_bytes() == b"old" and os.listdir(tmp_path) == ["kit"]


# ---------------------------------------------------------------- scene


def test_rotations_are_those_of_scipy_whatever_the_length_of_the_quaternion() -> None:
    yaw = RANDOM.uniform(-4.0, 4.0, 20)
    assert np.allclose(
        rotations_from_yaw(yaw), Rotation.from_euler("z", yaw[:, None]).as_matrix(), atol=1e-12
    )
    wxyz = RANDOM.normal(size=(20, 4)) * RANDOM.uniform(0.1, 9.0, (20, 1))
    expected = Rotation.from_quat(wxyz[:, [1, 2, 3, 0]]).as_matrix()
    assert np.allclose(rotations_from_quaternions(wxyz), expected, atol=1e-12)


def test_joined_labels_name_the_frames_of_both() -> None:
    one = FrameLabels(("a", "b"), np.array([0, 1]), np.array([5, 7]))
    other = FrameLabels(("c",), np.array([0]), np.array([9]))
    assert [one.joined(other).of(frame) for frame in range(3)] == [("a", 5), ("b", 7), ("c", 9)]


def test_a_pog_larger_than_the_free_memory_is_refused_before_it_is_taken(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    stored = io.BytesIO()
    write_pog(build_pog(BOXES, GRID), stored)
    monkeypatch.setattr(pog_store.psutil, "virtual_memory", lambda: SimpleNamespace(available=100))
    with pytest.raises(ValueError, match=r"words: needs .* GB of memory"):
        read_pog(stored)


def test_parts_add_up_and_belong_to_one_grid() -> None:
    pog, twice = build_pog(BOXES, GRID), PogSum(GRID)
    twice.add(pog)
    twice.add(pog)
    both = twice.pog(replace(pog.data, frames=2 * pog.data.frames))
    np.testing.assert_array_equal(both.counts, 2 * pog.counts)
    with pytest.raises(ValueError, match="the grid of a part"):
        PogSum(VoxelGrid(0.5, (4.0, 4.0, 2.0))).add(pog)
    with pytest.raises(ValueError, match="counts must"):
        Pog.of(GRID, pog.data, pog.index, pog.counts[1:])


def test_a_box_is_bad_on_either_side_of_the_car() -> None:
    for x_m in (-2e6, 2e6):
        assert first_bad_number(
            np.array([[0.0, 0.0, 0.0, 1.0, 1.0, 1.0], [x_m, 0.0, 0.0, 1.0, 1.0, 1.0]])
        ) == (1, 0)


def test_equal_frames_of_two_sequences_are_two_frames() -> None:
    codes, frame = np.array([0, 0, 1, 1], np.intp), np.array([0, 0, 0, 1])
    assert FrameCounter().number(["a", "b"], codes, frame).tolist() == [0, 0, 1, 2]


def test_boxes_of_one_frame_are_counted_across_pieces(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(frames, "MAX_BOXES_PER_FRAME", 3)
    none = np.zeros((2, 3))
    piece = BoxBatch(np.zeros(2, np.int64), np.zeros(2, np.uint8), none, none, np.zeros((2, 3, 3)))
    whole = WholeFrames(Path("a.csv"))
    assert list(whole.push(piece, 0)) == []
    with pytest.raises(InputError, match=r"a\.csv: too many boxes in one frame"):
        list(whole.push(piece, 0))


@pytest.mark.parametrize(
    ("least", "ends"), [(1, [2, 5, 6]), (2, [2, 5, 6]), (3, [5, 6]), (5, [5, 6]), (9, [6])]
)
def test_a_piece_of_a_table_ends_behind_the_last_row_of_a_frame(
    monkeypatch: pytest.MonkeyPatch, least: int, ends: list[int]
) -> None:
    monkeypatch.setattr(common, "BATCH_BOXES", least)
    runs = list(common.whole_frames(np.array([0, 0, 1, 1, 1, 2])))
    assert [run.stop for run in runs] == ends
    assert [run.start for run in runs] == [0, *ends[:-1]]


def test_a_class_that_there_is_not_is_refused() -> None:
    with pytest.raises(InputError, match=r"^classes must map 'dog' to one of"):
        ClassTable({}, {"dog": "animal"})


# ---------------------------------------------------------------- rig, formats


def test_marks_alone_are_a_step() -> None:
    history = History(preset("W+T"))
    assert history.apply("hide", history.rig, marks=Marks(hidden=frozenset({"x"})))
    assert not history.apply("hide", history.rig, marks=Marks(hidden=frozenset({"x"})))
    assert history.undo() and history.marks == Marks()


def test_zeros_of_different_sign_are_different_rigs() -> None:
    zero = camera((0.0, 0.0, 1.0))
    assert not same_rig(rig_of(zero), rig_of(zero.replace(position=(-0.0, 0.0, 1.0))))


@pytest.mark.parametrize("name", ["yes", "No", "off", "y"])
def test_a_name_that_older_yaml_takes_for_a_choice_is_quoted(name: str) -> None:
    assert f'name: "{name}"\n' in dumps(Rig(name=name))


def test_no_two_sensors_have_one_name() -> None:
    with pytest.raises(ValueError, match=r"name '.*' is used twice"):
        Rig(sensors=(camera((0.0, 0.0, 1.0)), camera((0.0, 0.0, 2.0))))


def test_sensors_that_are_off_are_not_listed() -> None:
    rig = preset("W+T")
    off = rig.replace(sensors=tuple(sensor.replace(enabled=False) for sensor in rig.sensors))
    assert (
        len(rig.enabled_lidars()) + len(rig.enabled_cameras()) == len(rig.sensors)
        and off.enabled_lidars() == off.enabled_cameras() == ()
    )


def test_the_narrowest_field_of_view_is_stated() -> None:
    with pytest.raises(ValueError, match=r"greater than or equal to 0\.001"):
        Camera(name="C", position=(0.0, 0.0, 1.0), hfov_deg=0.0009)


@pytest.mark.parametrize("text", ["-1e8 0 0 0 0 0", "0 0 -1e8 0 0 0", "0 0 1 0 0 -1e7"])
def test_a_pose_far_behind_is_too_far_as_well(text: str) -> None:
    with pytest.raises(InputError, match="must be finite"):
        parse_pose(text)


def test_a_text_with_a_nul_is_told_as_no_text(tmp_path: Path) -> None:
    (tmp_path / "a.json").write_bytes(b'{"a": "\0"}')
    with pytest.raises(InputError, match=r"a\.json: must be a rig file in UTF-8"):
        _ = Source(tmp_path / "a.json").json


def test_a_frame_has_one_parent_and_is_not_its_own() -> None:
    tree = FrameTree("a.yaml")
    tree.add("base", "kit", np.eye(4))
    for parent, child in (("other", "kit"), ("mast", "mast")):
        with pytest.raises(InputError, match=f"a.yaml: frame '{child}' has two parents"):
            tree.add(parent, child, np.eye(4))


@pytest.mark.parametrize("pairs", [[("a", "LONG"), ("b", "LONG")], [("LONG", "a"), ("a", "LONG")]])
def test_lines_about_frames_are_short_however_long_their_names_are(pairs: list[tuple[str, str]]) -> None:
    tree = FrameTree("a.yaml")
    with pytest.raises(InputError) as caught:
        for parent, child in pairs:
            tree.add(parent.replace("LONG", "9" * 800), child.replace("LONG", "9" * 800), np.eye(4))
        tree.root_of("9" * 800)
    assert len(str(caught.value)) < 200 and str(caught.value).isprintable()


def test_frames_are_chained_from_the_root_outwards() -> None:
    tree, turn, ahead = FrameTree("a.yaml"), np.eye(4), np.eye(4)
    turn[:3, :3] = rotation_from_rpy_deg((0.0, 0.0, 90.0))
    ahead[0, 3] = 2.0
    tree.add("base", "turned", turn)
    tree.add("turned", "ahead", ahead)
    assert tree.root_SE3("ahead")[:3, 3] == pytest.approx([0.0, 2.0, 0.0])


def test_a_distortion_of_zeros_is_none() -> None:
    notes = Notes()
    assert brown_conrady(Value([0.0] * 4, "a.yaml"), [0.0] * 4, "C", notes) == {}
    assert brown_conrady(Value([0.1], "a.yaml"), [0.1], "C", notes)["distortion"].k1 == 0.1


# ---------------------------------------------------------------- sensing


def test_a_fisheye_has_no_ray_beyond_straight_behind() -> None:
    around = Camera(
        name="C", position=(0.0, 0.0, 1.0), image=(200, 200), cast=(200, 200), fx=20.0, fy=20.0, cx=100.0,
        cy=100.0, distortion=KannalaBrandt(),
    )  # fmt: skip
    place = np.arange(200) + 0.5 - 100.0
    off_axis = np.hypot(*np.meshgrid(place, place)) / 20.0
    assert missing_ray_count(around) == np.count_nonzero(off_axis > np.pi)


def test_nothing_behind_a_distorted_pinhole_is_imaged() -> None:
    plane = distorted(BrownConrady(k1=0.1), np.array([[0.1, 0.1, 1.0], [0.1, 0.1, -1.0]]))
    assert np.isfinite(plane).all(axis=1).tolist() == [True, False]


def test_nothing_beyond_the_fold_of_a_fisheye_is_imaged() -> None:
    lens = KannalaBrandt(k1=-0.2)  # 1 - 0.6 t^2 = 0 at t = 1.29
    angle = np.array([1.2, 1.4])
    plane = distorted(lens, np.stack([np.sin(angle), np.zeros(2), np.cos(angle)], axis=1))
    assert np.isfinite(plane).all(axis=1).tolist() == [True, False]


def test_nothing_that_tangential_terms_turn_over_is_imaged() -> None:
    plane = distorted(BrownConrady(p1=0.5), np.array([[0.0, -0.1, 1.0], [0.0, -0.5, 1.0]]))
    assert np.isfinite(plane).all(axis=1).tolist() == [True, False]


def test_rays_that_a_lens_does_not_have_are_not_cast() -> None:
    matrix = {"fx": 800.0, "fy": 800.0, "cx": 800.0, "cy": 450.0}
    wide = Camera(
        name="C", position=(0.0, 0.0, 1.0), cast=(32, 18), distortion=BrownConrady(k1=-0.5), **matrix
    )
    rows = lattice(wide).rows
    assert np.isfinite(rows).all() and 0 < missing_ray_count(wide) == wide.ray_count - len(rows)


def test_a_tie_between_two_sectors_goes_to_the_left_one() -> None:
    """Half a sector is 22.5 degrees: this double is its tangent."""
    tangent = 0.41421356237309503
    assert np.degrees(np.arctan2(tangent, 1.0)) == 22.5
    x, y = np.array([1.0, 1.0, tangent, -tangent]), np.array([tangent, 0.9999 * tangent, 1.0, 1.0])
    assert [SECTORS[place] for place in sector_of(x, y)] == ["front-left", "front", "left", "rear-left"]
