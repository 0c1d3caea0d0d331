"""At rest the window holds as much as before, whatever was edited, compared and undone in between."""

from __future__ import annotations

import gc
from collections import Counter
from pathlib import Path

import numpy as np
from pytestqt.qtbot import QtBot

from riglens.app.background.counting import make_counter
from riglens.app.background.queue import Priority
from riglens.core.engine.engine import Engine, Evaluation
from riglens.core.targets.contribution import Contribution
from riglens.core.targets.counts import Counted, ObjectCounts
from riglens.core.targets.engine import TargetEngine
from riglens.core.targets.groups import Groups
from tests.app.window_bench import CAMERA, LIDAR, Bench, open_bench
from tests.waiting import TIMEOUT_MS, TIMEOUT_S

HEAVY = (Engine, TargetEngine, Evaluation, Contribution, Counted, ObjectCounts, Groups)


def held(bench: Bench) -> tuple[Counter[str], int]:
    """Return the numbers of engines and results that are alive at rest, and the bytes of the results' arrays."""
    bench.settle()
    features = bench.features
    bench.qtbot.waitUntil(
        lambda: (
            features.targets.is_current
            and all(row.scores and row.counted for row in features.compare.rows)
            and set(features.marginals.figures) == {sensor.name for sensor in bench.document.rig.sensors}
        ),
        timeout=TIMEOUT_MS,
    )
    assert bench.workbench.counter.wait_until_idle()
    assert bench.workbench.recompute.wait_until_idle(TIMEOUT_S, Priority.BACKGROUND)
    bench.workbench.rest()
    gc.collect()
    found = [one for one in gc.get_objects() if issubclass(type(one), HEAVY)]  # a dead proxy has no class
    arrays = {id(a): a for one in found for a in vars(one).values() if isinstance(a, np.ndarray)}
    return Counter(type(one).__name__ for one in found), sum(a.nbytes for a in arrays.values())


def test_engines_and_results_of_before_go(qtbot: QtBot, tmp_path: Path) -> None:
    with open_bench(qtbot, tmp_path, counter=make_counter(), coarse_above_ms=0.0) as bench:
        compare, document = bench.features.compare, bench.document
        bench.workbench.docks.bring_up("Compare")
        before = held(bench)
        compare.add_presets(("W+C",))
        for step in range(3):
            moved = LIDAR.replace(position=(0.1, 0.2 + 0.1 * step, 1.9))
            document.apply(document.rig.with_sensor("roof", moved), "move")
            turned = CAMERA.replace(rpy_deg=(0.0, 0.0, 5.0 * step + 5.0))
            document.apply(document.rig.with_sensor("front", turned), "turn")
            held(bench)
        added = tuple(row.key for row in compare.rows if row.origin == "preset")
        compare.panel.table.remove_wanted.emit(added)
        for _ in range(6):
            document.undo()
        assert held(bench) == before
