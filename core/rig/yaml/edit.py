"""Editing the text of a rig file: only what changed is rewritten, comments and layout around it stay.

The text is never dumped again. The nodes of the parsed text say where each value stands, and edits replace
just those characters. Comment lines directly above a sensor belong to it, as do comments indented deeper than
its dash; they move and go with it. What is set apart by a blank line ("# ---- cameras ----") stays where it is.
"""

from __future__ import annotations

from collections.abc import Sequence as AbstractSequence
from dataclasses import dataclass

from riglens.core.rig.model import COEFFICIENTS, Rig, Sensor, Vehicle
from riglens.core.rig.yaml.nodes import Mapping, Node, Plain, Scalar, Sequence, parse_yaml, plain_value
from riglens.core.rig.yaml.text import (
    FIELD_ORDER,
    implied_fields,
    line_end,
    plain,
    plain_fields,
    same_value,
    sensor_lines,
    value_text,
    vehicle_fields,
    written_fields,
)

Item = int | Sensor
"""A sensor of a new list: the index it had in the text, or a sensor that is not in the text yet."""


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


def rearranged(text: str, order: AbstractSequence[Item]) -> str:
    """Return the text with its sensors in that order."""
    root = parse_yaml(text, "rig")
    assert isinstance(root, Mapping)
    sensors = root.get("sensors")
    if isinstance(sensors, Sequence) and sensors.items and not sensors.flow:
        return _rearranged_block(text, root, sensors, order)
    if isinstance(sensors, Sequence) and (sensors.items or root.flow):
        return _rearranged_flow(text, sensors, order)
    return _first_sensors(text, root, sensors, order)


def _first_sensors(text: str, root: Mapping, sensors: object, order: AbstractSequence[Item]) -> str:
    """Add sensors to a file that has none: `sensors: []`, or no such key at all."""
    added = [item for item in order if not isinstance(item, int)]
    if root.flow:
        entry = f", sensors: [{', '.join(value_text(written_fields(sensor)) for sensor in added)}]"
        end = root.entries[-1][1].end
        return text[:end] + entry + text[end:]
    newline = _newline(text)
    lines = "".join(newline + line for sensor in added for line in sensor_lines(sensor, root.column + 2))
    if isinstance(sensors, Sequence):
        colon = text.index(":", root.key("sensors").end)
        text = text[: colon + 1] + text[sensors.end :]
        end = line_end(text, colon + 1)
        return text[:end] + lines + text[end:]
    end = line_end(text, root.end)
    return f"{text[:end]}{newline}{' ' * root.column}sensors:{lines}{text[end:]}"


def _rearranged_flow(text: str, sensors: Sequence, order: AbstractSequence[Item]) -> str:
    """Rearrange items in brackets: each place gets the text of the sensor that belongs there."""
    items = sensors.items
    new = [
        text[items[item].start : items[item].end]
        if isinstance(item, int)
        else value_text(written_fields(item))
        for item in order
    ]
    if not new or not items:
        return text[: sensors.start] + f"[{', '.join(new)}]" + text[sensors.end :]
    pieces, position = [], 0
    for place, (old, replacement) in enumerate(zip(items, new, strict=False)):
        pieces += [text[position : old.start], replacement]
        position = items[-1].end if place == len(new) - 1 else old.end
    rest = "".join(f", {extra}" for extra in new[len(items) :])
    return "".join(pieces) + rest + text[position:]


@dataclass
class _Blocks:
    """The lines of a block list: what comes before, each sensor, what lies between, what follows."""

    before: str
    bodies: list[str]
    gaps: list[str]
    after: str

    def joined(self) -> str:
        between = [*self.gaps, ""]
        middle = "".join(body + gap for body, gap in zip(self.bodies, between, strict=True))
        return self.before + middle + self.after


def _rearranged_block(text: str, root: Mapping, sensors: Sequence, order: AbstractSequence[Item]) -> str:
    if not order:
        return _without_sensors(text, root, sensors)
    newline = _newline(text)
    is_closed = text.endswith("\n")
    blocks = _split(text if is_closed else text + newline, sensors)
    blank = newline if blocks.gaps.count(newline) * 2 > len(blocks.gaps) else ""
    kept = [item for item in order if isinstance(item, int)]
    for index in reversed(range(len(sensors.items))):
        if index not in kept:
            _remove(blocks, index)
    blocks.bodies = [blocks.bodies[sorted(kept).index(index)] for index in kept]
    for place, item in enumerate(order):
        if not isinstance(item, int):
            lines = sensor_lines(item, sensors.column)
            _insert(blocks, place, "".join(line + newline for line in lines), blank)
    result = blocks.joined()
    return result if is_closed else result.removesuffix(newline)


def _remove(blocks: _Blocks, index: int) -> None:
    """Take a sensor out; comments of their own beside it stay, one of two blank gaps goes."""
    del blocks.bodies[index]
    before = blocks.gaps.pop(index - 1) if index > 0 else ""
    after = blocks.gaps.pop(max(index - 1, 0)) if blocks.gaps and index < len(blocks.bodies) else ""
    both = before + after if before.strip() and after.strip() else before if before.strip() else after
    if index == 0:
        blocks.before += both if both.strip() else ""
    elif index == len(blocks.bodies):
        blocks.after = (both if both.strip() else "") + blocks.after
    else:
        blocks.gaps.insert(index - 1, both)


