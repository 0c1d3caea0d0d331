"""Every option accepts what its message says that it accepts, up to the limits and not beyond."""

from __future__ import annotations

import dataclasses
import importlib
import math
import pkgutil
import re
from collections.abc import Iterator
from typing import Any, NamedTuple

import pytest

import riglens
from riglens.core.errors import InputError
from riglens.core.optimise.additions import Additions

NUMBER = r"(2\^63 - 1|-?[\d.,]+(?:e[+-]?\d+)?)"
LOW = re.compile(rf"(between|from|at least|≥|above) {NUMBER}")
HIGH = re.compile(rf"(and|to|at most|below) {NUMBER}")
WITH_ARGUMENTS = (Additions(("generic-16",)),)
"""Options that have no defaults for all of their fields."""


class Limits(NamedTuple):
    """A field of some options and the range in its message, as the field's type."""

    options: Any
    field: str
    kind: type
    low: tuple[float, bool] | None
    high: tuple[float, bool] | None


def all_options() -> Iterator[Any]:
    """Options of the library, with their defaults."""
    for found in pkgutil.walk_packages(riglens.__path__, "riglens."):
        if found.name.startswith(("riglens.app", "riglens.widgets")):
            continue
        for made in vars(importlib.import_module(found.name)).values():
            if isinstance(made, type) and dataclasses.is_dataclass(made) and made.__module__ == found.name:
                try:
                    yield made()
                except TypeError:
                    continue
    yield from WITH_ARGUMENTS


def refusal(options: Any, field: str, value: float) -> str:
    """The message about the range of a field; empty where none is given."""
    try:
        dataclasses.replace(options, **{field: value})
    except InputError as error:
        message = str(error).partition(" (got")[0]
        return message if LOW.search(message) or HIGH.search(message) else ""
    return ""


def limit(pattern: re.Pattern[str], message: str) -> tuple[float, bool] | None:
    """The number in a message and whether it is accepted itself."""
    found = pattern.search(message)
    if found is None:
        return None
    text = found[2].rstrip(".,").replace(",", "").replace("2^63 - 1", str(2**63 - 1))
    return (int(text) if text.isdecimal() else float(text)), found[1] not in ("above", "below")


def all_limits() -> Iterator[Limits]:
    """The fields whose ranges messages name."""
    for options in all_options():
        for field in dataclasses.fields(options):
            value = getattr(options, field.name)
            if field.init and isinstance(value, int | float) and not isinstance(value, bool):
                message = refusal(options, field.name, type(value)(-(10**9)))
                if message:
                    low, high = limit(LOW, message), limit(HIGH, message)
                    yield Limits(options, field.name, type(value), low, high)


LIMITS = list(all_limits())


@pytest.mark.parametrize("one", LIMITS, ids=lambda one: f"{type(one.options).__name__}.{one.field}")
def test_what_a_message_calls_acceptable_is_accepted_and_no_more(one: Limits) -> None:
    assert len(LIMITS) > 25
    for end, outwards in ((one.low, -1.0), (one.high, 1.0)):
        if end is not None:
            value, is_accepted = one.kind(end[0]), end[1]
            beyond = value + int(outwards) if one.kind is int else math.nextafter(value, outwards * math.inf)
            assert bool(refusal(one.options, one.field, value)) != is_accepted
            assert refusal(one.options, one.field, beyond)
    assert one.kind is int or refusal(one.options, one.field, math.nan)
