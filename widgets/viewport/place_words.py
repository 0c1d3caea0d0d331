"""Words and dots at places of the scene, upright and of one size: rings, bands, names, sensors.

A label is left out rather than put over a sensor or another label.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import pyvista as pv
from numpy.typing import NDArray
from vtkmodules.vtkRenderingCore import vtkRenderer, vtkTextActor

from riglens.core.rig.model import Camera, Sensor
from riglens.widgets.drawing.camera import Pixel, Size
from riglens.widgets.drawing.label import (
    Box,
    flat_actor,
    place_text,
    put_on_panel,
    set_words,
    text_actor,
    text_width_px,
    unit_px,
)
from riglens.widgets.sensors.appearance import colour_of
from riglens.widgets.sensors.bodies import sensor_body
from riglens.widgets.sensors.footprints import quick_footprint
from riglens.widgets.theme import Palette, rgb
from riglens.widgets.viewport.ground_layer import RINGS_M
from riglens.widgets.viewport.scene_state import SceneState

Points = NDArray[np.float64]
_LEAST_M = 0.2
_RING_PX, _BAND_PX, _NAME_PX = 12, 12, 13
_DOT_PX, _RIM_PX, _CORNERS = 4.5, 2.0, 20
"""Radius of a dot without its rim, width of the rim, and corners of the polygon."""
_BODY_PX = 34.0
"""A sensor whose body is larger than that needs no dot."""
_LEAST_CAR_PX = 26.0
"""Length of a car that two dots do not hide."""
_ASIDE_DEG = 100.0
"""Bearing of the labels of the rings from the viewer's, where nothing else is."""
_OFF_GIZMO_PX = 118
"""Distance of the name of a sensor from its handles' middle, which the name must not cover."""
_RIMS = ("#10141a", "#ffffff")


class Word(NamedTuple):
    """A label, the pixels at one of which its middle is, the first that is free, and its size and weight."""

    text: str
    places: tuple[Pixel, ...]
    font_px: int
    is_bold: bool = False


class PlaceWordsLayer:
    """Labels and dots on the overlay; `arrange` puts them into their places before each frame."""

    def __init__(self, overlay: vtkRenderer) -> None:
        self._overlay = overlay
        self._texts: list[vtkTextActor] = []
        self._styled: Palette | None = None
        self._mesh = pv.PolyData()
        self._dots = flat_actor(self._mesh)
        self._dots.SetPickable(False)
        overlay.AddViewProp(self._dots)

    @property
    def texts(self) -> tuple[str, ...]:
        """Return the labels that are shown."""
        return tuple(text.GetInput().strip() for text in self._texts if text.GetVisibility())

    def arrange_dots(self, state: SceneState, size: Size, pixel_ratio: float) -> list[Box]:
        """Place the dots in a picture of this size; return the pixels of all sensors."""
        return self._place_dots(state, size, unit_px(size, pixel_ratio))

    def arrange(
        self, state: SceneState, hovered: str | None, taken: Iterable[Box], size: Size, pixel_ratio: float
    ) -> None:
        """Place the labels in a picture of this size, off the pixels that are taken."""
        unit, used = unit_px(size, pixel_ratio), list(taken)
        shown = 0
        for word in _words(state, hovered, size, unit):
            box = self._place(shown, word, state.palette, used, size, unit)
            if box is not None:
                used.append(box)
                shown += 1
        for text in self._texts[shown:]:
            text.SetVisibility(False)
        self._styled = state.palette

    def _place_dots(self, state: SceneState, size: Size, unit: float) -> list[Box]:
        """Put a dot on every small sensor, unless dots would hide the car; return the pixels of all sensors."""
        sensors = state.shown
        if not sensors:
            self._dots.SetVisibility(False)
            return []
        places = np.array([sensor.position for sensor in sensors])
        pixels = state.camera.project(places, size)
        car_px = state.vehicle.length / state.camera.metres_per_pixel(np.zeros(3), size)
        boxes, centres, colours = [], [], []
        for sensor, (x, y, depth) in zip(sensors, pixels.tolist(), strict=True):
            if depth <= 0.0:
                continue
            is_selected = state.is_selected(sensor.name)
            radius = (_DOT_PX + (1.0 if is_selected else 0.0)) * unit
            boxes.append(Box(x - 5 * unit, size[1] - y - 5 * unit, 10 * unit, 10 * unit))
            pixel_m = state.camera.metres_per_pixel(np.array(sensor.position), size)
            is_large = _extent_m(sensor) / pixel_m > _BODY_PX * unit
            has_handles = is_selected and state.gizmo_pose is not None
            if is_large or car_px < _LEAST_CAR_PX * unit or has_handles or sensor.name in state.failed:
                continue
            colour = state.palette.selected if is_selected else colour_of(sensor.kind)
            rim = _RIMS[not state.palette.is_dark]
            for extra, filled in ((_RIM_PX * unit, rim), (0.0, colour)):
                centres.append((x, size[1] - y, radius + extra))
                colours.append(rgb(filled))
        self._dots.SetVisibility(bool(centres))
        if centres:
            _fill_discs(self._mesh, np.array(centres), np.array(colours))
        return boxes

    def _place(
        self, number: int, word: Word, palette: Palette, used: Sequence[Box], size: Size, unit: float
    ) -> Box | None:
        width, height = (
            _width_px(word.text, word.is_bold, round(word.font_px * unit)),
            1.5 * word.font_px * unit,
        )
        for x, y in word.places:
            box = Box(x - width / 2, size[1] - y - height / 2, width, height)
            fits = (
                box.left > 2
                and box.low > 2
                and box.left + width < size[0] - 2
                and box.low + height < size[1] - 2
            )
            if fits and not any(box.meets(other, 3.0 * unit) for other in used):
                self._write(number, word, palette, box, unit)
                return box
        return None

    def _write(self, number: int, word: Word, palette: Palette, box: Box, unit: float) -> None:
        while len(self._texts) <= number:
            text = text_actor()
            text.SetPickable(False)
            self._overlay.AddViewProp(text)
            self._texts.append(text)
            put_on_panel(text, palette, 0.78)
        text = self._texts[number]
        if self._styled is not palette:
            put_on_panel(text, palette, 0.78)
        text.GetTextProperty().SetBold(word.is_bold)
        set_words(text, f" {word.text} ")
        place_text(text, box.left, box.low + 0.3 * box.height, word.font_px * unit)
        text.SetVisibility(True)


