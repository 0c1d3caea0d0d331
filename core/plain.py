"""Frozen data: the base of validated ones, and any as JSON holds them."""

from __future__ import annotations

import difflib
import json
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from enum import Enum
from typing import Annotated, Any, Self, get_origin

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, model_validator
from pydantic_core import PydanticCustomError

Degrees = Annotated[float, Field(allow_inf_nan=False, ge=-1e6, le=1e6)]
"""Thousands of turns, and still exact to 1e-10 degrees."""


class Frozen(BaseModel):
    """Immutable, strict, no unknown keys; fields are addressed by the names of the YAML file."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, populate_by_name=True)

    @model_validator(mode="before")
    @classmethod
    def _known_fields(cls, data: Any) -> Any:
        """Refuse a field that does not exist with the name of the nearest one, which pydantic's own check lacks.

        Lists and arrays become tuples, where a field is no list itself, and numbers of numpy those of Python.
        """
        fields = cls.model_fields
        for key in data if isinstance(data, dict) else ():
            if key not in fields:
                known = [str(info.alias or name) for name, info in fields.items()]
                if key not in known:
                    raise _unknown_field(str(key), known)
        if not isinstance(data, dict):
            return data
        kept = {name for name, info in fields.items() if get_origin(info.annotation) is list}
        return {key: value if key in kept else _plain(value) for key, value in data.items()}

    def replace(self, **changes: object) -> Self:
        """Return a validated copy with some fields changed; raise pydantic's ValidationError where one does not fit."""
        fields = {name: getattr(self, name) for name in type(self).model_fields}
        return type(self)(**(fields | changes))


def _plain(value: Any) -> Any:
    if hasattr(value, "tolist"):
        value = value.tolist()
    return tuple(_plain(one) for one in value) if isinstance(value, list) else value


def _unknown_field(field: str, known: list[str]) -> PydanticCustomError:
    close = difflib.get_close_matches(field, known, n=1)
    hint = f" (did you mean '{close[0]}'?)" if close else f"; known are {', '.join(known)}"
    return PydanticCustomError(
        "unknown_field", "'{field}' is not a known field{hint}", {"field": field, "hint": hint}
    )


def to_plain(value: Any, *names: str) -> Any:
    """Return a value as dicts, lists, numbers and texts, in full precision; of an object all fields, or those named."""
    if names:
        return {name: to_plain(getattr(value, name)) for name in names}
    if is_dataclass(value):
        return {field.name: to_plain(getattr(value, field.name)) for field in fields(value)}
    if isinstance(value, BaseModel):
        return value.model_dump(by_alias=True)
    if isinstance(value, Mapping):
        return {str(key): to_plain(one) for key, one in value.items()}
    if isinstance(value, (list, tuple)):
        return [to_plain(one) for one in value]
    if isinstance(value, (np.ndarray, np.generic)):
        return value.tolist()
    return value.value if isinstance(value, Enum) else value


def to_text(document: Mapping[str, Any]) -> str:
    """Return plain data as JSON ending in a newline; refuse numbers that JSON cannot say."""
    return json.dumps(document, indent=1, allow_nan=False) + "\n"
