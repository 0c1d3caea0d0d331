"""File > Report: made in a process of its own with what the window shows; what it refuses is told."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from multiprocessing.connection import Connection
from pathlib import Path
from types import SimpleNamespace

import pytest
from PySide6.QtGui import QImage
from pytestqt.qtbot import QtBot

from riglens.app.background.report import PAGE, PDF, ReportJob, make_report
from riglens.core.errors import Cancelled, InputError
from riglens.core.rig.yaml.file import dumps
from riglens.core.scene.grid import VoxelGrid
from riglens.evaluation.options import SceneOptions, ScoreOptions
from riglens.reporting.pdf import page_images, pdf_of
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


def job(folder: Path, **scene: object) -> ReportJob:
    return ReportJob((RIG,), SceneOptions(**scene), ScoreOptions(camera_weight=0.25, body="blocks"), folder)  # type: ignore[arg-type]


@pytest.mark.slow
def test_a_report_is_made_of_the_rigs_scene_and_settings_of_its_request(tmp_path: Path) -> None:
    boxes, told = tmp_path / "boxes.csv", list[tuple[float, str]]()
    boxes.write_text(BOXES, encoding="utf-8")
    folder = tmp_path / "made"
    folder.mkdir()
    asked = job(folder, boxes=boxes, voxel_m=0.5, roi_m=(20.0, 10.0, 4.0))
    pages = make_report(asked, lambda share, stage: told.append((share, stage)))
    inputs = inputs_of(attached_figures((folder / PAGE).read_bytes(), "a"), "a")
    assert inputs.rigs == [dumps(RIG)] and (inputs.camera_weight, inputs.body) == (0.25, "blocks")
    assert (inputs.voxel_m, inputs.roi_m, inputs.boxes) == (0.5, [20.0, 10.0, 4.0], "boxes.csv")
    assert attached_figures((folder / PDF).read_bytes(), "a") == attached_figures(
        (folder / PAGE).read_bytes(), "a"
    )
    assert pages and all(path.exists() for path in pages)
    stages = list(dict.fromkeys(stage for _, stage in told if stage))
    assert stages[0] == "Reading the data" and {"Scoring", "Drawing errors", "Drawing the pages"} <= set(
        stages
    )
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


def test_the_pages_of_a_report_are_those_of_its_pdf() -> None:
    page = "<html lang=en><title>A report</title><script>no();</script>" + "<p>a line</p>" * 100
    images = list(page_images(pdf_of(page, {})))
    assert len(images) >= 2 and all(image.size == (910, 1287) for image in images)
    for image in images:
        darkest, brightest = image.convert("L").getextrema()
        assert darkest < 90 and brightest == 255 and image.getpixel((5, 5)) == (255, 255, 255)


GRID = VoxelGrid(0.2, (20.0, 10.0, 4.0))
PICKED = SceneOptions(roi_m=GRID.roi_m, voxel_m="auto", classes=("van=car",))


def preview(desk: FullDesk) -> ReportDialog:
    """The preview of a report that is made at once."""
    desk.load(GRID)
    desk.session.scene.options = PICKED  # type: ignore[union-attr,misc]
    jobs: list[ReportJob] = []

    def work(job: ReportJob, progress: object) -> list[Path]:
        jobs.append(job)
        for name in (PAGE, PDF):
            (job.folder / name).write_text(name, encoding="utf-8")
        paths = [job.folder / f"{number}.png" for number in (1, 2)]
        for path, colour in zip(paths, (0xFFFF0000, 0xFF00FF00), strict=True):
            image = QImage(40, 3000, QImage.Format.Format_RGB32)
            image.fill(colour)
            image.save(str(path))
        return paths

    report = desk.features.report
    report.work = work  # type: ignore[assignment]
    desk.act("report")
    desk.qtbot.waitUntil(lambda: bool(report.dialogs), timeout=TIMEOUT_MS)
    settings, score = desk.session.settings, jobs[0].score
    assert jobs[0].rigs[0] == desk.document.rig and score.body == settings.body
    assert (score.method, score.reading, score.camera_weight) == (
        settings.method,
        settings.reading,
        settings.camera_weight,
    )
    assert jobs[0].scene == SceneOptions(voxel_m=0.2, roi_m=GRID.roi_m, classes=("van=car",))
    return next(iter(report.dialogs.values()))


def test_a_report_needs_data_and_is_seen_before_anything_is_written(
    desk: FullDesk, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    desk.act("report")
    assert "no box data" in desk.workbench.errors.message
    dialog, report = preview(desk), desk.features.report
    made = next(iter(report.dialogs))
    desk.qtbot.waitUntil(lambda: dialog.pages.read == (0,), timeout=TIMEOUT_MS)  # the other is out of sight
    seen = dialog.pages.grab().toImage()
    assert seen.pixelColor(20, 30).name() == "#ff0000" and seen.pixelColor(20, 3060).name() == "#00ff00"
    shown: list[Path] = []
    report.show_file = shown.append
    dialog.browser.click()
    assert shown == [made / PAGE]
    dialog.html.click()
    assert desk.dialogs.suggested == Path("report.html") and desk.workbench.status.currentMessage() == ""
    told: list[int] = []
    show = desk.workbench.status.showMessage
    monkeypatch.setattr(
        desk.workbench.status, "showMessage", lambda text, ms=0: (told.append(ms), show(text, ms))
    )
    for button, name in ((dialog.html, PAGE), (dialog.pdf, PDF)):
        desk.dialogs.path = tmp_path / name
        button.click()
        assert desk.dialogs.path.read_text("utf-8") == name and name in desk.workbench.status.currentMessage()
    assert desk.workbench.notes.isHidden(), "nothing covers the view"
    assert len(told) == 2 and min(told) > 0, "the message goes away"
    assert desk.dialogs.suggested == Path("report.pdf")
    dialog.close()
    assert report.dialogs == {} and not made.exists()


def test_closing_the_window_removes_what_was_made(desk: FullDesk) -> None:
    preview(desk)
    made = next(iter(desk.features.report.dialogs))
    desk.workbench.closing.emit()
    assert not made.exists()


def test_closing_the_window_removes_what_is_being_made(desk: FullDesk) -> None:
    desk.load()
    desk.session.scene.options = SceneOptions()  # type: ignore[union-attr,misc]
    folders: list[Path] = []

    def work(job: ReportJob, progress: Callable[[float], object]) -> list[Path]:
        (job.folder / PAGE).write_text("half", encoding="utf-8")
        folders.append(job.folder)
        while True:
            progress(0.5)

    desk.features.report.work = work  # type: ignore[assignment]
    desk.act("report")
    desk.qtbot.waitUntil(lambda: bool(folders), timeout=TIMEOUT_MS)
    desk.workbench.closing.emit()
    assert not folders[0].exists()


def test_a_report_that_fails_leaves_no_folder_and_kept_rigs_are_in_it(desk: FullDesk) -> None:
    desk.load()
    desk.session.scene.options = SceneOptions()  # type: ignore[union-attr,misc]
    report, jobs = desk.features.report, []

    def work(job: ReportJob, progress: object) -> list[Path]:
        jobs.append(job)
        raise InputError("rig: wrong")

    report.work = work  # type: ignore[assignment]
    desk.act("report")
    desk.qtbot.waitUntil(lambda: desk.workbench.errors.message == "rig: wrong", timeout=TIMEOUT_MS)
    desk.qtbot.waitUntil(lambda: not jobs[0].folder.exists(), timeout=TIMEOUT_MS)
    row = SimpleNamespace(rig=RIG, name="kept", origin="snapshot")
    report._compare = SimpleNamespace(rows=[row, SimpleNamespace(rig=RIG, name="x", origin="current")])  # type: ignore[assignment]
    assert [rig.name for rig in report.rigs()] == ["kept", desk.document.rig.name]
