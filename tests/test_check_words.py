"""The check of wording finds what it excludes, with its line, and nothing in plain words."""

from __future__ import annotations

from pathlib import Path

import pytest

from tools import check_words

BAD = '''"""What a rig sees."""

ERROR = f"{3}: found 'x', accepted is a number"


def count() -> int:
    """Return the number of points.

    The points that a LiDAR gets onto nobody.
    """
    return 3
'''
GOOD = '''"""Count the points of a rig."""

ERROR = f"{3}: must be a number (got 'x')"


def whose() -> int:
    """Return the index of the owner; found objects are accepted where they are whole."""
    return 3
'''


def test_excluded_words_are_found_in_their_lines(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "bad.py").write_text(BAD, encoding="utf-8")
    assert check_words.main([str(tmp_path / "bad.py")]) == 1
    lines = capsys.readouterr().out.splitlines()
    assert [line.split(":")[1] for line in lines] == ["1", "3", "9", "9"]
    assert ["What" in lines[0], "accepted is" in lines[1]] == [True, True]
    assert {word for word in ("gets onto", "nobody") if any(word in line for line in lines[2:])} == {
        "gets onto",
        "nobody",
    }


def test_plain_words_pass(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "good.py").write_text(GOOD, encoding="utf-8")
    (tmp_path / "good.md").write_text("Detection range by class; nothing else.\n", encoding="utf-8")
    assert check_words.main([str(tmp_path / name) for name in ("good.py", "good.md")]) == 0
    assert capsys.readouterr().out == ""


def test_pages_are_checked_as_text(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "bad.md").write_text("One line.\nA second, accepted\nis nobody.\n", encoding="utf-8")
    assert check_words.main([str(tmp_path / "bad.md")]) == 1
    assert ":3: 'nobody'" in capsys.readouterr().out


def test_the_project_is_covered() -> None:
    names = {path.relative_to(check_words.ROOT).as_posix() for path in check_words.files()}
    assert {
        "core/rig/model.py",
        "widgets/theme.py",
        "app/commands/check.py",
        "riglens/api.py",
        "README.md",
    } <= names
