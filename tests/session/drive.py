"""A session in a process of its own: `python -m tests.session.drive work|recover|search FOLDER`.

`work` edits a rig, saves it, edits on, and is killed without warning; `recover` starts again and gets the edits back.
`search` drags a sensor while a search for rigs runs and while it rests, in turn.
"""

from __future__ import annotations

import json
import os
import signal
import sys
import traceback
from collections.abc import Callable
from pathlib import Path

from PySide6.QtCore import QPoint, QTimer
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QComboBox, QPushButton

from riglens.app.window.main_window import MainWindow
from riglens.app.window.start import open_window
from riglens.core.formats.opening import open_rig
from riglens.core.rig.presets import PRESETS
from riglens.core.rig.yaml.file import dumps, load_rig
from riglens.evaluation.options import SceneOptions, ScoreOptions
from riglens.widgets.gizmo.drag import Handle
from tests.session.person import Answers, Person

MODEL = "VLP-16"
ROUNDS = 4
"""Drags in each state of a search, after one that warms up."""


def work(person: Person) -> None:
    """Everything up to the crash."""
    window, document = person.window, person.window.session.document
    person.settle()
    person.look("start")
    place_on_roof(person)
    drag_and_turn(person)
    mirror_and_travel(person)
    change_voxel(person)
    compare(person)
    save(person, person.folder / "session.yaml")
    lift(person)
    person.wait(lambda: list((person.folder / "state").rglob("*.autosave.json")), "an autosave")
    person.notes["killed_with"] = dumps(document.rig)
    assert window.isWindowModified()


def place_on_roof(person: Person) -> None:
    """A library LiDAR onto the roof: what is seen grows."""
    document, before = person.window.session.document, person.seen()
    count = len(document.rig.sensors)
    person.double_click_model(MODEL)
    assert len(document.rig.sensors) == count + 1
    person.key("P")
    person.click(person.pixel((-0.1, 0.15, document.rig.vehicle.height)))
    placed = document.selected_sensor()
    assert placed is not None and placed.kind == "lidar"
    x, y, z = placed.position
    assert abs(x) < 1.0 and abs(y) < 0.7 and 1.2 < z < 1.7, placed.position
    assert person.seen() >= before
    person.look("placed-on-roof")


def drag_and_turn(person: Person) -> None:
    """Up along the blue arrow, then about the vertical: one undo step each."""
    document = person.window.session.document
    name = document.selected
    assert name is not None
    before = document.rig.sensor(name)
    person.key("W")
    person.settle()
    person.raise_dock("Map")
    person.drag("drag up, map in sight", person.handle(Handle("move", 2)), QPoint(0, -70))
    person.raise_dock("Inspector")
    person.drag("drag down", person.handle(Handle("move", 2)), QPoint(0, 25))
    lifted = document.rig.sensor(name)
    assert lifted.position[2] > before.position[2] + 0.1
    person.look("dragged")
    person.key("E")
    person.settle()
    person.drag("turn", person.handle(Handle("rotate", 2)), QPoint(50, 8))
    turned = document.rig.sensor(name)
    assert turned.position == lifted.position and turned.rpy_deg != lifted.rpy_deg
    person.look("turned")


def mirror_and_travel(person: Person) -> None:
    """Mirror, undo three times, redo three times: the same rig and the same figures."""
    document = person.window.session.document
    count = len(document.rig.sensors)
    person.key("M")
    assert len(document.rig.sensors) == count + 1
    person.look("mirrored")
    after, figures = document.rig, person.window.bench.panels.scores.table.as_text()
    for _ in range(3):
        person.key("Ctrl+Z")
    assert document.rig != after
    person.look("undone")
    for _ in range(3):
        person.key("Ctrl+Shift+Z")
    assert document.rig == after
    person.settle()
    assert person.window.bench.panels.scores.table.as_text() == figures


def change_voxel(person: Person) -> None:
    """Larger voxels, in the Scene panel."""
    panel = person.window.bench.panels.scene
    person.raise_dock("Scene")
    combo = panel.findChild(QComboBox, "voxel_m")
    load = panel.findChild(QPushButton, "load")
    assert combo is not None and load is not None
    edit = combo.lineEdit()
    assert edit is not None
    person.type_into(edit, "0.2")
    person.press(load)
    person.wait(lambda: "δ 0.2 m" in person.window.bench.status.scene.toolTip(), "voxels of 0.2 m")
    person.look("voxels-of-0.2-m")


def compare(person: Person) -> None:
    """The rig as the baseline, and two rigs of the paper beside each other."""
    person.key("Ctrl+B")
    assert person.window.session.pinned is not None
    person.raise_dock("Compare")
    feature = person.window.features.compare
    menu = feature.panel._add.menu()
    for name in ("W+T", "N+C"):
        person.choose(menu, "Preset", PRESETS[name].title)
    person.wait(lambda: all(row.scores is not None for row in feature.rows), "scores of all rigs")
    assert {"W+T", "N+C"} <= {row.name for row in feature.rows}
    person.look("compared")
    person.raise_dock("Scores")


