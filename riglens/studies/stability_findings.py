"""State what the stability study finds: which methods fail where, and what the metric cannot promise."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from riglens.core.scene.boxes import CLASSES
from riglens.core.study.stability_methods import METHOD_NAMES, MethodName, MethodRow, Verdict
from riglens.core.study.stability_metric import (
    DEFAULT_LATTICE,
    LETTERS,
    NATIVE,
    Axis,
    MetricStudy,
    Ranking,
    RayLattice,
    Setting,
    agreement,
    swapped,
)
from riglens.studies.accuracy_text import edge_text

TITLES: dict[MethodName, str] = {"fast": "fast engine", "plain": "plain method", "bresenham": "Bresenham"}
MOST_NAMED = 5


class Finding(NamedTuple):
    """Expectation of the metric, the verdict on this scene, and the figures."""

    claim: str
    verdict: Verdict
    evidence: str

    @classmethod
    def of(cls, claim: str, holds: bool, evidence: str) -> Finding:
        """Return the finding on an expectation that holds or fails."""
        return cls(claim, "ok" if holds else "fails", evidence)


def setting_text(axis: Axis, value: float | RayLattice | str) -> str:
    """Return the name of a setting; of a lattice what differs from the default."""
    if isinstance(value, RayLattice):
        cast = f"{value.cast[0]} × {value.cast[1]} rays" if value.cast != DEFAULT_LATTICE.cast else ""
        turn = f"{value.azimuths} azimuths" if value.azimuths != DEFAULT_LATTICE.azimuths else ""
        return ", ".join(filter(None, (cast, turn)))
    if isinstance(value, str):
        return f"reading {value}"
    return edge_text(value) if axis == "δ" else f"resample {value}" if axis == "frames" else f"λ {value:g}"


def methods_verdict(rows: Sequence[MethodRow]) -> Iterator[str]:
    """Yield for each method the number of cases it gets right, and its failures."""
    for method in METHOD_NAMES:
        judged = [row for row in rows if row.outcomes[method].verdict != "n.a."]
        failed = [row.case for row in judged if row.outcomes[method].verdict == "fails"]
        more = f" and {len(failed) - MOST_NAMED} more" if len(failed) > MOST_NAMED else ""
        yield (
            f"{TITLES[method]}: fails in {len(failed)} of {len(judged)} cases "
            f"({'; '.join(failed[:MOST_NAMED])}{more})."
            if failed
            else f"{TITLES[method]}: right in all {len(judged)} cases."
        )


def findings(study: MetricStudy) -> Iterator[Finding]:
    """Yield the expectations of the metric with their verdicts on this scene."""
    totals = study.h_total[study.plan.voxel_m]
    if not any(totals.values()):
        yield Finding("the scene has entropy", "n.a.", "H(Ω) = 0 for every class: there is no order")
        return
    yield from _about_rigs(study, max(totals, key=totals.__getitem__))
    if study.along("δ"):
        yield _about_order("the order does not depend on δ", study, study.along("δ"))
    if study.along("rays"):
        yield _about_order("the order does not depend on the number of rays", study, study.along("rays"))
    for other in study.along("rays"):
        if other.value == NATIVE:
            yield _about_native(study, other.ranking)
    residual, hits = study.along("reading")
    taus = [agreement(residual.ranking, study.reference, cls).tau for cls in CLASSES]
    yield Finding.of(
        "the reading residual gives the order of covered, reversed",
        all(tau is None or tau < -0.999 for tau in taus),
        "By definition: what is unseen is H(Ω) less what is seen, so the highest sees most.",
    )
    yield _about_order("the reading hits gives the order of covered", study, [hits])
    yield _about_order("the order does not depend on λ", study, study.along("λ"))
    if drawn := study.along("frames"):
        yield _about_order("the order does not depend on which frames were sampled", study, drawn)


def _about_rigs(study: MetricStudy, cls: str) -> Iterator[Finding]:
    """Yield what the metric says of rigs that ask it a question, and of voxels of other edges, for one class."""
    s_ms = {name: by_class[cls] for name, by_class in study.probes.items()}
    nat = {name: f"{value / 1e3:,.1f}".replace("-", "−") for name, value in s_ms.items()}
    yield Finding.of(
        "a rig without sensors is not the best",
        s_ms["empty"] < s_ms["rig"],
        f"S-MS without sensors is 0, of W+T {nat['rig']} · 10³ nat ({cls}): the highest "
        "possible score goes to the rig that sees nothing. S-MS falls as coverage grows; read it with 'seen'.",
    )
    yield Finding.of(
        "more sensors never lower the score",
        s_ms["rig"] >= s_ms["lidars"],
        f"Trapezoid alone {nat['lidars']}, with six cameras more {nat['rig']} · 10³ nat ({cls}).",
    )
    factor = s_ms["twins, hits"] / s_ms["rig, hits"] if s_ms["rig, hits"] else 1.0
    yield Finding.of(
        "a copy of a sensor in the same place changes nothing",
        s_ms["rig"] == s_ms["twins"],
        f"W+T {nat['rig']}, with each LiDAR twice {nat['twins']} · 10³ nat ({cls}). "
        f"The reading hits fails here: {factor:.2f} times as much.",
    )
    finest, coarsest = min(study.h_total), max(study.h_total)
    factor = study.h_total[finest][cls] / (study.h_total[coarsest][cls] or 1.0)
    if finest < coarsest:
        yield Finding.of(
            "scores of different grids can be compared",
            factor <= 1.1,
            f"H(Ω) of {cls} is {factor:,.0f} times as large at {edge_text(finest)} as at {edge_text(coarsest)}, "
            "and so is S-MS.",
        )


def _about_native(study: MetricStudy, native: Ranking) -> Finding:
    """Return whether the few rays cast by default rank the cameras as all their pixels do."""
    parts = []
    for cls in CLASSES:
        if study.reference.order("cameras", cls):
            orders = [ranking.order("cameras", cls) for ranking in (study.reference, native)]
            few, every = (" before ".join(LETTERS[letter] for letter in order) for order in orders)
            parts.append(f"{cls}: {every}" + ("" if few == every else f", by default {few}"))
    same = not any(swapped(native, study.reference, "cameras", cls) for cls in CLASSES)
    reason = (
        "" if same else " Where rays are farther apart than voxels, a narrow camera fills its view better."
    )
    return Finding.of(
        "352 × 128 rays rank the cameras as all 1600 × 900 pixels do", same, f"{'; '.join(parts)}.{reason}"
    )


def _about_order(claim: str, study: MetricStudy, others: Sequence[Setting]) -> Finding:
    """Return whether the eight rigs keep their order in all settings, for all classes; name the groups that swap."""
    parts, is_kept = [], True
    for cls in (cls for cls in CLASSES if study.reference.order("rigs", cls)):
        kept = [not swapped(other.ranking, study.reference, "rigs", cls) for other in others]
        is_kept = is_kept and all(kept)
        found = (
            (agreement(other.ranking, study.reference, cls).tau, setting_text(other.axis, other.value))
            for other in others
        )
        least, name = min(((tau, name) for tau, name in found if tau is not None), default=(None, ""))
        tau = "" if least is None else f"τ {least:.2f}".replace("-", "−")
        where = f", least {tau} ({name})" if tau and not all(kept) else ""
        parts.append(
            f"{cls}: {tau}" if len(others) == 1 else f"{cls}: kept in {sum(kept)} of {len(kept)}{where}"
        )
    counts = Counter(
        " and ".join(sorted(LETTERS[letter] for letter in pair))
        for cls in CLASSES
        for other in others
        for of in ("lidars", "cameras")
        for pair in swapped(other.ranking, study.reference, of, cls)
    )
    shown = ", ".join(f"{pair} {count} ×" for pair, count in counts.most_common(4))
    swaps = f"Groups that change places, out of {len(parts) * len(others)}: {shown}." if shown else ""
    return Finding.of(claim, is_kept, f"{'; '.join(parts)}. {swaps}".strip())


def conclusion(study: MetricStudy) -> Iterator[str]:
    """Yield pairs of groups whose order never changes (reading `covered`), and the distance of those whose order
    does."""
    others = [other.ranking for other in study.others if other.axis != "reading"]
    for of, title in (("lidars", "LiDAR groups"), ("cameras", "Camera groups")):
        orders = {cls: order for cls in CLASSES if (order := study.reference.order(of, cls))}
        if not orders:
            continue
        swaps = [
            (cls, pair) for r in others for cls in orders for pair in swapped(r, study.reference, of, cls)
        ]
        moved = {pair for _, pair in swaps}
        groups = next(iter(orders.values()))
        firm = [
            f"{LETTERS[a]} before {LETTERS[b]}"
            for a in groups
            for b in groups
            if (a, b) not in moved and all(order.index(a) < order.index(b) for order in orders.values())
        ]
        gaps = []
        for cls, pair in swaps:
            one, other = (abs(study.reference.figures(of, cls)[name]) for name in pair)
            gaps.append(abs(one - other) / max(one, other))
        rule = f" Pairs up to {100.0 * max(gaps):.1f} % apart by default change places." if gaps else ""
        yield (
            f"{title} whose order holds for all classes in all {len(others)} settings of δ, rays, λ "
            f"and frames: {', '.join(firm) or 'none'}.{rule}"
        )
