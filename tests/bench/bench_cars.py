"""Cars that are built, and larger ones: objects of all frames, a sensor moved, redundancy, a draw of the tolerance, and
whole jobs, each in a process of its own."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from itertools import count
from pathlib import Path
from statistics import median

import pytest

from riglens.core.figures.evaluated import EvaluationSettings, Evaluator
from riglens.core.metric.scores import MetricSettings
from riglens.core.review.measures import Measures
from riglens.core.review.redundancy import target_coverage, voxel_coverage
from riglens.core.review.tolerance import ToleranceRun, profile_called
from riglens.core.scene.readers.bundled import bundled_source
from riglens.core.targets.engine import TargetEngine, warm_up
from riglens.core.targets.settings import TargetSettings
from riglens.core.targets.traffic import Traffic, read_traffic
from tests.bench.bars import Bar
from tests.bench.peak import MEGABYTE, run_script
from tests.bench.scenes import Scenes, car, moved, names_of

THREADS, SAMPLE_FRAMES, ROUNDS = 2, 100, 3
GOAL = 1.0


@dataclass(frozen=True)
class Budget:
    """Times that the work on a car may take, ms: objects in all frames and, after a sensor has moved, in a sample; all
    voxels from scratch; a draw of the tolerance. jobs: how many times as long as JOBS_S whole jobs may take."""

    objects: float
    sample: float
    voxels: float
    draw: float
    jobs: float


CARS = {
    "production car": Budget(6000.0, 33.0, 1000.0, 500.0, 1.0),
    "Waymo car": Budget(20000.0, 100.0, 3000.0, 2000.0, 3.0),
    "4 x OS1-128, 8 cameras of 8 MP": Budget(30000.0, 100.0, 3000.0, 2000.0, 3.0),
    "60 sensors": Budget(20000.0, 33.0, 3000.0, 2000.0, 3.0),
}
"""Budgets of the production car are goals; those of the others are our choice, to see what changes."""
JOBS_S = {"review": 40.0, "report": 25.0, "sweep": 10.0, "proposal": 60.0, "first figures": 4.0}
"""Seconds that whole jobs may take, by the clock: those of a review, a report and the window are goals."""


@pytest.fixture(scope="module")
def traffic(is_quick: bool) -> Traffic:
    """The bundled town, with the kernels loaded."""
    warm_up(THREADS)
    return read_traffic(bundled_source())


@pytest.mark.parametrize("name", CARS)
def test_objects(bars: list[Bar], traffic: Traffic, is_quick: bool, name: str) -> None:
    rig, settings = car(name), TargetSettings(body="blocks")
    frames = SAMPLE_FRAMES if is_quick else traffic.frames
    TargetEngine(traffic, THREADS).evaluate(rig, settings, 2)
    ms = _median_ms(lambda: TargetEngine(traffic, THREADS).evaluate(rig, settings, frames))
    bars.append(_bar("car objects", f"{name}: {frames:,} frames from scratch", ms, CARS[name].objects))
    engine, camera, number = TargetEngine(traffic, THREADS), names_of(rig, "camera")[0], count(1)
    engine.evaluate(rig, settings, SAMPLE_FRAMES)

    def step() -> object:
        other = rig.with_sensor(camera, moved(rig.sensor(camera), next(number)))
        return engine.evaluate(other, settings, SAMPLE_FRAMES)

    work = f"{name}: a camera moved, {SAMPLE_FRAMES} frames"
    bars.append(_bar("car sample", work, _median_ms(step), CARS[name].sample))


@pytest.mark.parametrize("name", CARS)
def test_voxels_and_review(bars: list[Bar], scenes: Scenes, traffic: Traffic, name: str) -> None:
    rig, scene, settings = car(name), scenes.at(0.1), MetricSettings(body="blocks")
    scene.engine(THREADS).evaluate(rig, settings, False)
    ms = _median_ms(lambda: scene.engine(THREADS).evaluate(rig, settings, False))
    bars.append(_bar("car voxels", f"{name}: all scores from scratch, {scene.edge}", ms, CARS[name].voxels))
    engine = scene.engine(THREADS)
    engine.evaluate(rig, settings, False)
    counted = TargetEngine(traffic, THREADS).evaluate(rig, TargetSettings(body="blocks"), SAMPLE_FRAMES)
    ms = _median_ms(lambda: (voxel_coverage(engine, rig), target_coverage(counted)))
    bars.append(
        _bar("car redundancy", f"{name}: coverage and losses of what was cast", ms, CARS[name].voxels)
    )
    how = EvaluationSettings(settings, TargetSettings(body="blocks"))
    measures = Measures(Evaluator(scene.field, traffic, how, THREADS), SAMPLE_FRAMES)
    run = ToleranceRun(rig, profile_called("assembly"), 16)
    ms = _median_ms(lambda: run.take(measures(*run.wanted())))
    bars.append(
        _bar("car draw", f"{name}: a draw of the tolerance, {SAMPLE_FRAMES} frames", ms, CARS[name].draw)
    )


@pytest.mark.parametrize("job", JOBS_S)
@pytest.mark.parametrize("name", CARS)
def test_jobs(bars: list[Bar], xvfb: str, tmp_path: Path, name: str, job: str) -> None:
    wall_ms, cpu_ms, used = run_script("car_job", name, job, tmp_path)
    budget_ms = 1e3 * JOBS_S[job] * CARS[name].jobs
    work = f"{name}: {job}, {THREADS} threads; {cpu_ms / 1e3:.1f} s of CPU time, {used / MEGABYTE:.0f} MB"
    bars.append(Bar("car jobs", work, wall_ms, budget_ms, wall_ms / budget_ms, GOAL, "lower"))


def _median_ms(work: Callable[[], object]) -> float:
    times = []
    for _ in range(ROUNDS):
        started = time.process_time()
        work()
        times.append((time.process_time() - started) * 1e3)
    return median(times)


def _bar(name: str, work: str, ours_ms: float, budget_ms: float) -> Bar:
    return Bar(
        name, f"{work}; CPU time, {THREADS} threads", ours_ms, budget_ms, ours_ms / budget_ms, GOAL, "lower"
    )
