"""POG files come back as they were, damaged ones are refused, and the cache heals itself."""

import gc
import io
import os
import pickle
import stat
import sys
import zipfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from riglens.core.cache_folder import cache_folder
from riglens.core.errors import InputError
from riglens.core.scene.grid import VoxelGrid
from riglens.core.scene.pog import Pog, build_pog
from riglens.core.scene.pog_store import cached_pog, load_pog, save_pog
from tests.core.builders import Boxes, boxes_of

GRID = VoxelGrid(0.5, (4.0, 3.0, 2.0))
BOXES = boxes_of(
    (0, 0, (0.0, 0.0, 1.0), (2.0, 1.0, 1.0), 0.3),
    (1, 2, (0.5, 0.2, 1.0), (1.0, 1.0, 1.0), 0.0),
    frames=3,
)


@pytest.fixture
def pog() -> Pog:
    return build_pog(BOXES, GRID)


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("RIGLENS_CACHE_DIR", str(tmp_path / "cache"))
    return tmp_path / "cache"


def assert_same(found: Pog, expected: Pog) -> None:
    assert found.grid == expected.grid
    assert found.data == expected.data
    assert found.counts.dtype == expected.counts.dtype
    assert np.array_equal(found.counts, expected.counts)
    assert np.array_equal(found.index.words, expected.index.words)
    assert np.array_equal(found.index.first, expected.index.first)


def refused(path: Path) -> str:
    """The message of load_pog about a file, which is one line naming the file."""
    with pytest.raises(InputError) as caught:
        load_pog(path)
    message = str(caught.value)
    assert "\n" not in message and str(path) in message
    return message


def test_a_saved_pog_comes_back_as_it_was(pog: Pog, tmp_path: Path) -> None:
    data = replace(
        pog.data, unmapped=pog.data.unmapped + type(pog.data.unmapped)(tram=7), notes=("one", "two")
    )
    told = replace(pog, data=data)
    save_pog(told, tmp_path / "x.npz")
    found = load_pog(tmp_path / "x.npz")
    assert_same(found, told)
    assert found.data.statistics == told.data.statistics is not None


def test_a_missing_file_a_folder_and_foreign_files_are_refused(tmp_path: Path) -> None:
    assert "no such file" in refused(tmp_path / "nothing.npz")
    refused(tmp_path)
    for number, content in enumerate([b"", b"hello", b"PK\x03\x04", pickle.dumps([1]), b"\x93NUMPY"]):
        path = tmp_path / f"{number}.npz"
        path.write_bytes(content)
        refused(path)
    np.save(tmp_path / "array.npy", np.zeros(3))
    refused(tmp_path / "array.npy")
    np.savez(tmp_path / "other.npz", words=np.zeros(3))
    refused(tmp_path / "other.npz")


def test_any_flipped_byte_is_noticed_or_harmless(pog: Pog, tmp_path: Path) -> None:
    path = tmp_path / "x.npz"
    save_pog(pog, path)
    content = path.read_bytes()
    noticed = 0
    for position in range(0, len(content), 3):
        damaged = bytearray(content)
        damaged[position] ^= 0xFF if position % 2 else 0x01
        path.write_bytes(damaged)
        try:
            assert_same(load_pog(path), pog)
        except InputError:
            noticed += 1
    assert noticed > len(content) / 3 / 4


@pytest.mark.parametrize("name", ["header", "counts", "words", "digest"])
def test_content_that_was_changed_without_the_checksum_is_refused(
    pog: Pog, tmp_path: Path, name: str
) -> None:
    """The archive's own checksums are right: each array is whole, and could be that of another POG."""
    path = tmp_path / "x.npz"
    other = build_pog(replace(BOXES, centre_m=BOXES.centre_m + 0.5), GRID)
    save_pog(replace(other, data=replace(other.data, source="another")), tmp_path / "other.npz")
    save_pog(pog, path)
    with np.load(path) as whole, np.load(tmp_path / "other.npz") as another:
        arrays = {key: whole[key] for key in whole.files}
        changed = np.maximum(arrays["counts"], 1) if name == "counts" else another[name]
    assert not np.array_equal(arrays[name], changed)
    np.savez(path, **(arrays | {name: changed}))
    assert "checksum differs" in refused(path)


def test_a_truncated_file_is_refused(pog: Pog, tmp_path: Path) -> None:
    path = tmp_path / "x.npz"
    save_pog(pog, path)
    content = path.read_bytes()
    for length in range(0, len(content), 97):
        path.write_bytes(content[:length])
        refused(path)


def test_a_pickle_inside_is_never_run(pog: Pog, tmp_path: Path) -> None:
    path, victim = tmp_path / "x.npz", tmp_path / "victim"

    class Attack:
        def __reduce__(self) -> tuple[object, tuple[str]]:
            return os.mkdir, (str(victim),)

    save_pog(pog, path)
    with np.load(path) as archive:
        arrays = {name: archive[name] for name in archive.files}
    with zipfile.ZipFile(path, "w") as archive:
        for name, array in arrays.items():
            buffer = io.BytesIO()
            np.save(buffer, np.array([Attack()], object) if name == "words" else array)
            archive.writestr(f"{name}.npy", buffer.getvalue())
    refused(path)
    assert not victim.exists()


