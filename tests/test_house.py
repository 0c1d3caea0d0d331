"""The picture of the house and the page about it tell of the rooms that there are."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PAGE = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
PICTURE = (ROOT / "docs" / "images" / "house.svg").read_text(encoding="utf-8")
FLOORS = ("app", "riglens", "core", "widgets")


def rooms_of(floor: str) -> set[str]:
    folders = [file.parent for file in (ROOT / floor).glob("*/__init__.py")]
    return {folder.name for folder in folders if not folder.is_symlink()}


def drawn() -> dict[str, set[str]]:
    """Rooms by floor: bold words of size 15, which follow those of size 18."""
    found, rooms = dict[str, set[str]](), set[str]()
    for size, word in re.findall(r'font-size="(1[58])"[^>]*font-weight="bold">(\w+)<', PICTURE):
        if size == "18":
            rooms = found[word] = set()
        else:
            rooms.add(word)
    return found


@pytest.mark.parametrize("floor", FLOORS)
def test_the_picture_has_every_room_and_no_other(floor: str) -> None:
    assert drawn()[floor] == rooms_of(floor)


@pytest.mark.parametrize("floor", ["app", "riglens", "core"])
def test_the_page_says_what_every_room_is_for(floor: str) -> None:
    assert set(re.findall(rf"`{floor}/(\w+)`", PAGE)) >= rooms_of(floor)


def test_every_file_and_folder_that_the_page_names_is_there() -> None:
    named = set(re.findall(r"`((?:app|core|docs|riglens|tests|tools|widgets)/[\w./-]+)`", PAGE))
    assert len(named) > 20
    assert [name for name in sorted(named) if not (ROOT / name).exists()] == []


def test_a_mouse_move_goes_through_six_rooms_at_most() -> None:
    stops = [int(number) for number in re.findall(r'font-size="13"[^>]*font-weight="bold">(\d)<', PICTURE)]
    assert sorted(stops) == list(range(1, len(stops) + 1))
    assert 0 < len(stops) <= 6
