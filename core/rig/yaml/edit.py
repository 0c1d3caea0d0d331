"""Change a rig file as little as possible: changed values are rewritten, every other character stays.

ruamel's own writer cannot do this: it realigns and drops the comments that follow a sensor in braces.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise

from pydantic import BaseModel
from ruamel.yaml.nodes import CollectionNode, MappingNode, Node, ScalarNode, SequenceNode

from riglens.core.rig.model import Rig, Sensor, Vehicle
from riglens.core.rig.yaml.nodes import Plain, entries_of, parse_yaml, plain_value, value_text
from riglens.core.rig.yaml.text import (
    default_fields,
    implied_fields,
    ordered_fields,
    plain,
    plain_fields,
    same_value,
    sensor_lines,
    vehicle_fields,
    written_fields,
)

Item = int | Sensor
"""A sensor of a new list: the index it had in the text, or a sensor that is not in the text yet."""


def edited_text(text: str, old: Rig, new: Rig) -> str:
    """Return the text of a file that describes `old`, changed as little as possible to describe `new`.

    Sensors are recognised by name, or as renamed when everything else agrees. Fields that the file leaves to a
    library model or to the defaults stay out of the file while they are right.
    """
    text = _without_body(text, old)
    matches = match_sensors(old, new)
    order: list[Item] = [s if i is None else i for i, s in zip(matches, new.sensors, strict=True)]
    text = _with_values(text, new, matches)
    return text if order == list(range(len(old.sensors))) else _with_order(text, order)


def _without_body(text: str, old: Rig) -> str:
    """Return the text with `self_occlusion` in place of `body`, its other spelling."""
    entries = entries_of(parse_yaml(text, "rig"))
    if "body" not in entries:
        return text
    key, value = entries["body"]
    between = text[_end(text, key) : value.start_mark.index]
    said = f"self_occlusion{between}{value_text(old.self_occlusion)}"
    return text[: key.start_mark.index] + said + text[_end(text, value) :]


def match_sensors(old: Rig, new: Rig) -> list[int | None]:
    """Return for every sensor of `new` its index in `old`, None for a new one; sensors are matched by name."""
    places = {(sensor.name, sensor.kind): index for index, sensor in enumerate(old.sensors)}
    matches = [places.get((sensor.name, sensor.kind)) for sensor in new.sensors]
    free = [index for index in range(len(old.sensors)) if index not in matches]
    for place, sensor in enumerate(new.sensors):
        if matches[place] is None:
            renamed = next((i for i in free if _is_renamed(old.sensors[i], sensor)), None)
            if renamed is not None:
                matches[place] = renamed
                free.remove(renamed)
    return matches


def _is_renamed(old: Sensor, new: Sensor) -> bool:
    return plain_fields(old) | {"name": ""} == plain_fields(new) | {"name": ""}


# ---------------------------------------------------------------- values


def _with_values(text: str, new: Rig, matches: Sequence[int | None]) -> str:
    edits, root = _Edits(text), parse_yaml(text, "rig")
    edits.mapping(root, {k: v for k, v in new if k != "sensors"}, default_fields(Rig))
    listed = _sensors(root)
    sensors = listed.value if listed is not None else []
    for index, sensor in zip(matches, new.sensors, strict=True):
        if index is not None:
            fields = {key: getattr(sensor, key) for key in ordered_fields(sensor)}
            edits.mapping(sensors[index], fields, implied_fields(sensor))
    return edits.applied()


class _Edits:
    """Replacements of pieces of a text, collected first and applied together."""

    def __init__(self, text: str) -> None:
        self._text = text
        self._edits: list[tuple[int, int, str]] = []

    def mapping(self, node: Node, wanted: Mapping[str, object], implied: Mapping[str, Plain]) -> None:
        """Set the values of a mapping; those that are neither present nor implied are added in their order."""
        entries = entries_of(node)
        kept = {
            key: value
            for key, (_, value) in entries.items()
            if wanted.get(key, value) is not None
            or implied.get(key) is not None
            or plain_value(value) is None
        }
        for index, (key, value) in enumerate(node.value):
            if key.value not in kept:
                self._remove(node, index, any(later.value in kept for later, _ in node.value[index + 1 :]))
            elif key.value in wanted:
                self._value(key, value, wanted[key.value])
        earlier: list[str] = []
        for name, value in wanted.items():
            if name not in entries and not same_value(plain(value), implied.get(name)):
                anchors = [found for key, found in kept.items() if key in earlier] or [*kept.values()]
                self._add(node, f"{name}: {_new_text(value)}", anchors[-1])
            earlier.append(name)

    def _value(self, key: ScalarNode, node: Node, wanted: object) -> None:
        """Set a value of a mapping, number by number where the shape stays the same."""
        if same_value(plain_value(node), plain(wanted)):
            return
        start, end, present = node.start_mark.index, _end(self._text, node), entries_of(node).keys()
        if isinstance(wanted, BaseModel) and present and present <= plain_fields(wanted).keys():
            parts = {str(i.alias or n): getattr(wanted, n) for n, i in type(wanted).model_fields.items()}
            self.mapping(node, parts, default_fields(type(wanted)))
        elif isinstance(wanted, tuple) and isinstance(node, SequenceNode) and len(node.value) == len(wanted):
            for item, number in zip(node.value, wanted, strict=True):
                self._value(key, item, number)
        elif isinstance(node, CollectionNode) and not node.flow_style:
            colon = self._text.index(":", _end(self._text, key))
            self._edits.append((colon + 1, end, f" {_new_text(wanted)}"))
        else:
            self._edits.append((start, end, " " * (start == end) + _new_text(wanted)))

    def _add(self, node: Node, entry: str, behind: Node) -> None:
        end = _end(self._text, behind)
        if _is_flow(node):
            self._edits.append((end, end, f", {entry}"))
        else:
            end = _line_end(self._text, end)
            self._edits.append((end, end, f"{_newline(self._text)}{' ' * node.start_mark.column}{entry}"))

    def _remove(self, node: Node, index: int, is_followed: bool) -> None:
        """Take an entry out; `is_followed` by one that stays."""
        key, value = node.value[index]
        start, end = key.start_mark.index, _end(self._text, value)
        line_start = self._text.rfind("\n", 0, start) + 1
        if _is_flow(node) and not is_followed:
            start = _end(self._text, node.value[index - 1][1])
        elif _is_flow(node) or self._text[line_start:start].strip():
            # the line of a dash holds the first key, too
            end = node.value[index + 1][0].start_mark.index
        else:
            start, end = line_start, self._text.find("\n", end) + 1 or len(self._text)
        self._edits.append((start, end, ""))

    def applied(self) -> str:
        """Return the text with all edits made."""
        pieces, position = [], 0
        for start, end, new in sorted(self._edits, key=lambda edit: edit[:2]):
            pieces += [self._text[position:start], new]
            position = end
        return "".join([*pieces, self._text[position:]])


def _new_text(value: object) -> str:
    return value_text(vehicle_fields(value) if isinstance(value, Vehicle) else plain(value))


# ---------------------------------------------------------------- the list of sensors


def _with_order(text: str, order: Sequence[Item]) -> str:
    """Return the text with its sensors in that order."""
    root = parse_yaml(text, "rig")
    sensors = _sensors(root)
    if sensors is None or not sensors.value:
        return _with_first_sensors(text, root, sensors, [item for item in order if not isinstance(item, int)])
    if _is_flow(sensors):
        return _in_brackets(text, sensors, order)
    return _in_block(text, root, sensors, order)


def _with_first_sensors(text: str, root: Node, sensors: Node | None, added: Sequence[Sensor]) -> str:
    """Add sensors to a file that has none: `sensors: []`, or no such key at all."""
    newline, column = _newline(text), root.start_mark.column
    if _is_flow(root):
        listed = f"[{', '.join(value_text(written_fields(sensor)) for sensor in added)}]"
        start = sensors.start_mark.index if sensors else _end(text, root.value[-1][1])
        end, new = (_end(text, sensors), listed) if sensors else (start, f", sensors: {listed}")
        return text[:start] + new + text[end:]
    lines = "".join(newline + line for sensor in added for line in sensor_lines(sensor, column + 2))
    if sensors is not None:
        colon = text.index(":", _end(text, entries_of(root)["sensors"][0])) + 1
        text = text[:colon] + text[_end(text, sensors) :]
        end = _line_end(text, colon)
    else:
        end = _line_end(text, _end(text, root))
        lines = f"{newline}{' ' * column}sensors:{lines}"
    return text[:end] + lines + text[end:]


def _in_brackets(text: str, sensors: SequenceNode, order: Sequence[Item]) -> str:
    """Rearrange items in brackets: each place gets the text of the sensor that belongs there."""
    spans = [(item.start_mark.index, _end(text, item)) for item in sensors.value]
    new = [
        text[slice(*spans[item])] if isinstance(item, int) else value_text(written_fields(item))
        for item in order
    ]
    if not new:
        return text[: sensors.start_mark.index] + "[]" + text[_end(text, sensors) :]
    filled = min(len(new), len(spans))
    between = [text[end:start] for (_, end), (start, _) in pairwise(spans[:filled])]
    between += [", "] * (len(new) - filled)
    middle = "".join(piece + gap for piece, gap in zip(new, [*between, ""], strict=True))
    return text[: spans[0][0]] + middle + text[spans[-1][1] :]


def _in_block(text: str, root: Node, sensors: SequenceNode, order: Sequence[Item]) -> str:
    """Rearrange a list of lines: each sensor takes its own comments along, what lies between stays in its place."""
    newline, is_closed = _newline(text), text.endswith("\n")
    text = text if is_closed else text + newline
    spans = _spans(text, sensors)
    bodies = [text[start:end] for start, end in spans]
    gaps = ["", *(text[end:start] for (_, end), (start, _) in pairwise(spans)), ""]
    blank = newline if gaps.count(newline) * 2 > len(spans) - 1 else ""
    for index in reversed(range(len(spans))):
        if index not in order:
            gaps[index : index + 2] = [_one_gap(*gaps[index : index + 2])]
    bodies = [bodies[item] for item in order if isinstance(item, int)]
    for place, item in enumerate(order):
        if not isinstance(item, int):
            gaps.insert(max(place, 1), blank if bodies else "")
            lines = sensor_lines(item, sensors.start_mark.column)
            bodies.insert(place, "".join(line + newline for line in lines))
    before, after = text[: spans[0][0]], text[spans[-1][1] :]
    if not bodies:
        colon = text.index(":", _end(text, entries_of(root)["sensors"][0])) + 1
        before = f"{before[:colon]} []{before[colon:]}"
    middle = gaps[0] + "".join(body + gap for body, gap in zip(bodies, gaps[1:], strict=True))
    result = before + middle + after
    return result if is_closed else result.removesuffix(newline)


def _one_gap(before: str, after: str) -> str:
    """Return what stays between two sensors when the one between them goes: comments, or the shorter blank."""
    return "".join(gap for gap in (before, after) if gap.strip()) or min(before, after, key=len)


def _spans(text: str, sensors: SequenceNode) -> list[tuple[int, int]]:
    """Return start and end of the lines of each sensor with its own comments; every line ends with a line break."""
    column, spans = sensors.start_mark.column, list[tuple[int, int]]()
    for item in sensors.value:
        dash = text.rfind("-", 0, item.start_mark.index)
        while dash - (text.rfind("\n", 0, dash) + 1) != column:
            dash = text.rfind("-", 0, dash)
        start = _above_comments(text, dash - column, column)
        end = _below_comments(text, _end(text, item), column)
        spans.append((max(start, spans[-1][1]) if spans else start, end))
    return spans


def _above_comments(text: str, start: int, column: int) -> int:
    """Return the start of the comment lines directly above a line, those indented like the dash or less."""
    while start > 0:
        above = text.rfind("\n", 0, start - 1) + 1
        line = text[above:start]
        if not line.lstrip().startswith("#") or len(line) - len(line.lstrip()) > column:
            break
        start = above
    return start


def _below_comments(text: str, end: int, column: int) -> int:
    """Return the end of a sensor's last line and of the comment lines directly below that are indented deeper."""
    end = text.find("\n", end) + 1
    while (stop := text.find("\n", end)) >= 0:
        line = text[end : stop + 1]
        if not line.lstrip().startswith("#") or len(line) - len(line.lstrip()) <= column:
            break
        end = stop + 1
    return end


# ---------------------------------------------------------------- places in the text


def _sensors(root: Node) -> SequenceNode | None:
    node = entries_of(root)["sensors"][1] if "sensors" in entries_of(root) else None
    return node if isinstance(node, SequenceNode) else None


def _is_flow(node: Node) -> bool:
    return isinstance(node, CollectionNode) and bool(node.flow_style)


def _end(text: str, node: Node) -> int:
    """Return where a node ends: after its last character that is not blank."""
    if isinstance(node, CollectionNode) and not node.flow_style:
        return _end(text, node.value[-1][1] if isinstance(node, MappingNode) else node.value[-1])
    start = int(node.start_mark.index)
    return start + len(text[start : node.end_mark.index].rstrip())


def _line_end(text: str, position: int) -> int:
    """Return where the line around a position ends, before its line break."""
    end = text.find("\n", position)
    if end < 0:
        return len(text)
    return end - 1 if end > position and text[end - 1] == "\r" else end


def _newline(text: str) -> str:
    return "\r\n" if "\r\n" in text else "\n"