def _insert(blocks: _Blocks, place: int, body: str, gap: str) -> None:
    if blocks.bodies:
        blocks.gaps.insert(max(place - 1, 0), gap)
    blocks.bodies.insert(place, body)


def _split(text: str, sensors: Sequence) -> _Blocks:
    """Cut the text into the sensors' lines and what lies between; every piece ends with a line break."""
    starts = [_item_start(text, sensors, index) for index in range(len(sensors.items))]
    heads = [_above_comments(text, start, sensors.column) for start in starts]
    tails = [_below_comments(text, item.end, sensors.column) for item in sensors.items]
    heads = [heads[0], *(max(head, tail) for head, tail in zip(heads[1:], tails, strict=False))]
    return _Blocks(
        before=text[: heads[0]],
        bodies=[text[head:tail] for head, tail in zip(heads, tails, strict=True)],
        gaps=[text[tail:head] for tail, head in zip(tails, heads[1:], strict=False)],
        after=text[tails[-1] :],
    )


def _item_start(text: str, sensors: Sequence, index: int) -> int:
    """Return the start of the line with the item's dash."""
    dash = text.rfind("-", 0, sensors.items[index].start)
    while dash - (text.rfind("\n", 0, dash) + 1) != sensors.column:
        dash = text.rfind("-", 0, dash)
    return text.rfind("\n", 0, dash) + 1


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


def _without_sensors(text: str, root: Mapping, sensors: Sequence) -> str:
    colon = text.index(":", root.key("sensors").end)
    blocks = _split(text if text.endswith("\n") else text + _newline(text), sensors)
    kept = "".join(gap for gap in blocks.gaps if gap.strip())
    return blocks.before[: colon + 1] + " []" + blocks.before[colon + 1 :] + kept + blocks.after


def _newline(text: str) -> str:
    return "\r\n" if "\r\n" in text else "\n"


_RIG_ORDER = ("riglens", "name", "self_occlusion", "vehicle", "keep_out", "sensors")
_ABSENT: dict[str, Plain] = {"distortion": dict.fromkeys(COEFFICIENTS, 0.0)}
"""Values of the numbers of a nested mapping when the file omits them."""


def edited_text(text: str, old: Rig, new: Rig) -> str:
    """Return the text of a file that describes `old`, changed as little as possible to describe `new`.

    Sensors are recognised by name, or as renamed when everything else agrees. Fields that the file leaves to a
    library model or to the defaults stay out of the file while they are right.
    """
    text = _without_body(text, old)
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


def _without_body(text: str, old: Rig) -> str:
    """Return the text with `self_occlusion` in place of `body`, its other spelling."""
    root = _root(text)
    value = root.get("body")
    if value is None:
        return text
    key = root.key("body")
    said = value_text(old.self_occlusion)
    return f"{text[: key.start]}self_occlusion{text[key.end : value.start]}{said}{text[value.end :]}"


def _with_values(text: str, new: Rig, pairs: AbstractSequence[tuple[int, Sensor]]) -> str:
    edits, root = _Edits(text), _root(text)
    vehicle, vehicle_node = plain_fields(new.vehicle), root.get("vehicle")
    own = ("name", "self_occlusion", "keep_out")
    wanted: dict[str, Plain] = {key: plain(getattr(new, key)) for key in own}
    implied: dict[str, Plain] = {key: plain(Rig.model_fields[key].default) for key in own}
    if isinstance(vehicle_node, Mapping) and vehicle_node.entries:
        edits.mapping(vehicle_node, vehicle, plain_fields(Vehicle()), tuple(vehicle))
    else:
        wanted["vehicle"], implied["vehicle"] = vehicle_fields(new.vehicle), vehicle_fields(Vehicle())
    edits.mapping(root, wanted, implied, _RIG_ORDER)
    for index, sensor in pairs:
        edits.mapping(_item(root, index), plain_fields(sensor), implied_fields(sensor), FIELD_ORDER)
    return edits.applied()


def _without_one_obsolete_field(text: str, pairs: AbstractSequence[tuple[int, Sensor]]) -> str | None:
    """Return the text without the first field that no longer has a value (of a lens given otherwise), or None."""
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
        self, node: Mapping, wanted: dict[str, Plain], implied: dict[str, Plain], order: tuple[str, ...]
    ) -> None:
        """Give a mapping the wanted values; those that are neither present nor implied are added."""
        present = [key.text for key, _ in node.entries]
        for key, value in node.entries:
            if key.text in wanted:
                self.value(key, value, wanted[key.text], implied.get(key.text))
        for name in order:
            if name in wanted and name not in present and not same_value(wanted[name], implied.get(name)):
                self._add(node, f"{name}: {value_text(wanted[name])}", self._anchor(node, name, order))

    def value(self, key: Scalar, node: Node, wanted: Plain, implied: Plain = None) -> None:
        """Give a value of a mapping its wanted content, number by number where the shape stays the same."""
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
        """Return the value after which a new field goes: that of the last field before it, or else the last one."""
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
        """Return the text with all edits made."""
        pieces, position = [], 0
        for start, end, new in sorted(self._edits, key=lambda edit: edit[:2]):
            pieces += [self._text[position:start], new]
            position = end
        return "".join([*pieces, self._text[position:]])


def _is_part(node: Mapping, wanted: dict[str, Plain]) -> bool:
    """Return whether a mapping has fields, all of which are still wanted."""
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
