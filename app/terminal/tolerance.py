"""Tolerances as tables in the terminal."""

from __future__ import annotations

from rich import box
from rich.table import Table
from rich.text import Text

from riglens.app.terminal.console import results
from riglens.core.review.tolerance import Sensitivity, ToleranceProfile, ToleranceResult
from riglens.core.shown_text import visible

SHOWN = 10


def print_tolerance(found: ToleranceResult, body: str) -> None:
    """Print the spread of each figure beside the noise floor, and what does most, on standard output."""
    console = results()
    console.print(
        Text(f"{visible(found.rig.name)}: {profile_text(found.profile)}; body {body}"), soft_wrap=True
    )
    console.print(_spread_table(found))
    console.print(
        f"In %; more is better. {found.draws} draws (scrambled Sobol, seed {found.seed}), errors even within their "
        "limits. Noise floor: 5 to 95 % under errors of 1 mm and 0.01°, which are the lattice of rays and voxels.",
        soft_wrap=True,
    )
    if found.sensitivities:
        console.print(_sensitivity_table(found))
        console.print(
            "Percentage points at the error's limit, half of plus minus minus; the largest first.",
            soft_wrap=True,
        )


def profile_text(profile: ToleranceProfile) -> str:
    """A profile with its limits, and whose they are."""
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
    said = ", ".join(f"{name} ± {text}" for name, text, size in limits if size)
    return f"{profile.name}: {said or 'no errors'} ({profile.source})"


def _spread_table(found: ToleranceResult) -> Table:
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0))
    table.add_column("figure")
    for title in ("as designed", "median", "5 to 95 %", "worst", "draw", "noise floor"):
        table.add_column(title, justify="right", no_wrap=True)
    for name, spread in found.spreads.items():
        floor = found.floor[name]
        table.add_row(
            name,
            f"{100 * spread.nominal:.2f}",
            f"{100 * spread.median:.2f}",
            f"{100 * spread.p05:.2f} to {100 * spread.p95:.2f}",
            f"{100 * spread.worst:.2f}",
            f"{spread.worst_draw}",
            f"{100 * floor.p05:.2f} to {100 * floor.p95:.2f}",
        )
    return table


def _sensitivity_table(found: ToleranceResult) -> Table:
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0))
    table.add_column("error")
    for name in found.spreads:
        table.add_column(name.replace(" ", "\n"), justify="right")
    for one in sorted(found.sensitivities, key=_largest, reverse=True)[:SHOWN]:
        unit = "°" if one.axis in ("roll", "pitch", "yaw") else " mm"
        title = Text(f"{visible(one.sensor)} {one.axis} {one.limit:g}{unit}")
        table.add_row(title, *(f"{100 * one.effect[name]:+.2f}" for name in found.spreads))
    return table


def _largest(one: Sensitivity) -> float:
    return max(abs(effect) for effect in one.effect.values())
