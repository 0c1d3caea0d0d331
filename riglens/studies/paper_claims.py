"""The part of `riglens study table1` that repeats the paper's own claims: Fig. 5, its percentages, λ, and the voxel
that turns wide and narrow cameras round."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from riglens.core.engine.engine import Engine
from riglens.core.metric.scores import MetricSettings
from riglens.core.rig.presets import preset
from riglens.core.scene.boxes import CLASSES
from riglens.core.shown_tables import Block, ShownTable, Styled, table
from riglens.core.shown_values import thousands
from riglens.core.study.paper_claims import EVERY, MOST_LAMBDA, Claims, Sweep

WIDE, NARROW = "Wide", "Narrow"


@dataclass(frozen=True)
class CameraScores:
    """Camera S-MIG in nats and the share of entropy seen by wide and by narrow cameras on one voxel edge, by class:
    (wide, narrow) each."""

    voxel_m: float
    s_mig: dict[str, tuple[float, float]]
    seen: dict[str, tuple[float, float]]


def camera_scores(engine: Engine, voxel_m: float, settings: MetricSettings) -> CameraScores:
    """Score both groups of cameras on the field of an engine, with voxels of this edge."""
    wide, narrow = (engine.evaluate(preset(name), settings).scores.classes for name in (WIDE, NARROW))
    return CameraScores(
        voxel_m,
        {cls: (wide[cls].camera.s_mig, narrow[cls].camera.s_mig) for cls in CLASSES},
        {cls: (wide[cls].camera.seen, narrow[cls].camera.seen) for cls in CLASSES},
    )


def claims_shown(of: Claims, ours: Sequence[Sweep], voxels: Sequence[CameraScores]) -> Iterator[Block]:
    """Yield the claims next to what the tables say."""
    yield _fig5_table(of)
    largest = max(of.spread, key=lambda one: one.points)
    by_class = ", ".join(f"{one.cls} {one.points:.1f}" for one in of.spread)
    ahead, every = of.wide_ahead
    least, most = of.wide_leads
    yield (
        f'"Up to 30 %": rigs differ by {largest.points:.1f} points of AP at most: {largest.cls}, '
        f"{largest.detector},"
    )
    yield f"{largest.best} against {largest.worst}. By class: {by_class}."
    yield f'"Wide up to 10 %": wide cameras lead narrow ones in {ahead} of {every} pairs with the same LiDARs'
    yield f"and detector, by {least:.1f} to {most:.1f} points."
    yield _sweep_table(of.sweeps, ours)
    yield "λ: weights of cameras in S-MS with the best rank, of the published S-MIG and of ours,"
    yield f"up to {MOST_LAMBDA:g}. No detector was trained twice; of eight rigs a random order reaches 0.74 in 5 %."
    yield _voxel_table(voxels)
    turned = [cls for cls in CLASSES if len({_is_narrow_ahead(one, cls) for one in voxels}) > 1]
    if turned:
        yield f"The voxel edge turns wide and narrow cameras round for {', '.join(turned)}:"
        yield "which of them sees more entropy is no property of the cameras."


def _is_narrow_ahead(of: CameraScores, cls: str) -> bool:
    wide, narrow = of.seen[cls]
    return narrow > wide


def _fig5_table(of: Claims) -> ShownTable:
    shown = table(
        "Fig. 5 from the paper's own tables", *CLASSES, title=Styled("ρ of S-MS with published AP", "bold")
    )
    for name in of.fig5[CLASSES[0]]:
        cells = (_rank(of.fig5[cls][name]) for cls in CLASSES)
        shown.add_row(Styled(name, "bold") if name == EVERY else name, *cells)
    return shown


def _sweep_table(published: Sequence[Sweep], ours: Sequence[Sweep]) -> ShownTable:
    titles = ("best ρ\npaper", "λ\npaper", "best ρ\nours", "λ\nours", "ρ, ours,\npaper's λ")
    shown = table("class", "detector", *titles, words={0, 1, 3, 5}, dense=True)
    for one, other in zip(published, ours, strict=True):
        is_first = one.detector == EVERY
        shown.add_row(
            one.cls if is_first else "",
            one.detector,
            _rank(one.best),
            _range(one),
            _rank(other.best),
            _range(other),
            _rank(other.usual),
        )
    return shown


def _rank(rho: float) -> str:
    return "–" if math.isnan(rho) else f"{rho:+.2f}".replace("-", "−")


def _range(of: Sweep) -> str:
    if math.isnan(of.best):
        return "–"
    return f"{of.low:.2f}–{of.high:.2f}"


def _voxel_table(voxels: Sequence[CameraScores]) -> ShownTable:
    titles = [f"{cls}\n{group.lower()}" for cls in CLASSES for group in (WIDE, NARROW)]
    shown = table("seen by cameras alone, %\nS-MIG, 10³ nat", *titles)
    for one in voxels:
        shown.add_row(Styled(f"voxel {one.voxel_m:g} m", "bold"))
        shown.add_row("  seen", *(f"{100.0 * value:.1f}" for cls in CLASSES for value in one.seen[cls]))
        shown.add_row("  S-MIG", *(thousands(value, 2) for cls in CLASSES for value in one.s_mig[cls]))
    return shown