def test_an_unwritable_place_is_refused_and_nothing_is_left(pog: Pog, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be written"):
        save_pog(pog, tmp_path / "no such folder" / "x.npz")
    with pytest.raises(InputError, match="cannot be written"):
        save_pog(pog, tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_an_interruption_between_two_arrays_leaves_neither_a_file_nor_an_archive_that_complains(
    pog: Pog, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(archive: zipfile.ZipFile, *words: Any, **options: Any) -> None:
        member = opened(archive, *words, **options)
        members.append(member)
        raise KeyboardInterrupt

    opened, members, lost = zipfile.ZipFile.open, [], []
    monkeypatch.setattr(zipfile.ZipFile, "open", interrupted)
    monkeypatch.setattr(sys, "unraisablehook", lambda told: lost.append(told.exc_value))
    with pytest.raises((KeyboardInterrupt, ValueError)):
        save_pog(pog, tmp_path / "x.npz")
    members.clear()
    gc.collect()
    assert lost == [] and list(tmp_path.iterdir()) == []


class Counting(Boxes):
    """Boxes that count how often they are read."""

    read = 0

    def batches(self, progress=None):  # type: ignore[no-untyped-def]
        type(self).read += 1
        return super().batches(progress)


@pytest.fixture
def source() -> Counting:
    Counting.read = 0
    return Counting(**vars(BOXES))


def test_the_cache_saves_the_second_reading(cache: Path, source: Counting) -> None:
    first, second = cached_pog(source, GRID), cached_pog(source, GRID)
    assert Counting.read == 1
    assert_same(second, first)
    assert [path.parent for path in cache.iterdir()] == [cache]


@pytest.mark.parametrize("damage", [b"", b"garbage", None])
def test_a_damaged_cache_file_is_rebuilt(cache: Path, source: Counting, damage: bytes | None) -> None:
    first = cached_pog(source, GRID)
    (file,) = cache.iterdir()
    content = file.read_bytes()
    file.write_bytes(content[: len(content) // 2] if damage is None else damage)
    assert_same(cached_pog(source, GRID), first)
    assert Counting.read == 2
    assert_same(cached_pog(source, GRID), first)
    assert Counting.read == 2


def test_the_cache_tells_grids_and_contents_apart(cache: Path, source: Counting) -> None:
    cached_pog(source, GRID)
    for grid in (
        VoxelGrid(0.25, GRID.roi_m),
        VoxelGrid(0.5, (4.0, 3.0, 2.5)),
        VoxelGrid(0.5, (3.0, 4.0, 2.0)),
    ):
        assert cached_pog(source, grid).grid == grid
    assert cached_pog(replace(source, frames=4), GRID).data.frames == 4
    moved = replace(source, centre_m=source.centre_m + 0.5)
    assert not np.array_equal(cached_pog(moved, GRID).index.words, cached_pog(source, GRID).index.words)
    assert len(list(cache.iterdir())) == 6


@pytest.mark.parametrize(
    "obstacle", ["a file where the folder should be", "a folder where the file should be"]
)
def test_without_a_usable_cache_the_pog_is_built_all_the_same(
    cache: Path, source: Counting, pog: Pog, obstacle: str
) -> None:
    if obstacle.startswith("a file"):
        cache.write_text("in the way", encoding="utf-8")
    else:
        cached_pog(source, GRID)
        (file,) = cache.iterdir()
        file.unlink()
        (file / "in the way").mkdir(parents=True)
    assert_same(cached_pog(source, GRID), pog)


def test_a_cache_that_may_not_be_looked_into_does_no_harm(
    cache: Path, source: Counting, pog: Pog, monkeypatch: pytest.MonkeyPatch
) -> None:
    def forbidden(*_: object, **__: object) -> None:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "exists", forbidden)
    monkeypatch.setattr(Path, "mkdir", forbidden)
    assert_same(cached_pog(source, GRID), pog)


def test_the_cache_lies_where_the_environment_says_and_else_with_the_user(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("RIGLENS_CACHE_DIR", "/somewhere/else")
    assert cache_folder() == Path("/somewhere/else")
    monkeypatch.delenv("RIGLENS_CACHE_DIR")
    monkeypatch.setenv("HOME", "/home/somebody")
    assert "riglens" in str(cache_folder())


def test_a_pog_can_be_written_to_a_device_that_swallows_it_and_leaves_the_device(
    tmp_path: Path, pog: Pog
) -> None:
    """`riglens pog --out /dev/null` failed; this is a device of the test's own, which could be replaced."""
    null = tmp_path / "null"
    try:
        os.mknod(null, stat.S_IFCHR | 0o666, os.makedev(1, 3))
        null.write_bytes(b"x")
    except (OSError, AttributeError):
        pytest.skip("only the system's administrator may make devices, and not everywhere")
    save_pog(pog, null)
    assert stat.S_ISCHR(null.stat().st_mode) and [path.name for path in tmp_path.iterdir()] == ["null"]
