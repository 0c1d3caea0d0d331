"""Numbers of the object table: rounded as Python rounds them, to the last bit."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from riglens.core.targets.object_table import rounded

ties = st.integers(-(10**12), 10**12).map(lambda whole: (whole + 0.5) / 1e9)


@given(st.lists(st.one_of(st.floats(-1e300, 1e300), st.floats(-200.0, 200.0), ties), min_size=1))
def test_numbers_are_rounded_as_python_rounds_them(values: list[float]) -> None:
    expected = [round(value, 9) for value in values]
    found = rounded(np.array(values)).tolist()
    assert found == expected
    assert [math.copysign(1.0, one) for one in found] == [math.copysign(1.0, one) for one in expected]


@pytest.mark.parametrize("value", [0.5e-9, 1.5e-9, 2.5e-9, 59.123456789500005, 2.0**52 / 1e9, -0.0])
def test_ties_are_rounded_as_python_rounds_them(value: float) -> None:
    near = np.array([value, np.nextafter(value, 1e9), np.nextafter(value, -1e9)])
    assert rounded(near).tolist() == [round(one, 9) for one in near.tolist()]
