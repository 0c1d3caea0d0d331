"""Word the detection-range figures, for the terminal and the window alike."""

from __future__ import annotations

import math

from riglens.core.targets.detection_range import Reach

HEADINGS = {0.0: "end on", 90.0: "side on"}
_NAMES = {0.0: "ahead", 90.0: "left", 180.0: "behind", -90.0: "right"}


def bearing_text(bearing_deg: float) -> str:
    """Return a direction from the car as text: its name, or degrees to a side."""
    turned = math.remainder(bearing_deg, 360.0)
    named = _NAMES.get(abs(turned) if abs(turned) == 180.0 else turned)
    return named or f"{abs(turned):g}° {'left' if turned > 0.0 else 'right'}"


def reach_text(reach: Reach, to_m: float) -> str:
    """Return worst/median/best, once where they are the same; ">" marks the farthest distance tried."""
    if reach.most_m == 0.0:
        return "never"
    values = [reach.least_m, reach.median_m, reach.most_m]
    texts = [f">{to_m:g}" if math.isinf(value) else f"{value:.0f}" for value in values]
    return texts[0] if len(set(texts)) == 1 else "/".join(texts)


def stop_text(speed_kmh: float | None) -> str:
    """Format a speed with its unit; empty where the car does not drive towards the object."""
    if speed_kmh is None:
        return ""
    return "any speed tried" if math.isinf(speed_kmh) else f"{speed_kmh:.0f} km/h"
