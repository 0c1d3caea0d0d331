"""Editing the text of a rig file: only what changed is rewritten, comments and layout around it stay.

The text is never dumped again. The nodes of the parsed text say where each value stands, and edits replace
just those characters.
"""

from __future__ import annotations

from collections.abc import Sequence as AbstractSequence
from typing import Any

from riglens.core.rig.distortion import COEFFICIENTS
from riglens.core.rig.model import Rig, Sensor, Vehicle
from riglens.core.rig.yaml_nodes import Mapping, Node, Scalar, Sequence, parse_yaml, plain_value
from riglens.core.rig.yaml_sensors import match_sensors, rearranged
from riglens.core.rig.yaml_text import (
    FIELD_ORDER,
    implied_fields,
    line_end,
    plain_fields,
    same_value,
    value_text,
    vehicle_fields,
)

_RIG_ORDER = ("riglens", "name", "vehicle", "sensors")
_ABSENT = {"distortion": dict.fromkeys(COEFFICIENTS, 0.0)}
"""What a number of a nested mapping is when the file does not say it."""


def edited_text(text: str, old: Rig, new: Rig) -> str:
    """The text of a file that says `old`, changed as little as possible so that it says `new`.

    Sensors are recognised by name, or as renamed when all else agrees. Fields that the file leaves to a
    library model or to the defaults stay left out while they say the right thing.
    """
    matches = match_sensors(old, new)
    pairs = [(index, sensor) for index, sensor in zip(matches, new.sensors, strict=True) if index is not None]
    while (shorter := _without_one_obsolete_field(text, pairs)) is not None:
        text = shorter
    text = _with_values(text, new, pairs)
    if matches != list(range(len(old.sensors))):
        order = [
            sensor if index is None else index for index, sensor in zip(matches, new.sensors, strict=True)
        ]
        text = rearranged(text, order)
    return text


def _with_values(text: str, new: Rig, pairs: AbstractSequence[tuple[int, Sensor]]) -> str:
    edits, root = _Edits(text), _root(text)
    vehicle, vehicle_node = plain_fields(new.vehicle), root.get("vehicle")
    wanted: dict[str, Any] = {"name": new.name}
    implied: dict[str, Any] = {"name": Rig.model_fields["name"].default}
    if isinstance(vehicle_node, Mapping) and vehicle_node.entries:
        edits.mapping(vehicle_node, vehicle, plain_fields(Vehicle()), tuple(vehicle))
    else:
        wanted["vehicle"], implied["vehicle"] = vehicle_fields(new.vehicle), vehicle_fields(Vehicle())
    edits.mapping(root, wanted, implied, _RIG_ORDER)
    for index, sensor in pairs:
        edits.mapping(_item(root, index), plain_fields(sensor), implied_fields(sensor), FIELD_ORDER)
    return edits.applied()


def _without_one_obsolete_field(text: str, pairs: AbstractSequence[tuple[int, Sensor]]) -> str | None:
    """The text without the first field that no longer has a value (a lens said in another way), or None."""
    root = _root(text)
    for index, sensor in pairs:
        item, wanted, implied = _item(root, index), plain_fields(sensor), implied_fields(sensor)
        for place, (key, value) in enumerate(item.entries):
            is_gone = wanted[key.text] is None and implied.get(key.text) is None
            if is_gone and plain_value(value) is not None:
                return _without_entry(text, item, place)
    return None


def _without_entry(text: str, mapping: Mapping, place: int) -> str:
    key, value = mapping.entries[place]
    following = mapping.entries[place + 1 : place + 2]
    line_start = text.rfind("\n", 0, key.start) + 1
    if (mapping.flow and following) or text[line_start : key.start].strip():
        start, end = key.start, following[0][0].start if following else value.end
    elif mapping.flow:
        start, end = mapping.entries[place - 1][1].end, value.end
    else:
        start, end = line_start, min(line_end(text, value.end) + 1, len(text))
    return text[:start] + text[end:]


class _Edits:
    """Replacements of pieces of a text, collected first and applied together."""

    def __init__(self, text: str) -> None:
        self._text = text
        self._newline = "\r\n" if "\r\n" in text else "\n"
        self._edits: list[tuple[int, int, str]] = []

    def mapping(
        self, node: Mapping, wanted: dict[str, Any], implied: dict[str, Any], order: tuple[str, ...]
    ) -> None:
        """Make a mapping say the wanted values; those that are not there and not implied are added."""
        present = [key.text for key, _ in node.entries]
        for key, value in node.entries:
            if key.text in wanted:
                self.value(key, value, wanted[key.text], implied.get(key.text))
        for name in order:
            if name in wanted and name not in present and not same_value(wanted[name], implied.get(name)):
                self._add(node, f"{name}: {value_text(wanted[name])}", self._anchor(node, name, order))

    def value(self, key: Scalar, node: Node, wanted: Any, implied: Any = None) -> None:
        """Make a value of a mapping say what is wanted, number by number where the shape stays."""
        if same_value(plain_value(node), wanted):
            return
        if isinstance(node, Mapping) and isinstance(wanted, dict) and _is_part(node, wanted):
            absent = _ABSENT.get(key.text, implied)
            self.mapping(node, wanted, absent if isinstance(absent, dict) else {}, tuple(wanted))
        elif isinstance(node, Sequence) and isinstance(wanted, tuple) and len(node.items) == len(wanted):
            for item, number in zip(node.items, wanted, strict=True):
                self.value(key, item, number)
        elif isinstance(node, (Mapping, Sequence)) and not node.flow:
            colon = self._text.index(":", key.end)
            self._edits.append((colon + 1, node.end, f" {value_text(wanted)}"))
        else:
            space = " " if node.start == node.end else ""
            self._edits.append((node.start, node.end, space + value_text(wanted)))

    def _anchor(self, node: Mapping, name: str, order: tuple[str, ...]) -> Node:
        """The value behind which a new field goes: that of the last field before it, else the last one."""
        earlier = order[: order.index(name)]
        known = [value for key, value in node.entries if key.text in earlier]
        return known[-1] if known else node.entries[-1][1]

    def _add(self, node: Mapping, entry: str, behind: Node) -> None:
        if node.flow:
            self._edits.append((behind.end, behind.end, f", {entry}"))
        else:
            end = line_end(self._text, behind.end)
            self._edits.append((end, end, f"{self._newline}{' ' * node.column}{entry}"))

    def applied(self) -> str:
        """The text with all edits made."""
        pieces, position = [], 0
        for start, end, new in sorted(self._edits, key=lambda edit: edit[:2]):
            pieces += [self._text[position:start], new]
            position = end
        return "".join([*pieces, self._text[position:]])


def _is_part(node: Mapping, wanted: dict[str, Any]) -> bool:
    """Whether a mapping holds something, and nothing that is no longer wanted."""
    return bool(node.entries) and {key.text for key, _ in node.entries} <= wanted.keys()


def _root(text: str) -> Mapping:
    root = parse_yaml(text, "rig")
    assert isinstance(root, Mapping)
    return root


def _item(root: Mapping, index: int) -> Mapping:
    sensors = root.get("sensors")
    assert isinstance(sensors, Sequence)
    item = sensors.items[index]
    assert isinstance(item, Mapping)
    return item
