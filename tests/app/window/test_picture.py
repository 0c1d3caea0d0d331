"""Pictures for reports: the dialog shows what it saves, and it is what `riglens render` draws."""

from __future__ import annotations

import os
import threading
from collections.abc import Iterator
from dataclasses import replace
from multiprocessing.connection import Connection

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QGuiApplication, QImage
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from riglens.app.background import picture_process
from riglens.app.background.picture_process import PictureJob, PictureMaker
from riglens.app.window.settings import Settings
from riglens.core.errors import InputError
from riglens.core.figures.figure import Estimate
from riglens.core.rig.model import Rig
from riglens.core.scene.boxes import CLASSES
from riglens.rendering.picture import Findings, PictureWords, with_words
from riglens.rendering.picture_set import CAPTIONS, VIEWS
from riglens.widgets.panels.dialogs.picture import PictureDialog
from riglens.widgets.theme import palette
from riglens.widgets.viewport.scene_state import SceneState
from riglens.widgets.viewport.still import png_of, render_still
from tests.app.window_bench import Bench
from tests.waiting import TIMEOUT_MS

SIZE = (240, 150)


@pytest.fixture(scope="module")
def at_work(file_window: Bench) -> None:
    """Begin the threads that draw and that find how high the sensors stand, which end with the window."""
    opened_dialog(file_window).reject()


@pytest.fixture
def bench(at_work: None, whole: Bench) -> Iterator[Bench]:
    yield whole
    if whole.features.picture.dialog is not None:
        whole.features.picture.dialog.reject()


class StandIn(PictureMaker):
    """Draws at once, in this process, one grey pixel; `jobs` are what was asked for."""

    def __init__(self) -> None:
        super().__init__()
        self.jobs: list[PictureJob] = []

    def ask(self, job: PictureJob) -> None:
        self.jobs.append(job)
        self.answered.emit(job, png_of(np.full((1, 1, 3), 128, np.uint8)))


def with_stand_in(bench: Bench, monkeypatch: pytest.MonkeyPatch) -> StandIn:
    picture, maker = bench.features.picture, StandIn()
    maker.answered.connect(picture._on_made)
    monkeypatch.setattr(picture, "maker", maker)
    return maker


def opened_dialog(bench: Bench) -> PictureDialog:
    """The dialog, asking for a small picture; the view shows how high the sensors stand, which is found elsewhere."""
    bench.qtbot.waitUntil(lambda: bool(bench.viewport.state.masts), timeout=TIMEOUT_MS)
    bench.act("screenshot")
    dialog = bench.features.picture.dialog
    assert dialog is not None
    dialog.width_px.setValue(SIZE[0])
    dialog.height_px.setValue(SIZE[1])
    return dialog


def wait_for_picture(bench: Bench) -> None:
    """Wait until the last picture asked for is in the dialog."""
    bench.qtbot.waitUntil(lambda: bench.features.picture.maker.wait_until_idle(0.0), timeout=TIMEOUT_MS)
    QApplication.processEvents()


def press(button) -> None:
    QTest.mouseClick(button, Qt.MouseButton.LeftButton)


def pixels(image: QImage) -> np.ndarray:
    image = image.convertToFormat(QImage.Format.Format_RGBA8888)
    rows = np.frombuffer(image.constBits(), np.uint8).reshape(image.height(), image.bytesPerLine())
    return rows[:, : 4 * image.width()].reshape(image.height(), image.width(), 4).copy()


