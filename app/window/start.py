"""Opens the window on a rig and runs it to its end."""

from __future__ import annotations

import gc
import sys

from PySide6.QtCore import Qt, QTimer
from PySide6.QtWidgets import QApplication

from riglens.app.background.compiling import OtherKernels
from riglens.app.background.counting import make_counter
from riglens.app.background.memory import FreedMemory, keep_one_source, share_memory
from riglens.app.background.recompute import Recompute
from riglens.app.launch.interrupt import Grace, quit_on_interrupt
from riglens.app.session.document import Document
from riglens.app.window.main_window import MainWindow
from riglens.app.window.settings import Settings
from riglens.app.window.unexpected import failures_told
from riglens.core.formats.report import OpenedRig
from riglens.core.metric.scores import MetricSettings
from riglens.core.sensing.kept import RAYS, SHADOWS
from riglens.core.user_folders import config_folder, state_folder
from riglens.evaluation.options import SceneOptions, ScoreOptions
from riglens.widgets.panels.controls.style import apply_style, is_dark
from riglens.widgets.theme import palette

LONGEST_WAIT_MS = 3000
"""Longest wait for the first picture, which loading boxes and compiled code would slow down; a window that opens
minimised draws none."""

KEPT_RAYS_BYTES = 240 << 20
"""Room for rays: enough for scores and objects of cameras with one lens of 2.5 megapixels, which take 195 MB, and of
small sensors beside them; not of two such lenses."""

SWITCH_S = 2e-4
"""Longest turn of a thread that runs Python while another waits. Each of hundreds of calls of Qt that make one form
waits for a turn of each busy worker: with Python's 5 ms a form took 1.7 s beside two of them, so it takes 0.2 s."""


def open_window(opened: OpenedRig, scene: SceneOptions, score: ScoreOptions) -> int:
    """Open the window on a rig, run it and return the exit code.

    Boxes are loaded in the background: the window is there at once,
    and says what is wrong with them.
    """
    sys.setswitchinterval(SWITCH_S)
    share_memory()
    keep_one_source()
    RAYS.limit_bytes = KEPT_RAYS_BYTES
    app = QApplication.instance() or QApplication(["riglens"])
    assert isinstance(app, QApplication)
    apply_style(app)
    from riglens.widgets.viewport.backend import (
        create_viewport,  # loads VTK, which a check of the rig file does not need
    )

    path = opened.file.path if opened.file is not None else None
    document = Document(opened.rig, opened.file, path)
    settings = MetricSettings(camera_weight=score.camera_weight)
    kept = Settings(config_folder() / "window.ini")
    viewport = create_viewport(palette=palette(is_dark()))
    recompute = Recompute(threads=score.threads, waits=True, others=OtherKernels())
    viewport.shown.connect(recompute.begin, Qt.ConnectionType.SingleShotConnection)
    QTimer.singleShot(LONGEST_WAIT_MS, recompute, recompute.begin)
    window = MainWindow(
        document, viewport, recompute, make_counter(threads=score.threads), scene, settings, kept=kept
    )
    window.session.set_body(score.body)
    freed = FreedMemory(lambda: document.is_dragging, window)
    window.bench.answers.answered.connect(freed.note)
    freed.resting.connect(window.bench.rest)
    for kept_answers in (RAYS, SHADOWS):  # 240 and 64 MB, of no use to another rig
        freed.resting.connect(kept_answers.release_unused)
        document.opened.connect(kept_answers.forget)
    grace = Grace()
    with quit_on_interrupt(app) as interrupt, failures_told(window.bench.report_error, state_folder()):
        window.bench.closing.connect(
            lambda: grace.start(interrupt.code)
        )  # the last to be told: all is kept by then
        window.show()
        gc.freeze()  # what is there now stays: looking through it once would take as long as drawing a frame
        gc.enable()  # app.main paused it
        window.features.autosave.start(state_folder() / "unsaved")
        window.features.help.start()
        window.features.exchange.show_report(opened.report)
        code = app.exec() or interrupt.code
    grace.cancel()
    return code
