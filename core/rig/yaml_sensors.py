"""Adding, removing and reordering the sensors in the text of a rig file, comments kept.

Comment lines directly above a sensor belong to it, as do comments indented deeper than its dash; they move
and go with it. What is set apart by a blank line ("# ---- cameras ----") stays where it is.
"""

from __future__ import annotations

from collections.abc import Sequence as AbstractSequence
from dataclasses import dataclass

from riglens.core.rig.model import Rig, Sensor
from riglens.core.rig.yaml_nodes import Mapping, Sequence, parse_yaml
from riglens.core.rig.yaml_text import line_end, plain_fields, sensor_lines, value_text, written_fields

Item = int | Sensor
"""A sensor of a new list: the index it had in the text, or a sensor that is not in the text yet."""


def match_sensors(old: Rig, new: Rig) -> list[int | None]:
    """For every sensor of `new` its index in `old`, None for a new one; names say who is who."""
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
    """The text with its sensors in that order."""
    root = parse_yaml(text, "rig")
    assert isinstance(root, Mapping)
    sensors = root.get("sensors")
    if isinstance(sensors, Sequence) and sensors.items and not sensors.flow:
        return _rearranged_block(text, root, sensors, order)
    if isinstance(sensors, Sequence) and (sensors.items or root.flow):
        return _rearranged_flow(text, sensors, order)
    return _first_sensors(text, root, sensors, order)


def _first_sensors(text: str, root: Mapping, sensors: object, order: AbstractSequence[Item]) -> str:
    """Sensors for a file that has none: `sensors: []`, or no such key at all."""
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
    """Items in brackets: each place gets the text of the sensor that belongs there."""
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
    """The lines of a block list: what stands before, each sensor, what stands between, what follows."""

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
    """Start of the line with the item's dash."""
    dash = text.rfind("-", 0, sensors.items[index].start)
    while dash - (text.rfind("\n", 0, dash) + 1) != sensors.column:
        dash = text.rfind("-", 0, dash)
    return text.rfind("\n", 0, dash) + 1


def _above_comments(text: str, start: int, column: int) -> int:
    """Start of the comment lines directly above a line, those indented like the dash or less."""
    while start > 0:
        above = text.rfind("\n", 0, start - 1) + 1
        line = text[above:start]
        if not line.lstrip().startswith("#") or len(line) - len(line.lstrip()) > column:
            break
        start = above
    return start


def _below_comments(text: str, end: int, column: int) -> int:
    """End of a sensor's last line and of the comment lines directly below that are indented deeper."""
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
