"""The chart of a sweep: figures over one field, or over two; what lies within the noise is marked."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.figure import Figure
from numpy.typing import NDArray

from riglens.core.errors import InputError
from riglens.core.shown_text import visible
from riglens.core.sweep.table import Doubles, better_of, doubles, header_of, main_figures, near_best
from riglens.widgets.theme import CLASS_COLOURS

if TYPE_CHECKING:
    from pyarrow import Table

INK, GREY = "#222222", "#6b6b6b"
STYLES = ("-", "--", "-.", ":")
MOST_COLUMNS = 4
BAND = "band: noise floor (mounts off by 1 mm and 0.01°) + 2 SE of the change from the given rig"
MARKS = "rings: within the noise of the best, unless all are"


def sweep_figure(table: Table, figures: Sequence[str] = ()) -> Figure:
    """Draw some figures of a sweep over its one or two fields, a panel for each; curves of classes share the panel of
    their figure. Raise InputError as `require_drawable`."""
    header = header_of(table)
    require_drawable(header, figures)
    fields, names = header["design"]["fields"], list(figures) or main_figures(table)
    panels = {name: [name] for name in names}
    if len(fields) == 1:
        panels = {_measure(name): [one for one in names if _measure(one) == _measure(name)] for name in names}
    rows = math.ceil(len(panels) / MOST_COLUMNS)
    columns = math.ceil(len(panels) / rows)
    size = (7.2, 4.6) if (len(fields), len(panels)) == (1, 1) else (4.4 * columns + 0.4, 4.0 * rows + 0.6)
    with mpl.rc_context({"font.size": 9.5, "text.parse_math": False}):
        figure = Figure(figsize=size, dpi=110)
        FigureCanvasAgg(figure)
        figure.set_layout_engine("constrained")
        rigs = ", ".join(dict.fromkeys(visible(one["name"]) for one in header["rigs"]))
        figure.suptitle(f"{rigs}: {len(table):,} rigs", color=INK)
        for place, (title, shown) in enumerate(panels.items(), 1):
            axes = figure.add_subplot(rows, columns, place)
            if len(fields) == 1:
                _draw_curves(axes, table, header, shown)
            else:
                _draw_map(figure, axes, table, header, title)
            better = better_of(shown[0])
            axes.set_title(
                title if better == "neither" else f"{title}: {better} is better", fontsize=9, color=INK
            )
        band = f"{BAND}; " if len(fields) == 1 else ""
        figure.supxlabel(f"{band}{MARKS}", fontsize=8, color=GREY)
    return figure


def _measure(column: str) -> str:
    """Return the name of a column without its class."""
    first, _, rest = column.partition(".")
    return rest if first in CLASS_COLOURS else column


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
        near = near_best(name, value, noise)
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
        _ring(axes, place, value, near)
    axes.set_xlabel(_title(field, unit), color=INK)
    axes.grid(True, color="#dddddd", lw=0.6)
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(loc="best", fontsize=8, frameon=False)


def _draw_map(figure: Figure, axes: Axes, table: Table, header: dict[str, Any], name: str) -> None:
    (x_name, x_unit), (y_name, y_unit) = header["design"]["fields"].items()
    x, y, value = (doubles(table, one) for one in (x_name, y_name, name))
    near = near_best(name, value, _noise(table, header, name))
    xs, ys = np.unique(x), np.unique(y)
    if header["design"]["kind"] == "grid" and min(len(xs), len(ys)) > 1:
        order = np.lexsort((x, y))
        shaped = value[order].reshape(len(ys), len(xs))
        drawn: ScalarMappable = axes.pcolormesh(xs, ys, shaped, shading="nearest", cmap="viridis")
    else:
        drawn = axes.scatter(x, y, c=value, cmap="viridis", s=22)
    _ring(axes, x, y, near)
    figure.colorbar(drawn, ax=axes, location="right")
    axes.set_xlabel(_title(x_name, x_unit), color=INK)
    axes.set_ylabel(_title(y_name, y_unit), color=INK)


def _ring(axes: Axes, x: Doubles, y: Doubles, near: NDArray[np.bool_]) -> None:
    """Draw rings around the points that are near, unless all of them are."""
    some = near & ~near.all()
    axes.scatter(x[some], y[some], s=60, facecolors="none", edgecolors="#e11d48", linewidths=1.6, zorder=3)


def _noise(table: Table, header: Mapping[str, Any], name: str) -> Doubles:
    """Return the noise floor of a figure plus, where it has one, two standard errors of its change."""
    column, floor = f"{name}_change_se", float(header["noise_floor"].get(name, 0.0))
    return floor + (2.0 * doubles(table, column) if column in table.column_names else np.zeros(len(table)))


def _title(name: str, unit: str) -> str:
    return f"{visible(name)} [{unit}]" if unit else visible(name)
