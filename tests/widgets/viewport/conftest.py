"""A view of each kind; what all views share is tried on the quicker one, and with `make slow` on both."""

from collections.abc import Iterator
from typing import get_args

import pytest
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from riglens.widgets.viewport.scene_state import SceneState
from riglens.widgets.viewport.view import Tool
from tests.widgets.viewport.views import BOTH, RIG, AnyView, settle, shown


@pytest.fixture(scope="module", params=BOTH)
def opened(request: pytest.FixtureRequest, qapp: QApplication) -> Iterator[tuple[AnyView, SceneState]]:
    """One view for the tests of a file, and what it shows first: opening it takes longer than most of them."""
    made = shown(request.param, QtBot(request), rig=RIG, selected="roof")
    yield made, made.state
    made.close()
    made.deleteLater()


@pytest.fixture
def view(opened: tuple[AnyView, SceneState]) -> AnyView:
    """The view as it was opened: with its first camera, and no tool in hand."""
    made, first = opened
    made.cancel_drag()
    for tool in get_args(Tool):
        made.set_tool(tool, False)
    made.show_state(first)
    settle(made)
    return made
