"""Hold the rig that is open in the window: history, file, selection, hidden, locked and failed sensors, the drag.

`Document` in document.py adds the edits.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import NamedTuple

from PySide6.QtCore import QObject, Signal

from riglens.core.errors import InputError
from riglens.core.geometry import Pose
from riglens.core.rig.edits import list_text, partner_of, with_enabled
from riglens.core.rig.groups import posed
from riglens.core.rig.history import Edit, History, Marks
from riglens.core.rig.model import Rig, Sensor, Vehicle
from riglens.core.rig.yaml.file import RigFile, load_rig, new_rig_file

Names = tuple[str, ...]


class _Emitted(NamedTuple):
    """Parts of the rig that were emitted last."""

    vehicle: Vehicle
    is_modified: bool
    steps: tuple[str | None, str | None]


class OpenRig(QObject):
    """A rig with undo, a selection, sets of hidden, locked and failed sensors, and the file it belongs to.

    There is one selection: what list and view show as selected, and what every action on "the selected sensors"
    works on. One of the selected sensors is the current one, which has the gizmo and the inspector.

    `revision` grows by one with every change of the rig, previews of a drag included. Mirror pairs stay in step
    whatever is dragged or edited.
    """

    opened = Signal()
    """Everything was exchanged for another rig; sent before the other signals of this."""
    rig_changed = Signal()
    """The rig changed: also emitted for every preview of a drag. Parts of it have signals of their own, emitted after
    this one."""
    rig_settled = Signal()
    """The rig changed and no drag is open, or a drag ended."""
    vehicle_changed = Signal()
    modified_changed = Signal()
    """The rig began or ceased to differ from the saved one."""
    steps_changed = Signal()
    """The labels of undo and redo changed."""
    selection_changed = Signal()
    hidden_changed = Signal()
    locked_changed = Signal()
    failed_changed = Signal()
    """The failed sensors changed, and with them `working_rig`."""
    file_changed = Signal()
    """The path or the saved state changed; also sent when a document is opened."""

    def __init__(self, rig: Rig, rig_file: RigFile | None = None, path: Path | None = None) -> None:
        super().__init__()
        self.revision = 0
        self._start(rig, rig_file, path)
        self._emitted = self._parts()

    def _start(self, rig: Rig, rig_file: RigFile | None, path: Path | None) -> None:
        self._history = History(rig)
        self._rig_file = rig_file or new_rig_file(rig)
        self._dragged: Names = ()
        self._last_edit = Edit("")
        self.path: Path | None = path
        self._selection: Names = ()
        self._failed: frozenset[str] = frozenset()
        self._working = rig, self._failed, rig

    # ------------------------------------------------------------------ state
    @property
    def rig(self) -> Rig:
        """Return the current rig, including an open drag."""
        return self._history.rig

    @property
    def folder(self) -> Path | None:
        """Folder of the rig's file; None for a rig that was never saved."""
        return None if self.path is None else self.path.parent

    @property
    def saved_rig(self) -> Rig:
        """The rig that was last saved or opened."""
        return self._history.saved

    @property
    def hidden(self) -> frozenset[str]:
        """Names of the sensors that are not drawn; they still count in the scores."""
        return self._history.marks.hidden & self._names()

    @property
    def locked(self) -> frozenset[str]:
        """Return the names of the sensors that are protected from dragging, editing and deleting.

        A lock guards against slips of the hand and says nothing about the rig, so no file holds it.
        """
        return self._history.marks.locked & self._names()

    @property
    def fixed(self) -> frozenset[str]:
        """Return the names of the sensors that cannot be moved: locked ones, and those whose mirror image is locked."""
        rig, locked = self.rig, self.locked
        if not locked:
            return locked
        return frozenset(
            one.name for one in rig.sensors if one.name in locked or partner_of(rig, one.name) in locked
        )

    @property
    def is_free(self) -> bool:
        """Return whether sensors are selected of which none is fixed: they may be moved, edited and deleted."""
        return bool(self.chosen) and not self.fixed.intersection(self.chosen)

    @property
    def failed(self) -> frozenset[str]:
        """Names of the sensors that are taken as failed: a question to the rig and no part of it, so neither
        undone nor saved."""
        return self._failed

    @property
    def working_rig(self) -> Rig:
        """Return the rig without failed sensors: the one that scores, maps and targets refer to."""
        rig, failed, working = self._working
        if rig is not self.rig or failed != self._failed:
            working = with_enabled(self.rig, self._failed, False) if self._failed else self.rig
            self._working = self.rig, self._failed, working
        return working

    @property
    def is_modified(self) -> bool:
        """Return whether the rig differs from the saved one."""
        return self._history.is_modified

    @property
    def is_dragging(self) -> bool:
        """Return whether a drag is open: started and neither finished nor cancelled."""
        return bool(self._dragged)

    @property
    def undo_label(self) -> str | None:
        """Return the label of the step that undo would revert, None if there is none."""
        return self._history.undo_label

    @property
    def redo_label(self) -> str | None:
        """Return the label of the step that redo would repeat, None if there is none."""
        return self._history.redo_label

    @property
    def selection(self) -> Names:
        """Names of the selected sensors in the order in which they were selected; the last is the current one."""
        return self._selection

    @property
    def chosen(self) -> Names:
        """Names of the selected sensors in the order of the rig: what actions on several sensors work on."""
        return tuple(sensor.name for sensor in self.rig.sensors if sensor.name in self._selection)

    @property
    def selected(self) -> str | None:
        """Name of the current sensor, which gizmo and inspector edit; None when nothing is selected."""
        return self._selection[-1] if self._selection else None

    def selected_sensor(self) -> Sensor | None:
        """Return the current sensor, None when nothing is selected."""
        return self.rig.sensor(self.selected) if self.selected is not None else None

    def _names(self) -> frozenset[str]:
        return frozenset(sensor.name for sensor in self.rig.sensors)

    # ------------------------------------------------------------------ files
    def open(self, path: Path) -> None:
        """Load a rig file; InputError leaves the document unchanged."""
        rig_file = load_rig(path)
        self.show(rig_file.rig, rig_file, path)

    def show(self, rig: Rig, rig_file: RigFile | None = None, path: Path | None = None) -> None:
        """Replace the rig by another one, which counts as saved."""
        self._start(rig, rig_file, path)
        self.opened.emit()
        self._rig_moved_on()
        self.selection_changed.emit()
        self.hidden_changed.emit()
        self.locked_changed.emit()
        self.failed_changed.emit()
        self.file_changed.emit()

    def save(self, path: Path) -> None:
        """Write the rig to a file and take it as the saved state; InputError when that is impossible."""
        self.cancel_drag()
        self._rig_file = self._rig_file.save(path, self.rig)
        self._history.mark_saved()
        self.path = path
        self.file_changed.emit()
        self._emit_parts()

    # ------------------------------------------------------------------ selection and visibility
    def select(self, name: str | None) -> None:
        """Select one sensor and no other, or nothing."""
        self.choose(() if name is None else (name,))

    def choose(self, names: Names) -> None:
        """Select these sensors and no others; the last is the current one. Unknown names are left out."""
        known = self._names()
        wanted = tuple(name for name in dict.fromkeys(names) if name in known)
        if wanted != self._selection:
            self._selection = wanted
            self.selection_changed.emit()

    def choose_all(self) -> None:
        """Select every sensor; the current one stays current."""
        others = tuple(sensor.name for sensor in self.rig.sensors if sensor.name != self.selected)
        self.choose((*others, self.selected) if self.selected is not None else others)

    def choose_more(self, names: Names) -> None:
        """Select these sensors, too; the last of them becomes the current one."""
        self.choose((*(name for name in self._selection if name not in names), *names))

    def choose_fewer(self, names: Names) -> None:
        """Take sensors out of the selection."""
        self.choose(tuple(name for name in self._selection if name not in names))

    def toggle_selected(self, name: str) -> None:
        """Select one more sensor, which becomes the current one, or take it out of the selection."""
        rest = tuple(other for other in self._selection if other != name)
        self.choose(rest if name in self._selection else (*rest, name))

    def set_hidden(self, names: Names, hidden: bool) -> None:
        """Draw sensors or not, as one undo step."""
        changed = self.hidden | set(names) if hidden else self.hidden - set(names)
        if self._mark(f"{'hide' if hidden else 'show'} {list_text(names)}", Marks(changed, self.locked)):
            self.hidden_changed.emit()

    def set_locked(self, names: Names, locked: bool) -> None:
        """Guard sensors against edits, or let them be edited again, as one undo step."""
        changed = self.locked | set(names) if locked else self.locked - set(names)
        if self._mark(f"{'lock' if locked else 'unlock'} {list_text(names)}", Marks(self.hidden, changed)):
            self.locked_changed.emit()

    def keep_locked(self, names: Names) -> None:
        """Lock the sensors that were locked when this file was last open; this is no undo step."""
        self._history.begin_with(Marks(self.hidden, frozenset(names)))
        self.locked_changed.emit()

    def set_failed(self, names: Names, failed: bool) -> None:
        """Mark sensors as failed or as working; the rig is unchanged. Unknown names are ignored."""
        wanted = self._failed | set(names) if failed else self._failed - set(names)
        if (failed_now := wanted & self._names()) != self._failed:
            self._failed = failed_now
            self.failed_changed.emit()

    def _mark(self, label: str, marks: Marks) -> bool:
        """Hide or lock others than before; False when nothing changes."""
        self.cancel_drag()
        self._last_edit = Edit("")
        is_other = self._history.apply(label, self.rig, marks=marks)
        self._emit_parts()
        return is_other

    def _refuse_locked(self, names: Names) -> None:
        """Raise InputError when one of these sensors, or the mirror image of one, is locked."""
        meant = {*names, *(partner_of(self.rig, name) for name in names)}
        found = [sensor.name for sensor in self.rig.sensors if sensor.name in self.locked & meant]
        if found:
            raise InputError(f"{list_text(found)}: locked; unlock it in the list of sensors first")

    # ------------------------------------------------------------------ drags: many previews, one undo step
    def begin_drag(self, names: Names) -> None:
        """Open a drag of sensors; when one of them is locked all stay where they are."""
        self.cancel_drag()
        if names and set(names) <= self._names() - self.fixed:
            self._history.begin(f"move {list_text(names)}")
            self._dragged = names

    def preview(self, poses: Mapping[str, Pose]) -> None:
        """Move the dragged sensors; ignored when these are not the ones being dragged."""
        if self._dragged and poses.keys() == set(self._dragged):
            self._history.preview(posed(self.rig, poses))
            self._rig_moved_on()

    def finish_drag(self) -> None:
        """Keep where the drag ended, as one undo step."""
        self._end_drag(self._history.commit)

    def cancel_drag(self) -> None:
        """Go back to where the drag began, if one is open."""
        self._end_drag(self._history.cancel)

    def _end_drag(self, end: Callable[[], bool]) -> None:
        if self._dragged:
            self._dragged, self._last_edit = (), Edit("")
            end()
            self._rig_moved_on()

    def _rig_moved_on(self) -> None:
        """Count the revision and emit the changes; the selection already exists in the rig."""
        self.revision += 1
        failed, self._failed = self._failed, self._failed & self._names()
        self.rig_changed.emit()
        if failed != self._failed:
            self.failed_changed.emit()
        self._emit_parts()
        if not self.is_dragging:
            self.rig_settled.emit()

    def _parts(self) -> _Emitted:
        return _Emitted(self.rig.vehicle, self.is_modified, (self.undo_label, self.redo_label))

    def _emit_parts(self) -> None:
        """Emit the parts that differ from those emitted last."""
        before, now = self._emitted, self._parts()
        self._emitted = now
        changes = (
            (before.vehicle is not now.vehicle and before.vehicle != now.vehicle, self.vehicle_changed),
            (before.is_modified != now.is_modified, self.modified_changed),
            (before.steps != now.steps, self.steps_changed),
        )  # fmt: skip
        for is_other, changed in changes:
            if is_other:
                changed.emit()
