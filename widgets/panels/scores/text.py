"""How scores read: columns of a class's scores, and their values as text with signs that need no colour."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from riglens.core.metric.scores import ClassScores, Reading

MINUS, NONE = "\u2212", "–"

SIGN_NOTE = (
    "<b>S-MS = λ · S-MIG(cameras) + S-MIG(LiDARs)</b>, in nat, with S-MIG = −(entropy of the voxels "
    "that the sensors reach), as the paper writes it.<br>So S-MS <b>falls</b> as coverage "
    "grows: without sensors it is 0. The paper argues the other way round, that covering more is better; "
    "both are true of the published system. Read S-MS together with <b>seen</b>, the share of the scene's "
    "uncertainty that any sensor looks at, which grows with coverage.<br>The order of rigs by S-MS depends on voxels "
    "and ray lattices (stability study): do not trust a small lead."
)
NOTHING_NOTE = "No boxes of this class: there is nothing to see"
SEEN_NOTE = (
    "Share of the class's entropy H(Ω) that any enabled sensor looks at; more is better.\n"
    "Traffic blocks no ray here: what stands behind it is told by on target, in the panel Targets"
)


@dataclass(frozen=True)
class Column:
    """One number per class: its titles, its value, its text form, and the sign of its change as coverage grows.

    The value is NaN where there is nothing to take a share of.
    """

    key: str
    title: str
    short: str
    tip: str
    value: Callable[[ClassScores], float]
    is_share: bool = False


COLUMNS = (
    Column(
        "camera",
        "Cameras S-MIG",
        "S-MIG cam.",
        "S-MIG of all enabled cameras together",
        lambda c: c.camera.s_mig,
    ),
    Column(
        "lidar", "LiDARs S-MIG", "S-MIG LiD.", "S-MIG of all enabled LiDARs together", lambda c: c.lidar.s_mig
    ),
    Column("s_ms", "S-MS", "S-MS", SIGN_NOTE, lambda c: c.s_ms),
    Column(
        "seen",
        "Seen by any",
        "Seen",
        SEEN_NOTE,
        lambda c: c.any_seen if c.h_total > 0.0 else math.nan,
        is_share=True,
    ),
)


def column_of(key: str) -> Column:
    """Return the column of that key."""
    return next(column for column in COLUMNS if column.key == key)


def rough_text(column: Column, value: float) -> str:
    """Return a value with one decimal instead of two: an estimate is no better than that."""
    if column.is_share:
        return f"{100 * value:.1f} %"
    return _signed(f"{abs(value) / 1000:.1f}", value, plus="")


def value_text(column: Column, value: float) -> str:
    """Return a value with two decimals in the column's unit, a dash where there is none."""
    if math.isnan(value):
        return NONE
    return share_text(value) if column.is_share else kilo_text(value)


def kilo_text(value_nat: float) -> str:
    """Return 10^3 nat with two decimals and a real minus sign; never "-0.00"."""
    return _signed(f"{abs(value_nat) / 1000:.2f}", value_nat, plus="")


def share_text(share: float) -> str:
    """Return a fraction as percent with two decimals."""
    return f"{100 * share:.2f} %"


def change_text(change: float, column: Column) -> str:
    """Return a signed change; a change too small for two decimals says so, none at all is a dash.

    Where the number goes is an arrow for S-MS and S-MIG, whose sign does not say whether more is seen.
    """
    if change == 0.0:
        return NONE
    size, unit = (abs(change) * 100, " pp") if column.is_share else (abs(change) / 1000, "")
    digits = f"{size:.2f}" if size >= 0.005 else "<0.01"
    arrow = "" if column.is_share else " ↑" if change > 0.0 else " ↓"
    return _signed(digits, change, plus="+") + unit + arrow


def looks_at_more(change: float, column: Column, reading: Reading) -> bool:
    """Return whether a non-zero change means that more is seen: the sign depends on score and reading."""
    return (change > 0) == (column.is_share or reading == "residual")


def exact_text(column: Column, value: float) -> str:
    """Return the value in full precision, with its unit."""
    if math.isnan(value):
        return NOTHING_NOTE
    return f"{value!r} of H(Ω)" if column.is_share else f"{value!r} nat"


def _signed(digits: str, value: float, plus: str) -> str:
    if not any(character in "123456789" for character in digits):
        return digits
    return (MINUS if value < 0 else plus) + digits
