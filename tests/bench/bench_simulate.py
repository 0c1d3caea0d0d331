"""Simulated sweeps: CPU time of one thread per frame of the town, against a budget."""

from __future__ import annotations

import time

import pytest

from riglens.core.rig.model import Lidar, LinearAngles, Rig
from riglens.core.scene.readers.bundled import bundled_source
from riglens.core.simulate.sweeps import Simulator
from riglens.core.simulate.world import Worlds
from riglens.core.targets.traffic import Traffic, read_traffic
from tests.bench.bars import Bar
from tests.bench.scenes import wide_trapezoid

STEP = 10
"""Every so many frames of the town."""
GOAL = 1.0
DENSE = Lidar(
    name="dense",
    position=(0.0, 0.0, 2.0),
    elevations_deg=LinearAngles(from_=-22.5, to=22.5, count=128),
    azimuths_deg=LinearAngles(from_=-180.0, to=180.0, count=1024),
    range_m=(0.5, 120.0),
)
RIGS = {"W+T": (wide_trapezoid(), 250.0), "one LiDAR": (Rig(name="dense", sensors=(DENSE,)), 40.0)}
"""Rigs, and how many frames a second one thread has to simulate."""


@pytest.fixture(scope="module")
def traffic() -> Traffic:
    """The bundled town."""
    return read_traffic(bundled_source())


@pytest.mark.parametrize("name", RIGS)
def test_sweeps(bars: list[Bar], traffic: Traffic, name: str) -> None:
    rig, per_second = RIGS[name]
    simulator = Simulator(rig, Worlds(traffic))
    simulator.sweep(0)  # loads the kernels
    frames = range(0, traffic.frames, STEP)
    started = time.process_time()
    for frame in frames:
        simulator.sweep(frame)
    ours_ms = (time.process_time() - started) * 1e3 / len(frames)
    rays = sum(lidar.ray_count for lidar in rig.enabled_lidars())
    work = f"{name}, {rays:,} rays, a frame of the town with clutter, CPU time of one thread"
    bars.append(Bar("simulate", work, ours_ms, 1e3 / per_second, ours_ms * per_second / 1e3, GOAL, "lower"))
