"""The same edit to several sensors of a rig at once: each function gives the rig as it is afterwards."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from riglens.core.errors import InputError
from riglens.core.rig.mirror import without_sensor
from riglens.core.rig.model import MAX_SENSORS, Rig, Sensor


def with_enabled(rig: Rig, names: Collection[str], enabled: bool) -> Rig:
    """The rig with these sensors counted in the scores, or not."""
    return rig.model_copy(
        update={
            "sensors": tuple(
                sensor.model_copy(update={"enabled": enabled}) if sensor.name in names else sensor
                for sensor in rig.sensors
            )
        }
    )


def without(rig: Rig, names: Collection[str]) -> Rig:
    """The rig without these sensors; a mirror image whose partner goes stays and stands alone."""
    for name in names:
        rig = without_sensor(rig, name)
    return rig


def duplicated(rig: Rig, names: Collection[str], left_m: float) -> tuple[Rig, tuple[str, ...]]:
    """The rig with a copy of each of these sensors, `left_m` metres to the left of it, and the copies' names.

    InputError when the rig would hold too many sensors.
    """
    taken = [sensor.name for sensor in rig.sensors]
    copies: list[Sensor] = []
    for sensor in rig.sensors:
        if sensor.name in names:
            x, y, z = sensor.position
            name = free_name(taken, sensor.name)
            taken.append(name)
            copies.append(sensor.replace(name=name, position=(x, y + left_m, z), mirror_of=None))
    if len(taken) > MAX_SENSORS:
        raise InputError(f"sensors: a rig holds at most {MAX_SENSORS}; delete some first")
    grown: Rig = rig.model_copy(update={"sensors": (*rig.sensors, *copies)})
    return grown, tuple(copy.name for copy in copies)


def free_name(taken: Collection[str], wanted: str) -> str:
    """`wanted`, or with the first number behind it that makes it unique."""
    if wanted not in taken:
        return wanted
    stem, _, tail = wanted.rpartition("_")
    stem = stem if stem and tail.isdigit() else wanted
    number = 2
    while f"{stem}_{number}" in taken:
        number += 1
    return f"{stem}_{number}"


def list_text(names: Sequence[str]) -> str:
    """One name as it is, several as their number: for the labels of edits."""
    return names[0] if len(names) == 1 else f"{len(names)} sensors"
