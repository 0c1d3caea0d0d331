"""The chart of a sweep shows the figures of its table, with their noise."""

from __future__ import annotations

import numpy as np
import pyarrow as pa
import pytest

from riglens.core.errors import InputError
from riglens.core.sweep.table import joined
from riglens.studies.sweep_chart import sweep_figure


def made(fields, kind, rigs=1):
    """A table of a sweep over some fields of a few rigs."""
    rng = np.random.default_rng(0)
    count = len(next(iter(fields.values())))
    columns = {"rig": ["r"] * count, **fields}
    for name in ("car", "bicycle", "pedestrian"):
        columns[f"{name}.lidar.on_target"] = rng.random(count)
        columns[f"{name}.lidar.on_target_change_se"] = np.full(count, 0.02)
    floor = {name: 0.01 for name in columns if name.endswith("on_target")}
    design = {"kind": kind, "fields": dict.fromkeys(fields, "m"), "rows": count}
    header = {"rigs": [{"name": f"r{n}"} for n in range(rigs)], "noise_floor": floor, "design": design}
    return joined([pa.table(columns)], header)


def test_curves_run_through_the_figures_in_the_order_of_the_field():
    table = made({"top.z": [2.0, 1.0, 3.0]}, "table")
    (axes,) = sweep_figure(table).axes
    assert axes.get_xlabel() == "top.z [m]"
    lines = {line.get_label(): line for line in axes.lines}
    assert len(lines) == 3
    values = np.array(table["car.lidar.on_target"].to_pylist())[[1, 0, 2]]
    assert lines["car.lidar.on_target"].get_xdata().tolist() == [1.0, 2.0, 3.0]
    assert np.array_equal(lines["car.lidar.on_target"].get_ydata(), values)
    band = axes.collections[0].get_paths()[0].vertices
    assert band[:, 1].max() == pytest.approx(values.max() + 0.01 + 2 * 0.02)


def test_rigs_have_curves_of_their_own():
    table = made({"top.z": [1.0, 2.0, 1.0, 2.0]}, "grid", rigs=2)
    (axes,) = sweep_figure(table, ["car.lidar.on_target"]).axes
    assert [len(line.get_xdata()) for line in axes.lines] == [2, 2]


@pytest.mark.parametrize("kind", ["grid", "sobol"])
def test_maps_of_two_fields_hold_every_rig(kind):
    x, y = np.meshgrid([1.0, 2.0, 3.0], [10.0, 20.0])
    table = made({"top.z": x.T.ravel(), "top.yaw": y.T.ravel()}, kind)
    figure = sweep_figure(table, ["car.lidar.on_target"])
    shown = np.ma.getdata(figure.axes[0].collections[0].get_array()).ravel()
    expected = np.array(table["car.lidar.on_target"].to_pylist())
    assert sorted(shown) == sorted(expected)
    if kind == "grid":
        assert np.array_equal(shown.reshape(2, 3), expected.reshape(3, 2).T)


@pytest.mark.parametrize(
    ("fields", "rigs", "figures", "part"),
    [
        ({"a": [1.0], "b": [1.0], "c": [1.0]}, 1, [], "one or two varied fields (got 3)"),
        ({"a": [1.0, 1.0], "b": [1.0, 1.0]}, 2, [], "needs one rig (got 2)"),
        ({"a": [1.0]}, 1, ["car.seen"], "got 'car.seen'"),
    ],
)
def test_what_cannot_be_drawn_is_refused(fields, rigs, figures, part):
    with pytest.raises(InputError) as caught:
        sweep_figure(made(fields, "grid", rigs), figures)
    assert part in str(caught.value)
