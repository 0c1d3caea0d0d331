"""Ctrl-C ends a command also when the exception is lost on its way."""

from __future__ import annotations

import signal
import time
from collections.abc import Callable
from dataclasses import dataclass

import pytest

from riglens.app.launch.interrupt import insistent_interrupt
from tests.waiting import TIMEOUT_S


@dataclass
class HandTimer:
    """A timer that is over when a test says so."""

    seconds: float
    function: Callable[[], None]
    daemon: bool = False
    is_running: bool = False

    def start(self) -> None:
        self.is_running = True

    def cancel(self) -> None:
        self.is_running = False


class Timers(list[HandTimer]):
    """Everything that was timed, in order."""

    def __call__(self, seconds: float, function: Callable[[], None]) -> HandTimer:
        self.append(HandTimer(seconds, function))
        return self[-1]


def test_an_interruption_that_somebody_swallows_comes_again():
    before, swallowed, timers = signal.getsignal(signal.SIGINT), [], Timers()
    with pytest.raises(KeyboardInterrupt), insistent_interrupt(timers):
        try:
            signal.raise_signal(signal.SIGINT)
        except KeyboardInterrupt as lost:
            swallowed.append(lost)
        assert [timer.is_running for timer in timers] == [True]
        timers[0].function()
        time.sleep(TIMEOUT_S)  # until the signal is there
    assert len(swallowed) == 1
    assert signal.getsignal(signal.SIGINT) is before
    assert not any(timer.is_running for timer in timers)


def test_an_interruption_that_is_heard_comes_once():
    timers = Timers()
    with pytest.raises(KeyboardInterrupt), insistent_interrupt(timers):
        signal.raise_signal(signal.SIGINT)
    assert [timer.is_running for timer in timers] == [False]


def test_a_failure_after_a_swallowed_interruption_is_an_interruption():
    with pytest.raises(KeyboardInterrupt), insistent_interrupt():
        try:
            signal.raise_signal(signal.SIGINT)
        except KeyboardInterrupt:
            raise RuntimeError("half done") from None