@pytest.mark.slow
def test_what_is_previewed_is_saved_larger_by_the_code_that_draws_everywhere_also_after_a_cancel(
    bench, tmp_path
):
    dialog, picture = opened_dialog(bench), bench.features.picture
    for box in (dialog.title, dialog.scores, dialog.light, dialog.transparent):
        box.setChecked(True)
    dialog.scale.setCurrentIndex(1)
    wait_for_picture(bench)
    preview = pixels(dialog.preview.image)
    assert preview.shape == (SIZE[1], SIZE[0], 4) and preview[0, -1, 3] == 0
    bench.dialogs.path = tmp_path / "view.png"
    press(dialog.save)
    assert dialog.busy.is_running and not dialog.save.isEnabled()
    dialog.busy.cancel.click()
    assert not dialog.busy.is_running and dialog.save.isEnabled() and picture.maker._process is None
    press(dialog.save)
    bench.qtbot.waitUntil(lambda: picture.maker._process is not None, timeout=TIMEOUT_MS)
    process = picture.maker._process
    bench.qtbot.waitUntil(lambda: picture.dialog is None, timeout=TIMEOUT_MS)
    bench.qtbot.waitUntil(lambda: not process.is_alive, timeout=TIMEOUT_MS)
    saved = pixels(QImage(str(tmp_path / "view.png")))
    assert saved.shape == (2 * SIZE[1], 2 * SIZE[0], 4) and saved[0, -1, 3] == 0

    result = bench.workbench.answers.result
    assert result is not None
    found = Findings(
        result.request.rig, result.evaluation.scores, result.request.settings, result.scene.field
    )
    state = replace(bench.viewport.state, palette=palette(False))
    state = with_words(state, PictureWords(True, True, True), found)
    again = render_still(state, SIZE, 2, transparent=True)
    assert np.abs(saved.astype(int) - again).mean() < 0.5


def test_the_dialog_asks_for_what_is_chosen(bench, monkeypatch):
    maker = with_stand_in(bench, monkeypatch)
    dialog = opened_dialog(bench)
    dialog.legend.setChecked(False)
    dialog.transparent.setChecked(True)
    dialog.scale.setCurrentIndex(3)
    last = maker.jobs[-1]
    assert (last.size_px, last.scale, last.transparent, last.purpose) == (SIZE, 1, True, "preview")
    assert not last.state.show_legend and not last.state.caption.table
    press(dialog.copy)
    assert (maker.jobs[-1].scale, maker.jobs[-1].purpose) == (4, "copy")
    assert QGuiApplication.clipboard().image().size() == dialog.preview.image.size()


def test_a_picture_that_cannot_be_written_leaves_a_message(bench, monkeypatch, tmp_path):
    with_stand_in(bench, monkeypatch)
    dialog = opened_dialog(bench)
    bench.dialogs.path = tmp_path / "missing" / "view.png"
    press(dialog.save)
    assert bench.workbench.errors.isVisible()
    assert not (tmp_path / "missing").exists()


def test_a_picture_beyond_the_limit_cannot_be_saved(bench, monkeypatch):
    with_stand_in(bench, monkeypatch)
    dialog = opened_dialog(bench)
    dialog.width_px.setValue(4000)
    assert dialog.save.isEnabled()
    dialog.scale.setCurrentIndex(3)
    assert not dialog.save.isEnabled()


def die(pipe: Connection) -> None:
    pipe.recv()


def test_when_the_process_dies_the_window_says_so(bench, monkeypatch):
    monkeypatch.setattr("riglens.app.background.picture_process.WORK", f"{__name__}:die")
    dialog = opened_dialog(bench)
    bench.qtbot.waitUntil(lambda: bench.workbench.errors.isVisible(), timeout=TIMEOUT_MS)
    assert dialog.save.isEnabled()


def test_words_of_a_picture_are_those_of_the_rig_and_its_scores(bench):
    result = bench.workbench.answers.result
    assert result is not None
    found = Findings(Rig(name="mine"), result.evaluation.scores, result.request.settings, result.scene.field)
    caption = with_words(SceneState(), PictureWords(title=True, scores=True), found).caption
    assert caption.title == "mine" and "0 cameras, 0 LiDARs · δ = 0.5 m" in caption.subtitle
    head = f"body {found.rig.body}"
    assert [row[0] for row in caption.table] == [head, "car", "bicycle", "pedestrian"]
    assert len(caption.table[0]) > 1 and "At least 5 points" not in caption.table[0]
    objects = {"share_5": dict.fromkeys(CLASSES, Estimate(0.5))}
    counted = with_words(SceneState(), PictureWords(scores=True), replace(found, objects=objects)).caption
    assert "At least 5 points" in counted.table[0] and "50.00 %" in counted.table[1]
    bare = with_words(SceneState(), PictureWords(legend=False), found)
    assert not bare.show_legend and not bare.caption.title and not bare.caption.table


