"""Format figures: values, errors and changes with their units, with signs that need no colour."""

from __future__ import annotations

from typing import Literal, TypeVar

import numpy as np
from numpy.typing import NDArray

from riglens.core.figures.coverage import VoxelFigure
from riglens.core.figures.figure import SE_FACTOR, Estimate, Figure, Unit
from riglens.core.figures.objects import ObjectFigure
from riglens.core.sensors.registry import kind_of
from riglens.core.shown_values import NONE

Number = TypeVar("Number", float, NDArray[np.float64])
MINUS = "\u2212"
UNITS: dict[Unit, str] = {
    "share": "%",
    "nat": "10³ nat",
    "points": "points",
    "px": "px",
    "m": "m",
    "m²": "m²",
}
EXACT_UNITS: dict[Unit, str] = UNITS | {"share": "fraction", "nat": "nat"}
"""Units of values in full precision."""
_SHORT: dict[Unit, str] = UNITS | {"nat": "", "points": "pts"}
_DECIMALS: dict[Unit, int] = {"points": 0, "px": 0, "m": 1, "m²": 1}
"""Decimals of values in other units than percent and 10³ nat."""
Verdict = Literal["better", "worse", "too small to distinguish rigs", ""]
UNRESOLVED: Verdict = "too small to distinguish rigs"


def in_unit(figure: Figure, value: Number) -> Number:
    """Return a value, or several, in the unit in which it is shown: percent, 10³ nat."""
    return 100.0 * value if figure.unit == "share" else value / 1000.0 if figure.unit == "nat" else value


def in_sentence(title: str) -> str:
    """Return a title as it stands inside a sentence."""
    return title[:1].lower() + title[1:] if title[1:2].islower() else title


def change_unit(figure: Figure) -> str:
    """Return the unit of a change, in full."""
    return "pp" if figure.unit == "share" else UNITS[figure.unit]


def value_text(figure: Figure, value: float, decimals: int = 2) -> str:
    """Format a value with its unit; 10³ nat have none. Decimals are those of percent and 10³ nat."""
    shown = in_unit(figure, value)
    return _with_unit(
        f"{abs(shown):.{_DECIMALS.get(figure.unit, decimals)}f}", shown, "", _SHORT[figure.unit]
    )


def estimate_text(figure: Figure, found: Estimate) -> str:
    """Format an estimate with two standard errors if it has any; a dash where there is none."""
    if not found.exists or not found.se:
        return value_text(figure, found.value) if found.exists else NONE
    shown, places = in_unit(figure, found.value), decimals_of(figure, found.se)
    digits = f"{abs(shown):.{places}f}"
    return _with_unit(digits, shown, "", f"{error_text(figure, found.se)} {_SHORT[figure.unit]}")


def parts_text(figure: Figure, found: Estimate) -> str:
    """Say what one kind of sensor alone would give, in the figure's unit: "= LiDARs 56.3 + 4.9"; empty where a figure
    has no parts."""
    alone = [(kind_of(kind).plural, value) for kind, value in found.parts.items() if value > 0.0]
    if not found.exists or not alone:
        return ""
    first, value = alone[0]
    if len(alone) == 1:
        return f"{first} alone"
    more = f"{in_unit(figure, found.value - value):.1f}"
    return f"= {first} {in_unit(figure, value):.1f} + {more}"


def error_text(figure: Figure, se: float) -> str:
    """Return two standard errors as "±0.3", or "±0.03" below 0.1; never as zero unless there is no error: that is
    empty."""
    return f"±{max(in_unit(figure, SE_FACTOR * se), 0.01):.{decimals_of(figure, se)}f}" if se else ""


def decimals_of(figure: Figure, se: float) -> int:
    """Return the decimals of a value, or a change, with a standard error; of one without, for 0."""
    return 2 if in_unit(figure, SE_FACTOR * se) < 0.095 else 1


def change_text(figure: Figure, change: float, decimals: int = 2) -> str:
    """Format a signed change; one too small for the decimals has no sign, none at all is a dash.

    An arrow says where it goes if the sign does not say whether more is seen.
    """
    return _change(figure, change, decimals, "")


