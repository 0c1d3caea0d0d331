"""Edits of a rig, each a function that returns the changed rig: mirror pairs, and several sensors at once."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Iterable, Sequence
from typing import Any

from riglens.core.errors import InputError
from riglens.core.geometry import Pose, Vec3
from riglens.core.rig.model import MAX_SENSORS, Rig, Sensor
from riglens.core.sensors.base import HALVES

_LEFT, _RIGHT = ("left", "Left", "LEFT"), ("right", "Right", "RIGHT")
_SAME_PLACE_M = 0.01
_OTHER_SIDE = {"L": "R", "R": "L", "l": "r", "r": "l"}
_SIDE_LETTER = re.compile(r"(?<![A-Z0-9])[FRBSMC]?[LR](?![A-Za-z])|(?<![A-Za-z0-9])[frbsmc]?[lr](?![A-Za-z])")
"""L or R as a word or after one letter for front, rear, back, side, middle, corner: FL, CAM_RR2, side_l."""


def replaced(item: Any, path: tuple[str | int, ...], value: Any) -> Any:
    """Return an item with what lies at a path (names of fields and places in tuples) replaced, validated on the way;
    all else stays the very same objects. Raise pydantic's ValidationError for a value that does not fit."""
    if not path:
        return value
    step, rest = path[0], path[1:]
    if isinstance(step, int):
        return (*item[:step], replaced(item[step], rest, value), *item[step + 1 :])
    return item.replace(**{step: replaced(getattr(item, step), rest, value)})


def mirrored_pose(pose: Pose) -> Pose:
    """Return the pose on the other side of the car's middle plane: y, roll and yaw change sign.

    Reflecting both frames at y = 0 turns Rz(yaw) Ry(pitch) Rx(roll) into Rz(-yaw) Ry(pitch) Rx(-roll).
    """
    (x, y, z), (roll, pitch, yaw) = pose.position_m, pose.rpy_deg
    return Pose((x, 0.0 - y, z), (0.0 - roll, pitch, 0.0 - yaw))


def partner_of(rig: Rig, name: str) -> str | None:
    """Return the name of the other sensor of a mirror pair; None for a sensor without one."""
    for sensor in rig.sensors:
        if sensor.mirror_of is not None and name in (sensor.name, sensor.mirror_of):
            return sensor.mirror_of if sensor.name == name else sensor.name
    return None


def mirrored_name(name: str, y_m: float = 0.0) -> str:
    """Return a name for the mirror image of a sensor at `y_m`, metres to the left of the middle plane.

    Left becomes right and vice versa, in words (`left`) and in single letters (`CAM_FL`, `L2`). A name that
    says no side gets the side of its image, such as `roof_right`; on the middle plane it stays as it is.
    """
    swap = dict(zip(_LEFT + _RIGHT, _RIGHT + _LEFT, strict=True))
    swapped = re.sub("|".join(swap), lambda match: swap[match[0]], name)
    if swapped == name:
        swapped = _SIDE_LETTER.sub(lambda match: match[0][:-1] + _OTHER_SIDE[match[0][-1]], name)
    if swapped != name or y_m == 0.0:
        return swapped
    side = "right" if y_m > 0.0 else "left"
    return f"{name}_{side.upper() if name.isupper() else side}"


def with_mirror_image(rig: Rig, name: str, image_name: str) -> Rig:
    """Return the rig with the mirror image of a sensor added after it, the two linked.

    Raise ValueError when the sensor lies and looks along the middle plane: its image would be in the same place.
    """
    sensor = rig.sensor(name)
    if sensor.pose == mirrored_pose(sensor.pose):
        raise ValueError(f"{name} is on the middle plane of the car: its mirror image is in the same place")
    image = _image(sensor, sensor.model_copy(update={"name": image_name, "mirror_of": name}))
    place = [other.name for other in rig.sensors].index(name) + 1
    return rig.replace(sensors=(*rig.sensors[:place], image, *rig.sensors[place:]))


def nearest_to_image(rig: Rig, name: str) -> str | None:
    """Return the name of the unpaired sensor of the same kind that is nearest to a sensor's mirror image, if any."""
    sensor = rig.sensor(name)
    image_m = mirrored_pose(sensor.pose).position_m
    free = [
        other
        for other in rig.sensors
        if other.kind == sensor.kind and other.name != name and partner_of(rig, other.name) is None
    ]
    return min(free, key=lambda other: math.dist(other.position, image_m)).name if free else None


