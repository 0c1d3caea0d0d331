"""A POG file made to mislead is refused in one line that names file and field, before any kernel sees its arrays."""

import io
import json
import os
import tracemalloc
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from riglens.core.errors import InputError
from riglens.core.scene import pog_store
from riglens.core.scene.columns import VoxelIndex, empty_words, unpack
from riglens.core.scene.grid import VoxelGrid
from riglens.core.scene.pog import Pog, PogSum, build_pog
from riglens.core.scene.pog_store import cached_pog, load_pog, pog_key, read_pog, save_pog
from tests.core.builders import boxes_of

GRID = VoxelGrid(0.5, (4.0, 3.0, 2.0))
BOXES = boxes_of(
    (0, 0, (0.0, 0.0, 1.0), (2.0, 1.0, 1.0), 0.3),
    (1, 2, (0.5, 0.2, 1.0), (1.0, 1.0, 1.0), 0.0),
    frames=3,
)
LEVELS = GRID.shape[2]


@pytest.fixture
def path(tmp_path: Path) -> Path:
    """A sound POG file."""
    save_pog(build_pog(BOXES, GRID), tmp_path / "x.npz")
    return tmp_path / "x.npz"


def arrays_of(path: Path) -> dict[str, Any]:
    with np.load(path) as archive:
        return {name: archive[name] for name in archive.files}


def rewrite(path: Path, **changes: Any) -> None:
    """Exchange arrays of a POG file; the checksum is right afterwards, as whoever means harm makes it."""
    arrays = arrays_of(path) | {name: np.asarray(value) for name, value in changes.items()}
    arrays["digest"] = np.array(pog_store._digest(str(arrays["header"]), arrays["words"], arrays["counts"]))
    np.savez(path, **arrays)


def set_field(path: Path, name: str, value: Any) -> None:
    header = json.loads(str(arrays_of(path)["header"])) | {name: value}
    rewrite(path, header=json.dumps(header))


def refused(path: Path) -> str:
    """The message of load_pog about a file: one line naming it."""
    with pytest.raises(InputError) as caught:
        load_pog(path)
    message = str(caught.value)
    assert message.isprintable() and str(path) in message and len(message) < 600
    return message


def test_the_sound_file_of_these_tests_is_read(path: Path) -> None:
    rewrite(path)
    assert load_pog(path).data.frames == 3


@pytest.mark.parametrize("levels", [1, 3, 4, 63])
def test_voxels_above_the_grid_are_refused(tmp_path: Path, levels: int) -> None:
    grid = VoxelGrid(0.5, (2.0, 2.0, levels * 0.5))
    save_pog(build_pog(BOXES, grid), tmp_path / "x.npz")
    for level in (levels, 63):
        words = empty_words(grid)
        words[5] = np.uint64(1) << np.uint64(level)
        rewrite(tmp_path / "x.npz", words=words, counts=np.ones((1, 3), np.uint16))
        assert f"words: found voxels above the grid's height of {levels} levels" in refused(
            tmp_path / "x.npz"
        )


def test_a_full_file_of_another_height_is_refused(path: Path) -> None:
    """The case that corrupted the heap: all 64 bits of every word, for a grid of four levels."""
    words = np.full(empty_words(GRID).size, 0xFFFFFFFFFFFFFFFF, np.uint64)
    rewrite(path, words=words, counts=np.ones((64 * words.size, 3), np.uint16))
    assert "above the grid's height" in refused(path)


def test_grids_of_whole_words_may_use_every_bit(tmp_path: Path) -> None:
    grid = VoxelGrid(0.5, (1.0, 1.0, 32.0))
    save_pog(build_pog(BOXES, grid), tmp_path / "x.npz")
    rewrite(
        tmp_path / "x.npz",
        words=np.full(4, 0xFFFFFFFFFFFFFFFF, np.uint64),
        counts=np.ones((256, 3), np.uint16),
    )
    assert load_pog(tmp_path / "x.npz").index.count == 256


@pytest.mark.parametrize("dtype", [np.uint16, np.uint32])
def test_counts_above_the_number_of_frames_are_refused(path: Path, dtype: type) -> None:
    counts = arrays_of(path)["counts"].astype(dtype)
    counts[1, 2] = 3
    rewrite(path, counts=counts)
    load_pog(path)
    counts[1, 2] = 4
    rewrite(path, counts=counts)
    assert "counts must be at most 3, the number of frames (got 4)" in refused(path)


