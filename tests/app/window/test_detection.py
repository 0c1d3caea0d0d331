"""The study of detection in the window: which rigs it compares, progress, charts that fill, stop, and going on."""

from __future__ import annotations

import pickle
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pytestqt.qtbot import QtBot

from riglens.app.background.detection import CHART, PAIRS, DetectionJob, study
from riglens.app.evaluation.options import AutoVoxel, SceneOptions
from riglens.app.studies import detection as study_detection
from riglens.core.errors import Cancelled, InputError
from riglens.core.scene.grid import VoxelGrid
from riglens.widgets.panels.dialogs.detection import DetectionDialog
from riglens.widgets.viewport.still import png_of
from tests.app.window_bench import RIG, Bench, open_bench
from tests.waiting import TIMEOUT_MS

SPEAKS = """
import json, sys
print("note: reading", file=sys.stderr)
for share, line in ((0.25, "done: sweeps of small"), (0.75, "done: net of seed 1")):
    print(json.dumps([share, line]), flush=True)
"""
REFUSES = "import sys; print('riglens: training a detector needs PyTorch', file=sys.stderr); sys.exit(2)"
ENDLESS = SPEAKS + "import time\nwhile True: time.sleep(0.05)\n"


@pytest.fixture
def bench(qtbot: QtBot, tmp_path: Path) -> Iterator[Bench]:
    with open_bench(qtbot, tmp_path) as opened:
        opened.features.detection.folder = tmp_path / "detection"
        yield opened


def job(folder: Path, **changes: object) -> DetectionJob:
    return DetectionJob((RIG,), SceneOptions(**changes), "ignored", folder)  # type: ignore[arg-type]


def png(grey: int) -> bytes:
    return png_of(np.full((2, 2, 3), grey, np.uint8))


def opened(bench: Bench) -> DetectionDialog:
    bench.act("detection")
    dialog = bench.features.detection.dialog
    assert dialog is not None
    return dialog


# ---------------------------------------------------------------- the process


def test_it_tells_of_each_piece_and_of_the_share_done(tmp_path: Path) -> None:
    shares: list[float] = []
    heard: list[str] = []
    assert study(job(tmp_path), shares.append, heard.append, SPEAKS) == tmp_path
    assert heard == ["done: sweeps of small", "done: net of seed 1"]
    assert shares[0] == 0.0 and shares[-1] == 0.75 and shares == sorted(shares)


def test_what_the_command_refuses_is_the_error(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"^training a detector needs PyTorch$"):
        study(job(tmp_path), lambda share: None, print, REFUSES)


def test_cancelled_it_ends_the_process(tmp_path: Path) -> None:
    def enough(share: float) -> None:
        if share > 0.5:
            raise Cancelled

    with pytest.raises(Cancelled):
        study(job(tmp_path), enough, lambda line: None, ENDLESS)  # would never return otherwise


GRID = VoxelGrid(0.2, (20.0, 10.0, 4.0))