def change_estimate_text(figure: Figure, change: Estimate) -> str:
    """Format a change with two standard errors if it has any."""
    if not change.exists:
        return NONE
    return _change(figure, change.value, decimals_of(figure, change.se), error_text(figure, change.se))


def _change(figure: Figure, change: float, decimals: int, error: str) -> str:
    if change == 0.0:
        return NONE
    places = decimals if figure.unit in ("share", "nat") else 1
    size, least = abs(in_unit(figure, change)), 10.0**-places
    unit = f"{error} {_unit_of_change(figure)}".lstrip()
    if size < least / 2.0:
        return f"<{least:.{places}f} {unit}".rstrip()
    return _with_unit(f"{size:.{places}f}", change, "+", unit) + _arrow(figure, change)


def change_digits(figure: Figure, change: Estimate) -> str:
    """Format a change without its unit and error, for a column of them; a dash where there is none."""
    text = change_text(figure, change.value, 2 if figure.unit == "nat" else 1) if change.exists else NONE
    return text.removesuffix(f" {_unit_of_change(figure)}")


def exact_text(figure: Figure, value: float) -> str:
    """Return a value in full precision, with its unit."""
    if figure.unit == "share":
        return f"{value!r} of H(Ω)" if isinstance(figure, VoxelFigure) else f"{value!r}"
    return f"{value!r} {EXACT_UNITS[figure.unit]}"


def verdict(figure: Figure, change: Estimate) -> Verdict:
    """Return whether a change is for the better, or too small to tell: unresolved, or within its error; empty for none
    at all and for a figure without a direction."""
    if not change.exists or change.value == 0.0 or figure.better == "neither":
        return ""
    gain = figure.is_gain(change.value)
    if gain is None or abs(change.value) <= SE_FACTOR * change.se:
        return UNRESOLVED
    return "better" if gain else "worse"


def tip_text(
    figure: Figure, where: str, value: Estimate, change: Estimate, baseline: str, about: str = ""
) -> str:
    """Describe a figure in full: place, value, objects, error, change, and what it is of; or why there is none."""
    lines = [f"{where}: {precise_text(figure, value) if value.exists else value.reason}"]
    if value.state == "outside":
        lines.append(f"Outside the domain: {value.reason}")
    alone = (f"{kind_of(kind).plural} alone {value_text(figure, one)}" for kind, one in value.parts.items())
    lines += [", ".join(alone)] if value.parts else []
    if value.objects:
        lines.append(f"{figure.title} of {value.objects:,} objects")
    if change.exists:
        lines.append(_change_line(figure, change, baseline))
    return "\n".join([*lines, *filter(None, (about,))])


def precise_text(figure: Figure, value: Estimate) -> str:
    """Return a value exactly, that of objects with four digits and its error."""
    if not isinstance(figure, ObjectFigure):
        return exact_text(figure, value.value)
    calibrated = "the calibration and " if figure.calibration is not None else ""
    sure = f" ±{in_unit(figure, SE_FACTOR * value.se):.2g}"
    sure = f"{sure} (two standard errors of {calibrated}a sample of frames)" if value.se else ""
    return f"{in_unit(figure, value.value):.4g}{sure} {UNITS[figure.unit]}"


def _change_line(figure: Figure, change: Estimate, baseline: str) -> str:
    if change.value == 0.0:
        return f"the same as {baseline}"
    sure = f" ±{in_unit(figure, SE_FACTOR * change.se):.2g}" if change.se else ""
    told = f"{in_unit(figure, change.value):+.3g}{sure} {change_unit(figure)} against {baseline}"
    found = verdict(figure, change)
    return f"{told}: {found}" if found else told


def _unit_of_change(figure: Figure) -> str:
    return "pp" if figure.unit == "share" else _SHORT[figure.unit]


def _arrow(figure: Figure, change: float) -> str:
    return "" if figure.unit != "nat" else " ↑" if change > 0.0 else " ↓"


def _with_unit(digits: str, value: float, plus: str, unit: str) -> str:
    """Return digits with the sign of a value; digits of zero have no sign."""
    sign = (MINUS if value < 0 else plus) if any(one in "123456789" for one in digits) else ""
    return f"{sign}{digits} {unit}".rstrip()
