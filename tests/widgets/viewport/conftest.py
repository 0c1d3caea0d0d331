"""A view of each kind; what all views share is tried on the quicker one, and with `make slow` on both."""

from collections.abc import Iterator

import pytest
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from tests.widgets.viewport.views import BOTH, RIG, AnyView, settle, shown


@pytest.fixture(scope="module", params=BOTH)
def opened(request: pytest.FixtureRequest, qapp: QApplication) -> Iterator[AnyView]:
    """One view for the tests of a file: opening it takes longer than most of them."""
    made = shown(request.param, QtBot(request), rig=RIG, selected="roof")
    made.first = made.state
    yield made
    made.close()
    made.deleteLater()


@pytest.fixture
def view(opened: AnyView) -> AnyView:
    """The view as it was opened: with its first camera, and no tool in hand."""
    opened.cancel_drag()
    for put_away in (opened.set_snap, opened.set_picking, opened.set_measuring, opened.set_painting):
        put_away(False)
    opened.set_placing(upright=False, below_rails=False)
    opened.show_state(opened.first)
    settle(opened)
    return opened
