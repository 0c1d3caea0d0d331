"""Heatmap draped on the ground: the cells above each place as one colour, smooth between places, clear where low."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pyvista as pv
from numpy.typing import NDArray
from vtkmodules.vtkRenderingCore import vtkProp, vtkRenderer

from riglens.core.view.heatmap_data import HeatmapData, Values
from riglens.widgets.drawing.actors import hidden, rgba_actor, show_mesh
from riglens.widgets.heatmap.scale import (
    CLEAR_UP_TO,
    DEFAULT_LOOK,
    OPAQUE,
    OPAQUE_OVER,
    HeatLook,
    colour_rows,
    colours,
    draped_ramp,
    in_slice,
    is_clear_where_low,
    on_scale,
)
from riglens.widgets.theme import DARK, Palette

Grid = NDArray[np.float64]
_HEIGHT_M = 0.012
TOP_SHARE = 0.995
"""Quantile of the places with a value that has the strongest colour."""


class Places(NamedTuple):
    """Places of cells on the ground: the place (m,) of each in a grid (nx, ny), whose first middle is `low_m`."""

    of_cell: NDArray[np.int64]
    shape: tuple[int, int]
    low_m: NDArray[np.float64]


def places_of(data: HeatmapData) -> Places:
    """Return the places of a heatmap's cells, with an empty one around them."""
    if not len(data.centres_m):
        return Places(np.zeros(0, np.int64), (0, 0), np.zeros(2))
    flat = data.centres_m[:, :2].astype(np.float64)
    low = flat.min(axis=0) - data.cell_m
    steps = np.rint((flat - low) / data.cell_m).astype(np.int64)
    nx, ny = (steps.max(axis=0) + 2).tolist()
    return Places(steps[:, 0] * ny + steps[:, 1], (nx, ny), low)


def draped(data: HeatmapData, look: HeatLook, places: Places) -> tuple[Grid, Grid]:
    """Return the value and the strength, 0 to 1, of each place, (nx, ny).

    Entropies and changes are summed over the height, of other values the highest counts; of steps the one with most
    weight.
    """
    nx, ny = places.shape
    rows = in_slice(look, data.centres_m[:, 2])
    where, values = places.of_cell[rows], data.values[rows].astype(np.float64)

    def summed(parts: Grid) -> Grid:
        return np.asarray(np.bincount(where, parts, nx * ny), np.float64).reshape(nx, ny)

    if data.scale in ("steps", "level"):
        weights = np.ones(len(rows)) if data.weights is None else data.weights[rows].astype(np.float64)
        held = summed(weights)
        if data.scale == "level":
            shown = np.divide(summed(weights * values), held, out=np.zeros((nx, ny)), where=held > 0.0)
        else:
            votes = [summed(weights * (values == step)) for step in range(len(data.labels))]
            shown = np.argmax(votes, axis=0).astype(np.float64)
        return shown, _strength(held, look)
    if data.unit == "nat" or data.scale == "change":
        shown = _smooth(summed(values))
    else:
        most = np.zeros(nx * ny)
        np.maximum.at(most, where, values - data.vmin)
        shown = _smooth(most.reshape(nx, ny))
    return shown, _strength(np.abs(shown), look)


def _strength(sizes: Grid, look: HeatLook) -> Grid:
    """Return sizes as shares of nearly the largest of them."""
    present = sizes[sizes > 0.0]
    top = float(np.quantile(present, TOP_SHARE)) if present.size else 1.0
    return np.asarray(on_scale((sizes / max(top, 1e-30)).astype(np.float32), look.log), np.float64)


def _smooth(values: Grid) -> Grid:
    """Return values mixed with their neighbours', so that no cell shows as a square."""
    for axis in (0, 1):
        before, after = np.roll(values, 1, axis=axis), np.roll(values, -1, axis=axis)  # the rim is empty
        values = 0.5 * values + 0.25 * (before + after)
    return values


def drape_colours(
    data: HeatmapData, look: HeatLook, values: Grid, strengths: Grid, palette: Palette
) -> NDArray[np.uint8]:
    """Return the colours (nx, ny, 4) of places, clear where the value is low."""
    rgba, shares = np.empty((*values.shape, 4), np.uint8), strengths
    if data.is_loss:
        shares = values / data.vmax
    if is_clear_where_low(data):
        rgba[..., :3] = 255.0 * draped_ramp(shares, palette)
    else:
        rows = colour_rows(data.scale, values.astype(np.float32), strengths.astype(np.float32), data.vmax)
        rgba[..., :3] = colours(data.scale)[rows]
    start = max(CLEAR_UP_TO if data.scale == "ramp" else 0.04, look.threshold)
    most = min(1.0, OPAQUE * look.opacity / DEFAULT_LOOK.opacity)
    alpha = most * np.clip((strengths - start) / OPAQUE_OVER, 0.0, 1.0)
    if data.is_loss:
        alpha = alpha * np.clip((shares - CLEAR_UP_TO) / OPAQUE_OVER, 0.0, 1.0)
    rgba[..., 3] = 255.0 * alpha
    return rgba


class DrapeLayer:
    """The drape of a scene: one mesh of which only the colours change while the cells stay the same."""

    def __init__(self, renderer: vtkRenderer) -> None:
        self._actor = hidden(renderer, rgba_actor(pv.PolyData(), "rgba"))
        self._actor.force_translucent = True
        self._cells: tuple[Values, Places, NDArray[np.float32]] | None = None

    @property
    def prop(self) -> vtkProp:
        """Return the prop that is drawn."""
        return self._actor

    def show(self, data: HeatmapData | None, look: HeatLook, palette: Palette = DARK) -> None:
        """Drape a heatmap, or nothing."""
        if data is None or not len(data.values):
            show_mesh(self._actor, None)
            return
        if self._cells is None or self._cells[0] is not data.centres_m:
            places = places_of(data)
            self._cells = data.centres_m, places, _corners(places, data.cell_m)
        _, places, points = self._cells
        rgba = drape_colours(data, look, *draped(data, look, places), palette).reshape(-1, 4)
        index = np.arange(len(rgba)).reshape(places.shape)
        quads = np.stack([index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]], axis=-1).reshape(
            -1, 4
        )
        quads = quads[(rgba[:, 3] > 0)[quads].any(axis=1)]  # nothing is spent on what is clear
        mesh = pv.PolyData(points, np.insert(quads, 0, 4, axis=1).ravel()) if len(quads) else None
        if mesh is not None:
            mesh["rgba"] = rgba
        show_mesh(self._actor, mesh)


def _corners(places: Places, cell_m: float) -> NDArray[np.float32]:
    nx, ny = places.shape
    x, y = np.meshgrid(np.arange(nx) * cell_m, np.arange(ny) * cell_m, indexing="ij")
    flat = np.stack([x.ravel() + places.low_m[0], y.ravel() + places.low_m[1]], axis=1)
    return np.column_stack([flat, np.full(len(flat), _HEIGHT_M)]).astype(np.float32)
