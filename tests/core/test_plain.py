"""Frozen data become what JSON holds, without a digit less."""

from __future__ import annotations

import json
from dataclasses import dataclass
from enum import Enum

import numpy as np

from riglens.core.plain import to_plain
from riglens.core.rig.model import KannalaBrandt


class Tone(Enum):
    DARK = "dark"


@dataclass(frozen=True)
class Inner:
    share: np.float64
    tone: Tone = Tone.DARK


@dataclass(frozen=True)
class Outer:
    name: str
    inner: tuple[Inner, ...]
    table: np.ndarray
    missing: None = None

    @property
    def doubled(self) -> str:
        return 2 * self.name


def test_data_of_all_kinds_become_what_json_holds_in_the_order_of_their_fields():
    found = to_plain(Outer("a", (Inner(np.float64(0.1) + 0.2),), np.array([[1, 2]])))
    assert json.dumps(found) == (
        '{"name": "a", "inner": [{"share": 0.30000000000000004, "tone": "dark"}], "table": [[1, 2]], "missing": null}'
    )
    assert type(found["inner"][0]["share"]) is float and type(found["table"][0][0]) is int


def test_fields_and_properties_may_be_named_in_an_order_of_ones_own():
    assert list(to_plain(Outer("a", (), np.zeros(0)), "missing", "doubled").items()) == [
        ("missing", None),
        ("doubled", "aa"),
    ]


def test_models_are_written_by_the_names_of_their_files():
    found = to_plain({"lens": KannalaBrandt(k1=0.5)})
    assert found == {"lens": {"model": "kannala_brandt", "k1": 0.5, "k2": 0.0, "k3": 0.0, "k4": 0.0}}
