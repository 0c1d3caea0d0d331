"""Set of pictures for a report: the car from all sides, its footprints, blind zones, and what each camera sees."""

from __future__ import annotations

import math
import re
from base64 import b64encode
from collections.abc import Iterator
from dataclasses import replace
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from riglens.core.blind.zones import BlindEngine, BlindSettings
from riglens.core.errors import InputError
from riglens.core.files import write_file
from riglens.core.footprint.document import footprints_of
from riglens.core.footprint.ground import Footprint
from riglens.core.monitor import SILENT, Monitor
from riglens.core.rig.model import Camera, Rig
from riglens.core.shown_text import visible
from riglens.core.vehicle.solid import solid_of
from riglens.evaluation.ground_map import ground_map

if TYPE_CHECKING:  # what draws is loaded with the first picture
    from riglens.widgets.drawing.camera import OrbitCamera
    from riglens.widgets.theme import Palette
    from riglens.widgets.viewport.scene_state import SceneState

VIEWS = {
    "corner": ("iso", "The car from behind, with its sensors."),
    "top": ("top", "The car from above."),
    "front": ("front", "The car from ahead."),
    "left": ("left", "The left side of the car."),
    "rear": ("rear", "The car from behind, level."),
}
CAPTIONS = "captions.txt"
_CLOSE_UP_M, _NEARER = 1.0, 0.62
_FROM_AHEAD_DEG, _FILLED = (-38.0, 24.0), 0.86
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
        from riglens.widgets.drawing.lens import bend_of
        from riglens.widgets.viewport.still import render_still

        if self.sensor is None:
            return render_still(self.state, size_px, scale, transparent=True)
        width, height = self.sensor.image
        size = (size_px[0] * scale, max(1, round(size_px[0] * height / width)) * scale)
        bend = bend_of(self.sensor, size, scale)
        assert bend is not None  # a lens too wide has no shot
        flat = (bend.size[0] // scale, bend.size[1] // scale)
        return bend.of(render_still(replace(self.state, camera=bend.view), flat, scale))


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
    shots, written, captions = list(_shots(state, monitor)), [], []
    with monitor.stage("Drawing") as progress:
        for number, shot in enumerate(shots):
            image = shot.drawn(size_px, scale)
            png = png_of(image)
            svg = _embedded(png, (image.shape[1], image.shape[0]), shot)
            if shot.name == "footprints":
                svg = footprint_plan(state.rig, footprints_of(state.rig), shot.caption, state.palette)
            for suffix, content in ((".png", png), (".svg", svg.encode())):
                written.append(folder / f"{shot.name}{suffix}")
                write_file(written[-1], content)
            captions.append(f"{shot.name}: {shot.caption}")
            progress((number + 1) / len(shots))
    written.append(folder / CAPTIONS)
    write_file(written[-1], ("\n".join([visible(state.rig.name), *captions]) + "\n").encode())
    return tuple(written)


def car_with_sensors(rig: Rig) -> tuple[bytes, tuple[int, int], tuple[tuple[float, float], ...]]:
    """Return a close picture of a rig's car as a PNG without a ground, its size, and where each sensor is in it, in
    pixels right and down. Call `prepare_drawing` before."""
    from riglens.rendering.render import rig_state
    from riglens.widgets.viewport.still import png_of, render_still

    size_px = 1040, 680
    state = _close_up(_plain(rig_state(rig, "light")), "iso", _FROM_AHEAD_DEG, size_px)
    masts = tuple(replace(mast, short="", full="") for mast in state.masts)
    places = np.array([one.position for one in rig.sensors]).reshape(-1, 3)
    camera = _filling(
        state.camera, np.concatenate([solid_of(rig.vehicle).triangles_m.reshape(-1, 3), places]), size_px
    )
    seen = camera.project(places, size_px)[:, :2].tolist()
    image = render_still(replace(state, camera=camera, masts=masts), size_px, transparent=True)
    return png_of(image), size_px, tuple((x, y) for x, y in seen)


def _filling(camera: OrbitCamera, places_m: NDArray[np.float64], size_px: tuple[int, int]) -> OrbitCamera:
    """Return the camera moved until places (n, 3) fill a picture, with a margin for labels."""
    for _ in range(4):
        seen = camera.project(places_m, size_px)[:, :2]
        low, high = seen.min(axis=0), seen.max(axis=0)
        dx, dy = (np.array(size_px) - low - high) / 2.0
        camera = camera.panned(float(dx), float(dy), size_px)
        share = float(((high - low) / size_px).max())
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


def _shots(state: SceneState, monitor: Monitor) -> Iterator[Shot]:
    """Yield the pictures of the set."""
    plain = _plain(state)
    for name, (view, caption) in VIEWS.items():
        close = _close_up(plain, view)
        yield Shot(name, caption, close)
    above = replace(plain, ray_look=replace(plain.ray_look, fill="ground"), show_legend=True)
    reach = _reach_m(state.rig)
    if reach > 0.0:
        yield Shot("footprints", _footprint_caption(state.rig), _from_above(above, reach))
    if not state.vehicle.lacks_mesh:
        with monitor.stage("Casting rays"):
            found = BlindEngine(state.vehicle, BlindSettings(), threads=None).evaluate(state.rig)
        caption = "Lowest height at which an object beside the car is seen, 0.3 m wide; less is better."
        blind = replace(above, ground_map=ground_map(found, "any", 1))
        yield Shot("blind-zones", caption, _from_above(blind, state.vehicle.width / 2 + _AROUND_M))
    from riglens.widgets.drawing.camera import through

    for camera in state.rig.enabled_cameras():
        lens = through(camera)
        if lens is not None:
            width, height = camera.image
            limits = ", ".join(f"{limit:g}" for limit in state.ray_look.px_per_m)
            bands = f", with bands down to {limits} px/m" if state.shows_footprints else ""
            caption = f"What {visible(camera.name)} sees: {width} × {height} px{bands}."
            seen = replace(state, hidden=state.hidden - {camera.name}).seen_by(camera.name, lens)
            yield Shot(f"camera-{_file_name(camera.name)}", caption, seen, camera)


def _close_up(
    state: SceneState,
    view: str,
    direction_deg: tuple[float, float] | None = None,
    size_px: tuple[int, int] = (1600, 1000),
) -> SceneState:
    """Return the state with the car filling a picture seen from a named direction, or from an azimuth and elevation."""
    from riglens.widgets.drawing.camera import framed, view_camera

    vehicle = state.vehicle
    camera = view_camera(view, state.grid, 1.6, car_m=(vehicle.length, vehicle.height))
    x, y = _CLOSE_UP_M * vehicle.length / 2, _CLOSE_UP_M * vehicle.width / 2
    corners = np.array([(-x, -y, 0.0), (x, y, vehicle.height), *(one.position for one in state.shown)])
    near = corners[np.abs(corners).max(axis=1) < 4.0 * vehicle.length]
    if direction_deg is not None:
        camera = replace(camera, azimuth_deg=direction_deg[0], elevation_deg=direction_deg[1])
    camera = framed(camera, near, size_px)
    return replace(state, camera=replace(camera, distance_m=_NEARER * camera.distance_m))


def _from_above(state: SceneState, reach_m: float) -> SceneState:
    """Return the state seen from straight above up to a distance from the car."""
    from riglens.widgets.drawing.camera import view_camera

    camera = view_camera("top", state.grid, 1.6)
    distance = 1.06 * reach_m / math.tan(math.radians(camera.view_angle_deg) / 2)
    return replace(state, camera=replace(camera, distance_m=distance))


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
