"""The window ends its processes without waiting for their end."""

from __future__ import annotations

import threading
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess

import pytest
from pytestqt.qtbot import QtBot

from riglens.app.background.own_process import OwnProcess
from riglens.app.background.picture_process import PictureMaker
from riglens.app.background.proposing import Proposer
from tests.waiting import wait_for

STAY = f"{__name__}:stay"


def stay(pipe: Connection) -> None:
    """Take messages until the process is ended."""
    while True:
        pipe.recv()


@pytest.fixture(autouse=True)
def impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the interface thread wait for the end of no process."""
    join = BaseProcess.join

    def joined(process: BaseProcess, timeout: float | None = None) -> None:
        assert threading.current_thread() is not threading.main_thread()
        join(process, timeout)

    monkeypatch.setattr(BaseProcess, "join", joined)


def test_a_picture_that_is_cancelled(qtbot: QtBot) -> None:
    maker = PictureMaker()
    process = maker._process = OwnProcess(STAY)
    maker.cancel()
    assert maker._process is None
    wait_for(lambda: not process.is_alive)


def test_a_search_that_is_ended(qtbot: QtBot) -> None:
    proposer, lines = Proposer(work=STAY), list[str]()
    proposer.failed.connect(lines.append)
    proposer.send("pause")
    first = proposer._process
    assert first is not None
    proposer.end()
    proposer.send("pause")
    second = proposer._process
    assert second is not None and second is not first
    wait_for(lambda: not first.is_alive)
    assert second.is_alive and lines == []
    proposer.end()
    wait_for(lambda: not second.is_alive)
