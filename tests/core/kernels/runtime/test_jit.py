"""Kernel threads wait as the environment says, and serial kernels start none."""

import os

import pytest

from riglens.core.kernels.optimise.gains import gains, gains_serial
from riglens.core.kernels.runtime import jit


def test_the_serial_twin_of_a_kernel_starts_no_threads_and_has_a_name_of_its_own_in_the_cache():
    assert [twin.targetoptions.get("parallel", False) for twin in (gains, gains_serial)] == [True, False]
    assert [twin.py_func.__qualname__ for twin in (gains, gains_serial)] == ["gains", "gains_serial"]


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
