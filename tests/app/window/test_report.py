"""File > Report: made in a process of its own with what the window shows; what it refuses is told."""

from __future__ import annotations

import time
from collections.abc import Iterator
from multiprocessing.connection import Connection
from pathlib import Path
from types import SimpleNamespace

import pytest
from pytestqt.qtbot import QtBot

from riglens.app.background.report import ReportJob, make_report
from riglens.core.errors import Cancelled, InputError
from riglens.core.rig.yaml.file import dumps
from riglens.core.scene.grid import VoxelGrid
from riglens.evaluation.options import ReportOptions, SceneOptions, ScoreOptions
from riglens.reporting.reading import attached_figures, inputs_of
from riglens.widgets.panels.dialogs.report import ReportDialog
from tests.app.conftest import BOXES
from tests.app.window.desk import FullDesk, full_desk
from tests.app.window_bench import RIG
from tests.waiting import TIMEOUT_MS


def refuse(pipe: Connection) -> None:
    pipe.send((0.0, ""))
    pipe.send("no such thing")


def break_down(pipe: Connection) -> None:
    raise ValueError("a mistake")


def sleep(pipe: Connection) -> None:
    time.sleep(60)


@pytest.fixture
def desk(qtbot: QtBot) -> Iterator[FullDesk]:
    with full_desk(qtbot) as made:
        yield made


def job(folder: Path, suffix: str = ".html", **scene: object) -> ReportJob:
    score = ScoreOptions(camera_weight=0.25, body="blocks")
    read, holds = SceneOptions(**scene), ReportOptions(draws=1, project="A")  # type: ignore[arg-type]
    return ReportJob((RIG,), read, score, folder / f"made{suffix}", holds)


@pytest.mark.slow
def test_a_report_is_made_of_the_rigs_scene_and_settings_of_its_request(tmp_path: Path) -> None:
    boxes, told = tmp_path / "boxes.csv", list[tuple[float, str]]()
    boxes.write_text(BOXES, encoding="utf-8")
    attached = []
    for suffix in (".html", ".pdf"):
        asked = job(tmp_path, suffix, boxes=boxes, voxel_m=0.5, roi_m=(20.0, 10.0, 4.0))
        told.clear()
        made = make_report(asked, lambda share, stage: told.append((share, stage)))
        assert made == asked.out
        attached.append(attached_figures(made.read_bytes(), "a"))
    assert attached[0] == attached[1]
    inputs = inputs_of(attached[0], "a")
    assert inputs.rigs == [dumps(RIG)] and (inputs.camera_weight, inputs.body) == (0.25, "blocks")
    assert (inputs.voxel_m, inputs.roi_m, inputs.boxes) == (0.5, [20.0, 10.0, 4.0], "boxes.csv")
    assert inputs.labels.project == "A" and inputs.draws == 1
    stages = list(dict.fromkeys(stage for _, stage in told if stage))
    assert stages[0] == "Reading the data" and {
        "Scoring",
        "Sampling mount errors",
        "Writing the report",
    } <= set(stages)
    shares = [share for share, stage in told if stage]
    assert shares == sorted(shares) and shares[0] == 0.0 and shares[-1] == 1.0


def test_what_is_refused_is_the_error_and_cancelling_ends_the_process(tmp_path: Path) -> None:
    for work, line in (("refuse", "no such thing"), ("break_down", "ValueError: a mistake")):
        with pytest.raises(InputError, match=f"^{line}$"):
            make_report(job(tmp_path), lambda share, stage: None, f"{__name__}:{work}")
    with pytest.raises(InputError, match=r"^.*missing\.csv: "):
        make_report(job(tmp_path, boxes=tmp_path / "missing.csv"), lambda share, stage: None)

    def cancel(share: float, stage: str) -> None:
        raise Cancelled

    with pytest.raises(Cancelled):
        make_report(job(tmp_path), cancel, f"{__name__}:sleep")


GRID = VoxelGrid(0.2, (20.0, 10.0, 4.0))
PICKED = SceneOptions(roi_m=GRID.roi_m, voxel_m="auto", classes=("van=car",))


