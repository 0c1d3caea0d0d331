"""Words on blind zones that the terminal, charts and the window share."""

from __future__ import annotations

from riglens.core.review.blind import Hole


def hole_text(hole: Hole | None) -> str:
    """Return the area of a patch and its distance from the car as text."""
    return "none" if hole is None else f"{hole.area_m2:.1f} m², {hole.nearest_m:.1f} m off"
