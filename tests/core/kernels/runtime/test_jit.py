"""Kernel threads wait as the environment says."""

import os

import pytest

from riglens.core.kernels.runtime import jit


def test_threads_that_wait_are_told_to_sleep_soon(monkeypatch):
    monkeypatch.delenv("OMP_WAIT_POLICY", raising=False)
    monkeypatch.delenv(jit.SPIN, raising=False)
    jit.use_threads(1)
    assert os.environ[jit.SPIN] == "2000"


@pytest.mark.parametrize("name, value", [("OMP_WAIT_POLICY", "active"), (jit.SPIN, "7")])
def test_what_the_user_says_about_waiting_threads_holds(monkeypatch, name, value):
    for other in ("OMP_WAIT_POLICY", jit.SPIN):
        monkeypatch.delenv(other, raising=False)
    monkeypatch.setenv(name, value)
    jit.use_threads(1)
    assert {key: os.environ[key] for key in ("OMP_WAIT_POLICY", jit.SPIN) if key in os.environ} == {
        name: value
    }
