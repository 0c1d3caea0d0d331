"""A view of each kind."""

from collections.abc import Iterator

import pytest
from pytestqt.qtbot import QtBot

from tests.widgets.viewport.views import RIG, AnyView, Offscreen, Window, shown


@pytest.fixture(params=[Window, Offscreen], ids=["window", "offscreen"])
def view(request: pytest.FixtureRequest, qtbot: QtBot) -> Iterator[AnyView]:
    made = shown(request.param, qtbot, rig=RIG, selected="roof")
    yield made
    made.close()
