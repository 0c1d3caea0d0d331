"""A view of each kind; what all views share is tried on the quicker one, and with `make slow` on both."""

from collections.abc import Iterator

import pytest
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from riglens.widgets.viewport.scene_state import SceneState
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
    for put_away in (made.set_snap, made.set_picking, made.set_measuring, made.set_painting):
        put_away(False)
    made.set_placing(upright=False, below_rails=False)
    made.show_state(first)
    settle(made)
    return made