def linked(rig: Rig, name: str, other: str) -> Rig:
    """Return the rig with two sensors as a mirror pair; the second takes pose and fields of the first.

    Raise ValueError when they are of different kinds or one of them belongs to another pair.
    """
    follower = _image(rig.sensor(name), rig.sensor(other)).replace(mirror_of=name)
    return rig.replace(sensors=_with(rig, [follower]).sensors)


def unlinked(rig: Rig, name: str) -> Rig:
    """Return the rig with the mirror pair of a sensor dissolved; both stay where they are."""
    pair = (name, partner_of(rig, name))
    return _with(rig, [_follower(sensor, None) for sensor in rig.sensors if sensor.name in pair])


def in_step(before: Rig, after: Rig) -> Rig:
    """Return `after` with its mirror pairs in step: a change of one sensor changes the other.

    Where both changed, or have just been paired, the sensor that the other names leads. A pair whose leader was
    renamed stays a pair; one whose leader is gone is dissolved.
    """
    if all(sensor.mirror_of is None for sensor in after.sensors):
        return after
    after = _with_living_leaders(before, after)
    old = {sensor.name: sensor for sensor in before.sensors}
    images = []
    for follower in after.sensors:
        if follower.mirror_of is None:
            continue
        leader, was = after.sensor(follower.mirror_of), old.get(follower.name)
        is_new = was is None or was.mirror_of is None
        if is_new or not _agrees(leader, old.get(leader.name)):
            images.append(_image(leader, follower))
        elif not _agrees(follower, was):
            images.append(_image(follower, leader))
    return _with(after, images)


def _with_living_leaders(before: Rig, after: Rig) -> Rig:
    """Update mirror partners of a renamed sensor, and unlink those of a deleted one."""
    names = {sensor.name for sensor in after.sensors}
    renamed = {}
    if len(before.sensors) == len(after.sensors):
        pairs = zip(before.sensors, after.sensors, strict=True)
        renamed = {old.name: new.name for old, new in pairs if old.name not in names}
    lost = [
        sensor for sensor in after.sensors if sensor.mirror_of is not None and sensor.mirror_of not in names
    ]
    return _with(after, [_follower(sensor, renamed.get(sensor.mirror_of or "")) for sensor in lost])


def _agrees(sensor: Sensor, old: Sensor | None) -> bool:
    """Return whether a sensor is as it was, apart from name and pair; a sensor of another name counts as it was."""
    return old is None or _image(sensor, old) == _image(old, old)


def _image(sensor: Sensor, own: Sensor) -> Sensor:
    """Return the mirror image of a sensor, with name, pair and failing groups of `own`."""
    image = sensor.mirrored().with_pose(mirrored_pose(sensor.pose))
    kept = {"name": own.name, "mirror_of": own.mirror_of, "fails_with": own.fails_with}
    return image.model_copy(update=kept)


def _follower(sensor: Sensor, leader: str | None) -> Sensor:
    return sensor.model_copy(update={"mirror_of": leader})


def _with(rig: Rig, changed: list[Sensor]) -> Rig:
    """Return the rig with some sensors replaced by those of the same names."""
    new = {sensor.name: sensor for sensor in changed}
    sensors = tuple(new.get(sensor.name, sensor) for sensor in rig.sensors)
    return rig.model_copy(update={"sensors": sensors})


def damaged(rig: Rig, said: Iterable[str]) -> Rig:
    """Return the rig with some sensors failed, "roof", or half blocked, "roof=left"; InputError for what is neither.

    Failed sensors are disabled. Mirror pairs are dissolved: damage to one sensor is none to the other.
    """
    names = {sensor.name for sensor in rig.sensors}
    for one in said:
        name, _, half = (one, "", "") if one in names else one.rpartition("=")
        if name not in names or (name != one and half not in HALVES):
            accepted = f"the name of a sensor, or NAME={'|'.join(HALVES)}"
            raise InputError(f"must be {accepted} (got '{one:.80}')", "damaged")
        sensor = unlinked(rig, name).sensor(name)
        blocked = (*sensor.blocked, HALVES[half]) if half else sensor.blocked
        rig = unlinked(rig, name).with_sensor(name, sensor.replace(blocked=blocked, enabled=bool(half)))
    return rig


