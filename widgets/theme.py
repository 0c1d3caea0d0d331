"""Every colour but those of kinds of sensors, for light and dark windows: classes, axes, 3D view, panels. No Qt."""

from __future__ import annotations

from dataclasses import dataclass, field

CLASS_COLOURS = {"car": "#3b82f6", "bicycle": "#f59e0b", "pedestrian": "#ec4899"}
AXIS_COLOURS = ("#e5484d", "#30a46c", "#3e7bfa")
SELECTED_COLOUR = "#ffd60a"
LINKED_COLOUR = "#a78bfa"
"""Colour of mirror pairs: the link mark in the list, the partner of the selection, the line between them."""
MEASURE_COLOUR = "#d946ef"
"""The line of the measuring tool: seen on every car, light and dark."""
WORST_COLOUR = "#f43f5e"
"""Sensors in the worst draw of a tolerance."""
RIG_COLOURS = (
    "#4e79a7", "#f28e2b", "#59a14f", "#e15759", "#9d76b8", "#4fb0ae", "#d6b02a", "#a57a5a", "#e88fa3", "#8a949e",
)  # fmt: skip
"""For things side by side that have no colour of their own; distinguishable on light and on dark."""
BLIND_COLOURS = ("#e9f2ea", "#c8dcc9", "#f2dfa0", "#e8b06b", "#d2734e", "#8c2d25")
"""Ground around the car: from seen down to the lowest of the heights, to where an adult is unseen."""
OVERLAP_COLOURS = ("#8c2d25", "#e8b06b", "#8fc3a0", "#2f7d6b")
"""Ground that no sensor, one, two, or at least three cover."""


@dataclass(frozen=True)
class Palette:
    """Colours of the 3D view as `#rrggbb`; classes and axes look the same in both themes."""

    background: str
    """Of plates under words."""
    background_top: str
    horizon: str
    ground: str
    road: str
    mark: str
    ring: str
    text: str
    roi: str
    paint: str
    traffic: str
    bands: tuple[str, str, str, str]
    """Footprints, from the finest band to the coarsest."""
    band_opacity: tuple[float, float, float, float]
    heat: tuple[str, str, str, str]
    """Heatmap on the ground, from low to high."""
    classes: dict[str, str] = field(default_factory=lambda: dict(CLASS_COLOURS))
    axes: tuple[str, str, str] = AXIS_COLOURS
    selected: str = SELECTED_COLOUR
    seam: str = "#000000"
    """Under rays: dark or light like the ground, so that it hides only what is in between."""
    is_dark: bool = True


DARK = Palette(
    background="#161a20",
    background_top="#2b323c",
    horizon="#2f3742",
    ground="#1d2127",
    road="#272c34",
    mark="#8b95a3",
    ring="#5d6a7a",
    text="#d5dce6",
    roi="#8b98a9",
    paint="#e3e8ee",
    traffic="#687386",
    bands=("#8ff5ea", "#3fcbd8", "#2f93cf", "#3b68b8"),
    band_opacity=(0.44, 0.36, 0.29, 0.22),
    heat=("#6d2415", "#c8500f", "#f79a1c", "#ffe08a"),
    seam="#12151a",
)
LIGHT = Palette(
    background="#fafbfd",
    background_top="#c3cdd8",
    horizon="#e3e8ee",
    ground="#b4bdc7",
    road="#9aa4b0",
    mark="#f4f6f8",
    ring="#5f6b79",
    text="#1f2933",
    roi="#4b5563",
    paint="#37506b",
    traffic="#dfe4ea",
    bands=("#04485a", "#0b7285", "#2796b4", "#6bb7d2"),
    band_opacity=(0.60, 0.46, 0.33, 0.26),
    heat=("#ffc061", "#ff8a1f", "#dc3b0a", "#7a1010"),
    selected="#0f172a",
    seam="#ffffff",
    is_dark=False,
)


@dataclass(frozen=True)
class Tones:
    """Colours with a meaning, as `#rrggbb`: readable on the panel background of their theme."""

    window: str
    panel: str
    field: str
    border: str
    text: str
    muted: str
    accent: str
    selection: str
    chosen: str
    more: str
    less: str
    error: str
    error_field: str


_LIGHT_AND_DARK = {
    "window": ("#eef1f4", "#20242b"),
    "panel": ("#f8f9fb", "#262b33"),
    "field": ("#ffffff", "#1b1f26"),
    "border": ("#d3d9e0", "#3b434f"),
    "text": ("#1f2933", "#e3e8ee"),
    "muted": ("#55606d", "#93a0ae"),
    "accent": ("#2563eb", "#5b93f7"),
    "selection": ("#2563eb", "#2f62c4"),
    "chosen": ("#d6e2fb", "#2f4468"),
    "more": ("#0f766e", "#2dd4bf"),
    "less": ("#a34a07", "#fbbf24"),
    "error": ("#b91c1c", "#f87171"),
    "error_field": ("#fdecec", "#3a2226"),
}
LIGHT_TONES, DARK_TONES = (
    Tones(**{name: pair[number] for name, pair in _LIGHT_AND_DARK.items()}) for number in (0, 1)
)


def palette(dark: bool) -> Palette:
    """Return the palette of the dark or the light theme."""
    return DARK if dark else LIGHT


def rgb(colour: str) -> tuple[float, float, float]:
    """Return red, green, blue in 0..1 of a `#rrggbb` colour."""
    return int(colour[1:3], 16) / 255, int(colour[3:5], 16) / 255, int(colour[5:7], 16) / 255


def mix(first: str, second: str, share: float) -> str:
    """Return a colour `share` (0..1) of the way from the first to the second."""
    parts = [round(255 * (a + (b - a) * share)) for a, b in zip(rgb(first), rgb(second), strict=True)]
    return "#" + "".join(f"{part:02x}" for part in parts)
