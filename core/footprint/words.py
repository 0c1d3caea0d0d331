"""Say footprints in a few words, the same in window, terminal and report."""

from __future__ import annotations

import math
from collections.abc import Sequence

from riglens.core.footprint.detail import DISTANCES_M, MEASURED, PixelsOn, focal_mm, pixel_um, pixels_on
from riglens.core.footprint.overlap import Overlap
from riglens.core.rig.model import Camera
from riglens.core.shown_text import visible


def pixels_text(found: Sequence[PixelsOn]) -> str:
    """Return the heights of an object at several distances in pixels, such as "218 / 73 / 44 / 22"."""
    return " / ".join("—" if math.isnan(one.height_px) else f"{one.height_px:.0f}" for one in found)


def overlap_text(shared: Overlap) -> str:
    """Return what two neighbours share, such as "A and B overlap by 5.1°", or the gap between them."""
    verb = "overlap by" if shared.overlap_deg >= 0.0 else "leave a gap of"
    return f"{visible(shared.right)} and {visible(shared.left)} {verb} {abs(shared.overlap_deg):.1f}°"


def camera_rows(camera: Camera, shared: Sequence[Overlap]) -> list[tuple[str, str]]:
    """Return captions and values of what a camera resolves, and of its neighbours among `shared`."""
    at = " / ".join(f"{distance:g}" for distance in DISTANCES_M)
    rows = [("Pixels tall at", f"{at} m")]
    rows += [(cls.capitalize(), pixels_text(pixels_on(camera, cls))) for cls in MEASURED]
    length_mm, pitch_um = focal_mm(camera), pixel_um(camera)
    known = length_mm is not None and pitch_um is not None
    rows.append(("Lens", f"{length_mm:.2f} mm, {pitch_um:g} µm pixels" if known else "— pixel size unknown"))
    sides = [("left", one.left, one) for one in shared if one.right == camera.name]
    sides += [("right", one.right, one) for one in shared if one.left == camera.name]
    texts = (
        f"{side}: {abs(one.overlap_deg):.1f}°{'' if one.overlap_deg >= 0.0 else ' gap'}, {visible(name)}"
        for side, name, one in sides
    )
    return [*rows, ("Overlap", "\n".join(texts) or "— no neighbour")]
