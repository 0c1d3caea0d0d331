"""File > Report: the command is run with what the window shows, and what it refuses is told."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace

import pytest
from pytestqt.qtbot import QtBot

from riglens.app.background.report import ReportJob, make_report
from riglens.app.background.tasks import TaskCancelled
from riglens.app.evaluation.options import SceneOptions
from riglens.core.errors import InputError
from riglens.core.metric.scores import MetricSettings
from riglens.core.rig.yaml.file import load_rig
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
        raise TaskCancelled

    with pytest.raises(TaskCancelled):
        make_report(job(tmp_path / "r.html"), cancel, "import time; time.sleep(60)")
    assert not (tmp_path / "r.html").exists()


def test_a_report_is_asked_for_made_and_offered(desk: FullDesk, tmp_path: Path) -> None:
    report, made = desk.features.report, []
    desk.workbench.actions["report"].trigger()
    assert "no box data" in desk.workbench.errors.message
    desk.load()
    desk.session.scene.options = SceneOptions()  # type: ignore[union-attr,misc]

    def work(job: ReportJob, progress: object) -> Path:
        made.append(job)
        return job.out

    report.work = work
    desk.workbench.actions["report"].trigger()
    assert made == [] and desk.dialogs.suggested == Path("report.html")
    desk.dialogs.path = tmp_path / "mine.html"
    desk.workbench.actions["report"].trigger()
    desk.qtbot.waitUntil(lambda: "mine.html" in desk.workbench.notes.message, timeout=TIMEOUT_MS)
    assert made[0].rigs[0] == desk.document.rig and made[0].settings == desk.session.settings
    row = SimpleNamespace(rig=RIG, name="kept", origin="snapshot")
    report._compare = SimpleNamespace(rows=[row, SimpleNamespace(rig=RIG, name="x", origin="current")])  # type: ignore[assignment]
    assert [rig.name for rig in report.rigs()] == [desk.document.rig.name, "kept"]
