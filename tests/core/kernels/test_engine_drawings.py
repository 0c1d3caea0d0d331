"""The drawings of docs/engine.md are those that the script draws."""

import runpy
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).resolve().parents[3]


def test_the_drawings_are_up_to_date(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(REPOSITORY / "tools"))
    drawings = runpy.run_path(str(REPOSITORY / "tools" / "draw_engine.py"))["DRAWINGS"]
    page = (REPOSITORY / "docs" / "engine.md").read_text(encoding="utf-8")
    for name, draw in drawings.items():
        assert f"(images/{name})" in page
        assert (REPOSITORY / "docs" / "images" / name).read_text(encoding="utf-8") == draw()
