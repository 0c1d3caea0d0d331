"""Desks and windows that most tests of features work on; a test file that needs another one makes its own."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from pytestqt.qtbot import QtBot

from tests.app.window.desk import FullDesk, full_desk
from tests.app.window_bench import Bench, open_bench


@pytest.fixture
def bench(qtbot: QtBot) -> Iterator[FullDesk]:
    """Every feature on a desk: no main window, thread or traffic."""
    with full_desk(qtbot) as opened:
        yield opened


@pytest.fixture
def desk(bench: FullDesk) -> FullDesk:
    """The same with data and scores."""
    bench.load()
    bench.answer()
    return bench


@pytest.fixture
def whole(qtbot: QtBot, tmp_path: Path) -> Iterator[Bench]:
    """The whole window: for keys, scores and closing."""
    with open_bench(qtbot, tmp_path) as opened:
        yield opened


@pytest.fixture
def unscored(qtbot: QtBot, tmp_path: Path) -> Iterator[Bench]:
    """The whole window without traffic and scores: for keys."""
    with open_bench(qtbot, tmp_path, data=False) as opened:
        yield opened