@lru_cache(maxsize=512)
def _extent_m(sensor: Sensor) -> float:
    """Return the longest edge of a sensor's body, whose size a library of files gives."""
    return float(np.ptp(sensor_body(sensor).box_m(), axis=0).max())


@lru_cache(maxsize=512)
def _width_px(text: str, is_bold: bool, font_px: int) -> float:
    actor = text_actor(is_bold)
    set_words(actor, f" {text} ")
    place_text(actor, 0.0, 0.0, font_px)
    return text_width_px(actor)


def _words(state: SceneState, hovered: str | None, size: Size, unit: float) -> Iterator[Word]:
    """Yield the labels of a state, the most important first."""
    yield from _names(state, hovered, size, unit)
    if state.show_legend and state.shows_footprints:
        yield from _band_words(state, size, unit)
    if state.show_legend and state.show_ground:
        yield from _ring_words(state, size)


def _names(state: SceneState, hovered: str | None, size: Size, unit: float) -> Iterator[Word]:
    wanted = [
        name for name in (state.selected if state.show_selection else None, hovered) if name is not None
    ]
    for sensor in state.shown:
        if sensor.name not in wanted:
            continue
        (x, y, depth) = state.camera.project(np.array([sensor.position]), size)[0].tolist()
        half = 0.5 * _width_px(sensor.name, True, round(_NAME_PX * unit))
        if depth > _LEAST_M:  # a camera has no place in its own picture
            away = (
                _OFF_GIZMO_PX if state.gizmo_pose is not None and sensor.name == state.selected else 30
            ) * unit
            high, low = y - away, y + away
            places = tuple((x + side * (half + 14 * unit), at) for at in (high, low) for side in (-1, 1))
            yield Word(sensor.name, ((x, high), *places), _NAME_PX, is_bold=True)


def _band_words(state: SceneState, size: Size, unit: float) -> Iterator[Word]:
    """Yield the limits of the camera that is selected, or else looks ahead, at a corner of each band."""
    camera = _labelled(state)
    if camera is None:
        return
    for band in quick_footprint(camera, state.ray_look.px_per_m).bands:
        if not band.patches:
            continue
        corners = band.patches[0]
        pixels = state.camera.project(np.column_stack([corners, np.zeros(len(corners))]), size)
        far = np.argsort(-np.hypot(*(corners - camera.position[:2]).T))[:2]
        ends = [pixels[row] for row in far if pixels[row, 2] > 0.0]
        ends.sort(key=lambda pixel: float(pixel[0]))
        half = 0.5 * _width_px(band.title, False, round(_BAND_PX * unit)) + 8 * unit
        places = [
            (float(end[0]) + side * half, float(end[1])) for end, side in zip(ends, (-1, 1), strict=False)
        ]
        yield Word(band.title.removeprefix("≥ "), tuple(places), _BAND_PX)


def _labelled(state: SceneState) -> Camera | None:
    """Return the pinhole camera whose bands are labelled: the selected one, or the one that looks most straight
    ahead."""
    chosen = state.selected_sensor
    if chosen is not None:
        if isinstance(chosen, Camera) and chosen.distortion is None and chosen in state.enabled:
            return chosen
        return None
    cameras = [one for one in state.enabled if isinstance(one, Camera) and one.distortion is None]
    return max(cameras, key=_ahead, default=None)


def _ahead(sensor: Sensor) -> float:
    return float(sensor.pose.rotation()[0, 0])


def _ring_words(state: SceneState, size: Size) -> Iterator[Word]:
    """Yield the distances of the rings, each at the first bearing where it is free, first to the viewer's left."""
    view = state.camera
    start_deg = view.azimuth_deg - _ASIDE_DEG
    turns = np.radians([start_deg + side * step for step in range(0, 180, 10) for side in (1, -1)])
    for radius_m in RINGS_M:
        places = radius_m * np.stack([np.cos(turns), np.sin(turns), np.zeros(len(turns))], axis=1)
        pixels = view.project(places, size)
        seen = pixels[pixels[:, 2] > 0.0]
        yield Word(f"{radius_m:g} m", tuple((float(x), float(y)) for x, y, _ in seen), _RING_PX)


def _fill_discs(mesh: pv.PolyData, discs: Points, colours: Points) -> None:
    """Fill a mesh with discs (x, y, radius) in pixels, and colours (n, 3) from 0 to 1."""
    turn = np.linspace(0.0, 2.0 * np.pi, _CORNERS, endpoint=False)
    circle = np.stack([np.cos(turn), np.sin(turn), np.zeros(_CORNERS)], axis=1)
    middles = np.column_stack([discs[:, :2], np.zeros(len(discs))])
    points = (middles[:, None] + discs[:, 2, None, None] * circle).reshape(-1, 3)
    mesh.points = points
    mesh.faces = np.insert(np.arange(len(points)).reshape(-1, _CORNERS), 0, _CORNERS, axis=1).ravel()
    mesh.cell_data["rgb"] = np.round(255.0 * colours).astype(np.uint8)
    mesh.cell_data.active_scalars_name = "rgb"
