"""A window in a process of its own, to be killed: edits its rig, says when that is on the disk, and waits."""

from __future__ import annotations

import sys
from pathlib import Path

from PySide6.QtCore import QTimer
from PySide6.QtWidgets import QApplication

from riglens.app.background.counting import make_counter
from riglens.app.background.recompute import Recompute
from riglens.app.session.document import Document
from riglens.app.window.main_window import MainWindow
from riglens.core.metric.scores import MetricSettings
from riglens.core.rig.yaml.file import load_rig
from tests.app.window_bench import RIG, FakeViewport, scene_options


def main(folder: Path, rig: Path | None) -> None:
    """Open `rig`, or a rig without a file, move the LiDAR to z = 3 m, and print the name of the autosave file."""
    app = QApplication([])
    file = load_rig(rig) if rig is not None else None
    document = Document(file.rig if file else RIG, file, rig)
    scene = scene_options(folder)
    window = MainWindow(
        document, FakeViewport(), Recompute(threads=1), make_counter(), scene, MetricSettings()
    )
    autosave = window.features.autosave
    autosave.start(folder / "unsaved")
    document.replace_sensor("roof", document.rig.sensor("roof").replace(position=(0.0, 0.0, 3.0)))
    timer = QTimer()

    def look() -> None:
        found = list((folder / "unsaved").glob("*.autosave.json"))
        if found:
            print(found[0].name, flush=True)
            timer.stop()

    timer.timeout.connect(look)
    timer.start(20)
    app.exec()


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]) if len(sys.argv) > 2 else None)
