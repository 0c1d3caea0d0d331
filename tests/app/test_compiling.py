"""What the open rig does not need is compiled by processes of low priority, once, and given up with the window."""

from __future__ import annotations

import sys
from functools import partial
from pathlib import Path
from typing import Any

import numba
import pytest

from riglens.app.background import compiling
from riglens.app.background.compiling import OtherKernels
from riglens.core.engine import warm_up
from riglens.core.kernels.body.shadow import find_ends
from riglens.core.kernels.cameras.frustum import mark_frustum
from riglens.core.kernels.fans.fan import mark_fan
from riglens.core.kernels.fans.profile import find_stays, masks_of
from riglens.core.kernels.rays.cast import mark_rays
from riglens.core.kernels.rays.strides import mark_strides
from riglens.core.kernels.runtime.compiled import KernelFolder
from riglens.core.kernels.voxels import update_coverage
from riglens.core.metric.scores import MetricSettings
from riglens.core.rig.model import Rig
from riglens.core.rig.presets import preset
from riglens.evaluation import every_kernel, kernel_steps

LONG = (sys.executable, "-c", "import time; time.sleep(600)")


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> KernelFolder:
    """An empty folder for compiled code."""
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path))
    folder = KernelFolder()
    monkeypatch.setattr(warm_up, "FOLDER", folder)
    monkeypatch.setattr(kernel_steps, "FOLDER", folder)
    return folder


@pytest.mark.usefixtures("folder")
def test_the_process_is_started_once_and_ends_with_the_window() -> None:
    others = OtherKernels(LONG)
    assert not others.is_running
    others.begin()
    first = dict(others._processes)
    others.begin()
    assert others.is_running and others._processes == first
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


@pytest.mark.parametrize("half", warm_up.HALVES)
def test_half_is_compiled_beside_the_first_load_and_the_process_goes_on(
    folder: KernelFolder, monkeypatch: pytest.MonkeyPatch, half: str
) -> None:
    monkeypatch.setattr(compiling.os, "cpu_count", lambda: 2)
    others = OtherKernels(LONG)
    others.begin_beside(half)
    first = others._processes[0]
    assert first is not None
    assert first.args == [*LONG, kernel_steps.first(half), *kernel_steps.shares_of(2)[0]]
    looks: list[float] = []

    def sleep(seconds: float) -> None:
        looks.append(seconds)
        if len(looks) == 3:
            folder.write(warm_up.mark_of(half), b"")

    others.wait_for(half, lambda: False, sleep)
    assert looks == [compiling.LOOK_S] * 3
    others.begin()
    second = others._processes[1]
    assert others._processes[0] is first and second is not None
    assert second.args == [*LONG, *kernel_steps.APART]
    others.close()
    assert first.poll() is not None and second.poll() is not None


def test_nobody_waits_for_a_half_that_are_unwanted_or_never_come(
    folder: KernelFolder, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(compiling.os, "cpu_count", lambda: 2)
    others = OtherKernels(LONG)
    others.begin_beside("fans")
    others.wait_for("fans", lambda: True, pytest.fail)
    others.close()
    others.wait_for("fans", lambda: False, pytest.fail)


@pytest.mark.parametrize("cpus, on_disk", [(1, False), (2, True)])
def test_nothing_is_compiled_beside_on_one_processor_or_when_they_are_there(
    folder: KernelFolder, monkeypatch: pytest.MonkeyPatch, cpus: int, on_disk: bool
) -> None:
    monkeypatch.setattr(compiling.os, "cpu_count", lambda: cpus)
    if on_disk:
        folder.write(warm_up.mark_of("fans"), b"")
    others = OtherKernels(LONG)
    others.begin_beside("fans")
    assert not others.is_running


UPRIGHT, TILTED = Rig(sensors=(warm_up.WARM_UP.sensors[0],)), preset("nuScenes car")


@pytest.mark.parametrize(
    ("half", "rig", "kernels"),
    [
        ("fans", UPRIGHT, (mark_fan, find_stays, masks_of, update_coverage.settle)),
        (
            "cameras",
            TILTED,
            (mark_frustum, find_ends, mark_strides, mark_rays, mark_fan, update_coverage.settle),
        ),
    ],
)
def test_what_is_compiled_ahead_is_what_an_evaluation_calls(
    monkeypatch: pytest.MonkeyPatch, half: str, rig: Rig, kernels: tuple[Any, ...]
) -> None:
    """Another type of an argument would be compiled for nothing, and the right one again."""
    monkeypatch.setattr(warm_up, "FOLDER", KernelFolder())
    monkeypatch.setattr(KernelFolder, "write", lambda *_: None)
    field = warm_up.tiny_field()
    assert warm_up.halves_of(rig) == half
    warm_up.warm_up(field, 2, rig, MetricSettings(body="blocks"))
    before = [set(kernel.signatures) for kernel in kernels]
    for compile_half in warm_up.HALVES[half]:
        compile_half(field)
    assert [set(kernel.signatures) for kernel in kernels] == before


@pytest.mark.usefixtures("folder")
def test_a_finished_step_is_not_done_again_and_none_is_started_when_all_are_on_disk(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    assert tuple(every_kernel.FUNCTIONS) == kernel_steps.STEPS
    done: list[str] = []
    fakes = {step: partial(done.append, step) for step in kernel_steps.STEPS}
    monkeypatch.setattr(every_kernel, "FUNCTIONS", fakes)
    kernel_steps.mark_done("points")
    assert kernel_steps.steps_done() == 1
    every_kernel.compile_steps(kernel_steps.STEPS)
    assert done == [step for step in kernel_steps.STEPS if step != "points"]
    assert kernel_steps.steps_done() == len(kernel_steps.STEPS)
    others = OtherKernels(LONG)
    others.begin()
    assert not others.is_running and others.progress() is None


@pytest.mark.usefixtures("folder")
def test_progress_is_counted_in_steps_while_the_process_runs() -> None:
    others = OtherKernels(LONG)
    others.begin()
    assert others.progress() == (0, len(kernel_steps.STEPS))
    kernel_steps.mark_done("rays")
    assert others.progress() == (1, len(kernel_steps.STEPS))
    others.close()
    assert others.progress() is None


def test_each_step_is_of_one_process() -> None:
    assert kernel_steps.shares_of(1) == (kernel_steps.STEPS,)
    shares = kernel_steps.shares_of(2)
    assert sorted(step for share in shares for step in share) == sorted(kernel_steps.STEPS)


def test_every_step_does_what_its_callers_do() -> None:
    """With code on disk they take seconds; a changed signature would be noticed by none but the first user."""
    for step in every_kernel.FUNCTIONS.values():
        step()
