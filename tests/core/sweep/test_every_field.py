"""Every number of every kind of sensor, and of the vehicle, can be varied."""

from collections.abc import Iterator
from typing import Any

import pytest
from pydantic import BaseModel

from riglens.core.errors import InputError
from riglens.core.geometry import Pose
from riglens.core.rig.library import default_library
from riglens.core.rig.model import Rig
from riglens.core.sensors.registry import kinds
from riglens.core.sweep.fields import POSE, field_called, value_of, with_values


def numbers_in(item: Any, path: str) -> Iterator[tuple[str, float]]:
    """Names of the numbers in a part of a rig, as its file spells them, with their values."""
    if isinstance(item, BaseModel):
        for name, info in type(item).model_fields.items():
            yield from numbers_in(getattr(item, name), f"{path}.{info.alias or name}")
    elif isinstance(item, tuple):
        for place, part in enumerate(item[:3]):
            yield from numbers_in(part, f"{path}.{place}")
    elif isinstance(item, (int, float)):
        yield path, item


@pytest.mark.parametrize("kind", [kind.name for kind in kinds()])
def test_any_number_of_any_kind_can_vary(kind: str) -> None:
    entries = [one for one in default_library().entries() if one.kind == kind]
    seen = set[str]()
    for entry in (entries[0], entries[len(entries) // 2], entries[-1]):
        rig = Rig(sensors=(entry.sensor("S", Pose((1.0, 0.0, 1.2))),))
        for name, value in [*numbers_in(rig.sensors[0], "S"), *numbers_in(rig.vehicle, "vehicle")]:
            field = field_called(rig, name)
            assert value_of(rig, field) == value, name
            assert with_values(rig, {field: value}) == rig, name
            changes = (value + 1, value - 1, value * 1.001, value * 0.999, 1 - value, 50.0)
            taken = [one for one in changes if takes(rig, name, one)]
            assert taken, f"{name} = {value} can only be what it is"
            seen.add(name)
    assert {f"S.{name}" for name in ("position.0", "rpy_deg.2", "enabled")} <= seen
    assert all(field_called(rig, f"S.{name}").sensor == "S" for name in POSE)


def takes(rig: Rig, name: str, value: float) -> bool:
    """Whether a number may have another value; what it may not be is said in one line."""
    field = field_called(rig, name)
    try:
        return with_values(rig, {field: value}) != rig
    except InputError as error:
        assert "\n" not in str(error)
        return False
