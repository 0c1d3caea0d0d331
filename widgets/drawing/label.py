"""Flat parts of a picture - text, plates, lines - placed in pixels over the 3D scene, the same at every scale."""

from __future__ import annotations

from typing import NamedTuple

import matplotlib
import numpy as np
import pyvista as pv
from numpy.typing import NDArray
from vtkmodules.vtkRenderingCore import vtkActor2D, vtkPolyDataMapper2D, vtkTextActor, vtkTextRenderer

from riglens.core.shown_text import visible_lines
from riglens.widgets.drawing.camera import Size
from riglens.widgets.theme import Palette, rgb

_FONTS = f"{matplotlib.get_data_path()}/fonts/ttf"
FONT_FILE, BOLD_FONT_FILE = f"{_FONTS}/DejaVuSans.ttf", f"{_FONTS}/DejaVuSans-Bold.ttf"
_FULL_VIEW_PX, _FULL_PICTURE_PX = (640, 400), (800, 500)
_LEAST_VIEW_PX = (308, 150)
_LEAST_UNIT, _LEGIBLE_UNIT = 0.4, 0.8
_LEAST_FONT_PX = 6
_PLATE_OPACITY = 0.82
_UNPLACED_PX = 10_000
_VTK_FONT_FILE = 4
DPI = 72
"""At this resolution VTK's font sizes are pixels."""


def unit_px(size: Size, pixel_ratio: float, crowded: bool = False) -> float:
    """Return the pixels per unit of length of flat parts: the pixel ratio, less in views too small for them.

    Text stays legible as long as it fits at all. `crowded`: a legend and a table are side by side.
    """
    full = _FULL_PICTURE_PX if crowded else _FULL_VIEW_PX
    room = min(size[0] / full[0], size[1] / full[1])
    if not crowded:
        fits = min(size[0] / _LEAST_VIEW_PX[0], size[1] / _LEAST_VIEW_PX[1])
        room = max(room, min(fits, _LEGIBLE_UNIT * pixel_ratio))
    return min(pixel_ratio, max(_LEAST_UNIT * pixel_ratio, room))


def text_actor(bold: bool = False, justification: int = 0) -> vtkTextActor:
    """Return a line of text in a font with Greek letters, signs and exponents; 0 is left, 1 centred, 2 right."""
    actor = vtkTextActor()
    actor.SetPosition(-_UNPLACED_PX, -_UNPLACED_PX)  # a frame may be drawn between its making and its placing
    font = actor.GetTextProperty()
    font.SetFontFamily(_VTK_FONT_FILE)
    font.SetFontFile(BOLD_FONT_FILE if bold else FONT_FILE)
    font.SetJustification(justification)
    return actor


def put_on_panel(actor: vtkTextActor, palette: Palette, opacity: float) -> None:
    """Write in the colour of a palette's text, over a panel of its background."""
    style = actor.GetTextProperty()
    style.SetColor(*rgb(palette.text))
    style.SetBackgroundColor(*rgb(palette.background))
    style.SetBackgroundOpacity(opacity)


def set_words(actor: vtkTextActor, words: str) -> None:
    """Let an actor show these words as they are: VTK would take those between two dollar signs for mathematics."""
    actor.SetInput(visible_lines(words).replace("$", "\\$"))


def place_text(actor: vtkTextActor, x: float, y: float, font_px: float) -> None:
    """Put the start of the baseline at a pixel, counted from the lower left, and set the font size."""
    actor.SetPosition(round(x), round(y))
    actor.GetTextProperty().SetFontSize(max(_LEAST_FONT_PX, round(font_px)))


def text_width_px(actor: vtkTextActor) -> float:
    """Return the width in pixels of a text at the font size it was placed with."""
    box = [0, 0, 0, 0]
    vtkTextRenderer.GetInstance().GetBoundingBox(actor.GetTextProperty(), actor.GetInput(), box, DPI)
    return float(box[1] - box[0] + 1)


def flat_actor(mesh: pv.PolyData) -> vtkActor2D:
    """Return an actor for lines or polygons whose points are pixels, counted from the lower left."""
    actor, mapper = vtkActor2D(), vtkPolyDataMapper2D()
    mapper.SetInputData(mesh)
    actor.SetMapper(mapper)
    return actor


class Box(NamedTuple):
    """A rectangle of pixels, counted from the lower left."""

    left: float
    low: float
    width: float
    height: float

    def meets(self, other: Box, margin_px: float = 0.0) -> bool:
        """Return whether two rectangles overlap or are closer than a margin."""
        return (
            self.left - margin_px < other.left + other.width
            and other.left < self.left + self.width + margin_px
            and self.low - margin_px < other.low + other.height
            and other.low < self.low + self.height + margin_px
        )


class Plate:
    """A rectangle behind text, nearly opaque."""

    def __init__(self) -> None:
        self._mesh = pv.PolyData(np.zeros((4, 3)), [4, 0, 1, 2, 3])
        self.actor = flat_actor(self._mesh)
        self.actor.GetProperty().SetOpacity(_PLATE_OPACITY)

    def box(self) -> Box | None:
        """Return what it covers; None while it is hidden."""
        left, right, low, high = self._mesh.bounds[:4]
        return Box(left, low, right - left, high - low) if self.actor.GetVisibility() else None

    def set_colour(self, colour: str) -> None:
        """Fill it with a `#rrggbb` colour."""
        self.actor.GetProperty().SetColor(*rgb(colour))

    def cover(self, left: float, low: float, width: float, height: float) -> None:
        """Cover a rectangle of pixels, counted from the lower left."""
        right, high = left + width, low + height
        self._mesh.points = [(left, low, 0), (right, low, 0), (right, high, 0), (left, high, 0)]


class ColourBar:
    """A row of coloured fields of equal width."""

    def __init__(self) -> None:
        self._mesh = pv.PolyData()
        self.actor = flat_actor(self._mesh)
        self._shares = np.zeros(0)
        self._place = (0.0, 0.0, 0.0, 0.0)

    def set_colours(self, colours: NDArray[np.float64]) -> None:
        """Set colours (n, 3) from 0 to 1, from left to right; the bar stays where it is."""
        count = len(colours)
        self._shares = np.repeat(np.arange(count + 1) / max(1, count), 2)
        first = 2 * np.arange(count)
        self._mesh.points = self._corners()
        self._mesh.faces = np.stack(
            [np.full(count, 4), first, first + 2, first + 3, first + 1], axis=1
        ).ravel()
        self._mesh.cell_data["rgb"] = np.round(255 * colours).astype(np.uint8)
        self._mesh.cell_data.active_scalars_name = "rgb"

    def cover(self, left: float, low: float, width: float, height: float) -> None:
        """Fill a rectangle of pixels, counted from the lower left."""
        self._place = (left, low, width, height)
        self._mesh.points = self._corners()

    def _corners(self) -> NDArray[np.float64]:
        left, low, width, height = self._place
        points = np.zeros((len(self._shares), 3))
        points[:, 0] = left + self._shares * width
        points[:, 1] = low + np.arange(len(points)) % 2 * height
        return points
