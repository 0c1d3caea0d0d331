"""What an edit of a rig changed: its name for the Edit menu, and whether it goes on with the edit before it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from riglens.core.rig.model import Rig
from riglens.core.rig.yaml_text import plain_fields, same_value

Place = tuple[str | int, ...]
_VERBS = {"position": "move", "rpy_deg": "turn", "name": "rename", "mirror_of": "pair"}


@dataclass(frozen=True)
class Edit:
    """`label` in lower case, such as "move roof"; `numbers` are the places of the numbers that changed.

    Without numbers the edit changed something else too, and never goes on with another.
    """

    label: str
    numbers: frozenset[Place] = frozenset()

    def continues(self, other: Edit) -> bool:
        """Whether both changed the very same numbers, as repeated nudges do."""
        return bool(self.numbers) and self.numbers == other.numbers


def describe(before: Rig, after: Rig) -> Edit:
    """Name what leads from one rig to the other."""
    changes = list(_changes((), plain_fields(before), plain_fields(after)))
    is_numeric = all(_is_number(old) and _is_number(new) for _, old, new in changes)
    numbers = frozenset(place for place, _, _ in changes) if is_numeric else frozenset()
    return Edit(_label(before, after, [place for place, _, _ in changes]), numbers)


def _changes(place: Place, old: Any, new: Any) -> Iterator[tuple[Place, Any, Any]]:
    """Place, old and new value of every leaf that differs; lists of different lengths are one leaf."""
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


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _label(before: Rig, after: Rig, places: list[Place]) -> str:
    if {place[0] for place in places} == {"vehicle"}:
        return "edit the car"
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
