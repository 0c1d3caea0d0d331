"""Tolerance of figures to errors of mounts and a car that pitches: part of `riglens review`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from cyclopts import Group, Parameter
from rich.table import Table
from rich.text import Text

from riglens.app.commands.options import all_of
from riglens.app.terminal.console import results
from riglens.app.terminal.tables import table
from riglens.core.errors import InputError
from riglens.core.figures.figure import SE_FACTOR
from riglens.core.figures.registry import tolerated_figures
from riglens.core.files import write_file
from riglens.core.review.measures import measured_name
from riglens.core.review.tolerance import (
    Sensitivity,
    ToleranceOptions,
    ToleranceProfile,
    ToleranceResult,
    worst_rig,
)
from riglens.core.rig.yaml.file import dumps
from riglens.core.scene.boxes import CLASSES
from riglens.core.shown_text import visible

DRAWING = Group("Tolerance", sort_key=9)
SHOWN = 10


ToleranceArguments = Annotated[ToleranceOptions, all_of(ToleranceOptions, DRAWING)]


@Parameter(name="*")
@dataclass(frozen=True)
class WorstCase:
    """The worst case of a tolerance, as a file."""

    worst: Annotated[Path | None, Parameter(group=DRAWING, metavar="FILE.yaml")] = None
    """Also write the rig of the worst case, to compare it with the rig as designed."""
    worst_by: Annotated[str, Parameter(group=DRAWING, metavar="NAME")] = "seen car"
    """Figure by which the worst case is chosen, such as "seen car" or "on_target pedestrian"."""

    def __post_init__(self) -> None:
        figures = [measured_name(one, cls) for one in tolerated_figures() for cls in CLASSES]
        if self.worst_by not in figures:
            raise InputError(f"must be one of {', '.join(figures)} (got '{self.worst_by}')", "worst_by")

    @property
    def files(self) -> dict[str, Path | None]:
        """The files to write, by option."""
        return {"worst": self.worst}

    def write(self, found: ToleranceResult) -> None:
        """Write the rig of the worst case, if a file for it was named."""
        if self.worst is not None:
            write_file(self.worst, dumps(worst_rig(found, self.worst_by)))


def print_tolerance(found: ToleranceResult, body: str) -> None:
    """Print the spread of each figure next to the noise floor, and the largest effects, on standard output."""
    console = results()
    console.print(
        Text(f"{visible(found.rig.name)}: {_profile_text(found.profile)}; body {body}"), soft_wrap=True
    )
    console.print(_spread_table(found))
    fewer = [figure.title for figure in tolerated_figures() if figure.better == "less"]
    console.print(f"In %; more is better, of {', '.join(fewer)} less. {found.sample_text}", soft_wrap=True)
    console.print(
        f"{found.draws} draws (scrambled Sobol, seed {found.seed}), errors uniform within their "
        "limits. Noise floor: 5 to 95 % under errors of 1 mm and 0.01°, which are the lattice of rays and voxels.",
        soft_wrap=True,
    )
    used, of = found.frames
    if found.sensitivities:
        console.print(_sensitivity_table(found))
        console.print(
            "Percentage points at the error's limit, half the difference of plus and minus; the largest first"
            + (f"; objects on {used:,} of {of:,} frames." if used < of else "."),
            soft_wrap=True,
        )


def _profile_text(profile: ToleranceProfile) -> str:
    """Return a profile with its limits and their source."""
    limits = (
        (
            "sensors",
            f"{profile.position_mm:g} mm, {profile.angle_deg:g}°",
            profile.position_mm + profile.angle_deg,
        ),
        (
            "brackets",
            f"{profile.bracket_position_mm:g} mm, {profile.bracket_angle_deg:g}°",
            profile.bracket_position_mm + profile.bracket_angle_deg,
        ),
        (
            "car",
            f"roll {profile.car_roll_deg:g}°, pitch {profile.car_pitch_deg:g}°",
            profile.car_roll_deg + profile.car_pitch_deg,
        ),
        ("heave", f"{profile.car_heave_mm:g} mm", profile.car_heave_mm),
    )
    said = ", ".join(f"{name} ±{text}" for name, text, size in limits if size)
    return f"{profile.name}: {said or 'no errors'} ({profile.source})"


def _spread_table(found: ToleranceResult) -> Table:
    titles = ("as designed", "median", "5 to 95 %", "worst", "±", "draw", "noise floor")
    made = table("figure", *titles, dense=True)
    for name, spread in found.spreads.items():
        floor = found.floor[name]
        made.add_row(
            name,
            f"{100 * spread.nominal:.2f}",
            f"{100 * spread.median:.2f}",
            f"{100 * spread.p05:.2f} to {100 * spread.p95:.2f}",
            f"{100 * spread.worst:.2f}",
            f"{100 * SE_FACTOR * spread.worst_se:.2f}" if spread.worst_se else "",
            f"{spread.worst_draw}",
            f"{100 * floor.p05:.2f} to {100 * floor.p95:.2f}",
        )
    return made


def _sensitivity_table(found: ToleranceResult) -> Table:
    made = table("error", *(name.replace(" ", "\n") for name in found.spreads), dense=True)

    def largest(one: Sensitivity) -> float:
        return max(abs(effect) for effect in one.effect.values())

    for one in sorted(found.sensitivities, key=largest, reverse=True)[:SHOWN]:
        unit = "°" if one.axis in ("roll", "pitch", "yaw") else " mm"
        title = Text(f"{visible(one.sensor)} {one.axis} {one.limit:g}{unit}")
        made.add_row(title, *(f"{100 * one.effect[name]:+.2f}" for name in found.spreads))
    return made
