"""Undo and redo of rigs: every edit is one step, so is a whole drag, and so is hiding or locking a sensor."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from riglens.core.rig.model import Rig, Sensor
from riglens.core.rig.yaml.file import same_rig
from riglens.core.rig.yaml.nodes import Plain
from riglens.core.rig.yaml.text import plain, plain_fields, same_value

Place = tuple[str | int, ...]
_VERBS = {"position": "move", "rpy_deg": "turn", "name": "rename", "mirror_of": "pair"}


@dataclass(frozen=True)
class Edit:
    """`label` in lower case, such as "move roof"; `numbers` are the places of the numbers that changed.

    Without numbers the edit changed something else too, and never continues another.
    """

    label: str
    numbers: frozenset[Place] = frozenset()

    def continues(self, other: Edit) -> bool:
        """Return whether both changed the very same numbers, as repeated nudges do."""
        return bool(self.numbers) and self.numbers == other.numbers


def describe(before: Rig, after: Rig) -> Edit:
    """Name what leads from one rig to the other."""
    changes = list(_changes((), plain_fields(before), plain_fields(after)))
    is_numeric = all(_is_number(old) and _is_number(new) for _, old, new in changes)
    numbers = frozenset(place for place, _, _ in changes) if is_numeric else frozenset()
    return Edit(_label(before, after, [place for place, _, _ in changes]), numbers)


def differences_in_words(before: Rig, after: Rig) -> tuple[str, ...]:
    """Return what differs between two rigs, sensor by sensor by their names, in words."""
    old, new = ({one.name: one for one in rig.sensors} for rig in (before, after))
    both = [
        (old[name], one)
        for name, one in new.items()
        if name in old and not same_value(*map(plain, (old[name], one)))
    ]
    every = [
        *(f"{name} removed" for name in old if name not in new),
        *(f"{name} added" for name in new if name not in old),
        *(f"{after.name} {' and '.join(_edits(before, after))}" for before, after in both),
    ]
    places = {place[0] for place, _, _ in _changes((), plain_fields(before), plain_fields(after))}
    others = sorted(str(place) for place in places - {"sensors", "name"})
    return (*every, *(f"{place.replace('_', ' ')} changed" for place in others))


def _edits(before: Sensor, after: Sensor) -> Iterator[str]:
    """Yield what differs between two sensors of one name."""
    changed = {str(place[0]) for place, _, _ in _changes((), plain_fields(before), plain_fields(after))}
    if "kind" in changed or "model" in changed:
        yield f"is {after.model or after.kind} instead of {before.model or before.kind}"
        changed &= {"position", "rpy_deg"}
    if "position" in changed:
        x, y, z = (b - a for a, b in zip(before.position, after.position, strict=True))
        ways = [(x, "ahead", "back"), (y, "left", "right"), (z, "higher", "lower")]
        parts = [
            f"{abs(way):.2f} m {more if way > 0 else less}" for way, more, less in ways if abs(way) >= 0.005
        ]
        yield " ".join(["moved", ", ".join(parts) or "by less than 0.01 m"])
    if "rpy_deg" in changed:
        names = zip(("roll", "pitch", "yaw"), before.rpy_deg, after.rpy_deg, strict=True)
        yield "turned: " + ", ".join(f"{name} {b - a:+.1f}°" for name, a, b in names if a != b).replace(
            "-", "−"
        )
    if "enabled" in changed:
        yield "switched on" if after.enabled else "switched off"
    rest = sorted(changed - {"position", "rpy_deg", "enabled"})
    if rest:
        yield f"edited: {', '.join(rest)}"


def _changes(place: Place, old: Plain, new: Plain) -> Iterator[tuple[Place, Plain, Plain]]:
    """Yield place, old and new value of every leaf that differs; lists of different lengths are one leaf."""
    if same_value(old, new):
        return
    if isinstance(old, dict) and isinstance(new, dict) and old.keys() == new.keys():
        for key in old:
            yield from _changes((*place, key), old[key], new[key])
    elif isinstance(old, tuple) and isinstance(new, tuple) and len(old) == len(new):
        for index, pair in enumerate(zip(old, new, strict=True)):
            yield from _changes((*place, index), *pair)
    else:
        yield place, old, new


def _is_number(value: object) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _label(before: Rig, after: Rig, places: list[Place]) -> str:
    if {place[0] for place in places} == {"vehicle"}:
        return "edit the car"
    if places == [("self_occlusion",)]:
        return "make the car solid" if after.self_occlusion else "let rays through the car"
    if places == [("housings",)]:
        return "make housings solid" if after.housings == "blocks" else "let rays through housings"
    if places == [("name",)]:
        return "rename the rig"
    indices = sorted({int(place[1]) for place in places if place[0] == "sensors" and len(place) > 1})
    if not indices or len({place[0] for place in places}) > 1:
        return "edit the rig"
    fields = tuple(sorted({str(place[2]) for place in places if len(place) > 2}))
    names = [before.sensors[index].name for index in indices]
    return f"{_verb(fields, after, indices)} {' and '.join(names) if len(names) < 3 else f'{len(names)} sensors'}"


def _verb(fields: tuple[str, ...], after: Rig, indices: list[int]) -> str:
    if fields == ("enabled",):
        return "switch on" if after.sensors[indices[0]].enabled else "switch off"
    if fields == ("position", "rpy_deg"):
        return "move"
    return _VERBS.get(fields[0], "edit") if len(fields) == 1 else "edit"


@dataclass(frozen=True)
class Marks:
    """Names of the sensors that are not drawn, and of those that are guarded against edits.

    They are not part of a rig or its file, but can be undone like edits of it.
    """

    hidden: frozenset[str] = frozenset()
    locked: frozenset[str] = frozenset()


@dataclass(frozen=True)
class _Step:
    """A rig with its marks, and the edit that led to it."""

    label: str
    rig: Rig
    marks: Marks = Marks()


class History:
    """The rigs of a session in the order of the edits, the current place among them, and which one is on the disk.

    A drag, and a group of edits likewise, is `begin`, any number of `preview`, then `commit` or `cancel`;
    previews change `rig` but not the stack. Rigs are immutable, so steps share their sensors and cost almost
    nothing.
    """

    def __init__(self, rig: Rig) -> None:
        self._steps = [_Step("", rig)]
        self._index = 0
        self._saved = rig
        self._open_label: str | None = None
        self._previewed: Rig | None = None

    @property
    def rig(self) -> Rig:
        """The rig to show now: the preview of an open drag, else the last committed one."""
        return self.committed if self._previewed is None else self._previewed

    @property
    def committed(self) -> Rig:
        """The rig of the current step, without an open drag."""
        return self._steps[self._index].rig

    @property
    def marks(self) -> Marks:
        """Return the hidden and locked sensors of the current step, possibly including names that no longer exist."""
        return self._steps[self._index].marks

    @property
    def saved(self) -> Rig:
        """The rig that was last saved or opened."""
        return self._saved

    @property
    def is_dragging(self) -> bool:
        """Return whether a drag is open."""
        return self._open_label is not None

    @property
    def is_modified(self) -> bool:
        """Return whether the rig shown differs from the saved one; editing it back makes it unmodified again."""
        return self.rig is not self._saved and not same_rig(self.rig, self._saved)

    def begin(self, label: str) -> None:
        """Open a drag; one that is still open is committed first."""
        self.commit()
        self._open_label = label

    def preview(self, rig: Rig) -> None:
        """Show a rig during the open drag; raise RuntimeError when none is open."""
        if self._open_label is None:
            raise RuntimeError("preview without begin")
        self._previewed = rig

    def commit(self) -> bool:
        """Close the open drag as one step; return False when there was none or when nothing moved."""
        label, rig = self._open_label, self._previewed
        self.cancel()
        return label is not None and rig is not None and self._push(label, rig)

    def cancel(self) -> bool:
        """Close the open drag and go back to the rig before it; return False when there was none."""
        was_open = self.is_dragging
        self._open_label = self._previewed = None
        return was_open

    def apply(self, label: str, rig: Rig, continues: bool = False, marks: Marks | None = None) -> bool:
        """Make one edit one step, committing an open drag first; return False when rig and marks stay the same.

        With `continues` it becomes part of the previous step, unless that one is on the disk or was undone.
        Without `marks` those of the previous step stay.
        """
        self.commit()
        if continues and self._can_continue():
            return self._extend(rig)
        return self._push(label, rig, marks)

    def begin_with(self, marks: Marks) -> None:
        """Take these marks as those of the current step; this cannot be undone."""
        self._steps[self._index] = replace(self._steps[self._index], marks=marks)

    def _can_continue(self) -> bool:
        is_last = self._index == len(self._steps) - 1
        return self._index > 0 and is_last and self.committed is not self._saved

    def _extend(self, rig: Rig) -> bool:
        """Replace the result of the current step; drop the step if it no longer changes the rig."""
        if same_rig(rig, self.committed):
            return False
        last = self._steps.pop()
        self._index -= 1
        self._push(last.label, rig, last.marks)
        return True

    def undo(self) -> bool:
        """Go one step back, or cancel an open drag; return False when there is nothing to undo."""
        if self.cancel():
            return True
        if self._index == 0:
            return False
        self._index -= 1
        return True

    def redo(self) -> bool:
        """Go one step forward, or cancel an open drag; return False when there is nothing to redo."""
        if self.cancel():
            return True
        if self._index == len(self._steps) - 1:
            return False
        self._index += 1
        return True

    @property
    def undo_label(self) -> str | None:
        """The edit that `undo` would revert, None when there is none."""
        if self._open_label is not None:
            return self._open_label
        return self._steps[self._index].label if self._index > 0 else None

    @property
    def redo_label(self) -> str | None:
        """The edit that `redo` would repeat, None when there is none."""
        is_last = self._index == len(self._steps) - 1
        return None if self.is_dragging or is_last else self._steps[self._index + 1].label

    def mark_saved(self) -> None:
        """Note that the rig of the current step is now on the disk."""
        self._saved = self.committed

    def _push(self, label: str, rig: Rig, marks: Marks | None = None) -> bool:
        marks = marks or self.marks
        if same_rig(rig, self.committed) and marks == self.marks:
            return False
        del self._steps[self._index + 1 :]
        self._steps.append(_Step(label, rig, marks))
        self._index += 1
        return True
