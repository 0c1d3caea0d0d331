"""Score the paper's eight rigs (Table I) on another scene, next to the published figures.

What can be compared is the order of the rigs, not the figures: those depend on the scene, on the voxel edge
and on the ray lattice.
"""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal, NamedTuple

from riglens.assets import asset_path
from riglens.core.engine.engine import Engine
from riglens.core.metric.scores import MetricSettings, Scores
from riglens.core.rig.presets import PAPER_CAMERA_GROUPS, PAPER_LIDAR_GROUPS, PAPER_RIGS, preset
from riglens.core.scene.boxes import CLASSES, Progress

Measure = Literal["camera_s_mig", "lidar_s_mig", "s_ms"]
MEASURES: tuple[Measure, ...] = ("camera_s_mig", "lidar_s_mig", "s_ms")
_NAT_PER_PUBLISHED = 1000.0


class Figures(NamedTuple):
    """One rig and one class of the table, in nats."""

    camera_s_mig: float
    lidar_s_mig: float
    s_ms: float

    def of(self, measure: Measure) -> float:
        """Return the figure of that name."""
        return self[MEASURES.index(measure)]


@dataclass(frozen=True)
class Table1Row:
    """One rig: our figures and the published ones by class name, in nats."""

    rig: str
    ours: dict[str, Figures]
    published: dict[str, Figures]


@dataclass(frozen=True)
class Order:
    """Names sorted by a measure, the lowest (best covered) first, here and in the paper.

    `agrees` when our figures rise strictly in the published order; `kendall_tau` and `spearman_rho` are the
    rank correlations of the figures, None when all of ours are equal.
    """

    cls: str
    what: Literal["LiDAR groups", "camera groups", "rigs"]
    measure: Measure
    ours: tuple[str, ...]
    published: tuple[str, ...]
    agrees: bool
    kendall_tau: float | None
    spearman_rho: float | None


@dataclass(frozen=True)
class Table1:
    """The table in the paper's layout, and for each class three orders: LiDAR groups, camera groups, rigs."""

    settings: MetricSettings
    rows: tuple[Table1Row, ...]
    orders: tuple[Order, ...]

    @property
    def agrees(self) -> bool:
        """Return whether every order of every class agrees."""
        return all(order.agrees for order in self.orders)


def table1(engine: Engine, settings: MetricSettings, progress: Progress | None = None) -> Table1:
    """Score the paper's eight rigs and compare them with the published figures.

    What `progress` raises passes through.
    """
    scores: dict[str, Scores] = {}
    for done, name in enumerate(PAPER_RIGS, 1):
        evaluation = engine.evaluate(preset(name), settings)
        scores[name] = evaluation.scores
        if progress is not None:
            progress(done / len(PAPER_RIGS))
    return compare(scores, settings)


def compare(scores: Mapping[str, Scores], settings: MetricSettings) -> Table1:
    """Return the table from scores of the eight rigs by name (W+C to N+T)."""
    published = published_table1()
    ours = {
        name: {
            cls: Figures(of.classes[cls].camera.s_mig, of.classes[cls].lidar.s_mig, of.classes[cls].s_ms)
            for cls in CLASSES
        }
        for name, of in scores.items()
    }
    rows = tuple(Table1Row(name, ours[name], published[name]) for name in PAPER_RIGS)
    orders = tuple(order for cls in CLASSES for order in _orders(rows, cls))
    return Table1(settings, rows, orders)


def published_table1() -> dict[str, dict[str, Figures]]:
    """Return the figures of the paper by rig and class, in nats (the paper prints thousands)."""
    table: dict[str, dict[str, Figures]] = {name: {} for name in PAPER_RIGS}
    with asset_path("paper", "table1.csv").open(encoding="utf-8", newline="") as stream:
        for line in csv.DictReader(stream):
            figures = [float(line[f"{measure}_1e3"]) * _NAT_PER_PUBLISHED for measure in MEASURES]
            table[line["rig"]][line["class"]] = Figures(*figures)
    return table


def _orders(rows: Sequence[Table1Row], cls: str) -> tuple[Order, ...]:
    """Return the three orders of a class; a group has the same S-MIG in every rig it is part of."""
    by_name = {row.rig: row for row in rows}
    lidars = {group: by_name[f"W+{group[0]}"] for group in PAPER_LIDAR_GROUPS}
    cameras = {group: by_name[f"{group[0]}+C"] for group in PAPER_CAMERA_GROUPS}
    return (
        _order(lidars, cls, "LiDAR groups", "lidar_s_mig"),
        _order(cameras, cls, "camera groups", "camera_s_mig"),
        _order(by_name, cls, "rigs", "s_ms"),
    )


def _order(
    rows: Mapping[str, Table1Row],
    cls: str,
    what: Literal["LiDAR groups", "camera groups", "rigs"],
    measure: Measure,
) -> Order:
    ours = {name: row.ours[cls].of(measure) for name, row in rows.items()}
    published = {name: row.published[cls].of(measure) for name, row in rows.items()}
    paper_order = tuple(sorted(rows, key=published.__getitem__))
    in_paper_order = [ours[name] for name in paper_order]
    tau, rho = tau_and_rho(list(ours.values()), list(published.values()))
    return Order(
        cls,
        what,
        measure,
        ours=tuple(sorted(rows, key=ours.__getitem__)),
        published=paper_order,
        agrees=all(low < high for low, high in pairwise(in_paper_order)),
        kendall_tau=tau,
        spearman_rho=rho,
    )


def tau_and_rho(some: list[float], others: list[float]) -> tuple[float | None, float | None]:
    """Return Kendall's tau-b and Spearman's rho, None if all figures of one are equal: they have no order."""
    if len(set(some)) == 1 or len(set(others)) == 1:
        return None, None
    from scipy import stats  # here, and not above: it takes longer to load than all the rest of the window

    tau = stats.kendalltau(some, others).statistic
    rho = stats.spearmanr(some, others).statistic
    return float(tau), float(rho)
