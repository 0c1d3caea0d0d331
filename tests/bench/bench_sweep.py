"""Sweeps: CPU time of one thread per rig of which one LiDAR moves, against a budget."""

from __future__ import annotations

import time

from riglens.core.metric.scores import PAPER_SETTINGS
from riglens.core.scene.readers.bundled import bundled_source
from riglens.core.sweep.design import Span, Sweep, grid
from riglens.core.sweep.rows import Sweeper, SweepFigures
from riglens.core.targets.settings import USUAL
from riglens.core.targets.traffic import read_traffic
from tests.bench.bars import Bar
from tests.bench.scenes import Scenes, names_of, wide_trapezoid

FRAMES, RIGS, PER_SECOND = 100, 120, 90.0


def test_rigs_of_a_sweep(bars: list[Bar], scenes: Scenes) -> None:
    rig, scene = wide_trapezoid(), scenes.at(0.10)
    span = Span.parsed(f"{names_of(rig, 'lidar')[0]}.z=1.6:2.2:{RIGS}")
    sweep, traffic = Sweep.of([rig], grid([span])), read_traffic(bundled_source())
    sweeper = Sweeper(SweepFigures(PAPER_SETTINGS, USUAL, FRAMES), rig, scene.field, traffic, 1)
    warm = list(sweeper.rows(sweep.part(range(3))))
    started = time.process_time()
    rows = list(sweeper.rows(sweep))
    ours_ms = (time.process_time() - started) * 1e3 / RIGS
    assert rows[:3] == warm
    work = f"a rig with one LiDAR of W+T moved, {FRAMES} frames, {scene.edge}, CPU time of one thread"
    bars.append(Bar("sweep", work, ours_ms, 1e3 / PER_SECOND, ours_ms * PER_SECOND / 1e3, 1.0, "lower"))