def save(person: Person, path: Path) -> None:
    """Ctrl+S writes the very rig that is shown."""
    person.window.bench.dialogs.path = path  # type: ignore[attr-defined]
    person.key("Ctrl+S")
    assert load_rig(path).rig == person.window.session.document.rig
    assert not person.window.isWindowModified()
    person.notes["saved"] = dumps(person.window.session.document.rig)


def lift(person: Person) -> None:
    """One more edit, which is not saved; undo and redo may have left nothing selected."""
    person.window.session.document.select(person.window.session.document.rig.sensors[-1].name)
    person.key("W")
    person.settle()
    person.drag("drag after saving", person.handle(Handle("move", 2)), QPoint(0, -30), steps=10)


def recover(person: Person) -> None:
    """The edits after the last save are offered, come back, and can be exported."""
    window, document = person.window, person.window.session.document
    expected = json.loads((person.folder / "work.json").read_text(encoding="utf-8"))
    person.settle()
    button = window.bench.notes.findChild(QPushButton, "Recover")
    assert button is not None and button.isVisible()
    person.look("recovery-offered")
    person.press(button)
    assert dumps(document.rig) == expected["killed_with"]
    assert window.isWindowModified() and document.path == person.folder / "session.yaml"
    person.look("recovered")
    person.key("Ctrl+Z")
    assert dumps(document.rig) == expected["saved"]
    person.key("Ctrl+Shift+Z")
    export(person)


def export(person: Person) -> None:
    """A picture with the scores on it by F12, and the rig as a robot description."""
    answers = person.window.bench.dialogs
    assert isinstance(answers, Answers)
    answers.path = person.folder / "view.png"
    person.key("F12")
    feature = person.window.features.picture
    person.wait(lambda: feature.dialog is not None and not feature.dialog.preview.image.isNull(), "a preview")
    assert feature.dialog is not None
    feature.dialog.scores.click()
    person.wait(feature.dialog.save.isEnabled, "a preview with scores")
    person.look("picture")
    person.press(feature.dialog.save)
    person.wait(answers.path.exists, "the picture")
    assert answers.path.read_bytes().startswith(b"\x89PNG")
    answers.path = person.folder / "session.urdf"
    menu = person.window.features.exchange.menu
    menu.popup(QPoint(40, 60))
    person.wait(menu.isVisible, "the formats")
    person.choose(menu, next(action.text() for action in menu.actions() if "URDF" in action.text()))
    menu.close()
    assert answers.path.read_text(encoding="utf-8").count("<joint") >= len(
        person.window.session.document.rig.sensors
    )


def search(person: Person) -> None:
    """Measure the frame times of a drag during a search and during a paused one."""
    document, panel = person.window.session.document, person.window.features.propose.panel
    person.settle()
    document.select(document.rig.enabled_lidars()[0].name)
    person.key("W")
    person.raise_dock("Propose")
    panel.show_options(panel.options.replace(count=8, singles=True, frames=1000))
    person.press(panel.start)
    person.wait(lambda: panel.bar.value() > 0, "the first mounts")
    took_ms: dict[str, list[float]] = {"paused": [], "running": []}
    for turn in range(ROUNDS + 1):
        for state, times in took_ms.items():
            person.press(panel.pause)
            QTest.qWait(500)  # casts under way end
            assert not panel.start.isEnabled(), "the search ended too early"
            by = QPoint(0, 60 if turn % 2 else -60)
            times += person.drag(f"{turn} {state}", person.handle(Handle("move", 2)), by)[: 100 * turn]
            person.settle()
    person.notes["frames_ms"] = took_ms
    person.press(panel.stop)


def main(part: str, folder: Path) -> int:
    """Open the window as the command line does and have a person use it; the process ends by its own hand."""
    app = QApplication(["riglens"])
    parts: dict[str, Callable[[Person], None]] = {"work": work, "recover": recover, "search": search}

    def use() -> None:
        window = next(widget for widget in app.topLevelWidgets() if isinstance(widget, MainWindow))
        window.bench.dialogs = Answers()
        window.activateWindow()
        person = Person(window, folder, part)
        try:
            parts[part](person)
        except BaseException:
            traceback.print_exc()
            QApplication.primaryScreen().grabWindow(0).save(str(folder / f"{part}-failed.png"))
            os._exit(1)
        (folder / f"{part}.json").write_text(json.dumps(person.notes, indent=1), encoding="utf-8")
        if part == "work":
            os.kill(os.getpid(), signal.SIGKILL)
        window.close()

    QTimer.singleShot(0, use)
    rig = str(folder / "session.yaml") if part == "recover" else "W+T"
    return open_window(open_rig(rig), SceneOptions(), ScoreOptions())


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], Path(sys.argv[2])))
