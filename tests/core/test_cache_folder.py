"""A cache that cannot be written costs time and one remark, never a result."""

import errno
import logging
import os
from pathlib import Path

import numba
import pytest

from riglens.assets import asset_path
from riglens.core import cache_folder
from riglens.core.cache_folder import keep, stored
from riglens.core.kernels.runtime.compiled import KernelFolder
from riglens.core.rig.library import NAME, read_entries, stored_entries
from riglens.core.scene.pog import build_pog
from riglens.core.scene.pog_store import cached_pog
from riglens.core.vehicle.store import stored_surfaces
from riglens.core.vehicle.surface import superellipsoid
from tests.core.test_pog_store import BOXES, GRID, assert_same


class Workshop:
    """Makes some bytes, and counts how often."""

    made = 0

    def __call__(self) -> bytes:
        self.made += 1
        return b"content\nof two lines"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The cache folder."""
    monkeypatch.setenv("RIGLENS_CACHE_DIR", str(tmp_path / "cache"))
    return tmp_path / "cache"


def test_what_the_same_maker_has_made_is_not_made_again(folder: Path) -> None:
    make = Workshop()
    for maker, times in (("one", 1), ("one", 1), ("other", 2), ("other", 2), ("one", 3)):
        assert stored("x", maker, make) == b"content\nof two lines"
        assert make.made == times


@pytest.mark.parametrize("damage", ["flipped", "cut short", "empty", "text"])
def test_a_damaged_file_is_replaced(folder: Path, damage: str) -> None:
    make = Workshop()
    stored("x", "one", make)
    whole = (folder / "x").read_bytes()
    broken = {
        "flipped": whole[:-3] + bytes([whole[-3] ^ 255]) + whole[-2:],
        "cut short": whole[: len(whole) // 2],
        "empty": b"",
        "text": b"\xff not ours",
    }
    (folder / "x").write_bytes(broken[damage])
    assert stored("x", "one", make) == b"content\nof two lines" and make.made == 2
    assert (folder / "x").read_bytes() == whole


def test_without_a_place_to_keep_it_it_is_made_every_time(folder: Path) -> None:
    folder.write_text("a file where the folder should be", encoding="utf-8")
    make = Workshop()
    for times in (1, 2):
        assert stored("x", "one", make) == b"content\nof two lines"
        assert make.made == times


@pytest.fixture
def full_disk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture) -> Path:
    """The cache folder, on a disk without room for content."""
    cache_folder._tell.cache_clear()

    def no_room(descriptor: int) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "fsync", no_room)
    monkeypatch.setenv("RIGLENS_CACHE_DIR", str(tmp_path / "cache"))
    return tmp_path / "cache"


def test_a_full_disk_is_told_once_with_folder_and_remedy_and_everything_is_computed(
    full_disk: Path, caplog: pytest.LogCaptureFixture
) -> None:
    for _ in range(2):
        assert_same(cached_pog(BOXES, GRID), build_pog(BOXES, GRID))
        library = asset_path("library.yaml")
        assert stored_entries(library) == read_entries(library, library.name)
        ((material, mesh),) = stored_surfaces(
            "test", lambda: [("paint", superellipsoid((1.0, 1.0, 1.0), 1.0))]
        )
        assert material == "paint" and len(mesh.triangles)
    (line,) = [record.getMessage() for record in caplog.records if record.levelno >= logging.WARNING]
    assert f"{full_disk} cannot be written (No space left on device)" in line and "RIGLENS_CACHE_DIR" in line
    assert not list(full_disk.iterdir())


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no named pipes")
def test_a_pipe_in_the_cache_is_not_waited_for(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("RIGLENS_CACHE_DIR", str(tmp_path))
    monkeypatch.setattr(numba.config, "CACHE_DIR", "")
    kernels = KernelFolder()
    assert kernels.path is not None
    for pipe in (tmp_path / NAME, tmp_path / "car-test", kernels.path / "a.nbc"):
        os.mkfifo(pipe)
    library = asset_path("library.yaml")
    assert stored_entries(library) == read_entries(library, library.name)
    assert stored_surfaces("test", lambda: [("paint", superellipsoid((1.0, 1.0, 1.0), 1.0))])
    assert kernels.read("a.nbc") is None


def test_a_folder_that_cannot_be_made_is_told_too(
    tmp_path: Path, full_disk: Path, caplog: pytest.LogCaptureFixture
) -> None:
    (tmp_path / "file").touch()
    keep(tmp_path / "file" / "cache" / "x", Path.touch)
    (line,) = caplog.messages
    assert f"{tmp_path / 'file' / 'cache'} cannot be written (Not a directory)" in line


def test_an_error_of_the_program_is_not_taken_for_a_full_disk(tmp_path: Path) -> None:
    def fail(path: Path) -> None:
        raise KeyError("wrong")

    with pytest.raises(KeyError):
        keep(tmp_path / "x", fail)
