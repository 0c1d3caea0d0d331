"""Document of the window: the rig being edited, the selection, hidden sensors, and its file.

Gizmo, tree and inspector only follow this document; they never talk to each other, so they always agree.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path

from riglens.app.session.open_rig import Names, OpenRig
from riglens.core.errors import InputError
from riglens.core.geometry import Pose
from riglens.core.rig.edits import (
    duplicated,
    free_name,
    in_step,
    list_text,
    pasted,
    with_enabled,
    without,
)
from riglens.core.rig.groups import Alignment, aligned, spaced
from riglens.core.rig.history import Edit, Marks, describe
from riglens.core.rig.model import MAX_SENSORS, Rig, Sensor
from riglens.core.rig.yaml.file import RigFile

DUPLICATE_OFFSET_M = 0.2
MERGE_S = 1.0
"""Edits of the same numbers within so long of each other are one undo step: nudges, spin-box steps, the wheel."""


class Document(OpenRig):
    """Open rig with every edit as one undo step.

    `clock` returns seconds, to merge edits in quick succession.
    """

    def __init__(
        self,
        rig: Rig,
        rig_file: RigFile | None = None,
        path: Path | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        super().__init__(rig, rig_file, path)
        self._clock = clock
        self._last_edit_s = -MERGE_S

    # ------------------------------------------------------------------ edits, one undo step each
    def apply(self, rig: Rig, label: str = "", marks: Marks | None = None) -> None:
        """Make `rig` the current one, as one undo step; nothing happens when it is equal.

        `label` is for the Edit menu, in lower case; without one it says what changed. Repeated edits of the same
        numbers become one step. `marks` are what is hidden and locked from then on, None for no change.
        """
        self.cancel_drag()
        rig = in_step(self.rig, rig)
        edit = describe(self.rig, rig)
        now_s = self._clock()
        continues = edit.continues(self._last_edit) and now_s - self._last_edit_s <= MERGE_S
        self._last_edit, self._last_edit_s = edit, now_s
        if self._history.apply(label or edit.label, rig, continues, marks):
            before, known = self._selection, self._names()
            self._selection = tuple(name for name in before if name in known)
            self._rig_moved_on()
            if self._selection != before:
                self.selection_changed.emit()

    def replace_sensor(self, name: str, sensor: Sensor) -> None:
        """Replace one sensor; selection and visibility follow a new name, InputError when it is taken."""
        self.cancel_drag()
        self._refuse_locked((name,))
        if sensor.name != name and sensor.name in self._names():
            raise InputError(f"name: '{sensor.name}' is used by another sensor; names must be unique")
        before = self._selection
        self._selection = tuple(sensor.name if other == name else other for other in before)
        failed = self._failed
        self._failed = frozenset(sensor.name if other == name else other for other in failed)
        self.apply(self.rig.with_sensor(name, sensor), marks=self._marks_with(name, sensor.name))
        if self._selection != before:
            self.selection_changed.emit()
        if self._failed != failed:
            self.failed_changed.emit()

    def _marks_with(self, name: str, new_name: str) -> Marks:
        """Return the hidden and locked sensors after a sensor is renamed."""
        hidden = self.hidden - {name} | {new_name} if name in self.hidden else self.hidden
        return Marks(hidden, self.locked)

    def replace_sensors(self, changes: Mapping[str, Sensor]) -> None:
        """Replace sensors as one step, InputError when one of them is locked; a single one may get a new name."""
        if len(changes) == 1:
            self.replace_sensor(*next(iter(changes.items())))
            return
        self.cancel_drag()
        self._refuse_locked(tuple(changes))
        sensors = tuple(changes.get(sensor.name, sensor) for sensor in self.rig.sensors)
        self.apply(self.rig.model_copy(update={"sensors": sensors}))

    def move(self, poses: Mapping[str, Pose]) -> None:
        """Set poses of sensors; InputError when one of them is locked."""
        self.replace_sensors({name: self.rig.sensor(name).with_pose(pose) for name, pose in poses.items()})

    def align(self, names: Names, how: Alignment) -> None:
        """Align sensors; InputError when one of them is locked, or a mirror pair prevents it."""
        self._refuse_locked(names)
        current = self.selected if self.selected in names else names[-1]
        self.apply(aligned(self.rig, names, how, str(current)), f"align {list_text(names)}")

    def space(self, names: Names) -> None:
        """Space sensors evenly; InputError when they are too few, one is locked, or a mirror pair prevents it."""
        self._refuse_locked(names)
        self.apply(spaced(self.rig, names), f"space {list_text(names)}")

    def rename(self, name: str, new_name: str) -> None:
        """Rename a sensor; InputError when the name is empty or taken."""
        if not new_name.strip():
            raise InputError("name must not be empty")
        self.replace_sensor(name, self.rig.sensor(name).replace(name=new_name.strip()))

    def set_enabled(self, names: Names, enabled: bool) -> None:
        """Count sensors in the scores or not."""
        self._refuse_locked(names)
        word = "enable" if enabled else "disable"
        self.apply(with_enabled(self.rig, names, enabled), f"{word} {list_text(names)}")

    def add(self, sensor: Sensor) -> str:
        """Append a sensor under a free name and select it; returns the name."""
        self.cancel_drag()
        if len(self.rig.sensors) >= MAX_SENSORS:
            raise InputError(f"sensors: at most {MAX_SENSORS} in a rig; delete one first")
        name = free_name(self._names(), sensor.name)
        alone = sensor.replace(name=name, mirror_of=None)
        self.apply(self.rig.replace(sensors=(*self.rig.sensors, alone)), f"add {name}")
        self.select(name)
        return name

    def duplicate(self, names: Names) -> Names:
        """Add copies of sensors next to them, of mirror pairs in place, and select those; return the copies' names."""
        self.cancel_drag()
        rig, copies = duplicated(self.rig, names, DUPLICATE_OFFSET_M)
        self.apply(rig, f"duplicate {list_text(names)}")
        self.choose(copies)
        return copies

    def paste(self, sensors: Sequence[Sensor]) -> None:
        """Add foreign sensors under free names and select them; offset where others already are."""
        self.cancel_drag()
        rig, names = pasted(self.rig, sensors, DUPLICATE_OFFSET_M)
        self.apply(rig, f"paste {list_text([sensor.name for sensor in sensors])}")
        self.choose(names)

    def delete(self, names: Names) -> None:
        """Remove sensors."""
        self.cancel_drag()
        self._refuse_locked(names)
        self.choose(tuple(name for name in self._selection if name not in names))
        self.apply(without(self.rig, names), f"delete {list_text(names)}")

    # ------------------------------------------------------------------ undo
    def undo(self) -> None:
        """Undo one step; during a drag, only the drag."""
        self._travel(self._history.undo)

    def redo(self) -> None:
        """Do the step again that was taken back last."""
        self._travel(self._history.redo)

    def _travel(self, step: Callable[[], bool]) -> None:
        if self.is_dragging:
            self.cancel_drag()
            return
        self._last_edit = Edit("")
        before, hidden, locked = self._selection, self.hidden, self.locked
        names = [sensor.name for sensor in self.rig.sensors]
        step()
        self._selection = self._selection_after(names)
        failed, self._failed = self._failed, frozenset(self._kept(names, self._failed))
        self._rig_moved_on()
        changes = (
            (failed, self._failed, self.failed_changed),
            (before, self._selection, self.selection_changed),
            (hidden, self.hidden, self.hidden_changed),
            (locked, self.locked, self.locked_changed),
        )
        for old, new, changed in changes:
            if old != new:
                changed.emit()

    def _selection_after(self, old: list[str]) -> Names:
        """Return the selection after a step from a rig of these sensors: the same ones, renamed or not.

        When nothing is left of the selection, what the step brought back is selected.
        """
        now = [sensor.name for sensor in self.rig.sensors]
        found = self._kept(old, self._selection)
        return found or tuple(name for name in now if name not in old and len(now) > len(old))

    def _kept(self, old: list[str], names: Iterable[str]) -> Names:
        """Return the current names of those sensors that are left after a step; `old` are all names before it."""
        now = [sensor.name for sensor in self.rig.sensors]
        renamed = dict(zip(old, now, strict=True)) if len(old) == len(now) else {}
        kept = (name if name in now else renamed.get(name) for name in names)
        return tuple(name for name in dict.fromkeys(kept) if name is not None)
