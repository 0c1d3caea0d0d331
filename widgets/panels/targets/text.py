"""Format figures of objects: shares in percent, points and pixels as numbers, errors and changes next to them."""

from __future__ import annotations

import math

from riglens.core.targets.quantities import FOUND, ON_TARGET, PREDICTED, RESOLVED, SE_FACTOR, Cells, Quantity
from riglens.widgets.panels.scores.text import MINUS, NONE, error_digits

UNITS = {"share": "%", "points": "points", "px": "px"}
UNRESOLVED = "too small to distinguish rigs"
CHANGE_UNITS = {"share": "pp", "points": "points", "px": "px"}


def value_text(quantity: Quantity, value: float) -> str:
    """Format a number with its unit, a dash where there is none."""
    if math.isnan(value):
        return NONE
    return f"{100.0 * value:.1f} %" if quantity.unit == "share" else f"{value:.0f} {_short(quantity)}"


def error_text(quantity: Quantity, se: float) -> str:
    """Return two standard errors as "±0.3", empty where all frames were used."""
    if se == 0.0 or math.isnan(se):
        return ""
    return f"±{error_digits(se)}" if quantity.unit == "share" else f"±{SE_FACTOR * se:.1f}"


def change_text(quantity: Quantity, change: float) -> str:
    """Return a signed change with its unit, empty where nothing changed."""
    if math.isnan(change) or change == 0.0:
        return ""
    size = abs(change) * (100.0 if quantity.unit == "share" else 1.0)
    told = "<0.1" if size < 0.05 else f"{size:.1f}"
    unit = "pp" if quantity.unit == "share" else _short(quantity)
    return f"{'+' if change > 0.0 else MINUS}{told} {unit}"


def is_better(quantity: Quantity, change: float) -> bool:
    """Return whether a nonzero change is an improvement."""
    return change * quantity.sign > 0.0


def tells_apart(quantity: Quantity, change: float) -> bool:
    """Return whether a change of a quantity is large enough to call a rig better or worse."""
    return not (quantity in (ON_TARGET, PREDICTED, FOUND) and abs(change) < RESOLVED)


def tip_text(
    quantity: Quantity,
    where: str,
    cells: Cells,
    place: int | tuple[int, int],
    baseline: str,
) -> str:
    """Describe one cell in full: place, quantity, number of objects, error, and change."""
    objects, value, se = int(cells.objects[place]), float(cells.value[place]), float(cells.se[place])
    if not objects:
        return f"{where}: no objects in these frames"
    unit, scale = UNITS[quantity.unit], 100.0 if quantity.unit == "share" else 1.0
    source = (
        "the calibration and a sample of frames" if quantity in (PREDICTED, FOUND) else "a sample of frames"
    )
    sure = f" ± {scale * SE_FACTOR * se:.2g} (two standard errors of {source})" if se else ""
    lines = [f"{where}: {scale * value:.4g}{sure} {unit}", f"{quantity.title} of {objects:,} objects"]
    change, change_se = float(cells.change[place]), float(cells.change_se[place])
    if change:
        sure = f" ± {scale * SE_FACTOR * change_se:.2g}" if change_se else ""
        better = "better" if is_better(quantity, change) else "worse"
        better = better if tells_apart(quantity, change) else UNRESOLVED
        told = CHANGE_UNITS[quantity.unit]
        lines.append(f"{scale * change:+.3g}{sure} {told} against {baseline}: {better}")
    return "\n".join(lines)


def _short(quantity: Quantity) -> str:
    return {"points": "pts", "px": "px"}.get(quantity.unit, "%")
