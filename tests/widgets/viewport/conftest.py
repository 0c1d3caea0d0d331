"""A view of each kind; what all views share is tried on the quicker one, and with `make slow` on both."""

from collections.abc import Iterator

import pytest
from pytestqt.qtbot import QtBot

from tests.widgets.viewport.views import BOTH, RIG, AnyView, shown


@pytest.fixture(params=BOTH)
def view(request: pytest.FixtureRequest, qtbot: QtBot) -> Iterator[AnyView]:
    made = shown(request.param, qtbot, rig=RIG, selected="roof")
    yield made
    made.close()
