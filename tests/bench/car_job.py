"""Run as a process of its own, `python -m tests.bench.car_job CAR JOB FOLDER`: prints the wall and CPU time of the job
in milliseconds, without importing the library, and the most bytes that it held more than before."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import riglens as rl
from riglens.core.rig.model import Rig
from riglens.core.rig.yaml.file import dumps
from riglens.evaluation.options import SceneOptions, ScoreOptions
from tests.bench.first_picture import start_with
from tests.bench.peak import peak, start_peak
from tests.bench.scenes import car, names_of

if TYPE_CHECKING:  # loads Qt
    from riglens.app.window.main_window import MainWindow

THREADS = 2


def sweep(rig: Rig, folder: Path) -> None:
    """Sweep the height of a LiDAR: ten rigs, objects in 100 frames each."""
    field = f"{names_of(rig, 'lidar')[0]}.z"
    height_m = rig.sensor(field[:-2]).position[2]
    rl.sweep(rig, {field: (height_m, height_m + 0.1, 10)}, compute="targets", threads=THREADS, workers=1)


def propose(rig: Rig, folder: Path) -> None:
    """Propose a mirror pair of LiDARs beside the sensors that are there."""
    rl.optimise(rig, rl.load_traffic(), add="generic-16", threads=THREADS)


def open_window(rig: Rig, folder: Path) -> None:
    """Open the window on a rig's file, as the product does, until its leading figures are exact."""
    from riglens.app.commands import start

    path = folder / "rig.yaml"
    path.write_text(dumps(rig), encoding="utf-8")
    start_with(until_exact)
    start.start(str(path), SceneOptions(), ScoreOptions(threads=THREADS))


def until_exact(window: MainWindow) -> None:
    """Leave the window when it shows the leading figures of all frames."""
    from PySide6.QtWidgets import QApplication

    targets = window.features.targets
    targets.counted.connect(lambda: QApplication.exit(0) if targets.is_current else None)


JOBS: dict[str, Callable[[Rig, Path], object]] = {
    "review": lambda rig, _: rl.review(rig, threads=THREADS),
    "report": lambda rig, folder: rl.report(rig, folder / "report.html", threads=THREADS),
    "sweep": sweep,
    "proposal": propose,
    "first figures": open_window,
}


def main(name: str, job: str, folder: Path) -> None:
    """Run a job and print what it took."""
    before, started, cpu = start_peak(), time.perf_counter(), time.process_time()
    JOBS[job](car(name), folder)
    wall_s, cpu_s = time.perf_counter() - started, time.process_time() - cpu
    print(round(1e3 * wall_s), round(1e3 * cpu_s), peak() - before, flush=True)
    os._exit(0)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], Path(sys.argv[3]))
