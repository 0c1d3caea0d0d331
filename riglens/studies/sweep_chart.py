"""The chart of a sweep: figures over one field, or over two; what lies within the noise is marked."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.figure import Figure

from riglens.core.errors import InputError
from riglens.core.shown_text import visible
from riglens.core.sweep.table import Doubles, better_of, doubles, header_of, main_figures, near_best
from riglens.widgets.theme import CLASS_COLOURS

if TYPE_CHECKING:
    from pyarrow import Table

INK, GREY = "#222222", "#6b6b6b"
STYLES = ("-", "--", "-.", ":")
NOISE = "band: noise floor (mounts off by 1 mm and 0.01°) + 2 SE of the change from the given rig"


def sweep_figure(table: Table, figures: Sequence[str] = ()) -> Figure:
    """Draw some figures of a sweep over its one or two fields; raise InputError as `require_drawable`."""
    header = header_of(table)
    require_drawable(header, figures)
    fields, names = header["design"]["fields"], list(figures) or main_figures(table)
    with mpl.rc_context({"font.size": 9.5, "text.parse_math": False}):
        figure = Figure(figsize=(7.2, 4.6) if len(fields) == 1 else (4.4 * len(names) + 0.4, 4.4), dpi=110)
        FigureCanvasAgg(figure)
        figure.set_layout_engine("constrained")
        rigs = ", ".join(dict.fromkeys(visible(one["name"]) for one in header["rigs"]))
        figure.suptitle(f"{rigs}: {len(table):,} rigs", color=INK)
        if len(fields) == 1:
            _draw_curves(figure.add_subplot(), table, header, names)
        else:
            for axes, name in zip(figure.subplots(1, len(names), squeeze=False)[0], names, strict=True):
                _draw_map(figure, axes, table, header, name)
    return figure


def require_drawable(header: Mapping[str, Any], figures: Sequence[str]) -> None:
    """Raise InputError when a sweep with this header has no chart of these figures."""
    fields, rigs = len(header["design"]["fields"]), len(header["rigs"])
    if fields not in (1, 2):
        raise InputError(f"needs one or two varied fields (got {fields})", "chart")
    if fields == 2 and rigs > 1:
        raise InputError(f"over two fields needs one rig (got {rigs})", "chart")
    for name in figures:
        if name not in header["noise_floor"]:
            raise InputError(f"must be a column of numbers of the table (got '{name}')", "figure")


def _draw_curves(axes: Axes, table: Table, header: dict[str, Any], names: Sequence[str]) -> None:
    (field, unit), rows = next(iter(header["design"]["fields"].items())), len(table) // len(header["rigs"])
    place = doubles(table, field)
    for number, name in enumerate(names):
        colour = CLASS_COLOURS.get(name.partition(".")[0], f"C{number}")
        value, noise = doubles(table, name), _noise(table, header, name)
        for rig, known in enumerate(header["rigs"]):
            own = np.arange(rig * rows, (rig + 1) * rows)
            own = own[np.argsort(place[own], kind="stable")]
            label = name if len(header["rigs"]) == 1 else f"{name}, {visible(known['name'])}"
            axes.plot(
                place[own], value[own], STYLES[rig % len(STYLES)], color=colour, label=label, marker="."
            )
            axes.fill_between(
                place[own], value[own] - noise[own], value[own] + noise[own], color=colour, alpha=0.18, lw=0
            )
    axes.set_xlabel(_title(field, unit), color=INK)
    axes.grid(True, color="#dddddd", lw=0.6)
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(loc="best", fontsize=8, frameon=False)
    axes.set_title(NOISE, fontsize=8, color=GREY, loc="left")


def _draw_map(figure: Figure, axes: Axes, table: Table, header: dict[str, Any], name: str) -> None:
    (x_name, x_unit), (y_name, y_unit) = header["design"]["fields"].items()
    x, y, value = (doubles(table, one) for one in (x_name, y_name, name))
    near, better = near_best(name, value, _noise(table, header, name)), better_of(name)
    xs, ys = np.unique(x), np.unique(y)
    if header["design"]["kind"] == "grid" and min(len(xs), len(ys)) > 1:
        order = np.lexsort((x, y))
        shaped = value[order].reshape(len(ys), len(xs))
        drawn: ScalarMappable = axes.pcolormesh(xs, ys, shaped, shading="nearest", cmap="viridis")
    else:
        drawn = axes.scatter(x, y, c=value, cmap="viridis", s=22)
    axes.scatter(x[near], y[near], s=60, facecolors="none", edgecolors="#e11d48", linewidths=1.6)
    figure.colorbar(drawn, ax=axes, location="bottom", shrink=0.9)
    axes.set_xlabel(_title(x_name, x_unit), color=INK)
    axes.set_ylabel(_title(y_name, y_unit), color=INK)
    marked = "" if better == "neither" else f", {better} is better\nmarked: within the noise of the best"
    axes.set_title(f"{name}{marked}", fontsize=8.5, color=INK)


def _noise(table: Table, header: Mapping[str, Any], name: str) -> Doubles:
    """Return the noise floor of a figure plus, where it has one, two standard errors of its change."""
    column, floor = f"{name}_change_se", float(header["noise_floor"].get(name, 0.0))
    return floor + (2.0 * doubles(table, column) if column in table.column_names else np.zeros(len(table)))


def _title(name: str, unit: str) -> str:
    return f"{visible(name)} [{unit}]" if unit else visible(name)
