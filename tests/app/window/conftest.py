"""Desks and windows that most tests of features work on; a test file that needs another one makes its own.

Opening a window takes far longer than using it, so the tests of a file share one: each finds it as if it were new.
"""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot, _close_widgets

from riglens.app.window.features.follow import Follow
from riglens.app.window.features.scene_data import choice_of
from tests.app.window.desk import Desk, FullDesk, full_desk, open_desk
from tests.app.window_bench import Bench, open_bench


@pytest.fixture(scope="module")
def file_bot(request: pytest.FixtureRequest, qapp: QApplication) -> Iterator[QtBot]:
    """The hands for what all tests of a file share."""
    yield QtBot(request)
    _close_widgets(request.node)


@pytest.fixture(scope="module")
def file_desk(file_bot: QtBot) -> Iterator[FullDesk]:
    """Every feature on a desk, for all tests of a file."""
    with full_desk(file_bot) as opened:
        yield opened


@pytest.fixture
def bench(file_desk: FullDesk) -> FullDesk:
    """Every feature on a desk: no main window, thread or traffic."""
    file_desk.start_over(file_desk.features)
    return file_desk


@pytest.fixture
def desk(qtbot: QtBot) -> Iterator[FullDesk]:
    """The same with data and scores, and of this test alone: what is loaded stays."""
    with full_desk(qtbot) as opened:
        opened.load()
        opened.answer()
        yield opened


@pytest.fixture
def followed(qtbot: QtBot) -> Iterator[Desk]:
    """A desk with data, before the first scores, whose view, list and inspector follow the rig: for one feature."""
    made = open_desk(qtbot)
    Follow(made.workbench).show_all()
    made.workbench.answers.ask()
    made.load()
    yield made
    made.workbench.closing.emit()


@pytest.fixture(scope="module")
def file_window(file_bot: QtBot, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Bench]:
    """The whole window for all tests of a file."""
    with open_bench(file_bot, tmp_path_factory.mktemp("window")) as opened:
        yield opened


@pytest.fixture
def whole(file_window: Bench) -> Bench:
    """The whole window: for keys, scores and closing."""
    panel, first = file_window.panels.scene, file_window.options
    file_window.start_over(file_window.features)
    if len(file_window.scenes) > 1 or panel.problem or panel.choice != choice_of(first):
        file_window.features.scene_data.load(first)
    panel.show_subject(choice_of(first))  # what was chosen but not loaded stays otherwise
    file_window.settle()
    del file_window.scenes[:-1]
    return file_window


@pytest.fixture(scope="module")
def file_unscored(file_bot: QtBot, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Bench]:
    """The whole window without traffic and scores, for all tests of a file."""
    with open_bench(file_bot, tmp_path_factory.mktemp("window"), data=False) as opened:
        yield opened


@pytest.fixture
def unscored(file_unscored: Bench) -> Bench:
    """The whole window without traffic and scores: for keys."""
    file_unscored.start_over(file_unscored.features)
    file_unscored.window.activateWindow()
    return file_unscored


@pytest.fixture
def plain_style(qapp: QApplication) -> Iterator[None]:
    """Give the next test the look that this one found."""
    palette, sheet, style = qapp.palette(), qapp.styleSheet(), qapp.style().objectName()
    yield
    qapp.setStyleSheet(sheet)
    qapp.setStyle(style)
    qapp.setPalette(palette)