def open_dialog(desk: FullDesk, options: SceneOptions = PICKED) -> tuple[ReportDialog, list[ReportJob]]:
    """The dialog of a report, and the jobs that it starts: they only write the name of their format."""
    desk.load(GRID)
    desk.session.scene.options = options  # type: ignore[union-attr,misc]
    jobs = list[ReportJob]()

    def work(job: ReportJob, progress: object) -> Path:
        jobs.append(job)
        job.out.write_text(job.out.suffix, encoding="utf-8")
        return job.out

    desk.features.report.work = work
    desk.act("report")
    dialog = desk.features.report.dialog
    assert dialog is not None
    return dialog, jobs


def test_a_report_needs_data(desk: FullDesk) -> None:
    desk.act("report")
    assert "no box data" in desk.workbench.errors.message and desk.features.report.dialog is None


@pytest.mark.parametrize("suffix", [".html", ".pdf"])
def test_a_report_is_made_as_the_dialog_says(desk: FullDesk, tmp_path: Path, suffix: str) -> None:
    report, shown = desk.features.report, list[Path]()
    report.show_file = shown.append
    row = SimpleNamespace(rig=RIG, name="kept", origin="snapshot")
    report._compare = SimpleNamespace(rows=[row, SimpleNamespace(rig=RIG, name="x", origin="current")])  # type: ignore[assignment]
    dialog, jobs = open_dialog(desk)
    assert dialog.choice.path.is_absolute() and dialog.choice.path.suffix == ".html"
    desk.dialogs.path = tmp_path / f"made{suffix}"
    dialog.browse_wanted.emit()
    assert dialog.format.currentData() == suffix
    dialog.labels["author"].setText("A. Engineer")
    dialog.tolerance.setChecked(False)
    dialog.make.click()
    desk.qtbot.waitUntil(lambda: bool(shown), timeout=TIMEOUT_MS)
    (job,), settings = jobs, desk.session.settings
    assert shown == [job.out] == [desk.dialogs.path] and job.out.read_text("utf-8") == suffix
    assert [rig.name for rig in job.rigs] == ["kept", desk.document.rig.name] and job.holds.draws == 0
    assert (job.score.method, job.score.reading, job.score.camera_weight, job.score.body) == (
        settings.method, settings.reading, settings.camera_weight, settings.body,
    )  # fmt: skip
    assert job.scene == SceneOptions(voxel_m=0.2, roi_m=GRID.roi_m, classes=("van=car",))
    assert job.holds.author == "A. Engineer" and str(job.out) in desk.workbench.status.currentMessage()
    again, _ = open_dialog(desk)
    assert again.labels["author"].text() == "A. Engineer" and again.choice.path.suffix == suffix


def test_a_file_that_cannot_be_written_is_named_before_the_work(desk: FullDesk, tmp_path: Path) -> None:
    boxes = tmp_path / "boxes.html"
    boxes.write_text("boxes", encoding="utf-8")
    dialog, jobs = open_dialog(desk, SceneOptions(boxes=boxes))
    for path in (tmp_path / "missing" / "a.html", boxes):
        dialog.show_path(path)
        dialog.make.click()
        assert path.name in dialog.note.text() and jobs == [] and dialog.isVisible()
    dialog.others.setChecked(False)
    dialog.opens.setChecked(False)
    dialog.show_path(tmp_path / "made")  # the ending of the format is added
    dialog.make.click()
    desk.qtbot.waitUntil(lambda: bool(jobs), timeout=TIMEOUT_MS)
    assert jobs[0].out == tmp_path / "made.html" and jobs[0].rigs == desk.features.report.rigs(False)


def test_a_report_that_fails_says_why(desk: FullDesk, tmp_path: Path) -> None:
    dialog, _ = open_dialog(desk)

    def work(job: ReportJob, progress: object) -> Path:
        raise InputError("rig: wrong")

    desk.features.report.work = work
    dialog.show_path(tmp_path / "made.html")
    dialog.make.click()
    desk.qtbot.waitUntil(lambda: desk.workbench.errors.message == "rig: wrong", timeout=TIMEOUT_MS)