@pytest.mark.parametrize("change", [1, -1])
def test_counts_for_more_or_fewer_voxels_are_refused(path: Path, change: int) -> None:
    counts = np.ones((arrays_of(path)["counts"].shape[0] + change, 3), np.uint16)
    rewrite(path, counts=counts)
    assert "counts must" in refused(path)


STATISTICS: dict[str, Any] = {
    "placed": {}, "sizes": {}, "bottoms": {}, "frames": 0, "most": 0, "origin_m": None, "is_origin_known": False,
}  # fmt: skip


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("frames", 0),
        ("frames", -3),
        ("frames", 10**400),
        ("frames", -(10**400)),
        ("frames", 2**32),
        ("frames", 3.0),
        ("frames", True),
        ("frames", "3"),
        ("frames", None),
        ("sequences", -1),
        ("sequences", 10**400),
        ("sequences", [1]),
        ("boxes", {"car": -1}),
        ("boxes", {"car": 10**400}),
        ("boxes", {"car": 1.5}),
        ("boxes", [1, 2, 3]),
        ("boxes", None),
        ("unmapped", {"tram": -1}),
        ("unmapped", {"tram": "many"}),
        ("unmapped", {"\ud800": 1}),
        ("unmapped", {f"name {number}": 1 for number in range(10_001)}),
        ("unmapped", 7),
        ("source", 7),
        ("source", "\ud800"),
        ("source", None),
        ("sha256", {}),
        ("notes", "a text"),
        ("notes", [1]),
        ("statistics", 7),
        ("statistics", {"placed": {}}),
        *(
            ("statistics", STATISTICS | wrong)
            for wrong in (
                {"placed": {"-1": 1}},
                {"placed": {"60": 1}},
                {"sizes": {"1e3": 1}},
                {"bottoms": {"9" * 5000: 1}},
                {"bottoms": {"0": 10**400}},
                {"origin_m": [0.0, 0.0]},
                {"origin_m": [0.0, 0.0, float("nan")]},
                {"most": -1},
            )
        ),
        ("voxel_m", "0.5"),
        ("voxel_m", 10**400),
        ("voxel_m", float("nan")),
        ("voxel_m", -0.5),
        ("voxel_m", True),
        ("roi_m", [4.0, 3.0]),
        ("roi_m", [4.0, 3.0, 2.0, 1.0]),
        ("roi_m", [4.0, 3.0, float("inf")]),
        ("roi_m", [4.0, 3.0, "\x1b[31m"]),
        ("roi_m", 5),
    ],
)
def test_wrong_header_fields_are_refused_by_name(path: Path, name: str, value: Any) -> None:
    set_field(path, name, value)
    assert f": {name}" in refused(path)


@pytest.mark.parametrize("header", ['{"riglens_pog": 99}', "{}", "[]", "not json"])
def test_headers_of_something_else_are_refused(path: Path, header: str) -> None:
    rewrite(path, header=header)
    refused(path)


def test_header_fields_that_an_older_file_lacks_have_defaults(path: Path) -> None:
    header = json.loads(str(arrays_of(path)["header"]))
    for name in ("notes", "sequences", "statistics"):
        del header[name]
    rewrite(path, header=json.dumps(header))
    assert load_pog(path).data.sequences == 1


def npy_header(shape: tuple[int, ...], dtype: str) -> bytes:
    """The beginning of an array's file; its content is left out."""
    buffer = io.BytesIO()
    np.lib.format.write_array_header_1_0(buffer, {"descr": dtype, "fortran_order": False, "shape": shape})
    return buffer.getvalue()


@pytest.mark.parametrize(
    ("name", "shape", "dtype"),
    [
        ("words", (1 << 32,), "<u8"),
        ("words", (1 << 62,), "<u8"),
        ("counts", (1 << 38, 3), "<u2"),
        ("counts", (-5, 3), "<u2"),
        ("header", (), "<U300000000"),
        ("digest", (1 << 34,), "<U64"),
    ],
)
def test_sizes_are_known_before_memory_is_taken(
    path: Path, name: str, shape: tuple[int, ...], dtype: str
) -> None:
    arrays = arrays_of(path)
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for key, array in arrays.items():
            with archive.open(f"{key}.npy", "w") as member:
                if key == name:
                    member.write(npy_header(shape, dtype) + bytes(1 << 20))
                else:
                    np.lib.format.write_array(member, array)
    tracemalloc.start()
    try:
        assert f": {name} must be" in refused(path)
        assert tracemalloc.get_traced_memory()[1] < 20e6
    finally:
        tracemalloc.stop()


