"""Format scores: columns of a class's scores, and their values as text with signs that need no colour.

Four figures come first, in the order of use: predicted AP, on target, seen, S-MS.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

from riglens.core.metric.scores import ClassScores, Reading
from riglens.core.sensors.registry import AnyKind, shown_kinds
from riglens.core.study.evidence import EVIDENCE
from riglens.core.targets.quantities import SE_FACTOR

MINUS, NONE = "\u2212", "–"

SIGN_NOTE = (
    "<b>S-MS = λ · S-MIG(cameras) + S-MIG(LiDARs)</b>, in nat, with S-MIG = −(entropy of the "
    "voxels that the sensors reach), as the paper writes it.<br>So S-MS <b>falls</b> as "
    "coverage grows: without sensors it is 0. The paper argues that S-MS grows "
    "with coverage; its formula does the opposite. Read S-MS together with "
    "<b>seen</b>, the share of the scene's uncertainty that any sensor covers, which grows "
    "with coverage.<br>The order of rigs by S-MS depends on voxels and ray lattices: "
    "do not trust small differences."
)
SCORE_FIGURES = (
    (
        "Predicted AP",
        "is the average precision, in %, that the detector of the detection study would reach with these "
        "LiDARs in this traffic. It does not predict your stack, ignores cameras, and is grey for rigs unlike "
        "those of the study.",
    ),
    (
        "On target",
        "rates each object by the distinct spots that the LiDARs hit, with occlusion by traffic and a solid car's "
        "body. It ignores cameras, and objects that the recording car did not see are missing.",
    ),
    (
        "Seen",
        "is the share of the scene's uncertainty that any sensor covers. It ignores occlusion by traffic and "
        "saturates near 100 %.",
    ),
    (
        "S-MS",
        (
            "is the paper's score, for comparison with the paper. It decreases as coverage grows: do "
            "not read it as a grade. The order in which it ranks rigs depends on voxels and rays."
        ),
    ),
)
"""The question each figure answers and its limits; README and docs/metric.md say the same."""
FIGURES_TITLE = "Four figures, four questions"
FIGURES_HELP = "".join(f"<p><b>{name}</b> {said}</p>" for name, said in SCORE_FIGURES)
FIGURES_HELP += f"<p><b>Against a detector</b> {' '.join(EVIDENCE.values())}</p>"
NOTHING_NOTE = "No boxes of this class: there is nothing to see"
NOT_COUNTED_NOTE = "Counting objects"
ON_TARGET_NOTE = (
    "Mean over the objects of the class of 1 - exp(-cells / 5), with the number of cells of 0.2 m "
    "on each that all LiDARs together hit; more is better.\nIncludes occlusion by "
    "traffic. During a drag it is estimated from a sample of frames, ± two standard errors. "
    "By distance and direction in the panel Targets."
)
PREDICTED_NOTE = (
    "Average precision (0 to 100) that the detector of the detection study would reach on these objects with the "
    "points of the LiDARs; more is better.\n"
    "Computed from the spots hit on each object by a curve per class. It compares rigs in the same traffic and does "
    "not predict the AP of your stack; cameras are ignored. Grey where the rig is outside its domain."
)
FOUND_NOTE = (
    "How many of 100 objects the detector of the second detection study would find with the points of the LiDARs, "
    "± two standard errors. It does not predict your stack; cameras are ignored. Grey outside its domain."
)
SEEN_NOTE = (
    "Share of the class's entropy H(Ω) that any enabled sensor covers; more is better.\n"
    "Occlusion by traffic is ignored here; on target includes it, see the panel Targets."
)


@dataclass(frozen=True)
class Column:
    """One number per class: its titles and its form; of shares, more is better."""

    key: str
    title: str
    short: str
    tip: str
    is_share: bool = False


@dataclass(frozen=True)
class MetricColumn(Column):
    """One of the scores of a class; NaN where there is nothing to take a share of."""

    value: Callable[[ClassScores], float] = field(kw_only=True)


PREDICTED = Column("predicted", "Predicted AP", "Pred. AP", PREDICTED_NOTE, is_share=True)
ON_TARGET = Column("on_target", "On target", "On target", ON_TARGET_NOTE, is_share=True)
DETECTED = Column(
    "detected",
    "Detected",
    "Detected",
    "Share of the objects with at least the LiDAR points set in the panel Targets; more is better.",
    is_share=True,
)
SEEN = MetricColumn(
    "seen",
    "Seen by any",
    "Seen",
    SEEN_NOTE,
    is_share=True,
    value=lambda c: c.any_seen if c.h_total > 0.0 else math.nan,
)
S_MS = MetricColumn("s_ms", "S-MS", "S-MS", SIGN_NOTE, value=lambda c: c.s_ms)


def columns() -> tuple[MetricColumn, ...]:
    """Return the scores: seen, S-MS, and the S-MIG of each kind of sensor that S-MS is made of."""
    return (SEEN, S_MS, *(_s_mig(kind) for kind in sorted(shown_kinds(()), key=lambda kind: kind.name)))


def _s_mig(kind: AnyKind) -> MetricColumn:
    return MetricColumn(
        kind.name,
        f"{kind.heading} S-MIG",
        f"S-MIG {kind.title[:3]}.",
        f"S-MIG of all enabled {kind.plural} together",
        value=lambda c: c.kinds[kind.name].s_mig,
    )


def column_of(key: str) -> MetricColumn:
    """Return the column of that key."""
    return next(column for column in columns() if column.key == key)


def rough_text(column: Column, value: float) -> str:
    """Format a value with one decimal instead of two: an estimate is no more precise."""
    if column.is_share:
        return f"{100 * value:.1f} %"
    return _signed(f"{abs(value) / 1000:.1f}", value, plus="")


def value_text(column: Column, value: float) -> str:
    """Format a value with two decimals in the column's unit, a dash where there is none."""
    if math.isnan(value):
        return NONE
    return share_text(value) if column.is_share else kilo_text(value)


def sampled_text(share: float, se: float) -> str:
    """Return a fraction as percent, with one decimal and its error where it was estimated."""
    if math.isnan(share) or se == 0.0:
        return NONE if math.isnan(share) else share_text(share)
    return f"{100 * share:.1f} ±{error_digits(se)} %"


def sampled_change_text(change: float, se: float) -> str:
    """Return a signed change of a fraction, with its error where it was estimated."""
    if math.isnan(change) or se == 0.0:
        return NONE if math.isnan(change) else change_text(change, ON_TARGET)
    return _signed(f"{abs(100 * change):.1f}", change, plus="+") + f" ±{error_digits(se)} pp"


def error_digits(se: float) -> str:
    """Format the error of a fraction, in percent with one decimal, never as zero."""
    return f"{max(100 * SE_FACTOR * se, 0.05):.1f}"


def kilo_text(value_nat: float) -> str:
    """Return 10^3 nat with two decimals and a real minus sign; never "-0.00"."""
    return _signed(f"{abs(value_nat) / 1000:.2f}", value_nat, plus="")


def share_text(share: float) -> str:
    """Return a fraction as percent with two decimals."""
    return f"{100 * share:.2f} %"


def change_text(change: float, column: Column) -> str:
    """Format a signed change; one too small for two decimals is marked, none at all is a dash.

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
