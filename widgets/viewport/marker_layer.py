"""The picked voxel: the edges of its cube, seen through everything, and never too small to be found."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pyvista as pv
from vtkmodules.vtkRenderingCore import vtkRenderer

from core.geometry import Vec3
from widgets.theme import Palette, rgb
from widgets.viewport.camera import OrbitCamera, Size

_LEAST_PX = 9.0
_WIDTH_PX = 2.0


@dataclass(frozen=True)
class Marker:
    """A cube to point out: its centre and edge, metres."""

    centre_m: Vec3
    edge_m: float


class MarkerLayer:
    """A cube of lines on the overlay."""

    def __init__(self, overlay: vtkRenderer) -> None:
        cube = pv.Cube().extract_all_edges()
        self._actor = pv.Actor(mapper=pv.DataSetMapper(cube))
        self._actor.prop.lighting = False
        self._actor.pickable = False
        self._actor.visibility = False
        self._marker: Marker | None = None
        overlay.AddActor(self._actor)

    def set_marker(self, marker: Marker | None, palette: Palette) -> None:
        """Point out another cube, or none."""
        self._marker = marker
        self._actor.visibility = marker is not None
        self._actor.prop.color = rgb(palette.selected)

    def arrange(self, camera: OrbitCamera, size: Size, pixel_ratio: float) -> None:
        """Draw the cube at its size, larger where it would be too small to see."""
        if self._marker is None:
            return
        least_m = _LEAST_PX * pixel_ratio * camera.metres_per_pixel(np.array(self._marker.centre_m), size)
        self._actor.scale = max(self._marker.edge_m, least_m)
        self._actor.position = self._marker.centre_m
        self._actor.prop.line_width = _WIDTH_PX * pixel_ratio
