"""Map the values of a heatmap to colours, opacity and the marks of a colour bar. No Qt, no VTK."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import matplotlib
import numpy as np
from numpy.typing import NDArray

from riglens.core.view.heatmap_data import HeatmapData, Scale, Values
from riglens.widgets.theme import Palette, mix, rgb

COLOUR_MAP, LEVEL_MAP = "inferno", "viridis"
STEP_COLOURS = ("#d7301f", "#fdae61", "#9fd4ea", "#2c7bb6")
LOST_COLOUR, NONE_COLOUR, GAINED_COLOUR = "#e5383b", "#9aa3ad", "#2f7df6"
LOG_DECADES = 3
"""Decades of a logarithmic scale, down from the largest value."""
LEVELS = 256
_AMONG_OTHERS, _ALONE = (0.02, 1.6, 1.0), (0.15, 0.8, 2.0)
"""Opacity of the weakest cells as a share of the strongest ones', its slope, and the number of layers."""
_MOST_TICKS = 6
CLEAR_UP_TO, OPAQUE_OVER, OPAQUE = 0.18, 0.4, 0.85
"""Of a heatmap on the ground: share of the strongest value up to which it is clear, the share over which its opacity
rises, and the end of that at the usual opacity."""


@dataclass(frozen=True)
class HeatLook:
    """User's settings for drawing a heatmap; they change no value.

    `threshold`: cells in the lowest part of the scale, 0 to 1, are not drawn. `opacity` is that of the highest
    value. `slice_m`: only cells whose centre lies between these heights are drawn, metres. `draped`: cells above each
    other as one colour on the ground, otherwise each for itself in space.
    """

    threshold: float = 0.02
    log: bool = False
    opacity: float = 0.5
    slice_m: tuple[float, float] | None = None
    draped: bool = False


DEFAULT_LOOK = HeatLook()
USUAL_LOOK = HeatLook(draped=True)
"""The look that window and pictures begin with."""


@dataclass(frozen=True)
class Tick:
    """A mark of the colour bar: its place from 0 (left) to 1, and its text."""

    place: float
    text: str


@lru_cache(maxsize=4)
def colours(scale: Scale = "ramp") -> NDArray[np.uint8]:
    """Return the colours of a scale from its lowest to its highest value, (256, 3); or one row per step."""
    if scale == "steps":
        table = np.array([rgb(colour) for colour in STEP_COLOURS])
    elif scale == "change":
        halves = [
            [rgb(mix(NONE_COLOUR, end, min(1.0, 0.4 + 0.75 * share))) for share in np.linspace(0, 1, 128)]
            for end in (LOST_COLOUR, GAINED_COLOUR)
        ]
        table = np.array(halves[0][::-1] + halves[1])
    elif scale == "level":
        table = matplotlib.colormaps[LEVEL_MAP](np.linspace(0.0, 1.0, LEVELS))[:, :3]
    else:
        table = matplotlib.colormaps[COLOUR_MAP](np.linspace(0.12, 1.0, LEVELS))[:, :3]
    return np.asarray(np.round(table * 255), dtype=np.uint8)


def strength(data: HeatmapData, values: Values, weights: Values | None, log: bool) -> Values:
    """Return the strength of each cell, 0 to 1: its place on the scale, by size where values have a sign.

    Opacity, threshold and drawing order depend on it.
    """
    if data.scale in ("steps", "level"):
        return on_scale(np.ones(len(values), np.float32) if weights is None else weights, log)
    sizes = np.abs(values) if data.scale == "change" else values - _zero(data)
    return on_scale(np.asarray(sizes / max(data.vmax - _zero(data), 1e-30), np.float32), log)


def on_scale(share: Values, log: bool) -> Values:
    """Return the place on the scale, 0 to 1, of a share of the largest value."""
    place = 1.0 + np.log10(np.maximum(share, 10.0 ** -(LOG_DECADES + 1))) / LOG_DECADES if log else share
    result: Values = np.clip(place, 0.0, 1.0).astype(np.float32)
    return result


def off_scale(place: float, log: bool) -> float:
    """Return the inverse of `on_scale` for one place: the share of the largest value."""
    return 10.0 ** (LOG_DECADES * (place - 1.0)) if log else place


def _zero(data: HeatmapData) -> float:
    return 0.0 if data.scale == "change" else data.vmin


def colour_rows(scale: Scale, values: Values, strengths: Values, vmax: float = 1.0) -> NDArray[np.int64]:
    """Return the row of `colours` per cell; `vmax` is the end of a scale of levels, which begins with 0."""
    if scale == "level":
        return np.asarray(np.clip(values / vmax, 0.0, 1.0) * (LEVELS - 1), dtype=np.int64)
    if scale == "steps":
        return np.clip(values, 0, len(STEP_COLOURS) - 1).astype(np.int64)
    if scale == "change":
        signed = np.where(values < 0, -strengths, strengths)
        return np.asarray(np.floor(127.5 * (1.0 + signed) + (values > 0) * 0.5), dtype=np.int64)
    return np.asarray(strengths * (LEVELS - 1), dtype=np.int64)


