"""The picked voxel: the edges of its cube, seen through everything, and never too small to be found."""

from __future__ import annotations

import numpy as np
import pyvista as pv
from vtkmodules.vtkRenderingCore import vtkRenderer

from riglens.widgets.drawing.actors import mapper_of
from riglens.widgets.drawing.camera import OrbitCamera, Size
from riglens.widgets.theme import Palette, rgb
from riglens.widgets.viewport.scene_state import Marker

_LEAST_PX = 12.0
_WIDTHS_PX = (4.0, 2.0)
_EDGE_COLOUR = "#101418"


class MarkerLayer:
    """A cube of lines on the overlay, with a dark edge so that it stands out against every colour."""

    def __init__(self, overlay: vtkRenderer) -> None:
        cube = pv.Cube().extract_all_edges()
        self._actors = tuple(pv.Actor(mapper=mapper_of(cube)) for _ in _WIDTHS_PX)
        self._marker: Marker | None = None
        for actor in self._actors:
            actor.prop.lighting = False
            actor.pickable = False
            actor.visibility = False
            overlay.AddActor(actor)

    def set_marker(self, marker: Marker | None, palette: Palette) -> None:
        """Point out another cube, or none."""
        self._marker = marker
        for actor, colour in zip(self._actors, (_EDGE_COLOUR, palette.selected), strict=True):
            actor.visibility = marker is not None
            actor.prop.color = rgb(colour)

    def arrange(self, camera: OrbitCamera, size: Size, pixel_ratio: float) -> None:
        """Draw the cube at its size, larger where it would be too small to see."""
        if self._marker is None:
            return
        least_m = _LEAST_PX * pixel_ratio * camera.metres_per_pixel(np.array(self._marker.centre_m), size)
        for actor, width_px in zip(self._actors, _WIDTHS_PX, strict=True):
            actor.scale = max(self._marker.edge_m, least_m)
            actor.position = self._marker.centre_m
            actor.prop.line_width = width_px * pixel_ratio
