"""The outline of the region of interest: a thin box around everything that is computed."""

from __future__ import annotations

import numpy as np
import pyvista as pv
from vtkmodules.vtkRenderingCore import vtkRenderer

from riglens.core.scene.grid import VoxelGrid
from riglens.widgets.car.materials import plain_actor
from riglens.widgets.theme import Palette


class RoiLayer:
    """ROI box outline; rebuilt when the grid or the palette changes."""

    def __init__(self, renderer: vtkRenderer) -> None:
        self._renderer = renderer
        self._actor: pv.Actor | None = None

    def set_grid(self, grid: VoxelGrid, palette: Palette) -> None:
        """Outline a grid's ROI."""
        if self._actor is not None:
            self._renderer.RemoveActor(self._actor)
        low = np.array(grid.origin_m)
        high = low + np.array(grid.roi_m)
        bounds = (low[0], high[0], low[1], high[1], low[2], high[2])
        outline = pv.Box(bounds).extract_all_edges()
        self._actor = plain_actor(outline, color=palette.roi, lighting=False, line_width=1)
        self._renderer.AddActor(self._actor)
