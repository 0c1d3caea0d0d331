"""Draw masts: thin lines from sensors to their missing support, with a foot on the skin and the height."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence

import numpy as np
import pyvista as pv
from numpy.typing import NDArray
from vtkmodules.vtkRenderingCore import vtkRenderer, vtkTextActor

from riglens.widgets.drawing.actors import hidden, line_mesh, plain_actor, show_mesh
from riglens.widgets.drawing.camera import OrbitCamera, Size
from riglens.widgets.drawing.label import Box, place_text, put_on_panel, set_words, text_actor
from riglens.widgets.theme import DARK
from riglens.widgets.viewport.masts import Mast
from riglens.widgets.viewport.scene_state import SceneState

MAST_COLOUR, EDGE_COLOUR = "#f8fafc", "#101418"
_WIDTHS_PX = (4.0, 1.8)
_FOOT_M, _CORNERS = 0.035, 16
_FONT_PX, _BESIDE_PX = 12, 7
_LETTER, _HIGH = 0.64, 1.7
"""Width of a letter and height of a label, in font sizes: near enough to keep labels apart."""
MOST_LABELS = 24
_ALONG = (0.5, 0.2, 0.8)
"""Candidate places of a label along its mast, from the sensor."""
Points = NDArray[np.float64]
Rectangle = tuple[float, float, float, float]
IsHidden = Callable[[Points], bool]
"""Returns whether the car hides a place (3,) in metres from the viewer."""


STUB_COLOUR = "#f43f5e"
_STUB_PX, _STUB_OPACITY = 1.6, 0.75


class StubsLayer:
    """Rays of a sensor that end at the car, in a warning colour; gone as soon as the sensor is elsewhere."""

    def __init__(self, main: vtkRenderer) -> None:
        look = {"color": STUB_COLOUR, "lighting": False, "opacity": _STUB_OPACITY}
        self._actor = hidden(main, plain_actor(pv.PolyData(), **look))

    def show(self, state: SceneState) -> None:
        """Draw the stubs of a state from the current places of the sensors."""
        stubs = state.stubs
        places = {sensor.name: sensor.position for sensor in state.shown}
        is_there = stubs is not None and places.get(stubs.name) == stubs.place_m
        self._actor.visibility = is_there and state.ray_look.shown
        if stubs is not None and is_there:
            starts = np.broadcast_to(np.array(stubs.place_m, np.float32), stubs.ends_m.shape)
            self._actor.mapper.SetInputData(line_mesh(starts, stubs.ends_m))

    def set_line_width(self, pixel_ratio: float) -> None:
        """Set the width of the lines, for dense screens and large pictures."""
        self._actor.prop.line_width = _STUB_PX * pixel_ratio


class MastLayer:
    """Lines with a dark edge in the scene, those of buried sensors over it; labels that would meet give way."""

    def __init__(self, main: vtkRenderer, overlay: vtkRenderer) -> None:
        self._overlay = overlay
        colours = (EDGE_COLOUR, MAST_COLOUR)
        self._free, self._buried = (
            tuple(hidden(where, plain_actor(pv.PolyData(), color=c, lighting=False)) for c in colours)
            for where in (main, overlay)
        )
        self._labels: list[vtkTextActor] = []
        self._shown: list[tuple[Mast, Points, bool]] = []
        self._drawn: tuple[object, ...] = ()
        self._palette = DARK
        self.boxes: list[Box] = []
        """The pixels of the labels."""

    def show(self, state: SceneState) -> None:
        """Draw the masts of the sensors that are shown, from where these are now."""
        places = {sensor.name: sensor.position for sensor in state.shown}
        drawn = (
            state.masts, tuple(places.get(mast.name) for mast in state.masts),
            tuple(state.is_selected(mast.name) for mast in state.masts), state.palette,
        )  # fmt: skip
        if drawn == self._drawn:
            return
        self._drawn = drawn
        self._shown = [
            (mast, np.array([places[mast.name], mast.foot_m]), state.is_selected(mast.name))
            for mast in state.masts
            if mast.name in places
        ]
        for actors, is_buried in ((self._free, False), (self._buried, True)):
            ends = [ends for mast, ends, _ in self._shown if mast.is_buried == is_buried]
            lines = _lines(np.stack(ends)) if ends else None
            for actor in actors:
                show_mesh(actor, lines)
        self._palette = state.palette

    def arrange(
        self,
        camera: OrbitCamera,
        size: Size,
        pixel_ratio: float,
        is_hidden: IsHidden,
        taken: Sequence[Box] = (),
    ) -> None:
        """Put labels next to masts: that of the selected sensor in full, then those of the longest, while there is
        room; except for the selected sensor, only next to what the car does not hide, and off what is `taken`."""
        for actors in (self._free, self._buried):
            for actor, width_px in zip(actors, _WIDTHS_PX, strict=True):
                actor.prop.line_width = width_px * pixel_ratio
        rooms = [(box.left, box.low, box.left + box.width, box.low + box.height) for box in taken]
        font_px = _FONT_PX * pixel_ratio
        wanted = [] if size[0] < 2 else _placed(self._shown, camera, size, font_px, is_hidden, rooms)
        self.boxes = [Box(left, low, right - left, high - low) for _, (left, low, right, high) in wanted]
        while len(self._labels) < len(wanted):
            self._labels.append(text_actor())
            self._overlay.AddViewProp(self._labels[-1])
        for number, label in enumerate(self._labels):
            label.SetVisibility(number < len(wanted))
            if number < len(wanted):
                words, (left, low, _, high) = wanted[number]
                set_words(label, f" {words} ")
                put_on_panel(label, self._palette, 0.85)
                place_text(label, left, low + 0.28 * (high - low), _FONT_PX * pixel_ratio)

    @property
    def label_texts(self) -> list[str]:
        """Return the labels in sight."""
        return [label.GetInput().strip() for label in self._labels if label.GetVisibility()]


def _placed(
    shown: list[tuple[Mast, Points, bool]],
    camera: OrbitCamera,
    size: Size,
    font_px: float,
    is_hidden: IsHidden,
    taken: Sequence[Rectangle] = (),
) -> list[tuple[str, Rectangle]]:
    """Return words and rectangles (left, low, right, high) in pixels from the lower left, without overlap."""
    order = sorted(shown, key=lambda item: (not item[2], -float(np.linalg.norm(item[1][0] - item[1][1]))))
    found: list[tuple[str, Rectangle]] = []
    for mast, ends, is_selected in order[:MOST_LABELS]:
        along = [ends[0] + share * (ends[1] - ends[0]) for share in _ALONG]
        if not (is_selected or mast.is_buried):
            along = [place for place in along if not is_hidden(place)]
        places = camera.project(np.array(along).reshape(-1, 3), size)
        rooms = (
            (words, room)
            for words in ((mast.full, mast.short) if is_selected else (mast.short,))
            if words
            for room in _rooms(words, places, size, font_px)
        )
        used = [*(() if is_selected else taken), *(room for _, room in found)]
        free = (item for item in rooms if not any(_meet(item[1], other) for other in used))
        found += [item for item in (next(free, None),) if item is not None]
    return found


def _rooms(words: str, places: Points, size: Size, font_px: float) -> Iterator[Rectangle]:
    """Yield candidate areas of a label in the view: right or left of places (n, 3) along its mast."""
    wide, high, beside = (
        (len(words) + 2) * _LETTER * font_px,
        _HIGH * font_px,
        _BESIDE_PX * font_px / _FONT_PX,
    )
    for x, y, depth in places.tolist():
        for left in (x + beside, x - beside - wide):
            low = size[1] - y - high / 2
            if depth > 0.0 and left >= 0.0 and left + wide <= size[0] and 0.0 <= low <= size[1] - high:
                yield left, low, left + wide, low + high


def _meet(one: Rectangle, other: Rectangle) -> bool:
    return one[0] < other[2] and other[0] < one[2] and one[1] < other[3] and other[1] < one[3]


def _lines(ends: Points) -> pv.PolyData:
    """Return lines (n, 2, 3) with a flat ring around the second end of each."""
    turn = 2.0 * math.pi * np.arange(_CORNERS + 1) / _CORNERS
    ring = _FOOT_M * np.stack([np.cos(turn), np.sin(turn), np.zeros_like(turn)], axis=1)
    corners = ends[:, 1, None, :] + ring
    starts = np.concatenate([ends[:, 0], corners[:, :-1].reshape(-1, 3)])
    stops = np.concatenate([ends[:, 1], corners[:, 1:].reshape(-1, 3)])
    return line_mesh(starts, stops)
