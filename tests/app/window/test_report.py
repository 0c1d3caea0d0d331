"""File > Report: the command is run with what the window shows, and what it refuses is told."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from pathlib import Path
from types import SimpleNamespace

import pytest
from PySide6.QtGui import QImage
from pytestqt.qtbot import QtBot

from riglens.app.background.report import ReportJob, draw_report, make_report, print_report
from riglens.app.evaluation.options import SceneOptions
from riglens.core.errors import Cancelled, InputError
from riglens.core.metric.scores import MetricSettings
from riglens.core.rig.yaml.file import load_rig
from riglens.widgets.panels.dialogs.report import ReportDialog
from tests.app.window.desk import FullDesk, full_desk
from tests.app.window_bench import RIG
from tests.waiting import TIMEOUT_MS

COPIES = "import sys, shutil; shutil.copy(sys.argv[2], sys.argv[sys.argv.index('--out') + 1])"
REFUSES = "import sys; print('note: a\\nriglens: no such thing', file=sys.stderr); sys.exit(2)"


@pytest.fixture
def desk(qtbot: QtBot) -> Iterator[FullDesk]:
    with full_desk(qtbot) as made:
        yield made


def job(out: Path, **scene: object) -> ReportJob:
    return ReportJob((RIG,), SceneOptions(**scene), MetricSettings(body="blocks", camera_weight=0.25), out)  # type: ignore[arg-type]


def test_the_command_gets_rigs_scene_and_settings(tmp_path: Path) -> None:
    out = tmp_path / "r.html"
    assert make_report(job(out), lambda share: None, COPIES) == out
    assert load_rig(out).rig == RIG
    words = job(out, boxes=Path("b.csv"), voxel_m=0.2, roi_m=(20.0, 10.0, 4.0), classes=("a=car",)).words(
        [Path("1.yaml")]
    )
    text = " ".join(words)
    assert text.startswith(
        f"report 1.yaml --out {out} --body blocks --method exact --reading covered --lambda 0.25"
    )
    assert "--boxes b.csv --voxel 0.2 --roi 20.0 10.0 4.0 --classes a=car" in text
    stored = " ".join(job(out, pog=Path("p.npz"), voxel_m=0.2).words([]))
    assert "--pog p.npz" in stored and "--voxel" not in stored


def test_what_the_command_refuses_is_the_error_and_cancelling_ends_it(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"^no such thing$"):
        make_report(job(tmp_path / "r.html"), lambda share: None, REFUSES)

    def cancel(share: float) -> None:
        raise Cancelled

    with pytest.raises(Cancelled):
        make_report(job(tmp_path / "r.html"), cancel, "import time; time.sleep(60)")
    assert not (tmp_path / "r.html").exists()


PAGE = (
    "<html><body><h1>A report</h1><script>no();</script><table><tr><td>on target</td></tr></table>"
    '<svg viewBox="0 0 20 10"><circle cx="5" cy="5" r="3"/></svg><figure data-view="v"><canvas></canvas></figure>'
    "</body></html>"
)


def test_the_pages_of_a_report_are_drawn_as_they_are_printed(tmp_path: Path) -> None:
    page = tmp_path / "report.html"
    page.write_text(PAGE + "<p>a line</p>" * 100, "utf-8")
    pictures = draw_report(page, lambda share: None)
    images = [QImage(str(path)) for path in pictures]
    assert len(images) >= 2 and all((image.width(), image.height()) == (909, 1286) for image in images)
    spots = [(x, y) for x in range(60, 300, 3) for y in range(60, 300, 3)]
    dark = [any(image.pixelColor(x, y).lightness() < 90 for x, y in spots) for image in images]
    assert all(dark) and images[0].pixelColor(5, 5).name() == "#ffffff"


def preview(desk: FullDesk) -> ReportDialog:
    """The preview of a report that is made at once."""
    desk.load()
    desk.session.scene.options = SceneOptions()  # type: ignore[union-attr,misc]
    jobs: list[ReportJob] = []

    def work(job: ReportJob, progress: object) -> Path:
        jobs.append(job)
        job.out.write_text(PAGE, "utf-8")
        return job.out

    def draw(page: Path, progress: object) -> list[Path]:
        (page.parent / "pages").mkdir()
        paths = [page.parent / "pages" / f"{number}.png" for number in (1, 2)]
        for path, colour in zip(paths, (0xFFFF0000, 0xFF00FF00), strict=True):
            image = QImage(40, 3000, QImage.Format.Format_RGB32)
            image.fill(colour)
            image.save(str(path))
        return paths

    report = desk.features.report
    report.work, report.draw = work, draw  # type: ignore[assignment]
    desk.act("report")
    desk.qtbot.waitUntil(lambda: bool(report.dialogs), timeout=TIMEOUT_MS)
    assert jobs[0].rigs[0] == desk.document.rig and jobs[0].settings == desk.session.settings
    return next(iter(report.dialogs.values()))


def test_a_report_needs_data_and_is_seen_before_anything_is_written(desk: FullDesk, tmp_path: Path) -> None:
    desk.act("report")
    assert "no box data" in desk.workbench.errors.message
    dialog, report = preview(desk), desk.features.report
    page = next(iter(report.dialogs))
    desk.qtbot.waitUntil(lambda: dialog.pages.read == (0,), timeout=TIMEOUT_MS)  # the other is out of sight
    seen = dialog.pages.grab().toImage()
    assert seen.pixelColor(20, 30).name() == "#ff0000" and seen.pixelColor(20, 3060).name() == "#00ff00"
    shown: list[Path] = []
    report.show_file = shown.append
    dialog.browser.click()
    assert shown == [page]
    dialog.html.click()
    assert desk.dialogs.suggested == Path("report.html") and desk.workbench.notes.message == ""
    desk.dialogs.path = tmp_path / "mine.html"
    dialog.html.click()
    assert desk.dialogs.path.read_text("utf-8") == PAGE and "mine.html" in desk.workbench.notes.message
    dialog.close()
    assert report.dialogs == {} and not page.parent.exists()


def test_a_pdf_is_printed_from_the_page_and_what_fails_is_told(desk: FullDesk, tmp_path: Path) -> None:
    dialog, report = preview(desk), desk.features.report
    page = next(iter(report.dialogs))
    desk.dialogs.path = tmp_path / "mine.pdf"
    with pytest.raises(InputError, match=r"^no such thing$"):
        print_report(page, desk.dialogs.path, lambda share: None, REFUSES)
    report.print = partial(print_report, run="import sys, shutil; shutil.copy(sys.argv[1], sys.argv[2])")
    dialog.pdf.click()
    assert desk.dialogs.suggested == Path("report.pdf")
    desk.qtbot.waitUntil(lambda: "mine.pdf" in desk.workbench.notes.message, timeout=TIMEOUT_MS)
    assert desk.dialogs.path.read_text("utf-8") == PAGE
    desk.workbench.closing.emit()
    assert not page.parent.exists()


def test_a_report_that_fails_leaves_no_folder_and_kept_rigs_are_in_it(desk: FullDesk) -> None:
    desk.load()
    desk.session.scene.options = SceneOptions()  # type: ignore[union-attr,misc]
    report, jobs = desk.features.report, []

    def work(job: ReportJob, progress: object) -> Path:
        jobs.append(job)
        raise InputError("rig: wrong")

    report.work = work  # type: ignore[assignment]
    desk.act("report")
    desk.qtbot.waitUntil(lambda: desk.workbench.errors.message == "rig: wrong", timeout=TIMEOUT_MS)
    desk.qtbot.waitUntil(lambda: not jobs[0].out.parent.exists(), timeout=TIMEOUT_MS)
    row = SimpleNamespace(rig=RIG, name="kept", origin="snapshot")
    report._compare = SimpleNamespace(rows=[row, SimpleNamespace(rig=RIG, name="x", origin="current")])  # type: ignore[assignment]
    assert [rig.name for rig in report.rigs()] == [desk.document.rig.name, "kept"]
