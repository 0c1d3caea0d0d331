"""The map of lowest visible heights around a car, as a picture: ahead is up, left is left."""

from __future__ import annotations

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch, Rectangle

from riglens.core.blind.zones import HEIGHTS_M, BlindMap, By, seen_by
from riglens.core.shown_text import visible
from riglens.widgets.theme import BLIND_COLOURS as COLOURS

INK = "#222222"


def blind_figure(found: BlindMap, by: By, k: int) -> Figure:
    """Draw from which height on an object is seen, in the steps of HEIGHTS_M."""
    figure = Figure(figsize=(8.6, 6.5), dpi=110)
    FigureCanvasAgg(figure)
    axes = figure.add_axes((0.08, 0.08, 0.62, 0.82))
    steps = found.steps(by, k).astype(np.float64)
    steps[~found.ground.counts] = np.nan
    half_x, half_y = found.grid.roi_m[0] / 2, found.grid.roi_m[1] / 2
    colours = ListedColormap(list(COLOURS))
    norm = BoundaryNorm(np.arange(len(COLOURS) + 1) - 0.5, len(COLOURS))
    axes.imshow(
        steps[::-1, ::-1],
        cmap=colours,
        norm=norm,
        extent=(half_y, -half_y, -half_x, half_x),
        interpolation="nearest",
    )
    outline = found.ground.outline
    corner = (outline.right_m, outline.rear_m)
    axes.add_patch(Rectangle(corner, outline.width_m, outline.length_m, facecolor="#5f6b76", edgecolor=INK))
    axes.set_xlabel("y (m), left of the car is left")
    axes.set_ylabel("x (m), ahead is up")
    axes.set_title(
        f"{visible(found.rig.name)}: seen by {seen_by(by, k)} from which height", color=INK, fontsize=10
    )
    labels = [f"up to {HEIGHTS_M[0]:g} m", *(f"above {height:g} m" for height in HEIGHTS_M)]
    patches = [
        Patch(facecolor=colour, edgecolor="#999999", label=label)
        for colour, label in zip(COLOURS, labels, strict=True)
    ]
    figure.legend(handles=patches, loc="upper left", bbox_to_anchor=(0.71, 0.9), frameon=False, title="from")
    words = f"object {found.settings.width_m:g} m wide\nδ {found.settings.voxel_m:g} m\nbody {found.settings.body}"
    figure.text(0.73, 0.45, words, color=INK, fontsize=9, va="top")
    return figure
