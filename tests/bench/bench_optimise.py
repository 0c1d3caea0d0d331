"""Proposals: the first one, all mounts of a sedan's skin, a proof, gains of all mounts while a sensor is dragged, and
drags at the real window during a search.
"""

from __future__ import annotations

import json
import time
from contextlib import suppress
from pathlib import Path
from statistics import median

import numpy as np

from riglens.core.errors import Cancelled
from riglens.core.optimise.additions import Additions
from riglens.core.optimise.bounds import branch_and_bound
from riglens.core.optimise.candidates import choices_of
from riglens.core.optimise.makers import HitTableMaker, Objects
from riglens.core.optimise.problem import Problem
from riglens.core.optimise.results import CASTING, Progress
from riglens.core.optimise.run import optimise, skin_gains
from riglens.core.optimise.search import search
from riglens.core.optimise.weights import EVEN
from riglens.core.rig.model import Rig
from riglens.core.rig.presets import preset
from riglens.core.scene.readers.bundled import bundled_source
from riglens.core.targets.settings import TargetSettings
from riglens.core.targets.traffic import Traffic, read_traffic
from riglens.core.vehicle.solid import solid_of
from tests.bench.bars import Bar
from tests.bench.scenes import moved
from tests.session.test_session import run

THREADS, FRAMES = 2, 50
SKIN = Additions(("generic-16",), 4, mirrored=False, spots_m=0.14)
"""About 700 mounts of 16 x 360 rays."""
USUAL = Additions(("generic-16",), 4, mirrored=False)
FIRST_S, ALL_S, SWEEP_MS, PROVEN_S, DRAG = 3.0, 10.0, 40.0, 5.0, 1.25


def _traffic() -> Traffic:
    return read_traffic(bundled_source())


def test_first_proposal(bars: list[Bar], rounds: int) -> None:
    problem = Problem(preset("nuScenes car"), _traffic(), USUAL, frames=FRAMES)
    stages = list[str]()

    def until_a_proposal(step: Progress) -> None:
        if step.best is not None:
            stages.append(step.stage)
            raise Cancelled

    times = []
    for _ in range(1 + min(rounds, 3)):  # the first one compiles
        start = time.perf_counter()
        with suppress(Cancelled):
            optimise(problem, THREADS, until_a_proposal)
        times.append(time.perf_counter() - start)
    assert set(stages) == {CASTING}
    bars.append(
        _bar(
            "a first proposal of four LiDARs on the nuScenes car, from its start", median(times[1:]), FIRST_S
        )
    )


def test_all_mounts_and_a_sweep_of_their_gains(bars: list[Bar], rounds: int) -> None:
    problem = Problem(preset("nuScenes car"), _traffic(), SKIN, frames=FRAMES)
    start = time.perf_counter()
    skin = skin_gains(problem, THREADS)
    taken, count = time.perf_counter() - start, len(skin.candidates)
    bars.append(_bar(f"{count} mounts of 16 x 360 rays in {FRAMES} frames", taken, ALL_S))
    rig = Rig(sensors=tuple(skin.candidates[number].sensors[0] for number in (0, count // 2)))
    times = []
    for number in range(rounds + 1):
        rig = rig.with_sensor(rig.sensors[0].name, moved(rig.sensors[0], number))
        start = time.perf_counter()
        gains = skin.gains(rig)
        times.append(time.perf_counter() - start)
    assert np.isfinite(gains).all()
    work = f"gains of {count} mounts while a LiDAR is dragged, its casting counted"
    bars.append(_bar(work, median(times[1:]), SWEEP_MS / 1e3))


def test_three_mounts_proven(bars: list[Bar]) -> None:
    rig, added = Rig(), Additions(("generic-16",), 3, mirrored=False)
    choices, settings = choices_of(rig, added), TargetSettings(body="blocks")
    maker = HitTableMaker(Objects(_traffic(), 100, settings, solid_of(rig.vehicle), THREADS, EVEN))
    listed = choices.candidates
    table = maker.table(np.zeros(0, np.int32), list(maker.each([one.sensors for one in listed])))
    limits, start = choices.limits, time.perf_counter()
    best, is_proven = branch_and_bound(table, limits, search(table, limits))
    taken_s = time.perf_counter() - start
    assert is_proven and len(best) == 3
    bars.append(_bar(f"the best three of {len(listed)} mounts, proven", taken_s, PROVEN_S))


def test_a_drag_during_a_search(bars: list[Bar], xvfb: str, tmp_path: Path) -> None:
    ended = run("search", tmp_path)
    assert ended.returncode == 0, ended.stderr
    frames_ms = json.loads((tmp_path / "search.json").read_text(encoding="utf-8"))["frames_ms"]
    running, paused = (np.array(frames_ms[state]) for state in ("running", "paused"))
    for name, share in (("median", 0.5), ("95 %", 0.95)):
        ours, alone = float(np.quantile(running, share)), float(np.quantile(paused, share))
        work = f"{name} of {len(running)} frames of a drag during a search, against the same with it paused"
        bars.append(Bar("optimise", work, ours, alone, ours / alone, DRAG, "lower"))


def _bar(work: str, taken_s: float, budget_s: float) -> Bar:
    return Bar("optimise", work, taken_s * 1e3, budget_s * 1e3, taken_s / budget_s, 1.0, "lower")
