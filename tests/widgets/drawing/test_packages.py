"""Modules that stand in for others until somebody needs them."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import pytest

from riglens.widgets.drawing.packages import StandIn, standing_in, when_called

REAL = "wide = 2\ndef double(number):\n    return wide * number\n"


@pytest.fixture
def real(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    """Name of a module that nobody has loaded; it is forgotten afterwards."""
    (tmp_path / "slow_to_load.py").write_text(REAL, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    yield "slow_to_load"
    sys.modules.pop("slow_to_load", None)


def test_an_import_finds_the_stand_in_and_loads_nothing(real):
    with standing_in(StandIn(real)):
        import slow_to_load
    assert isinstance(slow_to_load, StandIn)
    assert real not in sys.modules


def test_a_name_that_is_asked_for_comes_from_the_real_module(real):
    with standing_in(StandIn(real)):
        import slow_to_load
    assert slow_to_load.wide == 2
    assert sys.modules[real] is not slow_to_load and sys.modules[real].wide == 2


def test_a_name_that_nobody_lends_comes_from_the_real_module_at_once(real):
    with standing_in(StandIn(real, ModuleType("lender"))):
        from slow_to_load import wide
    assert wide == 2


def test_names_that_are_given_or_lent_load_nothing(real):
    lender = ModuleType("lender")
    lender.wide = 3
    with standing_in(StandIn(real, lender, double=when_called(real, "double"))):
        from slow_to_load import double, wide
    assert wide == 3 and real not in sys.modules
    assert double(5) == 10, "the real function, loaded by the call"


def test_a_module_that_is_loaded_keeps_its_place(real):
    import slow_to_load

    with standing_in(StandIn(real)):
        assert sys.modules[real] is slow_to_load
    assert sys.modules[real] is slow_to_load
