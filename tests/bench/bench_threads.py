"""Two threads and all of them against one, on a quiet computer and beside as many spinning processes as processors."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from riglens.core.engine.processors import PERIOD_S
from riglens.core.rig.model import Rig
from tests.bench.race import Goal, Race
from tests.bench.scenes import Scenes, moves, names_of, wide_trapezoid, with_model
from tools.beside_spinners import SPIN

PROCESSORS = os.cpu_count() or 1
LEAST = 0.9
"""More threads are never slower than one by more than a tenth."""
WIDE_GOAL = 2.5
"""How much quicker four threads are to be, where an edit takes long enough."""
ROUNDS = 9


@contextmanager
def spinning(processes: int) -> Iterator[None]:
    """That many processes that keep a processor busy each."""
    spinners = [subprocess.Popen([sys.executable, "-c", SPIN]) for _ in range(processes)]
    try:
        yield
    finally:
        for spinner in spinners:
            spinner.kill()
        for spinner in spinners:
            spinner.wait()


def rig_and_name(sensor: str) -> tuple[Rig, str]:
    """W+T and one of its sensors, or a model of the library in its place."""
    if sensor in ("lidar", "camera"):
        rig = wide_trapezoid()
        return rig, names_of(rig, sensor)[0]
    return with_model(sensor, "tilted")


@pytest.mark.parametrize("busy", [False, True], ids=["quiet", "busy"])
@pytest.mark.parametrize("threads", sorted({min(2, PROCESSORS), PROCESSORS}))
@pytest.mark.parametrize("sensor", ["lidar", "velodyne-vls-128"])
def test_threads(race: Race, scenes: Scenes, sensor: str, threads: int, busy: bool) -> None:
    scene = scenes.at(0.10)
    rig, name = rig_and_name(sensor)
    alone, together = scene.engine(1), scene.engine(threads)
    for engine in (alone, together):
        engine.evaluate(rig)
    beside = f", beside {PROCESSORS} spinning processes" if busy else ""
    wide = not busy and threads == 4 and sensor != "lidar"
    goal = Goal(
        "threads",
        f"{sensor} moved, {threads} threads against one{beside}, {scene.edge}",
        WIDE_GOAL if wide else LEAST,
    )
    with spinning(PROCESSORS if busy else 0):
        for engine in (alone, together) * 2:  # how busy the computer is takes a while to be noticed
            engine.evaluate(rig)
            time.sleep(2.0 * PERIOD_S)
        race.run(
            goal,
            moves(scene, rig, [name]),
            lambda m: together.evaluate(m.rig, with_seen=False),
            lambda m: alone.evaluate(m.rig, with_seen=False),
            rounds=ROUNDS,
        )
