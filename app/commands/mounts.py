"""Mounts of the sensors on the car: part of `riglens review`."""

from __future__ import annotations

from typing import Any

import numpy as np
from rich.text import Text

from riglens.app.terminal.console import results
from riglens.app.terminal.tables import table
from riglens.core.review.mounts import USUAL_LIMITS, Mount, Violation, mounts_of, violations
from riglens.core.rig.model import FORMAT_VERSION, Rig
from riglens.core.rig.yaml.file import identity_of
from riglens.core.shown_text import visible


def mounts_document(rig: Rig) -> dict[str, Any]:
    """Return the mounts of the enabled sensors and their violations of the usual limits, as plain data."""
    return {
        "riglens": FORMAT_VERSION,
        "rig": identity_of(rig),
        "gap_limit_m": USUAL_LIMITS.gap_m,
        "sensors": [_plain(mount) for mount in mounts_of(rig)],
        "problems": [{"sensor": one.sensor, "text": one.text} for one in violations(rig, USUAL_LIMITS)],
    }


def _plain(mount: Mount) -> dict[str, Any]:
    place = mount.status
    return {
        "name": mount.name,
        "height_m": mount.height_m,
        "gap_m": _finite(place.gap_m),
        "inside": place.inside,
        "below_ground": place.below_ground,
        "nearest_sensor": mount.neighbour,
        "nearest_sensor_m": _finite(mount.neighbour_m),
        "beyond_m": mount.beyond_m,
        "materials": sorted(mount.materials),
        "zones": list(mount.zones),
    }


def _finite(value: float) -> float | None:
    return value if np.isfinite(value) else None


def print_mounts(rig: Rig) -> None:
    """Print height, gap, neighbour and violations of each mount on standard output."""
    console = results()
    titles = ("mount", "height (m)", "off the skin (m)", "to the nearest (m)", "problems")
    made = table(*titles, words={0, 4}, wraps={1, 2, 3, 4}, dense=True, widest=28)
    wrong = violations(rig, USUAL_LIMITS)
    for mount in mounts_of(rig):
        figures = (mount.height_m, mount.status.gap_m, mount.neighbour_m)
        cells = (f"{value:.3f}" if np.isfinite(value) else "—" for value in figures)
        made.add_row(Text(visible(mount.name)), *cells, Text(_of(mount.name, wrong)))
    console.print(made)
    if others := _of("car", wrong):
        console.print(Text(f"car: {others}"), soft_wrap=True)
    console.print(
        f"Problems: farther than {USUAL_LIMITS.gap_m:g} m off the skin (our choice), inside, on glass or a door."
    )


def _of(name: str, wrong: tuple[Violation, ...]) -> str:
    return visible("; ".join(one.text for one in wrong if one.sensor == name))
