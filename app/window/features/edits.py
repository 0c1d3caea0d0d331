"""The rig edited by steps: undo and redo, sensors as text on the clipboard, mirror pairs."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from PySide6.QtGui import QGuiApplication

from riglens.app.window.actions import Spec
from riglens.app.window.feature import Feature
from riglens.app.window.workbench import Workbench
from riglens.core.errors import InputError
from riglens.core.rig.edits import (
    free_name,
    linked,
    mirrored_name,
    nearest_to_image,
    partner_of,
    unlinked,
    with_mirror_image,
)
from riglens.core.rig.model import Camera, Lidar, Rig
from riglens.core.rig.yaml.file import dumps, loads
from riglens.core.rig.yaml.nodes import MAX_BYTES


class Edits(Feature):
    """Undo and redo, with the name of the step in the menu."""

    specs = (
        Spec("undo", "Undo", "Take back the last change", "Ctrl+Z", "undo", "edit/history", "history"),
        Spec(
            "redo",
            "Redo",
            "Do again what was taken back",
            "Ctrl+Shift+Z; Ctrl+Y",
            "redo",
            "edit/history",
            "history",
        ),
    )

    def __init__(self, bench: Workbench) -> None:
        super().__init__(bench)
        self.bind(
            undo=partial(self.travel, self.document.undo),
            redo=partial(self.travel, self.document.redo),
        )
        self.document.steps_changed.connect(self._update)
        self._update()

    def travel(self, step: Callable[[], None]) -> None:
        """Undo or redo; during a drag both only give up the drag."""
        if not self.viewport.cancel_drag():
            step()

    def _update(self) -> None:
        for key, label in (("undo", self.document.undo_label), ("redo", self.document.redo_label)):
            action = self.actions[key]
            action.setEnabled(label is not None)
            action.setText(f"{key.capitalize()} {label}" if label else key.capitalize())


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

    def __init__(self, bench: Workbench) -> None:
        super().__init__(bench)
        self.bind(cut=bench.guarded(self.cut), copy=self.copy, paste=bench.guarded(self.paste))
        self.document.selection_changed.connect(self._update)
        self._update()

    def copy(self) -> None:
        """Put the selected sensors on the clipboard."""
        rig, names = self.document.rig, self.document.chosen
        if names:
            sensors = tuple(sensor.replace(mirror_of=None) for sensor in rig.sensors if sensor.name in names)
            QGuiApplication.clipboard().setText(dumps(rig.replace(sensors=sensors)))

    def cut(self) -> None:
        """Copy, then delete; InputError when a sensor is locked."""
        names = self.document.chosen
        if names:
            self.copy()
            self.document.delete(names)

    def paste(self) -> None:
        """Add the sensors of the clipboard under free names, as one step, and select them.

        Raises InputError when it holds none.
        """
        sensors = pasted(QGuiApplication.clipboard().text())
        names = sensors[0].name if len(sensors) == 1 else f"{len(sensors)} sensors"
        with self.document.group(f"paste {names}"):
            added = tuple(self.document.add(sensor) for sensor in sensors)
        self.document.choose(added)

    def _update(self) -> None:
        for key in ("cut", "copy"):
            self.actions[key].setEnabled(self.document.selected is not None)


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


class Mirror(Feature):
    """Makes, links and unlinks mirror pairs; the document keeps them in step."""

    specs = (
        Spec(
            "mirror", "Mirror", "Add the mirror image of the selected sensor; the two then move together", "M",
            "mirror", "sensor/edit",
        ),
        Spec(
            "link", "Link to mirror image",
            "Make a pair of the selected sensor and the one nearest to its mirror image, which moves there",
            "Ctrl+M", menu="sensor/edit",
        ),
        Spec(
            "unlink", "Unlink from mirror image", "Let the selected sensor and its mirror image move alone",
            "Ctrl+Shift+M", menu="sensor/edit",
        ),
    )  # fmt: skip

    def __init__(self, bench: Workbench) -> None:
        super().__init__(bench)
        self.bind(mirror=self.mirror, link=self.link, unlink=self.unlink)
        for changed in (self.document.rig_settled, self.document.selection_changed):
            changed.connect(self._update)
        self._update()

    def mirror(self) -> None:
        """Add the mirror image of the selected sensor, linked to it, and select it."""
        name, rig = self.document.selected, self.document.rig
        if name is not None and partner_of(rig, name) is None:
            image = free_name(frozenset(sensor.name for sensor in rig.sensors), mirrored_name(name))
            self._edit(lambda: with_mirror_image(rig, name, image), f"mirror {name}")
            self.document.select(image)

    def link(self) -> None:
        """Link the selected sensor to the one nearest to its mirror image."""
        name, rig = self.document.selected, self.document.rig
        other = nearest_to_image(rig, name) if name is not None and partner_of(rig, name) is None else None
        if name is not None and other is not None:
            if other in self.document.locked:
                self.bench.report_error(f"{other} is locked; unlock it in the list of sensors to move it")
                return
            self._edit(lambda: linked(rig, name, other), f"link {name} and {other}")

    def unlink(self) -> None:
        """Dissolve the pair of the selected sensor."""
        name, rig = self.document.selected, self.document.rig
        if name is not None:
            self._edit(lambda: unlinked(rig, name), f"unlink {name}")

    def _edit(self, make: Callable[[], Rig], label: str) -> None:
        def edit() -> None:
            try:
                rig = make()
            except ValueError as error:
                raise InputError(str(error)) from error
            self.document.apply(rig, label)

        self.bench.guarded(edit)()

    def _update(self) -> None:
        name, rig, actions = self.document.selected, self.document.rig, self.actions
        partner = partner_of(rig, name) if name is not None else None
        is_alone = name is not None and partner is None
        actions["mirror"].setEnabled(is_alone)
        actions["link"].setEnabled(name is not None and is_alone and nearest_to_image(rig, name) is not None)
        actions["unlink"].setEnabled(partner is not None)
        actions["unlink"].setText(f"Unlink from {partner}" if partner else "Unlink from mirror image")
