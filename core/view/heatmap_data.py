"""Define the content of a heatmap: cells, a value for each, and the legend."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Scale = Literal["ramp", "level", "steps", "change"]
"""ramp: from low to high, which is also from clear to opaque; level: from low to high, as opaque as weights say; steps:
a few named values; change: from lost through nothing to gained."""
Values = NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class HeatmapData:
    """Content of the heatmap: cell centres (m, 3) and edge in metres, a value per cell (m,), and its legend.

    Pass the same `centres_m` array again when only the values change: then nothing else is recomputed.
    `note` says which grid is shown (e.g. "cells of 0.4 m, sum of 4³ voxels"). With `steps` the values are places
    in `labels`, and with `level` they begin with 0; `weights` (m,) from 0 to 1 then decide how opaque a cell is. With
    `change` they are signed. is_loss: whether little of a level is good, so that the ground is clear there.
    """

    centres_m: Values
    cell_m: float
    values: Values
    title: str
    unit: str
    vmin: float
    vmax: float
    note: str = ""
    scale: Scale = "ramp"
    labels: tuple[str, ...] = ()
    weights: Values | None = None
    is_loss: bool = False
