"""Say footprints in a few words, the same in window, terminal and report."""

from __future__ import annotations

import math
from collections.abc import Sequence

from riglens.core.footprint.detail import PixelsOn
from riglens.core.footprint.overlap import Overlap
from riglens.core.shown_text import visible


def pixels_text(found: Sequence[PixelsOn]) -> str:
    """Return the heights of an object at several distances in pixels, such as "218 / 73 / 44 / 22"."""
    return " / ".join("—" if math.isnan(one.height_px) else f"{one.height_px:.0f}" for one in found)


def overlap_text(shared: Overlap) -> str:
    """Return what two neighbours share, such as "A and B overlap by 5.1°", or the gap between them."""
    verb = "overlap by" if shared.overlap_deg >= 0.0 else "leave a gap of"
    return f"{visible(shared.right)} and {visible(shared.left)} {verb} {abs(shared.overlap_deg):.1f}°"
