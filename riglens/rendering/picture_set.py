"""Set of pictures for a report: the car from all sides, its footprints, blind zones, and what each camera sees."""

from __future__ import annotations

import re
from base64 import b64encode
from collections.abc import Iterator
from dataclasses import replace
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from riglens.core.blind.zones import BlindEngine, BlindMap, BlindSettings
from riglens.core.errors import InputError
from riglens.core.files import write_file
from riglens.core.footprint.document import footprints_of
from riglens.core.footprint.ground import Footprint
from riglens.core.monitor import SILENT, Monitor
from riglens.core.rig.model import Camera, Rig, Vehicle
from riglens.core.shown_text import visible
from riglens.core.vehicle.solid import solid_of
from riglens.evaluation.ground_map import ground_map

if TYPE_CHECKING:  # what draws is loaded with the first picture
    from riglens.widgets.drawing.camera import OrbitCamera
    from riglens.widgets.theme import Palette
    from riglens.widgets.viewport.ground_map import GroundMap
    from riglens.widgets.viewport.scene_state import SceneState

VIEWS = {
    "corner": ("iso", "The car from behind, with its sensors."),
    "top": ("top", "The car from above."),
    "front": ("front", "The car from ahead."),
    "left": ("left", "The left side of the car."),
    "rear": ("rear", "The car from behind, level."),
}
CAPTIONS = "captions.txt"
_FROM_AHEAD_DEG, _FILLED = (-38.0, 24.0), 0.86
_KEY = 0.15
"""Share of a picture's height that its key has to itself."""
_SHADOW_M, _CLOSE_SHADOW_M = 0.4, 0.15
"""Shadow beside the car inside the margin of a picture: all of it, or so much that the margin holds the rest."""
_AROUND_M = 4.5
"""Ground beside the car in the picture of blind zones."""
_SCALE = 12.0
"""Units of a plan per metre."""


