"""Kinds of sensors in the order in which they are shown: built-in ones, then those of installed packages."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from functools import cache
from typing import Annotated, Any

from pydantic import AfterValidator, ValidationInfo
from pydantic_core import PydanticCustomError, PydanticKnownError

from riglens.core.extensions import extended
from riglens.core.sensors.base import Sensor
from riglens.core.sensors.camera import CAMERA
from riglens.core.sensors.kind import SensorKind
from riglens.core.sensors.lidar import LIDAR
from riglens.core.sensors.radar import RADAR
from riglens.core.sensors.ultrasonic import ULTRASONIC

AnyKind = SensorKind[Any]
BUILT_IN: dict[str, AnyKind] = {kind.name: kind for kind in (LIDAR, CAMERA, RADAR, ULTRASONIC)}
"""The kinds that come with RigLens, by name."""


@cache
def _kinds() -> dict[str, AnyKind]:
    return extended("riglens.sensors", BUILT_IN, SensorKind)


def kinds() -> tuple[AnyKind, ...]:
    """Return every kind; LiDARs first, as in lists of sensors."""
    return tuple(_kinds().values())


def further_kinds(present: Iterable[str]) -> tuple[AnyKind, ...]:
    """Return the kinds among those present that are neither LiDARs nor cameras: their hits are counted kind by kind."""
    there = set(present) - {LIDAR.name, CAMERA.name}
    return tuple(kind for kind in kinds() if kind.name in there)


def shown_kinds(present: Iterable[str]) -> tuple[AnyKind, ...]:
    """Return the kinds that have rows in tables: those that S-MS weighs, and those of the sensors that are there."""
    there = set(present)
    return tuple(kind for kind in kinds() if kind.score_weight != 0.0 or kind.name in there)


def kind_names() -> tuple[str, ...]:
    """Return the name of every kind; its place is its row in sums and sets of voxels."""
    return tuple(_kinds())


def kind_named(name: object) -> AnyKind | None:
    """Return the kind of that name, None when there is none."""
    return _kinds().get(name) if isinstance(name, str) else None


def kind_of(sensor: Sensor | str) -> AnyKind:
    """Return the kind of a sensor, or of a name that is known to be one."""
    return _kinds()[sensor if isinstance(sensor, str) else sensor.kind]


@contextmanager
def registered(kind: AnyKind) -> Iterator[None]:
    """Know one more kind for a while: for tests, and for trying one out."""
    if kind.name in _kinds():
        raise ValueError(f"kind '{kind.name}' already exists")
    _kinds()[kind.name] = kind
    try:
        yield
    finally:
        del _kinds()[kind.name]


def one_of(names: Iterable[str], name: str) -> str:
    """Return a name if it is one of some, in the words of a pydantic Literal if not."""
    if name in (known := tuple(names)):
        return name
    *first, last = (f"'{each}'" for each in known)
    raise PydanticCustomError("literal_error", f"Input should be {', '.join(first)} or {last}")


KindName = Annotated[str, AfterValidator(lambda name: one_of(kind_names(), name))]
"""The name of a kind, in a pydantic model."""


def validated_sensor(value: object, info: ValidationInfo) -> Sensor:
    """Return a sensor from its fields, by the model of its `kind`, or one that is a sensor already; for pydantic."""
    if isinstance(value, Sensor):
        return value
    if not isinstance(value, Mapping):
        raise PydanticKnownError("dict_type")
    kind = kind_named(value.get("kind"))
    if kind is None:
        raise ValueError(f"kind must be {' or '.join(_kinds())}")
    sensor: Sensor = kind.model.model_validate(value, by_alias=True, by_name=False, context=info.context)
    return sensor
