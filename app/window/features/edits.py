"""The rig edited by steps: undo and redo, sensors as text on the clipboard, mirror pairs."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from PySide6.QtGui import QGuiApplication

from riglens.app.window.actions import Spec
from riglens.app.window.feature import Feature
from riglens.app.window.features.sensors import NONE_SELECTED, follow_marks, hold_of
from riglens.app.window.workbench import Workbench
from riglens.core.errors import InputError
from riglens.core.rig.edits import (
    free_name,
    linked,
    list_text,
    mirrored_name,
    mirrored_pose,
    nearest_to_image,
    partner_of,
    unlinked,
    with_mirror_image,
)
from riglens.core.rig.model import Sensor
from riglens.core.rig.yaml.file import dumps, loads
from riglens.core.rig.yaml.nodes import MAX_BYTES
from riglens.core.shown_text import visible


class Edits(Feature):
    """Undo and redo, with the name of the step in the menu."""

    specs = (
        Spec("undo", "Undo", "Undo the last change.", "Ctrl+Z", "undo", "edit/history", "history"),
        Spec(
            "redo",
            "Redo",
            "Redo the last undone change.",
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
        """Undo or redo; during a drag both only cancel the drag."""
        if not self.viewport.cancel_drag():
            step()

    def _update(self) -> None:
        for key, label in (("undo", self.document.undo_label), ("redo", self.document.redo_label)):
            action = self.actions[key]
            self.actions.allow(key, "" if label is not None else f"There is nothing to {key}.")
            action.setText(visible(f"{key.capitalize()} {label}") if label else key.capitalize())


UNPAIRED = (
    "Select two sensors of one kind, or one that has another near its mirror image, none of them linked."
)
UNLINKED = "The selected sensors are not linked."
REMEDY = "copy sensors first, or paste sensors as rig YAML"


class Clipboard(Feature):
    """Copy, cut and paste of whole sensors as a rig file of their own."""

    specs = (
        Spec(
            "cut", "Cut", "Copy the selected sensors as text and delete them.", "Ctrl+X", "", "edit/clipboard"
        ),
        Spec(
            "copy",
            "Copy",
            "Copy the selected sensors as text (rig YAML).",
            "Ctrl+C",
            "copy",
            "edit/clipboard",
        ),
        Spec("paste", "Paste", "Add the sensors on the clipboard.", "Ctrl+V", "paste", "edit/clipboard"),
    )

    def __init__(self, bench: Workbench) -> None:
        super().__init__(bench)
        self.bind(cut=bench.guarded(self.cut), copy=self.copy, paste=bench.guarded(self.paste))
        follow_marks(self.document, self._update)

    def copy(self) -> None:
        """Put the selected sensors on the clipboard."""
        rig, names = self.document.rig, self.document.chosen
        if names:
            sensors = tuple(
                sensor if sensor.mirror_of in names else sensor.replace(mirror_of=None)
                for sensor in rig.sensors
                if sensor.name in names
            )
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
        self.document.paste(sensors_in(QGuiApplication.clipboard().text()))

    def _update(self) -> None:
        self.actions.allow("copy", "" if self.document.selected is not None else NONE_SELECTED)
        self.actions.allow("cut", hold_of(self.document))


def sensors_in(text: str) -> tuple[Sensor, ...]:
    """Return the sensors in a text: a rig file, its part from "sensors:" on, or a list of sensors."""
    if not text.strip():
        raise InputError(f"clipboard: no text; {REMEDY}")
    if len(text) > MAX_BYTES:
        raise InputError(f"clipboard: {len(text) / 1e6:.1f} MB of text is too much; {REMEDY}")
    try:
        sensors = loads(_whole(text), "clipboard").rig.sensors
    except InputError as error:
        raise InputError(f"{error}; {REMEDY}") from error
    if not sensors:
        raise InputError(f"clipboard: no sensors in the text; {REMEDY}")
    return sensors


def _whole(text: str) -> str:
    """Return a complete rig file around a part of one."""
    start = text.lstrip("\n\r").lstrip()
    if start.startswith("- "):
        return f"riglens: 1\nname: clipboard\nsensors:\n{text}"
    return f"riglens: 1\nname: clipboard\n{text}" if start.startswith("sensors:") else text


class Mirror(Feature):
    """Makes, links and unlinks mirror pairs; the document keeps them in step."""

    specs = (
        Spec(
            "mirror", "Mirror", "Add the mirror image of each selected sensor; both then move together.", "M",
            "mirror", "sensor/edit",
        ),
        Spec(
            "link", "Link to mirror image",
            "Pair two selected sensors, or one with the sensor nearest to its mirror image, which moves there.",
            "Ctrl+M", "link", "sensor/edit",
        ),
        Spec(
            "unlink", "Unlink from mirror image", "Let the selected sensors move without their mirror images.",
            "Ctrl+Shift+M", menu="sensor/edit",
        ),
    )  # fmt: skip

    def __init__(self, bench: Workbench) -> None:
        super().__init__(bench)
        guarded = bench.guarded
        self.bind(mirror=guarded(self.mirror), link=guarded(self.link), unlink=guarded(self.unlink))
        bench.panels.inspector.unlink_wanted.connect(guarded(self.unlink))
        for changed in (self.document.rig_settled, self.document.selection_changed):
            changed.connect(self._update)
        self._update()

    def mirror(self) -> None:
        """Add the mirror images of the selected sensors that have none, linked to them, and select the images."""
        names, rig, images = self._alone(), self.document.rig, []
        for name in names:
            sensor = rig.sensor(name)
            taken = frozenset(other.name for other in rig.sensors)
            images.append(free_name(taken, mirrored_name(name, sensor.position[1])))
            try:
                rig = with_mirror_image(rig, name, images[-1])
            except ValueError as error:
                self.bench.report_while(str(error), partial(self._is_on_plane, name))
                return
        self.document.apply(rig, f"mirror {list_text(names)}")
        self.document.choose(tuple(images))

    def _is_on_plane(self, name: str) -> bool:
        """Return whether a sensor is selected that is its own mirror image."""
        found = [sensor for sensor in self.document.rig.sensors if sensor.name == name]
        is_chosen = name in self.document.selection
        return is_chosen and any(sensor.pose == mirrored_pose(sensor.pose) for sensor in found)

    def link(self) -> None:
        """Link two selected sensors, or one to the sensor nearest to its mirror image."""
        pair, rig = self._pair(), self.document.rig
        if pair is None:
            return
        name, other = pair
        if {name, other} & self.document.locked:
            raise InputError(f"{other} is locked; unlock it in the list of sensors to move it")
        self.document.apply(linked(rig, name, other), f"link {name} and {other}")

    def unlink(self) -> None:
        """Dissolve the pairs of the selected sensors."""
        names, rig = self.document.chosen, self.document.rig
        for name in names:
            rig = unlinked(rig, name)
        if names:
            self.document.apply(rig, f"unlink {list_text(names)}")

    def _alone(self) -> tuple[str, ...]:
        """Return the selected sensors that belong to no pair."""
        rig = self.document.rig
        return tuple(name for name in self.document.chosen if partner_of(rig, name) is None)

    def _pair(self) -> tuple[str, str] | None:
        """Return the pair that would be linked: first the one that stays where it is."""
        rig, chosen, alone = self.document.rig, self.document.selection, self._alone()
        if len(alone) != len(chosen) or len(chosen) not in (1, 2):
            return None
        if len(chosen) == 2:
            return chosen if rig.sensor(chosen[0]).kind == rig.sensor(chosen[1]).kind else None
        other = nearest_to_image(rig, chosen[0])
        return None if other is None else (chosen[0], other)

    def _update(self) -> None:
        name, rig, actions = self.document.selected, self.document.rig, self.actions
        chosen = self.document.selection
        partner = partner_of(rig, name) if name is not None and len(self.document.selection) == 1 else None
        is_any, is_linked = bool(chosen), len(self._alone()) < len(chosen)
        linked = "The selected sensors are linked to their mirror images." if is_any else NONE_SELECTED
        actions.allow("mirror", "" if self._alone() else linked)
        actions.allow("link", "" if self._pair() is not None else UNPAIRED if is_any else NONE_SELECTED)
        actions.allow("unlink", "" if is_linked else UNLINKED if is_any else NONE_SELECTED)
        actions["unlink"].setText(
            visible(f"Unlink from {partner}") if partner else "Unlink from mirror image"
        )