class Shot(NamedTuple):
    """A picture of the set: its name, caption, and what is drawn, through the state's camera; or through the lens of a
    sensor, with the ground that it sees, else the ground is clear."""

    name: str
    caption: str
    state: SceneState
    sensor: Camera | None = None

    def drawn(self, size_px: tuple[int, int], scale: int) -> NDArray[np.uint8]:
        """Draw the picture: as wide as requested, that of a sensor in its proportions."""
        from riglens.widgets.drawing.lens import bends_of
        from riglens.widgets.viewport.still import render_still

        if self.sensor is None:
            return render_still(self.state, size_px, scale, transparent=True)
        width, height = self.sensor.image
        size = (size_px[0] * scale, max(1, round(size_px[0] * height / width)) * scale)
        image = np.zeros((size[1], size[0], 3), np.uint8)
        for bend in bends_of(self.sensor, size, scale):
            flat = (bend.size[0] // scale, bend.size[1] // scale)
            seen = bend.of(render_still(replace(self.state, camera=bend.view), flat, scale))
            image = np.where(np.isfinite(bend.places[..., :1]), seen, image)
        return image


def write_set(
    state: SceneState, folder: Path, size_px: tuple[int, int], scale: int = 1, monitor: Monitor = SILENT
) -> tuple[Path, ...]:
    """Write the set of a state's rig into a folder, PNG and SVG, and return the files; the ground is transparent but
    in what cameras see.

    SVG files of the scene hold the PNG; footprints are drawn as lines. Captions stand in a file of their own.
    InputError where a file cannot be written.
    """
    from riglens.widgets.viewport.still import png_of

    folder.mkdir(parents=True, exist_ok=True)
    shots, written, captions = list(_shots(state, size_px, monitor)), [], []
    with monitor.stage("Drawing") as progress:
        for number, shot in enumerate(shots):
            progress(number / len(shots), shot.name)
            image = shot.drawn(size_px, scale)
            png = png_of(image)
            svg = _embedded(png, (image.shape[1], image.shape[0]), shot)
            if shot.name == "footprints":
                svg = footprint_plan(state.rig, footprints_of(state.rig), shot.caption, state.palette)
            for suffix, content in ((".png", png), (".svg", svg.encode())):
                written.append(folder / f"{shot.name}{suffix}")
                write_file(written[-1], content)
            captions.append(f"{shot.name}: {shot.caption}")
    written.append(folder / CAPTIONS)
    write_file(written[-1], ("\n".join([visible(state.rig.name), *captions]) + "\n").encode())
    return tuple(written)


def car_with_sensors(rig: Rig) -> tuple[bytes, tuple[int, int], tuple[tuple[float, float], ...]]:
    """Return a close picture of a rig's car as a PNG without a ground, its size, and where each sensor is in it, in
    pixels right and down. Call `prepare_drawing` before."""
    from riglens.rendering.render import rig_state
    from riglens.widgets.viewport.still import png_of, render_still

    size_px = 1040, 680
    state = _unlabelled(_plain(rig_state(rig, "light")))
    camera = _close_up(state, "iso", size_px, _CLOSE_SHADOW_M, _FROM_AHEAD_DEG)
    places = np.array([one.position for one in rig.sensors]).reshape(-1, 3)
    seen = camera.project(places, size_px)[:, :2].tolist()
    image = render_still(replace(state, camera=camera), size_px, transparent=True)
    return png_of(image), size_px, tuple((x, y) for x, y in seen)


def _filling(
    camera: OrbitCamera, places_m: NDArray[np.float64], size_px: tuple[int, int], below: float = 0.0
) -> OrbitCamera:
    """Return the camera moved until places (n, 3) fill a picture above a share of its height, with a margin for
    labels."""
    room = np.array([size_px[0], (1.0 - below) * size_px[1]])
    for _ in range(4):
        seen = camera.project(places_m, size_px)[:, :2]
        low, high = seen.min(axis=0), seen.max(axis=0)
        dx, dy = (room - low - high) / 2.0
        camera = camera.panned(float(dx), float(dy), size_px)
        share = float(((high - low) / room).max())
        camera = replace(camera, distance_m=camera.distance_m * share / _FILLED)
    return camera


def _plain(state: SceneState) -> SceneState:
    """Return a state with the car and its sensors alone."""
    from riglens.widgets.viewport.scene_state import NO_CAPTION

    return replace(
        state, heatmap=None, skin_gain=None, ground_map=None, traffic=None, show_ground=False, show_gizmo=False,
        show_selection=False, selected=None, show_legend=False, caption=NO_CAPTION, ghosts=(), marker=None, post=None,
        measured=None, stubs=None, ray_look=replace(state.ray_look, shown=False, fill="none"),
    )  # fmt: skip


def _unlabelled(state: SceneState) -> SceneState:
    """Return a state without the lengths of masts."""
    return replace(state, masts=tuple(replace(mast, short="", full="") for mast in state.masts))


def _shots(state: SceneState, size_px: tuple[int, int], monitor: Monitor) -> Iterator[Shot]:
    """Yield the pictures of the set."""
    plain = _plain(state)
    for name, (view, caption) in VIEWS.items():
        shown = _unlabelled(plain) if name == "top" else plain  # a height is not seen from above
        yield Shot(name, caption, replace(shown, camera=_close_up(shown, view, size_px, _SHADOW_M)))
    above = _unlabelled(replace(plain, ray_look=replace(plain.ray_look, fill="ground"), show_legend=True))
    found = footprints_of(state.rig)
    patches = [patch for one in found for band in one.bands for patch in band.patches]
    if patches:
        camera = _from_above(above, np.concatenate(patches), size_px)
        yield Shot("footprints", _footprint_caption(state.rig), replace(above, camera=camera))
    if not state.vehicle.lacks_mesh:
        with monitor.stage("Casting rays"):
            zones = BlindEngine(state.vehicle, BlindSettings(), threads=None).evaluate(state.rig)
        caption = "Lowest height at which an object beside the car is seen, 0.3 m wide; less is better."
        hidden = _where_hidden(zones)
        camera = _from_above(above, _near_car(hidden, state.vehicle), size_px)
        yield Shot("blind-zones", caption, replace(above, camera=camera, ground_map=hidden))
    for sensor in state.rig.enabled_cameras():
        width, height = sensor.image
        *limits, last = (f"{limit:g}" for limit in state.ray_look.px_per_m)
        words = f"{', '.join(limits)} and {last}" if limits else last
        bands = f", with bands of at least {words} px/m" if state.shows_footprints else ""
        caption = f"What {visible(sensor.name)} sees: {width} × {height} px{bands}."
        seen = replace(state, hidden=state.hidden - {sensor.name}).seen_by(sensor.name, state.camera)
        yield Shot(f"camera-{_file_name(sensor.name)}", caption, seen, sensor)


def _where_hidden(zones: BlindMap) -> GroundMap:
    """Return the map of blind zones, clear where even the lowest object is seen."""
    found = ground_map(zones, "any", 1)
    lowest, *others = found.meanings
    return replace(found, meanings=(lowest._replace(opacity=0.0), *others))


def _near_car(hidden: GroundMap, vehicle: Vehicle) -> NDArray[np.float64]:
    """Return places (n, 2) that a picture of blind zones shows: the car, and cells of the zones as far as
    `_AROUND_M`."""
    corner = np.array([vehicle.length, vehicle.width]) / 2.0
    cells = np.argwhere((hidden.steps > 0) & (hidden.steps < len(hidden.meanings)))
    places = np.array(hidden.origin_m) + hidden.cell_m * (cells + 0.5)
    shown = np.clip(np.concatenate([[-corner, corner], places]), -corner - _AROUND_M, corner + _AROUND_M)
    return np.asarray(shown)


def _close_up(
    state: SceneState,
    view: str,
    size_px: tuple[int, int],
    shadow_m: float = 0.0,
    direction_deg: tuple[float, float] | None = None,
) -> OrbitCamera:
    """Return the camera that fills a picture with the car, its shadow beside it and the sensors near it, seen from a
    named direction, or from an azimuth and elevation."""
    from riglens.widgets.drawing.camera import framed, view_camera

    vehicle = state.vehicle
    camera = view_camera(view, state.grid, size_px[0] / size_px[1], car_m=(vehicle.length, vehicle.height))
    x, y = vehicle.length / 2, vehicle.width / 2
    box = np.array([(at, side, z) for at in (-x, x) for side in (-y, y) for z in (0.0, vehicle.height)])
    shadow = box[::2] + shadow_m * np.sign(box[::2]) if shadow_m else box[:0]
    car = box if vehicle.lacks_mesh else solid_of(vehicle).triangles_m.reshape(-1, 3)
    places = np.concatenate([shadow, car, *(np.array([one.position]) for one in state.shown)])
    near = places[np.abs(places).max(axis=1) < 4.0 * vehicle.length]
    if direction_deg is not None:
        camera = replace(camera, azimuth_deg=direction_deg[0], elevation_deg=direction_deg[1])
    return _filling(framed(camera, near, size_px), near, size_px)


def _from_above(state: SceneState, places_m: NDArray[np.float64], size_px: tuple[int, int]) -> OrbitCamera:
    """Return the camera straight above that fills a picture with places (n, 2) on the ground, above its key."""
    from riglens.widgets.drawing.camera import framed, view_camera

    camera = view_camera("top", state.grid, size_px[0] / size_px[1])
    ground = np.column_stack([places_m, np.zeros(len(places_m))])
    return _filling(framed(camera, ground, size_px), ground, size_px, _KEY)


def _reach_m(rig: Rig) -> float:
    reaches = [
        max(float(np.hypot(*patch.T).max()) for band in one.bands for patch in band.patches)
        for one in footprints_of(rig)
        if one.reach_m is not None
    ]
    return max(reaches, default=0.0)


def _footprint_caption(rig: Rig) -> str:
    cameras = "cameras by pixels per metre (EN 62676-4)" if rig.enabled_cameras() else ""
    others = len(rig.enabled_cameras()) < len(footprints_of(rig))
    waves = "radars and ultrasonic sensors by the class that they reach" if others else ""
    return f"Footprints on the ground: {'; '.join(filter(None, (cameras, waves)))}."


def _file_name(name: str) -> str:
    """Return a name that every file system takes."""
    return re.sub(r"[^A-Za-z0-9_-]+", "-", name).strip("-")[:80] or "sensor"


def _embedded(png: bytes, size: tuple[int, int], shot: Shot) -> str:
    width, height = size
    picture = b64encode(png).decode()
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}">'
        f"<title>{escape(shot.name)}</title><desc>{escape(shot.caption)}</desc>"
        f'<image width="{width}" height="{height}" href="data:image/png;base64,{picture}"/></svg>\n'
    )


