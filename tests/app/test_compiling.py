"""What the open rig does not need is compiled by a process of low priority, once, and given up with the window."""

from __future__ import annotations

import sys
from pathlib import Path

import numba
import pytest

from riglens.app.background.compiling import OtherKernels
from riglens.core.engine import warm_up
from riglens.core.kernels.compiled import KernelFolder
from riglens.core.rig.model import Rig

LONG = (sys.executable, "-c", "import time; time.sleep(600)")


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> KernelFolder:
    """An empty folder for compiled code."""
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path))
    folder = KernelFolder()
    monkeypatch.setattr(warm_up, "FOLDER", folder)
    return folder


@pytest.mark.usefixtures("folder")
def test_the_process_is_started_once_and_ends_with_the_window() -> None:
    others = OtherKernels(LONG)
    assert not others.is_running
    others.begin()
    first = others._process
    others.begin()
    assert others.is_running and others._process is first
    others.close()
    assert not others.is_running
    others.begin()
    assert not others.is_running


@pytest.mark.usefixtures("folder")
def test_a_window_that_is_closed_starts_none() -> None:
    others = OtherKernels(LONG)
    others.close()
    others.begin()
    assert not others.is_running


@pytest.mark.usefixtures("folder")
def test_a_process_that_cannot_be_started_costs_nothing() -> None:
    others = OtherKernels(("/nowhere/python",))
    others.begin()
    assert not others.is_running


def test_none_is_started_when_all_is_on_disk(monkeypatch: pytest.MonkeyPatch, folder: KernelFolder) -> None:
    warmed: list[Rig | None] = []
    monkeypatch.setattr(warm_up, "warm_up", lambda field, rig=None: warmed.append(rig))
    assert not warm_up.is_everything_compiled()
    warm_up.compile_everything()
    assert warm_up.is_everything_compiled() and folder.read(warm_up.MARKER) == b""
    assert warmed == [None, Rig(sensors=(warm_up.BENT,))]
    others = OtherKernels(LONG)
    others.begin()
    assert not others.is_running
