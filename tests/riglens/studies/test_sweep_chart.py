"""The chart of a sweep shows the figures of its table, with their noise."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest
from pyarrow import parquet

from riglens.app.commands.sweep import print_figures
from riglens.core.errors import InputError
from riglens.core.sweep.table import header_of, joined
from riglens.studies.sweep_chart import sweep_figure


def made(fields, kind, rigs=1):
    """A table of a sweep over some fields of a few rigs."""
    rng = np.random.default_rng(0)
    count = len(next(iter(fields.values())))
    columns = {"rig": ["r"] * count, **fields}
    for name in ("car", "bicycle", "pedestrian"):
        columns[f"{name}.lidar.share_5"] = rng.random(count)
        columns[f"{name}.lidar.share_5_change_se"] = np.full(count, 0.02)
    floor = {name: 0.01 for name in columns if name.endswith("share_5")}
    design = {"kind": kind, "fields": dict.fromkeys(fields, "m"), "rows": count}
    header = {"rigs": [{"name": f"r{n}"} for n in range(rigs)], "noise_floor": floor, "design": design}
    return joined([pa.table(columns)], header)


def test_curves_run_through_the_figures_in_the_order_of_the_field():
    table = made({"top.z": [2.0, 1.0, 3.0]}, "table")
    (axes,) = sweep_figure(table).axes
    assert axes.get_xlabel() == "top.z [m]"
    lines = {line.get_label(): line for line in axes.lines}
    assert len(lines) == 3
    values = np.array(table["car.lidar.share_5"].to_pylist())[[1, 0, 2]]
    assert lines["car.lidar.share_5"].get_xdata().tolist() == [1.0, 2.0, 3.0]
    assert np.array_equal(lines["car.lidar.share_5"].get_ydata(), values)
    band = axes.collections[0].get_paths()[0].vertices
    assert band[:, 1].max() == pytest.approx(values.max() + 0.01 + 2 * 0.02)


def test_rigs_have_curves_of_their_own():
    table = made({"top.z": [1.0, 2.0, 1.0, 2.0]}, "grid", rigs=2)
    (axes,) = sweep_figure(table, ["car.lidar.share_5"]).axes
    assert [len(line.get_xdata()) for line in axes.lines] == [2, 2]


def test_each_figure_has_a_panel_that_says_its_direction_and_rings_what_is_best():
    header = header_of(made({"top.z": [1.0, 2.0, 3.0]}, "table"))
    columns = {
        "car.neither": [0.3, 0.1, 0.2],
        "bicycle.neither": [0.1, 0.3, 0.2],
        "blind_m2": [7.0, 7.1, 7.2],
    }
    header["noise_floor"] = {"car.neither": 0.01, "bicycle.neither": 0.01, "blind_m2": 0.5}
    table = joined([pa.table({"top.z": [1.0, 2.0, 3.0], **columns})], header)
    missed, blind = sweep_figure(table, list(columns)).axes
    assert [len(missed.lines), len(blind.lines)] == [2, 1]
    assert all("less" in axes.get_title() for axes in (missed, blind))
    rings = [one.get_offsets().tolist() for axes in (missed, blind) for one in axes.collections[1::2]]
    assert rings == [[[2.0, 0.1]], [[1.0, 0.1]], []]


@pytest.mark.parametrize("kind", ["grid", "sobol"])
def test_maps_of_two_fields_hold_every_rig(kind):
    x, y = np.meshgrid([1.0, 2.0, 3.0], [10.0, 20.0])
    table = made({"top.z": x.T.ravel(), "top.yaw": y.T.ravel()}, kind)
    figure = sweep_figure(table, ["car.lidar.share_5"])
    shown = np.ma.getdata(figure.axes[0].collections[0].get_array()).ravel()
    expected = np.array(table["car.lidar.share_5"].to_pylist())
    assert sorted(shown) == sorted(expected)
    if kind == "grid":
        assert np.array_equal(shown.reshape(2, 3), expected.reshape(3, 2).T)


@pytest.mark.parametrize(
    ("column", "marked"),
    [
        ("car.lidar.share_5", {3.0}),
        ("car.neither", {0.0}),
        ("blind_m2", {0.0}),
        ("car.s_ms", set()),
        ("car.objects", set()),
    ],
)
def test_a_map_marks_what_is_best_in_the_direction_of_the_figure(column, marked):
    fields = {"top.z": [1.0, 1.0, 2.0, 2.0], "top.yaw": [10.0, 20.0, 10.0, 20.0]}
    values = [2.0, None, 3.0, 0.0]
    header = header_of(made(fields, "sobol"))
    header["noise_floor"][column] = 0.5
    table = joined([pa.table({**fields, column: values})], header)
    rings = sweep_figure(table, [column]).axes[0].collections[1].get_offsets().tolist()
    places = list(zip(fields["top.z"], fields["top.yaw"], strict=True))
    assert {values[places.index(tuple(place))] for place in rings} == marked


def test_figures_that_only_a_later_rig_has_can_be_drawn(riglens, boxes, tmp_path):
    lidar = "{name: top, kind: lidar, model: generic-16, position: [0, 0, 1.6]}"
    radar = "{name: grille, kind: radar, model: generic-radar, position: [2.2, 0, 0.5]}"
    for name, sensors in (("plain", [lidar]), ("radar", [lidar, radar])):
        text = "\n".join(["riglens: 1", f"name: {name}", "sensors:", *(f"  - {one}" for one in sensors)])
        (tmp_path / f"{name}.yaml").write_text(text, encoding="utf-8")
    out, rigs = tmp_path / "out.parquet", [tmp_path / f"{name}.yaml" for name in ("plain", "radar")]
    words = ("--boxes", boxes, "--compute", "targets", "--vary", "top.z=1.6:1.8:2", "--workers", 1)
    words = (*words, "--figure", "car.radar.share", "--chart", tmp_path / "out.png", "--out", out)
    found = riglens("sweep", *rigs, *words)
    assert found.code == 0, found.err
    table = parquet.read_table(out)
    assert table["car.radar.share"].null_count == 2 and "car.radar.share" in header_of(table)["noise_floor"]
    lines = sweep_figure(table, ["car.radar.share"]).axes[0].lines
    assert [np.isnan(line.get_ydata()).all() for line in lines] == [True, False]


def test_the_terminal_names_the_rig_that_is_best(capsys):
    table = made({"top.z": [1.0, 2.0, 3.0]}, "table")
    header = header_of(table)
    header["noise_floor"]["blind_m2"] = 0.1
    table = joined([table.append_column("blind_m2", pa.array([7.0, 5.0, 9.0]))], header)
    print_figures(table, Path("out.parquet"))
    (line,) = (line for line in capsys.readouterr().out.splitlines() if "blind_m2" in line)
    assert line.rstrip().endswith("top.z 2")


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
