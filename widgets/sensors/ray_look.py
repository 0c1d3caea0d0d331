"""Style of the sensors' rays: number of lines and opacity. No Qt, no VTK."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from riglens.core.footprint.ground import EN_62676_4
from riglens.core.option_help import OptionHelp

SELECTED_LINES, QUICK_LINES = 1150, 300
OTHER_LINES, _ALL_OTHERS, _QUICK_OTHERS = 130, 1500, 400
_FEWEST_LINES = 24
_OTHERS_SHARE = 0.6
_BOLDER = 0.25
LEAST_DENSITY, MOST_DENSITY = 0.125, 8.0

Fill = Literal["none", "ground", "frusta"]
"""Fill besides the rays: none, footprints on the ground, or the outside of fields of view.

Footprints belong to cameras, radars and ultrasonic sensors.
"""


@dataclass(frozen=True)
class Strokes:
    """Approximate number of lines in the fan of a sensor, and the opacity of its rays where they leave the ROI, 0 to
    1."""

    lines: int
    opacity: float


@dataclass(frozen=True)
class RayLook:
    """User's settings for drawing rays; they change no value.

    `opacity`, 0 to 1, is that of the selected sensor's rays where they leave the ROI; those of the others are
    fainter. `density` multiplies the number of rays at rest. While something moves there are never more than at
    density 1, but they are bolder. Surfaces that are filled have an opacity of their own, and need no rays. Without
    `of_all` only the selected sensor shows its rays, and without `lattice` a camera shows a short pyramid of them.
    `px_per_m` are the limits of a camera's bands on the ground, falling.
    """

    shown: Annotated[
        bool,
        OptionHelp("", "Draw the rays of the selected sensor, or of all with --all-rays.", "rays", "no-rays"),
    ] = True
    opacity: Annotated[float, OptionHelp("SHARE", "Opacity of the rays, 0 to 1.", "ray-opacity")] = 0.2
    density: Annotated[
        float,
        OptionHelp("FACTOR", "Factor by which the number of rays drawn changes, 0.125 to 8.", "ray-density"),
    ] = 1.0
    fill: Annotated[
        Fill,
        OptionHelp("NAME", "Show fields of view: footprints on the ground, or the outside of the field."),
    ] = "ground"
    of_all: Annotated[bool, OptionHelp("", "Draw the rays of every sensor.", "all-rays")] = False
    lattice: bool = False
    px_per_m: Annotated[
        tuple[float, ...],
        OptionHelp(
            "N", "Limits of the bands in the footprints of cameras, pixels per metre, falling.", "px-per-m"
        ),
    ] = EN_62676_4

    def of_selected(self, quick: bool = False) -> Strokes:
        """Return the strokes of the fan of the selected sensor."""
        return self._strokes(round(SELECTED_LINES * self.density), QUICK_LINES, self.opacity, quick)

    def of_others(self, sensors: int, quick: bool = False) -> Strokes:
        """Return the fan of each of `sensors` unselected sensors; of many sensors each has fewer lines."""
        share = 1 / max(1, sensors)
        at_rest = min(OTHER_LINES, max(_FEWEST_LINES, _ALL_OTHERS * share)) * self.density
        in_motion = min(OTHER_LINES, max(_FEWEST_LINES, _QUICK_OTHERS * share))
        return self._strokes(round(at_rest), round(in_motion), _OTHERS_SHARE * self.opacity, quick)

    def _strokes(self, at_rest: int, in_motion: int, opacity: float, quick: bool) -> Strokes:
        """Return strokes that are bolder where motion leaves out lines, so that a fan stays about as strong."""
        if not quick or in_motion >= at_rest:
            return Strokes(at_rest, opacity)
        return Strokes(in_motion, min(1.0, opacity * (at_rest / in_motion) ** _BOLDER))


DEFAULT_RAYS = RayLook()