def test_a_picture_of_a_changed_rig_says_so_shows_no_selection_and_has_a_ground_by_choice(bench, monkeypatch):
    maker = with_stand_in(bench, monkeypatch)
    bench.document.select("roof")
    dialog = opened_dialog(bench)
    dialog.title.setChecked(True)
    last = maker.jobs[-1].state
    assert (last.caption.title, last.show_ground, last.show_selection) == ("small", True, False)
    assert not last.is_selected("roof") and bench.viewport.state.is_selected("roof")
    dialog.ground.setChecked(False)
    assert not maker.jobs[-1].state.show_ground
    dialog.reject()
    bench.document.replace_sensor("roof", bench.document.rig.sensor("roof").replace(position=(0.0, 0.0, 2.5)))
    bench.settle()
    dialog = opened_dialog(bench)
    dialog.title.setChecked(True)
    assert maker.jobs[-1].state.caption.title == "small (changed)"


def test_the_options_of_the_last_time_are_chosen_again_also_in_the_next_session(bench, monkeypatch):
    maker = with_stand_in(bench, monkeypatch)
    dialog = opened_dialog(bench)
    for box in (dialog.title, dialog.light, dialog.transparent):
        box.setChecked(not box.isChecked())
    dialog.legend.setChecked(False)
    dialog.scale.setCurrentIndex(2)
    chosen = dialog.options
    dialog.reject()
    again = opened_dialog(bench)
    assert again.options == chosen and again.choice.scale == 3 and not chosen["legend"]
    assert not maker.jobs[-1].state.show_legend
    again.reject()
    picture, kept = bench.features.picture, Settings()
    picture.keep(kept)
    picture._options, picture._scale = {}, 1
    picture.restore(kept)
    assert opened_dialog(bench).options == chosen and bench.features.picture.dialog.choice.scale == 3
    kept.write("picture/scale", "99")
    kept.write("picture/options", {"legend": "no", "nonsense": True})
    picture.restore(kept)
    assert picture._scale == 1 and picture._options == {"nonsense": True}


@pytest.mark.slow
def test_the_picture_set_is_written_whole_by_its_own_process(bench, tmp_path, monkeypatch):
    monkeypatch.setattr("riglens.app.window.features.picture.SET_PX", (80, 50))
    monkeypatch.setattr("riglens.app.window.features.picture.SET_SCALE", 1)
    bench.dialogs.path = tmp_path / "set"
    bench.act("picture_set")
    bench.qtbot.waitUntil((bench.dialogs.path / CAPTIONS).exists, timeout=TIMEOUT_MS)
    title, *captions = (bench.dialogs.path / CAPTIONS).read_text(encoding="utf-8").splitlines()
    assert title == bench.document.rig.name
    names = {line.split(": ")[0] for line in captions}
    cameras = {f"camera-{one.name}" for one in bench.document.rig.enabled_cameras()}
    assert names >= {*VIEWS, *cameras}
    files = {file.name for file in bench.dialogs.path.iterdir()}
    assert files == {f"{name}{suffix}" for name in names for suffix in (".png", ".svg")} | {CAPTIONS}


def test_a_second_picture_set_waits_for_the_end_of_the_first(bench, tmp_path, monkeypatch):
    is_over = threading.Event()
    monkeypatch.setattr("riglens.app.window.features.picture.drawn_set", lambda *_: is_over.wait(60.0))
    bench.dialogs.path = tmp_path / "set"
    action = bench.workbench.actions["picture_set"]
    usual = action.toolTip()
    bench.act("picture_set")
    assert not action.isEnabled() and action.toolTip() != usual
    is_over.set()
    bench.qtbot.waitUntil(action.isEnabled, timeout=TIMEOUT_MS)
    assert action.toolTip() == usual


def crash(pipe: Connection) -> None:
    """End like a process that crashes."""
    os._exit(3)


def test_a_drawing_process_that_crashes_says_with_which_exit_code(tmp_path, monkeypatch):
    monkeypatch.setattr(picture_process, "SET_WORK", f"{__name__}:crash")
    with pytest.raises(InputError, match=r"the drawing process exited without a result \(exit code 3\)"):
        picture_process.drawn_set(SceneState(), tmp_path, (8, 5), 1, lambda *_: None)
