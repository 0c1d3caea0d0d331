"""The room on the screen around a widget, asked in a way that does not end the program later."""

import subprocess
import sys
from pathlib import Path

from PySide6.QtCore import QPoint, QRect
from PySide6.QtWidgets import QDialog
from pytestqt.qtbot import QtBot

from riglens.widgets.panels.controls.building import room_around

REPOSITORY = Path(__file__).resolve().parents[3]
ASKED = """
import gc, random, sys
from PySide6.QtWidgets import QApplication, QDialog, QMainWindow
from riglens.widgets.panels.controls.building import room_around
app, chance, windows = QApplication([]), random.Random(1), []
for step in range(3000):
    what = chance.choice("new new ask ask ask tie show drop gc".split())
    if what == "new" and len(windows) < 6:
        windows.append(chance.choice((QDialog, QMainWindow))())
    elif what == "gc":
        gc.collect()
    elif what == "drop" and windows:
        windows.pop(chance.randrange(len(windows)))
    elif windows:
        window = chance.choice(windows)
        if what == "show":
            window.show()
            app.processEvents()
        else:
            room_around(window)
        if what == "tie":
            window.itself = window  # for garbage collection, as all windows are that have callbacks
        del window
    assert len(app.screens()) == 1 and app.primaryScreen().availableGeometry().width() > 0
print("sound")
"""


def test_windows_that_asked_for_room_are_collected_without_harm(xvfb: str) -> None:
    done = subprocess.run(
        [sys.executable, "-c", ASKED], capture_output=True, encoding="utf-8", check=False, cwd=REPOSITORY
    )
    assert (done.returncode, done.stdout.strip()) == (0, "sound"), done.stderr


def test_the_room_is_that_of_the_screen_around_a_window_shown_or_hidden(qtbot: QtBot) -> None:
    window = QDialog()
    qtbot.addWidget(window)
    within = QDialog(window)
    window.setGeometry(QRect(300, 200, 200, 100))
    rooms = [room_around(window), room_around(within)]
    window.show()
    rooms.append(room_around(window))
    window.move(QPoint(-5000, -5000))
    rooms.append(room_around(window))
    assert len({(room.width(), room.height()) for room in rooms}) == 1
    assert rooms[0].width() >= 1000
