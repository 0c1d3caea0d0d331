"""Kinds of sensors as values of options; apart from other options, whose help needs no sensors."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

from riglens.core.sensors.registry import kind_names

if TYPE_CHECKING:
    KindChoice = str
    SeenByChoice = str
else:
    KindChoice = Literal[kind_names()]
    SeenByChoice = Literal[("any", *kind_names())]
