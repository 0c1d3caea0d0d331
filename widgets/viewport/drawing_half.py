"""Loads the half of pyvista that draws, without matplotlib's figures.

pyvista imports them for charts inside a scene, of which RigLens has none. They take a third of a second of every start.
"""

from __future__ import annotations

from riglens.widgets.stand_ins import StandIn, standing_in, when_called

_CANVAS = "matplotlib.backends.backend_agg"


def load_drawing_half() -> None:
    """Load pyvista and VTK; best before Qt, whose bindings read the source of every module that comes after them."""
    canvas = StandIn(_CANVAS, FigureCanvasAgg=when_called(_CANVAS, "FigureCanvasAgg"))
    with standing_in(StandIn("matplotlib.pyplot"), canvas):
        import pyvista.plotting  # noqa: F401
