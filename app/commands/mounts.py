"""Mounts of the sensors on the car: part of `riglens review`."""

from __future__ import annotations

import numpy as np
from rich.text import Text

from riglens.app.terminal.console import results
from riglens.app.terminal.tables import table
from riglens.core.review.mounts import USUAL_LIMITS, Violation, mounts_of, violations
from riglens.core.rig.model import Rig
from riglens.core.shown_text import visible


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
