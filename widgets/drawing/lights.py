"""The lights of the scene, fixed to the world: a key light, a fill, the sky and a low edge light."""

from __future__ import annotations

import numpy as np
import pyvista as pv
from vtkmodules.vtkRenderingCore import vtkRenderer

from riglens.widgets.drawing.camera import Points

_AIM_M = (0.0, 0.0, 0.6)
_LIGHTS = (
    ((4.0, -7.0, 8.0), 0.62),
    ((-7.0, 5.0, 5.0), 0.44),
    ((-5.0, -6.0, 3.0), 0.24),
    ((0.0, 0.0, 10.0), 0.32),
    ((8.0, 6.0, 1.5), 0.22),
)


def set_lights(renderer: vtkRenderer) -> None:
    """Light the scene of a renderer that has no lights."""
    for position, intensity in _LIGHTS:
        light = pv.Light(position=position, focal_point=_AIM_M, intensity=intensity, light_type="scene light")
        light.positional = False
        renderer.AddLight(light)


def light_on(normals: Points) -> Points:
    """Return the light on surfaces with unit normals (n, 3), all lights together: what VTK multiplies with a diffuse
    colour, (n,)."""
    places = np.array([position for position, _ in _LIGHTS]) - _AIM_M
    towards = places / np.linalg.norm(places, axis=1, keepdims=True)
    shares = np.clip(normals @ towards.T, 0.0, None)
    return np.asarray(shares @ np.array([intensity for _, intensity in _LIGHTS]))