def test_a_study_is_of_the_request_that_the_window_hands_over(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = job(tmp_path, boxes=tmp_path / "b.csv", voxel_m=0.2, roi_m=GRID.roi_m, find_ground=True)
    compared: list[Any] = []
    monkeypatch.setattr(study_detection, "compare", lambda *given: compared.append(given))
    heard = pickle.loads(pickle.dumps(asked))
    study_detection.study_job(heard, print)
    ((rigs, _, scene, plan, out, tell),) = compared
    assert (rigs, scene, out, tell) == (asked.rigs, asked.scene, tmp_path, print)
    assert (plan.quick, plan.where.workers, plan.body) == (True, 1, "ignored")
    with pytest.raises(InputError, match="stored POG"):
        study(job(tmp_path, pog=Path("p.npz")), lambda share: None, print)


def test_what_the_process_refuses_is_the_error_in_one_line(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"missing\.csv"):
        study(job(tmp_path, boxes=tmp_path / "missing.csv"), lambda share: None, print)


# ---------------------------------------------------------------- the dialog


def test_the_rig_and_those_kept_for_comparison_take_part_once(bench: Bench) -> None:
    feature = bench.features.detection
    assert [rig.name for rig in feature.rigs()] == ["small"]
    bench.act("snapshot")
    assert len(feature.rigs()) == 1
    bench.features.compare.add_presets(("Trapezoid", "Wide"))
    assert [rig.name for rig in feature.rigs()] == ["small", "Trapezoid"]
    assert "small, Trapezoid" in opened(bench).rigs.text()


def test_a_mesh_is_found_from_the_folder_of_the_work(bench: Bench, tmp_path: Path) -> None:
    rig = bench.document.rig
    (tmp_path / "here").mkdir()
    bench.document.save(tmp_path / "here" / "mine.yaml")
    bench.document.apply(rig.replace(vehicle=rig.vehicle.replace(body="cars/mine.stl")))
    (found,) = bench.features.detection.rigs()
    assert found.vehicle.body == str(tmp_path / "here" / "cars" / "mine.stl")


def test_the_voxel_edge_that_was_picked_and_the_region_are_those_of_the_study(bench: Bench) -> None:
    feature, dialog, jobs = bench.features.detection, opened(bench), list[DetectionJob]()

    def work(asked: DetectionJob, progress, hear) -> Path:
        jobs.append(asked)
        return asked.folder

    feature.work = work
    scene = bench.features.detection.session.scene
    assert scene is not None
    object.__setattr__(scene, "options", SceneOptions(roi_m=scene.field.grid.roi_m, auto=AutoVoxel()))
    dialog.start.click()
    bench.qtbot.waitUntil(lambda: bool(jobs), timeout=TIMEOUT_MS)
    grid = scene.field.grid
    assert jobs[0].scene == SceneOptions(voxel_m=grid.voxel_m, roi_m=grid.roi_m)


def test_charts_fill_while_it_runs_and_it_can_be_stopped_and_started_again(bench: Bench) -> None:
    feature, dialog = bench.features.detection, opened(bench)
    go_on, jobs = threading.Event(), list[DetectionJob]()

    def work(asked: DetectionJob, progress, hear) -> Path:
        jobs.append(asked)
        asked.folder.mkdir(exist_ok=True)
        for name in (CHART, PAIRS):
            (asked.folder / name).write_bytes(png(len(jobs)))
        hear(f"done: seed {len(jobs)}")
        progress(0.5)
        while not go_on.wait(0.01):
            progress(0.5)
        return asked.folder

    feature.work = work
    dialog.start.click()
    assert not dialog.start.isEnabled() and dialog.stop.isEnabled() and not dialog.quick.isEnabled()
    bench.qtbot.waitUntil(lambda: dialog.state.text() == "done: seed 1", timeout=TIMEOUT_MS)
    assert not dialog.chart.image.isNull() and not dialog.pairs.image.isNull()
    bench.qtbot.waitUntil(lambda: dialog.bar.value() == 500, timeout=TIMEOUT_MS)
    dialog.stop.click()
    bench.qtbot.waitUntil(lambda: dialog.start.isEnabled(), timeout=TIMEOUT_MS)
    assert "Start goes on" in dialog.state.text()
    go_on.set()
    dialog.start.click()
    bench.qtbot.waitUntil(lambda: dialog.state.text() == "Done", timeout=TIMEOUT_MS)
    bench.qtbot.waitUntil(lambda: dialog.start.isEnabled(), timeout=TIMEOUT_MS)
    assert len(jobs) == 2 and jobs[0].folder == jobs[1].folder and jobs[0].quick


def test_what_went_wrong_is_said_and_it_can_be_started_again(bench: Bench) -> None:
    feature, dialog = bench.features.detection, opened(bench)

    def work(asked: DetectionJob, progress, hear) -> Path:
        raise InputError("training a detector needs PyTorch")

    feature.work = work
    dialog.start.click()
    bench.qtbot.waitUntil(lambda: "needs PyTorch" in bench.window.bench.errors.message, timeout=TIMEOUT_MS)
    bench.qtbot.waitUntil(lambda: dialog.start.isEnabled(), timeout=TIMEOUT_MS)


def test_without_a_lidar_there_is_nothing_to_start(bench: Bench) -> None:
    dialog = opened(bench)
    bench.document.delete(("roof",))
    assert not dialog.start.isEnabled() and "No rig with a LiDAR" in dialog.rigs.text()
