"""Footprints of the sensors: part of `riglens review`."""

from __future__ import annotations

from collections.abc import Sequence

from rich.text import Text

from riglens.app.terminal.console import results
from riglens.app.terminal.tables import table
from riglens.core.footprint.detail import DISTANCES_M, focal_mm, pixels_on
from riglens.core.footprint.ground import Footprint
from riglens.core.footprint.overlap import overlaps
from riglens.core.footprint.words import overlap_text, pixels_text
from riglens.core.rig.model import Camera, Rig
from riglens.core.shown_text import visible

UNIT = " px/m"
NOTE = "Ground: of cameras by least pixels per metre, of other sensors by the class that they reach."


def print_footprints(rig: Rig, found: Sequence[Footprint]) -> None:
    """Print the ground that each sensor covers, and what cameras resolve, on standard output."""
    console = results()
    made = table(
        "sensor", "from (m)", "to (m)", "ground (m²)", words={0, 3}, wraps={3}, dense=True, widest=60
    )
    for one in found:
        reach = one.reach_m or (float("nan"), float("nan"))
        areas = ", ".join(
            f"{band.title.removesuffix(UNIT)}: {band.area_m2:.0f}" for band in one.bands if band.patches
        )
        cells = (f"{value:.1f}" if one.reach_m else "—" for value in reach)
        made.add_row(Text(visible(one.sensor.name)), *cells, Text(areas or "—"))
    console.print(made)
    console.print(NOTE, soft_wrap=True)
    cameras = [one.sensor for one in found if isinstance(one.sensor, Camera)]
    if not cameras:
        return
    at = " / ".join(f"{distance:g}" for distance in DISTANCES_M)
    titles = ("camera", f"pedestrian at {at} m (px)", f"car at {at} m (px)", "lens (mm)")
    sizes = table(*titles, words={0}, wraps={1, 2}, dense=True, widest=40)
    for camera in cameras:
        lens_mm = focal_mm(camera)
        texts = [pixels_text(pixels_on(camera, cls)) for cls in ("pedestrian", "car")]
        sizes.add_row(Text(visible(camera.name)), *texts, "—" if lens_mm is None else f"{lens_mm:.2f}")
    console.print(sizes)
    if shared := overlaps(rig.enabled_cameras()):
        console.print(Text(f"At the horizon {'; '.join(map(overlap_text, shared))}."), soft_wrap=True)
