"""The one mutable thing behind the window: the rig being edited, what is selected and hidden, and its file.

Gizmo, tree and inspector only follow this document; they never talk to each other, so they always agree.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from PySide6.QtCore import QObject, Signal

from core.errors import InputError
from core.geometry import Pose
from core.rig.edit_names import Edit, describe
from core.rig.history import History
from core.rig.many import duplicated, free_name, list_text, with_enabled, without
from core.rig.mirror import in_step, partner_of
from core.rig.model import MAX_SENSORS, Camera, Lidar, Rig
from core.rig.yaml_file import RigFile, load_rig, new_rig_file

DUPLICATE_OFFSET_M = 0.2
Names = tuple[str, ...]
MERGE_S = 1.0
"""Edits of the same numbers within so long of each other are one undo step: nudges, spin-box steps, the wheel."""


class Document(QObject):
    """A rig with undo, a selection, sets of hidden and locked sensors, and the file it belongs to.

    `revision` grows by one with every change of the rig, previews of a drag included. Mirror pairs stay in step
    whatever is edited. `clock` tells seconds, to see which edits follow closely.
    """

    rig_changed = Signal()
    selection_changed = Signal()
    hidden_changed = Signal()
    locked_changed = Signal()
    file_changed = Signal()
    """The path or the saved state changed; also sent when a document is opened."""

    def __init__(
        self,
        rig: Rig,
        rig_file: RigFile | None = None,
        path: Path | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        super().__init__()
        self.revision = 0
        self._clock = clock
        self._start(rig, rig_file, path)

    def _start(self, rig: Rig, rig_file: RigFile | None, path: Path | None) -> None:
        self._history = History(rig)
        self._rig_file = rig_file or new_rig_file(rig)
        self._dragged: str | None = None
        self._is_grouping = False
        self._last_edit, self._last_edit_s = Edit(""), -MERGE_S
        self.path = path
        self.selected: str | None = None
        self._hidden: frozenset[str] = frozenset()
        self._locked: frozenset[str] = frozenset()

    # ------------------------------------------------------------------ state
    @property
    def rig(self) -> Rig:
        """The rig as it is now, an open drag included."""
        return self._history.rig

    @property
    def saved_rig(self) -> Rig:
        """The rig that was last saved or opened."""
        return self._history.saved

    @property
    def hidden(self) -> frozenset[str]:
        """Names of the sensors that are not drawn; they still count in the scores."""
        return self._hidden & self._names()

    @property
    def locked(self) -> frozenset[str]:
        """Names of the sensors that are guarded against dragging, editing and deleting.

        A lock guards against slips of the hand and says nothing about the rig, so no file holds it.
        """
        return self._locked & self._names()

    @property
    def is_modified(self) -> bool:
        """Whether the rig differs from the saved one."""
        return self._history.is_modified

    @property
    def is_dragging(self) -> bool:
        """Whether a drag is open: started and neither finished nor cancelled."""
        return self._dragged is not None

    @property
    def undo_label(self) -> str | None:
        """What undo would take back, None when there is nothing."""
        return self._history.undo_label

    @property
    def redo_label(self) -> str | None:
        """What redo would do again, None when there is nothing."""
        return self._history.redo_label

    def selected_sensor(self) -> Lidar | Camera | None:
        """The selected sensor, None when nothing is selected."""
        return self.rig.sensor(self.selected) if self.selected is not None else None

    def _names(self) -> frozenset[str]:
        return frozenset(sensor.name for sensor in self.rig.sensors)

    # ------------------------------------------------------------------ files
    def open(self, path: Path) -> None:
        """Load a rig file; InputError leaves the document as it is."""
        rig_file = load_rig(path)
        self.show(rig_file.rig, rig_file, path)

    def show(self, rig: Rig, rig_file: RigFile | None = None, path: Path | None = None) -> None:
        """Exchange everything for another rig, which counts as saved."""
        self._start(rig, rig_file, path)
        self._rig_moved_on()
        self.selection_changed.emit()
        self.hidden_changed.emit()
        self.locked_changed.emit()
        self.file_changed.emit()

    def save(self, path: Path) -> None:
        """Write the rig to a file and take it as the saved state; InputError when that is impossible."""
        self.cancel_drag()
        self._rig_file = self._rig_file.save(path, self.rig)
        self._history.mark_saved()
        self.path = path
        self.file_changed.emit()

    # ------------------------------------------------------------------ selection and visibility
    def select(self, name: str | None) -> None:
        """Select a sensor by name, or nothing."""
        wanted = name if name in self._names() else None
        if wanted != self.selected:
            self.selected = wanted
            self.selection_changed.emit()

    def set_hidden(self, names: Names, hidden: bool) -> None:
        """Draw sensors or not."""
        changed = self._hidden | set(names) if hidden else self._hidden - set(names)
        if changed != self._hidden:
            self._hidden = changed
            self.hidden_changed.emit()

    def set_locked(self, names: Names, locked: bool) -> None:
        """Guard sensors against edits, or let them be edited again."""
        self.cancel_drag()
        changed = self._locked | set(names) if locked else self._locked - set(names)
        if changed != self._locked:
            self._locked = changed
            self.locked_changed.emit()

    def _refuse_locked(self, names: Names) -> None:
        """InputError when one of these sensors, or the mirror image of one, is locked."""
        meant = {*names, *(partner_of(self.rig, name) for name in names)}
        found = [sensor.name for sensor in self.rig.sensors if sensor.name in self.locked & meant]
        if found:
            raise InputError(f"{list_text(found)}: locked; unlock it in the list of sensors first")

    # ------------------------------------------------------------------ edits, one undo step each
    def apply(self, rig: Rig, label: str = "") -> None:
        """Make `rig` the current one, as one undo step; nothing happens when it says the same.

        `label` is for the Edit menu, in lower case; without one it says what changed. Repeated edits of the same
        numbers become one step.
        """
        self.cancel_drag()
        rig = in_step(self.rig, rig)
        if self._is_grouping:
            self._history.preview(rig)
            return
        edit = describe(self.rig, rig)
        now_s = self._clock()
        continues = edit.continues(self._last_edit) and now_s - self._last_edit_s <= MERGE_S
        self._last_edit, self._last_edit_s = edit, now_s
        if self._history.apply(label or edit.label, rig, continues):
            self._rig_moved_on()

    @contextmanager
    def group(self, label: str) -> Iterator[None]:
        """Make all edits inside one undo step, such as "align 3 sensors"; others hear of the rig at the end.

        An exception takes all of them back and goes on. A group inside a group is part of the outer one.
        """
        if self._is_grouping:
            yield
            return
        self.cancel_drag()
        self._history.begin(label)
        self._is_grouping = True
        end = self._history.cancel
        try:
            yield
            end = self._history.commit
        finally:
            self._is_grouping = False
            self._last_edit = Edit("")
            end()
            self._keep_selection_real()
            self._rig_moved_on()

    def _keep_selection_real(self) -> None:
        if self.selected not in self._names():
            self.select(None)

    def replace_sensor(self, name: str, sensor: Lidar | Camera) -> None:
        """Exchange one sensor; a new name takes selection and visibility along, InputError when taken."""
        self.cancel_drag()
        self._refuse_locked((name,))
        if sensor.name != name and sensor.name in self._names():
            raise InputError(f"name: '{sensor.name}' is used by another sensor; names must be unique")
        was_selected = self.selected == name
        if sensor.name != name and name in self._hidden:
            self._hidden = (self._hidden - {name}) | {sensor.name}
        if was_selected:
            self.selected = sensor.name
        self.apply(self.rig.with_sensor(name, sensor))
        if was_selected and sensor.name != name:
            self.selection_changed.emit()

    def rename(self, name: str, new_name: str) -> None:
        """Give a sensor another name; InputError when it is empty or taken."""
        if not new_name.strip():
            raise InputError("name: found nothing, accepted is any text that no other sensor uses")
        self.replace_sensor(name, self.rig.sensor(name).replace(name=new_name.strip()))

    def set_enabled(self, names: Names, enabled: bool) -> None:
        """Count sensors in the scores or not."""
        self._refuse_locked(names)
        word = "enable" if enabled else "disable"
        self.apply(with_enabled(self.rig, names, enabled), f"{word} {list_text(names)}")

    def add(self, sensor: Lidar | Camera) -> str:
        """Append a sensor under a free name and select it; returns the name."""
        self.cancel_drag()
        if len(self.rig.sensors) >= MAX_SENSORS:
            raise InputError(f"sensors: a rig holds at most {MAX_SENSORS}; delete one first")
        name = free_name(self._names(), sensor.name)
        alone = sensor.replace(name=name, mirror_of=None)
        self.apply(self.rig.replace(sensors=(*self.rig.sensors, alone)), f"add {name}")
        self.select(name)
        return name

    def duplicate(self, names: Names) -> Names:
        """Add copies of sensors a little to their left and select the last; returns the copies' names."""
        self.cancel_drag()
        rig, copies = duplicated(self.rig, names, DUPLICATE_OFFSET_M)
        self.apply(rig, f"duplicate {list_text(names)}")
        self.select(copies[-1])
        return copies

    def delete(self, names: Names) -> None:
        """Remove sensors."""
        self.cancel_drag()
        self._refuse_locked(names)
        if self.selected in names:
            self.select(None)
        self.apply(without(self.rig, names), f"delete {list_text(names)}")

    # ------------------------------------------------------------------ drags: many previews, one undo step
    def begin_drag(self, name: str) -> None:
        """Open a drag of one sensor; a locked one stays where it is."""
        self.cancel_drag()
        if name in self._names() and not {name, partner_of(self.rig, name)} & self.locked:
            self._history.begin(f"move {name}")
            self._dragged = name

    def preview(self, name: str, pose: Pose) -> None:
        """Move the dragged sensor; ignored when it is not the one being dragged."""
        if self._dragged == name:
            moved = self.rig.with_sensor(name, self.rig.sensor(name).with_pose(pose))
            self._history.preview(in_step(self.rig, moved))
            self._rig_moved_on()

    def finish_drag(self) -> None:
        """Keep where the drag ended, as one undo step."""
        self._end_drag(self._history.commit)

    def cancel_drag(self) -> None:
        """Go back to where the drag began, if one is open."""
        self._end_drag(self._history.cancel)

    def _end_drag(self, end: Callable[[], bool]) -> None:
        if self._dragged is not None:
            self._dragged, self._last_edit = None, Edit("")
            end()
            self._rig_moved_on()

    # ------------------------------------------------------------------ undo
    def undo(self) -> None:
        """Take back one step; during a drag, only the drag."""
        self._travel(self._history.undo)

    def redo(self) -> None:
        """Do the step again that was taken back last."""
        self._travel(self._history.redo)

    def _travel(self, step: Callable[[], bool]) -> None:
        if self.is_dragging:
            self.cancel_drag()
            return
        self._last_edit = Edit("")
        before = self.selected
        place = self._place_of_selection()
        step()
        self.selected = self._selection_after(place)
        self._rig_moved_on()
        if self.selected != before:
            self.selection_changed.emit()

    def _place_of_selection(self) -> int:
        """Index of the selected sensor; one past the end when nothing is selected."""
        names = [sensor.name for sensor in self.rig.sensors]
        return names.index(self.selected) if self.selected in names else len(names)

    def _selection_after(self, place: int) -> str | None:
        """What stays selected after a step: the same name, or the sensor that was only renamed."""
        if self.selected is None or self.selected in self._names():
            return self.selected
        return self.rig.sensors[place].name if place < len(self.rig.sensors) else None

    def _rig_moved_on(self) -> None:
        """Count the revision and tell everybody; the selection is one that exists in the rig by now."""
        self.revision += 1
        self.rig_changed.emit()
