"""Claims of the paper, from its own Tables I and II: Fig. 5, the spread of 30 %, wide cameras ahead by 10 %, and the
weight of cameras that would suit each detector best."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations, groupby, pairwise

import numpy as np
from numpy.typing import NDArray

from riglens.core.rig.presets import PAPER_LIDAR_GROUPS, PAPER_RIGS
from riglens.core.scene.boxes import CLASSES
from riglens.core.study.ranks import spearman
from riglens.core.study.table1 import Figures
from riglens.core.study.table2 import Paper

Doubles = NDArray[np.float64]
EVERY = "mean of detectors"
MOST_LAMBDA = 10.0
"""End of the sweep; beyond, the order of rigs no longer changes much."""


@dataclass(frozen=True)
class Fluctuation:
    """Spread of a detector's average precision of a class over the rigs, percentage points."""

    cls: str
    detector: str
    points: float
    best: str
    worst: str


@dataclass(frozen=True)
class Sweep:
    """Weights of cameras by which S-MS ranks the rigs as a detector does: the best rank correlation, the widest range
    of λ that reaches it, and the correlation at the paper's λ; NaN where all rigs have the same S-MIG."""

    cls: str
    detector: str
    best: float
    low: float
    high: float
    usual: float


@dataclass(frozen=True)
class Claims:
    """fig5: Spearman of S-MS with average precision by class, for the mean of detectors and for each; spread: the
    largest one of each class; wide_leads: least and most lead of wide cameras over narrow ones with the same LiDARs
    and detector, points, and how many of all are leads."""

    fig5: Mapping[str, Mapping[str, float]]
    spread: tuple[Fluctuation, ...]
    wide_leads: tuple[float, float]
    wide_ahead: tuple[int, int]
    sweeps: tuple[Sweep, ...]


def claims(paper: Paper, table: Mapping[str, Mapping[str, Figures]], usual: float) -> Claims:
    """Return what follows from published average precision of the eight rigs and their figures by rig and class;
    `usual`: the paper's λ."""
    assert [one.name for one in paper.rigs] == list(PAPER_RIGS)
    fig5 = {}
    for cls in CLASSES:
        s_ms = np.array([table[rig][cls].s_ms for rig in PAPER_RIGS])
        fig5[cls] = {name: float(spearman(s_ms, ap)) for name, ap in _detections(paper, cls).items()}
    leads = paper.percent[:, :, : len(PAPER_LIDAR_GROUPS)] - paper.percent[:, :, len(PAPER_LIDAR_GROUPS) :]
    return Claims(
        fig5,
        tuple(max(_spreads(paper, cls), key=lambda one: one.points) for cls in CLASSES),
        (float(leads.min()), float(leads.max())),
        (int((leads > 0.0).sum()), leads.size),
        tuple(sweeps(paper, table, usual)),
    )


def sweeps(paper: Paper, table: Mapping[str, Mapping[str, Figures]], usual: float) -> Sequence[Sweep]:
    """Return the best λ by class and detector, of the S-MIG of a table."""
    return [
        _sweep(cls, name, ap, *_migs(table, cls), usual)
        for cls in CLASSES
        for name, ap in _detections(paper, cls).items()
    ]


def _migs(table: Mapping[str, Mapping[str, Figures]], cls: str) -> tuple[Doubles, Doubles]:
    rows = [table[rig][cls] for rig in PAPER_RIGS]
    return np.array([one.camera_s_mig for one in rows]), np.array([one.lidar_s_mig for one in rows])


def _detections(paper: Paper, cls: str) -> dict[str, Doubles]:
    """Return average precision (rigs,) by detector, their mean first."""
    of = paper.of(cls)
    return {EVERY: of.mean(axis=0)} | dict(zip(paper.detectors, of, strict=True))


def _spreads(paper: Paper, cls: str) -> list[Fluctuation]:
    found = []
    for detector, ap in zip(paper.detectors, paper.of(cls), strict=True):
        best, worst = PAPER_RIGS[int(ap.argmax())], PAPER_RIGS[int(ap.argmin())]
        found.append(Fluctuation(cls, detector, float(np.ptp(ap)), best, worst))
    return found


def _sweep(cls: str, name: str, ap: Doubles, camera: Doubles, lidar: Doubles, usual: float) -> Sweep:
    """Try λ in every interval in which the order of the rigs stays the same; of several runs of the best ones the
    widest is returned."""
    edges = [0.0, *sorted(set(_crossings(camera, lidar))), MOST_LAMBDA]
    spans = list(pairwise(edges))
    ranks = [float(spearman((low + high) / 2 * camera + lidar, ap)) for low, high in spans]
    known = [rank for rank in ranks if not math.isnan(rank)]
    if not known:
        return Sweep(cls, name, math.nan, math.nan, math.nan, math.nan)
    best = max(known)
    runs = [
        [spans[place] for place in places]
        for is_best, places in groupby(range(len(spans)), lambda place: ranks[place] >= best - 1e-12)
        if is_best
    ]
    low, high = max(((run[0][0], run[-1][1]) for run in runs), key=lambda ends: ends[1] - ends[0])
    return Sweep(cls, name, best, low, high, float(spearman(usual * camera + lidar, ap)))


def _crossings(camera: Doubles, lidar: Doubles) -> list[float]:
    """Return the λ at which two rigs have the same S-MS."""
    found = []
    for one, other in combinations(range(len(camera)), 2):
        apart = camera[one] - camera[other]
        if apart != 0.0:
            at = (lidar[other] - lidar[one]) / apart
            if 0.0 < at < MOST_LAMBDA:
                found.append(float(at))
    return found
