"""Loads the half of pyvista that draws, without matplotlib, and without VTK's slow search for its libraries.

pyvista imports matplotlib for charts inside a scene and for colour maps by name. RigLens has neither of the two: its
surfaces bring their colours with them. Loading matplotlib takes half a second of every start.
"""

from __future__ import annotations

import os
from collections.abc import Iterable
from importlib.machinery import EXTENSION_SUFFIXES

import vtkmodules

from widgets.stand_ins import StandIn, standing_in, when_called

_search = vtkmodules.find_lib_path


def load_drawing_half() -> None:
    """Load pyvista and VTK; best before Qt, whose bindings slow down every import that comes after them."""
    vtkmodules.find_lib_path = _library
    listed = when_called("matplotlib.colors", "ListedColormap")
    colours = StandIn("matplotlib.colors", ListedColormap=listed, Colormap=object)
    with standing_in(*_matplotlib(colours)):
        import pyvista.plotting  # noqa: F401
    colours.forget("Colormap")  # a part of a composed type, until now; from here on the real class is wanted


def _matplotlib(colours: StandIn) -> list[StandIn]:
    """What pyvista names of matplotlib. Colour maps are in `cm` too, where pyvista finds them in older versions."""
    figures, maps, canvas = "matplotlib.pyplot", "matplotlib.cm", "matplotlib.backends.backend_agg"
    return [
        StandIn("matplotlib", pyplot=StandIn(figures), colors=colours, colormaps=StandIn(maps)),
        StandIn(figures),
        colours,
        StandIn(canvas, FigureCanvasAgg=when_called(canvas, "FigureCanvasAgg")),
    ]


def _library(folders: Iterable[str], name: str) -> str | None:
    """Path of a library of VTK, whose own search, kept for other names, reads a folder of 500 files for each."""
    for folder in folders:
        for ending in EXTENSION_SUFFIXES:
            path = os.path.join(folder, name + ending)
            if os.path.isfile(path):
                return os.path.realpath(path)
    found: str | None = _search(folders, name)
    return found
