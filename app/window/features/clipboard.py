"""Sensors as text on the clipboard: between windows, into a file, and back."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtGui import QGuiApplication

from riglens.app.window.actions import Spec
from riglens.app.window.feature import Feature
from riglens.core.errors import InputError
from riglens.core.rig.model import Camera, Lidar
from riglens.core.rig.yaml.file import dumps, loads
from riglens.core.rig.yaml.nodes import MAX_BYTES

if TYPE_CHECKING:
    from riglens.app.window.main_window import MainWindow

ACCEPTED = "accepted are sensors as rig YAML, as Copy writes them"


class Clipboard(Feature):
    """Copy, cut and paste of whole sensors as a rig file of their own."""

    specs = (
        Spec(
            "cut", "Cut", "Copy the selected sensors as text and delete them", "Ctrl+X", "", "edit/clipboard"
        ),
        Spec(
            "copy", "Copy", "Copy the selected sensors as text (rig YAML)", "Ctrl+C", "copy", "edit/clipboard"
        ),
        Spec("paste", "Paste", "Add the sensors on the clipboard", "Ctrl+V", "paste", "edit/clipboard"),
    )

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        self.bind(cut=window.guarded(self.cut), copy=self.copy, paste=window.guarded(self.paste))
        window.rig_shown.connect(self._update)

    def copy(self) -> None:
        """Put the selected sensors on the clipboard."""
        rig, names = self.document.rig, self.window.tree.chosen
        if names:
            sensors = tuple(sensor.replace(mirror_of=None) for sensor in rig.sensors if sensor.name in names)
            QGuiApplication.clipboard().setText(dumps(rig.replace(sensors=sensors)))

    def cut(self) -> None:
        """Copy, then delete; InputError when a sensor is locked."""
        names = self.window.tree.chosen
        if names:
            self.copy()
            self.document.delete(names)

    def paste(self) -> None:
        """Add the sensors of the clipboard under free names, as one step; InputError when it holds none."""
        sensors = pasted(QGuiApplication.clipboard().text())
        names = sensors[0].name if len(sensors) == 1 else f"{len(sensors)} sensors"
        with self.document.group(f"paste {names}"):
            for sensor in sensors:
                self.document.add(sensor)

    def _update(self) -> None:
        for key in ("cut", "copy"):
            self.window.actions_[key].setEnabled(self.document.selected is not None)


def pasted(text: str) -> tuple[Lidar | Camera, ...]:
    """The sensors that a text says: a rig file, its part from "sensors:" on, or a list of sensors."""
    if not text.strip():
        raise InputError(f"clipboard: there is no text on it; {ACCEPTED}")
    if len(text) > MAX_BYTES:
        raise InputError(f"clipboard: {len(text) / 1e6:.1f} MB of text; {ACCEPTED}")
    try:
        sensors = loads(_whole(text), "clipboard").rig.sensors
    except InputError as error:
        raise InputError(f"{error}; {ACCEPTED}") from error
    if not sensors:
        raise InputError(f"clipboard: the text has no sensors; {ACCEPTED}")
    return sensors


def _whole(text: str) -> str:
    """A part of a rig file made a whole one."""
    start = text.lstrip("\n\r").lstrip()
    if start.startswith("- "):
        return f"riglens: 1\nname: clipboard\nsensors:\n{text}"
    return f"riglens: 1\nname: clipboard\n{text}" if start.startswith("sensors:") else text