def footprint_plan(rig: Rig, found: tuple[Footprint, ...], caption: str, palette: Palette) -> str:
    """Return footprints from above as an SVG drawing, ahead to the right."""
    from riglens.widgets.sensors.footprints import tints

    reach = _reach_m(rig)
    half_x, half_y = rig.vehicle.length / 2, rig.vehicle.width / 2
    side = 2.0 * reach * _SCALE
    parts = []
    for one in found:
        for band, tint in zip(one.bands, tints(one.sensor, palette, len(one.bands)), strict=True):
            for patch in band.patches:
                points = " ".join(f"{(reach + x) * _SCALE:.1f},{(reach - y) * _SCALE:.1f}" for x, y in patch)
                words = f"{visible(one.sensor.name)}: {band.title}"
                parts.append(
                    f'<polygon points="{points}" fill="{tint.colour}" fill-opacity="{tint.opacity:.2f}" '
                    f'stroke="{tint.colour}" stroke-width="2"><title>{escape(words)}</title></polygon>'
                )
    car = (
        f'<rect x="{(reach - half_x) * _SCALE:.1f}" y="{(reach - half_y) * _SCALE:.1f}" rx="6" '
        f'width="{2 * half_x * _SCALE:.1f}" height="{2 * half_y * _SCALE:.1f}" fill="{palette.paint}"/>'
    )
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {side:.0f} {side:.0f}"><title>footprints</title>'
        f"<desc>{escape(caption)}</desc>{''.join(parts)}{car}</svg>\n"
    )


def require_folder(folder: Path) -> None:
    """Raise InputError where a set cannot be written into a folder."""
    if folder.exists() and not folder.is_dir():
        raise InputError(f"must be a folder (got the file {folder})", "set")