def with_enabled(rig: Rig, names: Collection[str], enabled: bool) -> Rig:
    """Return the rig with these sensors counted in the scores, or not."""
    chosen = (sensor for sensor in rig.sensors if sensor.name in names)
    return _with(rig, [sensor.model_copy(update={"enabled": enabled}) for sensor in chosen])


def without(rig: Rig, names: Collection[str]) -> Rig:
    """Return the rig without these sensors; a mirror image whose partner goes stays, unlinked."""
    for name in names:
        rig = unlinked(rig, name)
    return rig.model_copy(update={"sensors": tuple(s for s in rig.sensors if s.name not in names)})


def duplicated(rig: Rig, names: Collection[str], left_m: float) -> tuple[Rig, tuple[str, ...]]:
    """Return the rig with a copy of each of these sensors, and the copies' names.

    A mirror pair of which both are copied gives a linked pair in the same place, every other copy is `left_m`
    metres to the left. Raise InputError when the rig would hold too many sensors.
    """
    copied = [sensor for sensor in rig.sensors if sensor.name in names]
    taken = [sensor.name for sensor in rig.sensors]
    new_names = _free_names(taken, [sensor.name for sensor in copied])
    copies: list[Sensor] = []
    for sensor in copied:
        x, y, z = sensor.position
        is_pair = partner_of(rig, sensor.name) in new_names
        position = sensor.position if is_pair else (x, y + left_m, z)
        leader = new_names[sensor.mirror_of] if is_pair and sensor.mirror_of is not None else None
        copies.append(sensor.replace(name=new_names[sensor.name], position=position, mirror_of=leader))
    return _grown(rig, copies), tuple(copy.name for copy in copies)


def pasted(rig: Rig, sensors: Sequence[Sensor], step_m: float) -> tuple[Rig, tuple[str, ...]]:
    """Return the rig with foreign sensors added under free names, and those names; pairs among them stay linked.

    Where one of them would coincide with a sensor of the rig, all are shifted by multiples of `step_m`: to the left, or
    ahead when there is a pair among them, which has to stay symmetric. Raise InputError when the rig would hold too
    many sensors.
    """
    taken = [sensor.name for sensor in rig.sensors]
    new_names = _free_names(taken, [sensor.name for sensor in sensors])
    axis = 0 if any(sensor.mirror_of in new_names for sensor in sensors) else 1
    places_m = [sensor.position for sensor in rig.sensors]
    steps = 0
    while any(
        math.dist(_shifted(s.position, axis, steps * step_m), m) < _SAME_PLACE_M
        for s in sensors
        for m in places_m
    ):
        steps += 1
    copies = [
        sensor.replace(
            name=new_names[sensor.name],
            position=_shifted(sensor.position, axis, steps * step_m),
            mirror_of=new_names.get(sensor.mirror_of or ""),
        )
        for sensor in sensors
    ]
    return _grown(rig, copies), tuple(copy.name for copy in copies)


def _shifted(position_m: Vec3, axis: int, by_m: float) -> Vec3:
    if by_m == 0.0:
        return position_m
    x, y, z = (p + by_m * (place == axis) for place, p in enumerate(position_m))
    return x, y, z


def _free_names(taken: list[str], wanted: Sequence[str]) -> dict[str, str]:
    """Return a free name for each wanted one."""
    found: dict[str, str] = {}
    for name in wanted:
        found[name] = free_name([*taken, *found.values()], name)
    return found


def _grown(rig: Rig, copies: Sequence[Sensor]) -> Rig:
    """Return the rig with more sensors; InputError when they are too many."""
    if len(rig.sensors) + len(copies) > MAX_SENSORS:
        raise InputError(f"sensors: a rig holds at most {MAX_SENSORS}; delete some first")
    return rig.model_copy(update={"sensors": (*rig.sensors, *copies)})


def free_name(taken: Collection[str], wanted: str) -> str:
    """Return `wanted`, with the first number appended that makes it unique if it is taken."""
    if wanted not in taken:
        return wanted
    stem, _, tail = wanted.rpartition("_")
    stem = stem if stem and tail.isdigit() else wanted
    number = 2
    while f"{stem}_{number}" in taken:
        number += 1
    return f"{stem}_{number}"


def list_text(names: Sequence[str]) -> str:
    """Return a single name unchanged, several as their number: for the labels of edits."""
    return names[0] if len(names) == 1 else f"{len(names)} sensors"
