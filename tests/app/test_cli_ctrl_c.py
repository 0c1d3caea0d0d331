"""Ctrl-C ends a command also when the exception is lost on its way."""

import signal
import time

import pytest

from riglens.app.commands.ctrl_c import insistent_interrupt


def test_an_interruption_that_somebody_swallows_comes_again():
    before, swallowed = signal.getsignal(signal.SIGINT), []
    with pytest.raises(KeyboardInterrupt), insistent_interrupt(again_s=0.02):
        try:
            signal.raise_signal(signal.SIGINT)
        except KeyboardInterrupt as lost:
            swallowed.append(lost)
        time.sleep(20.0)
    assert len(swallowed) == 1
    assert signal.getsignal(signal.SIGINT) is before


def test_an_interruption_that_is_heard_comes_once():
    with pytest.raises(KeyboardInterrupt), insistent_interrupt(again_s=0.02):
        signal.raise_signal(signal.SIGINT)
    time.sleep(0.1)


def test_a_failure_after_a_swallowed_interruption_is_an_interruption():
    with pytest.raises(KeyboardInterrupt), insistent_interrupt():
        try:
            signal.raise_signal(signal.SIGINT)
        except KeyboardInterrupt:
            raise RuntimeError("half done") from None
