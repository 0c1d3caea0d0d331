"""The status bar counts compiled kernels while another process compiles them."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from pytestqt.qtbot import QtBot

from tests.app.window_bench import Bench, open_bench


@pytest.fixture
def bench(qtbot: QtBot, tmp_path: Path) -> Iterator[Bench]:
    with open_bench(qtbot, tmp_path) as opened:
        yield opened


def test_the_steps_that_are_ready_are_counted_until_the_process_ends(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    progress: list[tuple[int, int] | None] = [(3, 9), (4, 9), None]
    monkeypatch.setattr(bench.workbench.recompute, "compiling", lambda: progress.pop(0))
    shown = bench.window.features.preparing
    strip = shown._strip
    shown.show_progress()
    assert strip.is_running and strip.bar.text() == "preparing 3 of 9"
    shown.show_progress()
    assert strip.bar.text() == "preparing 4 of 9"
    shown.show_progress()
    assert not strip.is_running
