"""Designs: combinations, Sobol points and tables, and the rigs they make."""

from __future__ import annotations

import numpy as np
import pytest

from riglens.core.errors import InputError
from riglens.core.sweep import design
from riglens.core.sweep.design import Span, Sweep, grid, sobol, table
from tests.core.sweep.test_fields import RIG


def test_a_grid_holds_all_combinations_the_last_field_fastest():
    found = grid([Span.parsed("top.z=1.5:1.7:3"), Span.parsed("top.yaw=10:-10:2")])
    assert found.names == ("top.z", "top.yaw")
    assert found.values.tolist() == [[1.5, 10], [1.5, -10], [1.6, 10], [1.6, -10], [1.7, 10], [1.7, -10]]
    assert grid([]).values.shape == (1, 0)


@pytest.mark.parametrize(
    "text", ["top.z", "top.z=1", "top.z=1:2:3:4", "=1:2:3", "top.z=a:2:3", "top.z=1:2:x", "top.z=1:inf:3"]
)
def test_what_is_no_span_is_refused(text):
    with pytest.raises(InputError, match=r"^vary "):
        Span.parsed(text)


def test_numbers_of_values_are_checked(monkeypatch):
    with pytest.raises(InputError, match=r"≥ 1 \(got 0\)"):
        Span.parsed("top.z=1:2:0")
    with pytest.raises(InputError, match="unless FROM = TO"):
        Span.parsed("top.z=1:2:1")
    assert grid([Span.parsed("top.z=2:2:1")]).values.tolist() == [[2.0]]
    with pytest.raises(InputError, match="lacks the number"):
        grid([Span.parsed("top.z=1:2")])
    with pytest.raises(InputError, match=r"1 to 1,000,000 rigs \(got 10,000,000,000\)"):
        grid([Span("top.z", 0.0, 1.0, 100_000), Span("top.x", 0.0, 1.0, 100_000)])


def test_sobol_points_are_reproducible_and_more_begin_with_fewer():
    spans = [Span("top.z", 1.5, 2.0), Span("top.yaw", 30.0, -30.0)]
    few, many = sobol(spans, 10, 3).values, sobol(spans, 100, 3).values
    assert np.array_equal(many[:10], few) and np.array_equal(sobol(spans, 10, 3).values, few)
    assert not np.array_equal(sobol(spans, 10, 4).values, few)
    assert ((many >= [1.5, -30.0]) & (many <= [2.0, 30.0])).all()
    assert len(np.unique(np.floor((many[:64, 0] - 1.5) / 0.5 * 64))) == 64  # one in each of 64 parts
    with pytest.raises(InputError, match=r"^sobol must be an integer"):
        sobol(spans, 0)
    with pytest.raises(InputError, match=r"FIELD=FROM:TO"):
        sobol([Span("top.z", 0.0, 1.0, 3)], 4)
    with pytest.raises(InputError, match=r"^sobol needs fields"):
        sobol([], 4)


@pytest.mark.parametrize("ending", ["csv", "parquet"])
def test_a_table_gives_a_rig_for_each_row(tmp_path, ending):
    import pyarrow as pa
    from pyarrow import csv, parquet

    content, path = pa.table({"top.z": [1.5, 1.75], "top.yaw": [3, -4]}), tmp_path / f"rigs.{ending}"
    (csv.write_csv if ending == "csv" else parquet.write_table)(content, path)
    sweep = Sweep.of([RIG], table(path))
    assert [sweep.rig(row).sensor("top").position[2] for row in range(2)] == [1.5, 1.75]
    assert [sweep.rig(row).sensor("top").rpy_deg[2] for row in range(2)] == [3.0, -4.0]


@pytest.mark.parametrize(
    ("text", "part"),
    [
        ("top.z,top.yaw\n1.5,a\n", "column 'top.yaw' must hold finite numbers"),
        ("top.z\n1.5\n\n2.0,3\n", "not a table"),
        ("top.z\n", "1 to 1,000,000 rigs"),
        ("", "not a table"),
    ],
)
def test_a_table_that_cannot_be_used_is_one_line(tmp_path, text, part):
    path = tmp_path / "rigs.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError) as caught:
        table(path)
    assert part in str(caught.value) and "\n" not in str(caught.value)
    with pytest.raises(InputError, match="no such file"):
        table(tmp_path / "none.csv")


def test_a_table_has_limits(tmp_path, monkeypatch):
    import pyarrow as pa
    from pyarrow import parquet

    path = tmp_path / "rigs.parquet"
    parquet.write_table(pa.table({"top.z": [1.5, 1.75, 2.0]}), path)
    monkeypatch.setattr(design, "MAX_RIGS", 2)
    with pytest.raises(InputError, match=r"1 to 2 rigs \(got 3\)"):
        table(path)
    monkeypatch.setattr(design, "MAX_BYTES", 100)
    with pytest.raises(InputError, match="must be at most"):
        table(path)


def test_parts_of_a_sweep_are_its_rows():
    sweep = Sweep.of([RIG.replace(name="a"), RIG.replace(name="b")], grid([Span("top.z", 1.0, 2.0, 5)]))
    whole = [sweep.rig(row) for row in range(len(sweep))]
    part = sweep.part(range(3, 8))
    assert [part.rig(row) for row in range(len(part))] == whole[3:8]
    assert [rig.name for rig in whole] == ["a"] * 5 + ["b"] * 5


def test_a_value_that_fits_in_no_rig_is_found_before_the_work(monkeypatch):
    monkeypatch.setattr(design, "CHECKED", 2)
    with pytest.raises(InputError, match=r"'top.range_m.1' cannot be"):
        Sweep.of([RIG], grid([Span("top.range_m.1", 0.1, 100.0, 50)]))


@pytest.mark.parametrize(("field", "value"), [("top.range_m.1", 0.1), ("top.range_m.0", 200.0)])
def test_the_least_and_the_greatest_value_are_tried_before_the_work_wherever_they_are(
    monkeypatch, field, value
):
    monkeypatch.setattr(design, "CHECKED", 1)  # of others, the first row alone
    values = np.array([[50.0], [60.0], [value], [70.0]])
    with pytest.raises(InputError, match=rf"'{field}' cannot be"):
        Sweep.of([RIG], design.Design("table", (field,), values))