def alphas(
    strengths: Values, opacity: float, scale: Scale = "ramp", cells_deep: float = 1.0
) -> NDArray[np.uint8]:
    """Return the opacity of cells, 0 to 255: it grows with the strength up to `opacity`.

    Changes are few and isolated: they are more opaque, even small ones. Larger cells stand for `cells_deep` of the
    usual ones behind one another, and hide as much as all of them.
    """
    faintest, steepness, layers = _ALONE if scale == "change" else _AMONG_OTHERS
    steps = np.linspace(0.0, 1.0, LEVELS) ** steepness
    shares = 1.0 - (1.0 - opacity * (faintest + (1.0 - faintest) * steps)) ** (layers * cells_deep)
    table = np.round(255 * shares).astype(np.uint8)
    result: NDArray[np.uint8] = table[(strengths * (LEVELS - 1)).astype(np.int64)]
    return result


def in_slice(look: HeatLook, heights_m: Values) -> NDArray[np.int64]:
    """Return the row numbers of the cells whose centre is in the slice; all of them without one."""
    if look.slice_m is None:
        return np.arange(len(heights_m))
    low_m, high_m = look.slice_m
    return np.flatnonzero((heights_m >= low_m) & (heights_m < high_m))


def is_clear_where_low(data: HeatmapData) -> bool:
    """Return whether a heatmap on the ground goes from clear to opaque with its values."""
    return data.scale == "ramp" or data.is_loss


def draped_ramp(shares: NDArray[np.float64], palette: Palette) -> NDArray[np.float64]:
    """Return the colours of a heatmap on the ground, (..., 3) from 0 to 1, of shares from low to high."""
    table = np.array([rgb(colour) for colour in palette.heat])
    place, steps = np.clip(shares, 0.0, 1.0) * (len(table) - 1), np.arange(len(table))
    return np.stack([np.interp(place, steps, channel) for channel in table.T], axis=-1)


# ---------------------------------------------------------------- the colour bar
def bar_colours(data: HeatmapData, look: HeatLook, palette: Palette) -> NDArray[np.float64]:
    """Return the colours of the bar from left to right, (n, 3) from 0 to 1; undrawn values have that of the panel."""
    table = colours(data.scale) / 255.0
    if data.scale == "steps":
        return np.asarray(table[: len(data.labels)])
    places = np.linspace(0.0, 1.0, len(table))
    if look.draped and is_clear_where_low(data):
        clear = np.clip((CLEAR_UP_TO + OPAQUE_OVER - places) / OPAQUE_OVER, 0.0, 1.0)[:, None]
        return np.asarray(
            clear * np.array(rgb(palette.ground)) + (1.0 - clear) * draped_ramp(places, palette)
        )
    if data.scale == "level":
        return np.asarray(table)
    sizes = np.abs(2.0 * places - 1.0) if data.scale == "change" else places
    return np.where((sizes > look.threshold)[:, None], table, np.array(rgb(palette.background)))


def bar_ticks(data: HeatmapData, look: HeatLook) -> tuple[Tick, ...]:
    """Return the marks under the bar; none when the heatmap has no cells."""
    if not len(data.values):
        return ()
    if data.scale == "steps":
        count = max(1, len(data.labels))
        return tuple(Tick((place + 0.5) / count, label) for place, label in enumerate(data.labels))
    if look.draped and data.scale == "ramp":
        return Tick(0.0, "low"), Tick(1.0, "high")
    zero, span = _zero(data), max(data.vmax - _zero(data), 1e-30)
    log = look.log and data.scale != "level"
    values = tick_values(zero, data.vmax, log)
    places = on_scale((np.array(values, np.float32) - np.float32(zero)) / np.float32(span), log).tolist()
    if data.scale in ("ramp", "level"):
        return tuple(Tick(place, number_text(value)) for place, value in zip(places, values, strict=True))
    end, text = places[-1] / 2, number_text(values[-1])
    return Tick(0.5 - end, f"−{text} lost"), Tick(0.5, "0"), Tick(0.5 + end, f"+{text} gained")


def tick_values(low: float, high: float, log: bool) -> list[float]:
    """Round values from `low` to `high`: multiples of 1, 2 or 5, or powers of ten."""
    if not high > low:
        return [low]
    if log:
        top = math.floor(math.log10(high) + 1e-9)
        return [10.0**power for power in range(top - LOG_DECADES + 1, top + 1)]
    for exponent in range(math.floor(math.log10(high - low)) - 2, 400):
        for factor in (1.0, 2.0, 5.0):
            step = factor * 10.0**exponent
            if (high - low) / step < _MOST_TICKS - 1:
                first = math.ceil(low / step - 1e-9)
                return [n * step for n in range(first, math.floor(high / step + 1e-9) + 1)]
    return [low]


def number_text(value: float) -> str:
    """Return a round value as text, without noise of binary fractions."""
    return f"{value:.3g}" if value else "0"


def value_text(data: HeatmapData, place: float, log: bool) -> str:
    """Return the value at a place of the scale with its unit, for the threshold."""
    is_weight = data.scale in ("steps", "level")
    value = off_scale(place, log) * (1.0 if is_weight else data.vmax)
    unit = ("of the largest h" if data.scale == "steps" else "of full weight") if is_weight else data.unit
    return f"{value:.2g} {unit}".strip()
