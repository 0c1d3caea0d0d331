"""Describe the stability study: names of settings, the table of orders line by line, and the findings.

The findings say which methods fail where, and what the metric cannot promise.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from statistics import median

from riglens.app.studies.accuracy_text import edge_text
from riglens.core.scene.boxes import CLASSES
from riglens.core.study.stability_methods import METHODS, MethodName, MethodRow, Verdict
from riglens.core.study.stability_metric import (
    DEFAULT_LATTICE,
    LETTERS,
    NATIVE,
    MetricStudy,
    Ranking,
    RayLattice,
    Variation,
    agreement,
    swapped,
)

TITLES: dict[MethodName, str] = {"fast": "fast engine", "plain": "plain method", "bresenham": "Bresenham"}
MOST_NAMED = 5
Named = tuple[str, Ranking]
GROUPS = ", ".join(f"{letter} {name}" for letter, name in LETTERS.items())
READING_THE_TABLE = (
    "τ (Kendall) and ρ (Spearman) compare S-MS of the eight rigs with the first row, class by class. The "
    f"letters are the groups by S-MIG, lowest first: {GROUPS}. "
    "'Least' is the lowest correlation and the rarest order."
)


@dataclass(frozen=True)
class Line:
    """Line of the table of orders: a setting and its results, class by class."""

    setting: str
    cells: tuple[Cell, ...]


@dataclass(frozen=True)
class Cell:
    """Correlations with the default and orders of the groups as letters; None and "" without one."""

    tau: float | None
    rho: float | None
    lidars: str
    cameras: str
    lidars_as_default: bool
    cameras_as_default: bool


def setting_text(variation: Variation) -> str:
    """The name of a setting."""
    value = variation.value
    if isinstance(value, RayLattice):
        return lattice_text(value)
    if isinstance(value, str):
        return f"reading {value}"
    return edge_text(value) if variation.axis == "δ" else f"λ {value:g}"


def lattice_text(lattice: RayLattice) -> str:
    """Return rays per camera and azimuths, where they differ from the default."""
    parts = []
    if lattice.cast != DEFAULT_LATTICE.cast:
        parts.append(f"{lattice.cast[0]} × {lattice.cast[1]} rays")
    if lattice.azimuths != DEFAULT_LATTICE.azimuths:
        parts.append(f"{lattice.azimuths} azimuths")
    return ", ".join(parts)


def default_text(study: MetricStudy) -> str:
    """The name of the reference."""
    return f"default: {edge_text(study.plan.voxel_m)}, λ {study.plan.camera_weight:g}"


def lines(study: MetricStudy) -> Iterator[Line]:
    """The table of orders: the default, every variation, the resampled frames in two lines."""
    yield _line(default_text(study), study.reference, study)
    for variation in sorted(study.variations, key=_position):
        yield _line(setting_text(variation), variation.ranking, study)
    if study.resamples:
        yield from _resample_lines(study)


def _position(variation: Variation) -> tuple[int, float]:
    axis = ("δ", "rays", "reading", "λ").index(variation.axis)
    return axis, -variation.value if isinstance(variation.value, float) and axis == 0 else 0.0


def _line(setting: str, ranking: Ranking, study: MetricStudy) -> Line:
    return Line(setting, tuple(_cell(ranking, study.reference, cls) for cls in CLASSES))


def _cell(ranking: Ranking, reference: Ranking, cls: str) -> Cell:
    found = agreement(ranking, reference, cls)
    lidars, cameras = ("".join(ranking.order(of, cls)) for of in ("lidars", "cameras"))
    default = ["".join(reference.order(of, cls)) for of in ("lidars", "cameras")]
    return Cell(found.tau, found.rho, lidars, cameras, lidars == default[0], cameras == default[1])


def _resample_lines(study: MetricStudy) -> Iterator[Line]:
    """Median and least correlation over the resamples, with the most frequent and the rarest order."""
    count = len(study.resamples)
    every = [_line("", drawn, study).cells for drawn in study.resamples]
    by_class = [*zip(*every, strict=True)]
    yield Line(f"frames resampled {count} times: median", tuple(_summary(cells, False) for cells in by_class))
    yield Line(f"frames resampled {count} times: least", tuple(_summary(cells, True) for cells in by_class))


def _summary(cells: Sequence[Cell], least: bool) -> Cell:
    taus = [cell.tau for cell in cells if cell.tau is not None]
    rhos = [cell.rho for cell in cells if cell.rho is not None]
    pick = min if least else median
    orders = [Counter(getattr(cell, of) for cell in cells).most_common() for of in ("lidars", "cameras")]
    lidars, cameras = (order[-1 if least else 0][0] for order in orders)
    as_default = [
        next(getattr(cell, f"{of}_as_default") for cell in cells if getattr(cell, of) == name)
        for of, name in (("lidars", lidars), ("cameras", cameras))
    ]
    return Cell(
        pick(taus) if taus else None,
        pick(rhos) if rhos else None,
        lidars,
        cameras,
        as_default[0],
        as_default[1],
    )


def caption(study: MetricStudy, source: str) -> str:
    """Describe the inputs of the orders in one line."""
    plan = study.plan
    return (
        f"{source}, {study.frames:,} frames · {edge_text(plan.voxel_m)}, λ {plan.camera_weight:g}, "
        f"{DEFAULT_LATTICE.cast[0]} × {DEFAULT_LATTICE.cast[1]} rays per camera, "
        f"{DEFAULT_LATTICE.azimuths} azimuths per LiDAR, reading covered"
    )


# ---------------------------------------------------------------- what it finds


@dataclass(frozen=True)
class Finding:
    """Expectation of the metric, the verdict on this scene, and the figures."""

    claim: str
    verdict: Verdict
    evidence: str


def methods_verdict(rows: Sequence[MethodRow]) -> Iterator[str]:
    """Yield for each method the number of cases it gets right, and its failures."""
    for method in METHODS:
        judged = [row for row in rows if row.outcomes[method].verdict != "n.a."]
        failed = [row.case for row in judged if row.outcomes[method].verdict == "fails"]
        if not failed:
            yield f"{TITLES[method]}: right in all {len(judged)} cases."
            continue
        more = f" and {len(failed) - MOST_NAMED} more" if len(failed) > MOST_NAMED else ""
        shown = "; ".join(failed[:MOST_NAMED]) + more
        yield f"{TITLES[method]}: fails in {len(failed)} of {len(judged)} cases ({shown})."


def findings(study: MetricStudy) -> Iterator[Finding]:
    """Yield the expectations of the metric with their verdicts on this scene."""
    if not any(study.h_total[study.plan.voxel_m].values()):
        yield Finding("the scene has entropy", "n.a.", "H(Ω) = 0 for every class: there is no order")
        return
    yield from _about_sign(study)
    yield _about_copies(study)
    yield from _about_grids(study)
    yield from _about_rays(study)
    yield from _about_readings(study)
    yield _about_order("the order does not depend on λ", study, _named(study.along("λ")))
    if study.resamples:
        drawn = [(f"resample {number}", ranking) for number, ranking in enumerate(study.resamples, 1)]
        yield _about_order("the order does not depend on which frames were sampled", study, drawn)


# ---------------------------------------------------------------- one rig


def _nat(value_nat: float) -> str:
    return f"{value_nat / 1e3:,.1f}".replace("-", "−")


def _richest_class(study: MetricStudy) -> str:
    totals = study.h_total[study.plan.voxel_m]
    return max(totals, key=totals.__getitem__)


def _about_sign(study: MetricStudy) -> Iterator[Finding]:
    cls = _richest_class(study)
    empty, lidars, rig = (study.probes[name].s_ms[cls] for name in ("empty", "lidars", "rig"))
    yield Finding(
        "a rig without sensors is not the best",
        "fails" if empty >= rig else "ok",
        f"S-MS without sensors is 0, of W+T {_nat(rig)} · 10³ nat ({cls}): the highest "
        "possible score goes to the rig that sees nothing. S-MS falls as coverage grows; read it with 'seen'.",
    )
    yield Finding(
        "more sensors never lower the score",
        "fails" if rig < lidars else "ok",
        f"Trapezoid alone {_nat(lidars)}, with six cameras more {_nat(rig)} · 10³ nat ({cls}).",
    )


def _about_copies(study: MetricStudy) -> Finding:
    cls = _richest_class(study)
    once, twice = (study.probes[name].s_ms[cls] for name in ("rig", "twins"))
    hits = [study.probes[name].s_ms[cls] for name in ("rig, hits", "twins, hits")]
    factor = hits[1] / hits[0] if hits[0] else 1.0
    return Finding(
        "a copy of a sensor in the same place changes nothing",
        "ok" if once == twice else "fails",
        f"W+T {_nat(once)}, with each LiDAR twice {_nat(twice)} · 10³ nat ({cls}). "
        f"The reading hits fails here: {factor:.2f} times as much.",
    )


# ---------------------------------------------------------------- orders


def _named(variations: Iterable[Variation]) -> list[Named]:
    return [(setting_text(variation), variation.ranking) for variation in variations]


def _about_grids(study: MetricStudy) -> Iterator[Finding]:
    if len(study.h_total) < 2:
        return
    cls = _richest_class(study)
    finest, coarsest = min(study.h_total), max(study.h_total)
    factor = study.h_total[finest][cls] / (study.h_total[coarsest][cls] or 1.0)
    yield Finding(
        "scores of different grids can be compared",
        "fails" if factor > 1.1 else "ok",
        f"H(Ω) of {cls} is {factor:,.0f} times as large at {edge_text(finest)} as at {edge_text(coarsest)}, "
        "and so is S-MS.",
    )
    yield _about_order("the order does not depend on δ", study, _named(study.along("δ")))


def _about_rays(study: MetricStudy) -> Iterator[Finding]:
    if study.along("rays"):
        others = _named(study.along("rays"))
        yield _about_order("the order does not depend on the number of rays", study, others)
    for variation in study.along("rays"):
        if variation.value == NATIVE:
            yield _about_native(study, variation.ranking)


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
    return Finding(
        "352 × 128 rays rank the cameras as all 1600 × 900 pixels do",
        "ok" if same else "fails",
        f"{'; '.join(parts)}.{reason}",
    )


def _about_readings(study: MetricStudy) -> Iterator[Finding]:
    for variation in study.along("reading"):
        if variation.value == "hits":
            yield _about_order("the reading hits gives the order of covered", study, _named([variation]))
            continue
        taus = [agreement(variation.ranking, study.reference, cls).tau for cls in CLASSES]
        yield Finding(
            "the reading residual gives the order of covered, reversed",
            "ok" if all(tau is None or tau < -0.999 for tau in taus) else "fails",
            "By definition: what is unseen is H(Ω) less what is seen, so the highest sees most.",
        )


def _about_order(claim: str, study: MetricStudy, others: Sequence[Named]) -> Finding:
    """Return whether the eight rigs keep their order in all settings, for all classes."""
    ordered = [cls for cls in CLASSES if study.reference.order("rigs", cls)]
    kept = {
        cls: [not swapped(ranking, study.reference, "rigs", cls) for _, ranking in others] for cls in ordered
    }
    parts = [_about_class(study, others, cls, kept[cls]) for cls in ordered]
    verdict: Verdict = "ok" if all(all(flags) for flags in kept.values()) else "fails"
    return Finding(claim, verdict, f"{'; '.join(parts)}. {_swaps(study, others, len(ordered))}".strip())


def _about_class(study: MetricStudy, others: Sequence[Named], cls: str, kept: Sequence[bool]) -> str:
    found = [(agreement(ranking, study.reference, cls).tau, name) for name, ranking in others]
    least, name = min(((tau, name) for tau, name in found if tau is not None), default=(None, ""))
    tau = "" if least is None else f"τ {least:.2f}".replace("-", "−")
    if len(others) == 1:
        return f"{cls}: {tau}"
    where = f", least {tau} ({name})" if tau and not all(kept) else ""
    return f"{cls}: kept in {sum(kept)} of {len(kept)}{where}"


def _swaps(study: MetricStudy, others: Sequence[Named], classes: int) -> str:
    """Name the groups that change places, and how often."""
    counts: Counter[str] = Counter()
    for cls in CLASSES:
        for _, ranking in others:
            for of in ("lidars", "cameras"):
                for pair in swapped(ranking, study.reference, of, cls):
                    counts[" and ".join(sorted(LETTERS[letter] for letter in pair))] += 1
    shown = ", ".join(f"{pair} {count} ×" for pair, count in counts.most_common(4))
    return f"Groups that change places, out of {classes * len(others)}: {shown}." if shown else ""


# ---------------------------------------------------------------- what can be relied on


def conclusion(study: MetricStudy) -> Iterator[str]:
    """Yield pairs of groups that never change places (reading `covered`), and the distance of those that do."""
    others = [variation.ranking for variation in study.variations if variation.axis != "reading"]
    others += study.resamples
    for of, title in (("lidars", "LiDAR groups"), ("cameras", "camera groups")):
        classes = [cls for cls in CLASSES if study.reference.order(of, cls)]
        if not classes:
            continue
        pairs = _agreed_pairs(study.reference, of, classes)
        swaps = [
            (cls, pair) for r in others for cls in classes for pair in swapped(r, study.reference, of, cls)
        ]
        moved = {pair for _, pair in swaps}
        firm = [f"{LETTERS[a]} before {LETTERS[b]}" for a, b in pairs if (a, b) not in moved]
        gaps = [_gap(study.reference.figures(of, cls), pair) for cls, pair in swaps]
        rule = f" Pairs up to {max(gaps):.1%} apart by default change places." if gaps else ""
        yield (
            f"{title} whose order holds for all classes in all {len(others)} settings of δ, rays, λ "
            f"and frames: {', '.join(firm) or 'none'}.{rule}"
        )


def _agreed_pairs(reference: Ranking, of: str, classes: Sequence[str]) -> list[tuple[str, str]]:
    """Pairs that every class puts in the same order by default."""
    places = [{name: place for place, name in enumerate(reference.order(of, cls))} for cls in classes]
    return [(a, b) for a in places[0] for b in places[0] if all(place[a] < place[b] for place in places)]


def _gap(figures: dict[str, float], pair: tuple[str, str]) -> float:
    """Difference of two figures as a share of the larger."""
    one, other = (abs(figures[name]) for name in pair)
    return abs(one - other) / max(one, other)
