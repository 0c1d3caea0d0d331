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


def test_another_text_is_read(kept: Path, reads: list[Path], tmp_path: Path) -> None:
    stored_entries(BUNDLED)
    other = tmp_path / "other.yaml"
    other.write_text(OTHER, encoding="utf-8")
    assert [entry.name for entry in stored_entries(other)] == ["tiny"]
    assert reads == [BUNDLED, other]
