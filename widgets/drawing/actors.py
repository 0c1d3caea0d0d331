"""From meshes to actors: materials, plain and coloured actors, line segments, and VTK's arrays as numpy's."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, cast

import numpy as np
import pyvista as pv
from numpy.typing import NDArray
from vtkmodules.util.numpy_support import numpy_to_vtkIdTypeArray, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkDataArray, vtkIdTypeArray
from vtkmodules.vtkRenderingCore import vtkPolyDataMapper, vtkProp, vtkRenderer


@dataclass(frozen=True)
class Material:
    """A Phong material; the colour is `#rrggbb`, the rest as in VTK."""

    colour: str
    ambient: float = 0.25
    diffuse: float = 0.75
    specular: float = 0.1
    power: float = 20.0


def surface_actor(mesh: pv.PolyData, material: Material, colours: str = "") -> pv.Actor:
    """Return a shaded, unpickable actor of a mesh in one material, or with its colours from a uint8 point array."""
    actor = plain_actor(mesh)
    prop = actor.prop
    prop.color, prop.ambient, prop.diffuse = material.colour, material.ambient, material.diffuse
    prop.specular, prop.specular_power = material.specular, material.power
    prop.interpolation = "Phong"
    if colours:
        _colour_by_array(actor, colours)
    return actor


def numpy_of(array: vtkDataArray) -> NDArray[Any]:
    """View a VTK array as numpy values; writing to them writes to the array."""
    return cast(NDArray[Any], vtk_to_numpy(array))  # type: ignore[no-untyped-call]


def vtk_ids(numbers: NDArray[np.int64]) -> vtkIdTypeArray:
    """Copy numbers into a VTK array of ids."""
    return cast(vtkIdTypeArray, numpy_to_vtkIdTypeArray(numbers, True))  # type: ignore[no-untyped-call]


def mapper_of(mesh: pv.PolyData) -> vtkPolyDataMapper:
    """Return a mapper without pyvista's colour map, which would load matplotlib's figures."""
    mapper = vtkPolyDataMapper()
    mapper.SetInputData(mesh)
    return mapper


def plain_actor(mesh: pv.PolyData, **properties: Any) -> pv.Actor:
    """Return an unpickable actor that shows a mesh in one colour; `properties` are set on its pyvista property."""
    actor = pv.Actor(mapper=mapper_of(mesh))
    actor.mapper.ScalarVisibilityOff()
    actor.pickable = False
    for name, value in properties.items():
        setattr(actor.prop, name, value)
    return actor


def rgba_actor(mesh: pv.PolyData, array: str) -> pv.Actor:
    """Return an unlit, unpickable actor coloured by an (n, 4) or (n, 3) uint8 array of the mesh."""
    actor = plain_actor(mesh, lighting=False)
    _colour_by_array(actor, array)
    return actor


def _colour_by_array(actor: pv.Actor, array: str) -> None:
    mapper = actor.mapper
    mapper.ScalarVisibilityOn()
    mapper.SetColorModeToDirectScalars()
    mapper.SetScalarModeToUsePointFieldData()
    mapper.SelectColorArray(array)


def hidden(renderer: vtkRenderer, actor: pv.Actor) -> pv.Actor:
    """Add an actor to a renderer, out of sight until it is shown."""
    actor.visibility = False
    renderer.AddActor(actor)
    return actor


def show_mesh(actor: pv.Actor, mesh: pv.PolyData | None) -> None:
    """Have an actor show a mesh; without one, or without points, it is out of sight."""
    actor.visibility = mesh is not None and mesh.n_points > 0
    if mesh is not None and mesh.n_points:
        actor.mapper.SetInputData(mesh)


def exchange(renderer: vtkRenderer, before: Iterable[vtkProp], now: Iterable[vtkProp]) -> None:
    """Have a renderer show these in place of others."""
    for prop in before:
        renderer.RemoveActor(prop)
    for prop in now:
        renderer.AddActor(prop)


def line_mesh(starts_m: NDArray[Any], ends_m: NDArray[Any]) -> pv.PolyData:
    """Return line segments between points (n, 3) and (n, 3); point 2k starts segment k."""
    count = len(starts_m)
    points = np.stack([starts_m, ends_m], axis=1).reshape(-1, 3).astype(np.float32)
    ends = np.arange(2 * count).reshape(-1, 2)
    lines = np.insert(ends, 0, 2, axis=1).ravel()
    return pv.PolyData(points, lines=lines) if count else pv.PolyData()
