"""The cached sensor library: the same models as in its YAML, and read again when the file is no good."""

from __future__ import annotations

from pathlib import Path

import pytest

from riglens.assets import asset_path
from riglens.core.rig import library
from riglens.core.rig.library import Entry, read_entries, stored_entries

BUNDLED = asset_path("library.yaml")
OTHER = """
tiny:
  kind: camera
  title: A tiny camera
  source: measured on the bench by hand
  image: [640, 480]
  hfov_deg: 60
"""


@pytest.fixture
def kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where the cached library is."""
    monkeypatch.setenv("RIGLENS_CACHE_DIR", str(tmp_path / "cache"))
    return tmp_path / "cache" / library.NAME


@pytest.fixture
def reads(monkeypatch: pytest.MonkeyPatch) -> list[Path]:
    """The YAML files that were read."""
    files: list[Path] = []

    def read(path: Path, where: str) -> tuple[Entry, ...]:
        files.append(path)
        return read_entries(path, where)

    monkeypatch.setattr(library, "read_entries", read)
    return files


def test_the_second_start_reads_no_yaml_and_finds_the_same_models(kept: Path, reads: list[Path]) -> None:
    first, second = stored_entries(BUNDLED), stored_entries(BUNDLED)
    assert second == first == read_entries(BUNDLED, BUNDLED.name)
    assert [repr(entry) for entry in second] == [repr(entry) for entry in first]
    assert reads == [BUNDLED]


@pytest.mark.parametrize("damage", ["one figure", "cut short", "empty", "text"])
def test_a_damaged_file_is_replaced(kept: Path, reads: list[Path], tmp_path: Path, damage: str) -> None:
    text = tmp_path / "other.yaml"
    text.write_text(OTHER)
    entries = stored_entries(text)
    whole = kept.read_bytes()
    kept.write_bytes(
        {
            "one figure": whole.replace(b"640", b"641", 1),
            "cut short": whole[: len(whole) // 2],
            "empty": b"",
            "text": b"\xff not JSON",
        }[damage]
    )
    assert kept.read_bytes() != whole
    assert stored_entries(text) == entries
    assert len(reads) == 2
    assert kept.read_bytes() == whole


def test_another_text_is_read(kept: Path, reads: list[Path], tmp_path: Path) -> None:
    stored_entries(BUNDLED)
    other = tmp_path / "other.yaml"
    other.write_text(OTHER)
    assert [entry.name for entry in stored_entries(other)] == ["tiny"]
    assert reads == [BUNDLED, other]


def test_without_a_place_to_keep_it_the_library_is_read_every_time(kept: Path, reads: list[Path]) -> None:
    kept.parent.write_text("a file where the folder should be")
    assert stored_entries(BUNDLED) == stored_entries(BUNDLED)
    assert len(reads) == 2
