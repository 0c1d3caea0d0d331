"""Measuring tool: two places in the view and the labels of the line between them. No Qt, no VTK."""

from __future__ import annotations

import math
from dataclasses import dataclass

from riglens.core.geometry import Vec3

BODY, GROUND = "body", "ground"
LEAST_M = 5e-4
"""Shorter is nothing, to the millimetre that is shown."""
_MINUS = "\u2212"


@dataclass(frozen=True)
class Place:
    """Point in the vehicle frame, metres, and the thing there: BODY, GROUND, or the name of a `sensor`."""

    point_m: Vec3
    what: str
    sensor: str | None = None


@dataclass(frozen=True)
class Measured:
    """Ends of a measurement; until the second place is clicked it may end at `aim`, the place under the mouse."""

    first: Place
    second: Place | None = None
    aim: Place | None = None

    @property
    def places(self) -> tuple[Place, ...]:
        """The places that were clicked."""
        return (self.first,) if self.second is None else (self.first, self.second)

    @property
    def end(self) -> Place:
        """The second place, or the one under the mouse, or the first."""
        return self.second or self.aim or self.first

    @property
    def delta_m(self) -> Vec3:
        """From the first place to the end along x, y and z of the vehicle, metres."""
        end = self.end
        x, y, z = (b - a for a, b in zip(self.first.point_m, end.point_m, strict=True))
        return x, y, z

    @property
    def distance_m(self) -> float:
        """Length of the straight line."""
        return math.hypot(*self.delta_m)


def measured_lines(found: Measured) -> tuple[str, ...]:
    """Return the lines of a measurement: distance, parts along the axes, heights over the ground."""
    is_begun = found.end is found.first
    places = (found.first,) if is_begun else (found.first, found.end)
    heights = " and ".join(f"{place.point_m[2]:.3f}".replace("-", _MINUS) for place in places)
    names = " to ".join(place.what for place in places)
    if is_begun:
        return f"{names}, {heights} m above the ground", "click the second point"
    dx, dy, dz = (_signed(value) for value in found.delta_m)
    return (
        f"{found.distance_m:.3f} m",
        f"dx {dx}  dy {dy}  dz {dz} m",
        f"{names}: {heights} m above the ground",
    )


def _signed(length_m: float) -> str:
    """Return metres with a sign, without one where they round to zero."""
    return "0.000" if abs(length_m) < LEAST_M else f"{length_m:+.3f}".replace("-", _MINUS)
