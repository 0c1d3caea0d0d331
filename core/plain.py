"""Frozen data as JSON holds them."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from enum import Enum
from typing import Any

import numpy as np
from pydantic import BaseModel


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