def test_arrays_that_expand_beyond_their_shape_are_not_read_to_the_end(path: Path) -> None:
    arrays = arrays_of(path)
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for key, array in arrays.items():
            with archive.open(f"{key}.npy", "w") as member:
                np.lib.format.write_array(member, array)
                member.write(bytes(50_000_000) if key == "words" else b"")
    tracemalloc.start()
    try:
        assert "words: longer than its shape" in refused(path)
        assert tracemalloc.get_traced_memory()[1] < 20e6
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize("kind", [zipfile.ZIP_LZMA, zipfile.ZIP_BZIP2])
def test_other_compressions_are_refused(path: Path, kind: int) -> None:
    arrays = arrays_of(path)
    with zipfile.ZipFile(path, "w", kind) as archive:
        for key, array in arrays.items():
            with archive.open(f"{key}.npy", "w") as member:
                np.lib.format.write_array(member, array)
    assert "compressed in another way" in refused(path)


def test_arrays_of_other_layouts_are_refused(path: Path) -> None:
    arrays = arrays_of(path)
    rewrite(path, words=arrays["words"].astype(">u8"))
    assert "words must be" in refused(path)
    rewrite(path, words=arrays["words"], counts=np.asfortranarray(arrays["counts"]))
    assert "counts must" in refused(path)


def test_devices_and_pipes_are_refused_at_once(path: Path, tmp_path: Path) -> None:
    (tmp_path / "zero.npz").symlink_to("/dev/zero")
    os.mkfifo(tmp_path / "pipe.npz")
    assert "(got a device)" in refused(Path("/dev/zero"))
    assert "(got a device)" in refused(tmp_path / "zero.npz")
    assert "(got a pipe)" in refused(tmp_path / "pipe.npz")
    assert "cannot be read: Is a directory" in refused(tmp_path)
    (tmp_path / "link.npz").symlink_to(path)
    assert load_pog(tmp_path / "link.npz").data.frames == 3


def test_only_a_part_may_hold_no_frame(tmp_path: Path) -> None:
    sound = build_pog(BOXES, GRID)
    index = VoxelIndex.of(GRID, empty_words(GRID))
    empty = Pog.of(GRID, boxes_of(frames=0).report(), index, sound.counts[:0])
    save_pog(empty, tmp_path / "part.npz")
    with (tmp_path / "part.npz").open("rb") as file:
        assert read_pog(file, is_part=True).data.frames == 0
    assert "frames must be" in refused(tmp_path / "part.npz")


def test_a_cached_file_of_another_grid_is_not_taken(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("RIGLENS_CACHE_DIR", str(tmp_path))
    other = VoxelGrid(0.5, (3.0, 4.0, 2.0))
    save_pog(build_pog(BOXES, other), tmp_path / f"{pog_key(BOXES.content_hash, GRID)}.npz")
    assert cached_pog(BOXES, GRID).grid == GRID


def test_kernels_never_get_words_or_counts_of_another_grid() -> None:
    sound = build_pog(BOXES, GRID)
    for words in (empty_words(GRID)[:-1], empty_words(GRID).astype(np.int64), ~empty_words(GRID)):
        with pytest.raises(ValueError, match="words"):
            VoxelIndex.of(GRID, words)
        with pytest.raises(ValueError, match="words"):
            unpack(GRID, words)
    with pytest.raises(ValueError, match="counts"):
        Pog.of(GRID, sound.data, sound.index, sound.counts[:-1])
    with pytest.raises(ValueError, match="counts"):
        Pog.of(VoxelGrid(0.25, GRID.roi_m), sound.data, sound.index, sound.counts)
    with pytest.raises(ValueError, match="grid"):
        PogSum(VoxelGrid(0.25, GRID.roi_m)).add(sound)
