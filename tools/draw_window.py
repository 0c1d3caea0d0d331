"""Draw docs/images/window.png and docs/images/compare.png: the window as README shows it.

    xvfb-run -a -s "-screen 0 1440x900x24" python tools/draw_window.py window|compare

Needs a display without a window manager, of the size of the larger picture. Scores take some seconds.
"""

from __future__ import annotations

import os
import sys
import tempfile
import time
from pathlib import Path

from PySide6.QtCore import QTimer
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QDockWidget

from riglens.app.window.main_window import MainWindow
from riglens.app.window.start import open_window
from riglens.core.formats.opening import open_rig
from riglens.evaluation.options import SceneOptions, ScoreOptions

IMAGES = Path(__file__).resolve().parents[1] / "docs" / "images"
LONGEST_S = 180
STILL_MS = 5_000
"""Time for the full picture after that."""


def settled(window: MainWindow) -> None:
    """Wait until all scores and counts belong to the rigs and everything is drawn."""
    targets, compare, marginals = window.features.targets, window.features.compare, window.features.marginals
    end = time.monotonic() + LONGEST_S
    while time.monotonic() < end:
        QTest.qWait(100)
        has_losses = len(marginals.figures) == sum(one.enabled for one in window.session.document.rig.sensors)
        is_whole = targets.is_current and has_losses and all(row.counted for row in compare.rows)
        if window.is_exact and is_whole and all(row.scores for row in compare.rows):
            break
    QTest.qWait(STILL_MS)


def first_window(window: MainWindow) -> None:
    """Show the window as it starts, with the front camera selected."""
    window.setGeometry(0, 0, 1440, 900)
    window.session.document.select("CAM_FRONT")


def compared_rigs(window: MainWindow) -> None:
    """Show the dark theme, the map, and four of the paper's rigs as bars."""
    window.setGeometry(0, 0, 1280, 800)
    window.features.theme.actions["theme_dark"].trigger()
    window.features.compare.add_presets(("W+C", "W+P", "W+L"))
    window.session.document.select("CAM_FRONT")
    for dock in window.findChildren(QDockWidget):
        if dock.windowTitle() in ("Map", "Compare"):
            dock.raise_()
    window.features.compare.panel.set_bars(True)


def draw(name: str) -> None:
    """Open the window in this process and keep its picture."""
    rig, show = {"window": ("nuScenes car", first_window), "compare": ("W+T", compared_rigs)}[name]

    def act() -> None:
        (window,) = (it for it in QApplication.topLevelWidgets() if isinstance(it, MainWindow))
        show(window)
        settled(window)
        place = window.geometry()
        screen = window.screen().grabWindow(0, place.x(), place.y(), place.width(), place.height())
        assert screen.save(str(IMAGES / f"{name}.png"))
        os._exit(0)

    app = QApplication(["riglens"])
    QTimer.singleShot(2000, app, act)
    with tempfile.TemporaryDirectory() as folder:
        os.environ |= {"RIGLENS_CONFIG_DIR": folder, "RIGLENS_STATE_DIR": folder}
        open_window(open_rig(rig), SceneOptions(), ScoreOptions())


if __name__ == "__main__":
    draw(sys.argv[1])
