"""The second half of `riglens study table1`: published average precision against our figures of the same rigs."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from riglens.core.engine.engine import Engine
from riglens.core.figures.registry import figure_named
from riglens.core.figures.text import in_sentence
from riglens.core.files import write_file
from riglens.core.monitor import Monitor
from riglens.core.scene.boxes import CLASSES, DataReport
from riglens.core.shown_tables import Block, ShownTable, Styled, table
from riglens.core.shown_values import NONE, thousands
from riglens.core.study.detection.statistics import COLUMNS, MEAN
from riglens.core.study.detection.surrogates import SURROGATES, Surrogates, surrogates
from riglens.core.study.ranks import RankCorrelation
from riglens.core.study.table2 import Agreement, Paper, agreements, icra, place3d
from riglens.core.targets.engine import TargetEngine
from riglens.core.targets.settings import USUAL
from riglens.core.targets.traffic import WITHIN_M, Traffic, traffic_of
from riglens.evaluation.options import SceneOptions
from riglens.evaluation.traffic import load_traffic
from riglens.studies.files import csv_text

SAMPLE_FRAMES = 400
"""Frames in which points on objects are counted, drawn at random: the order of rigs needs no more."""
_TITLES = {"residual": "S-MS residual", "hits": "S-MS hits", "perception": "perception entropy"}
"""Of what is no figure of ours: readings of one, and another paper's."""
_COMPARED = tuple(name for name in SURROGATES if name not in ("rays", "predicted"))
"""Rigs of a paper all cast the same number of rays; predicted AP is of another detector."""
_SHOWN = tuple(name for name in _COMPARED if name not in ("share_1", "perception"))
"""A pipe has no room for more columns: the baseline and the other paper's figure stand with the ranks alone."""
SURE_P = 0.05
_IN_NATS = ("s_ms", "residual", "hits")


@dataclass(frozen=True)
class Compared:
    """A paper, our figures of its rigs, those of objects only where there are any, and their agreement."""

    paper: Paper
    has_objects: bool
    ours: Surrogates
    agreements: list[Agreement]


def compare_papers(engine: Engine, scene: SceneOptions, monitor: Monitor) -> list[Compared]:
    """Score the rigs of both papers in all ways."""
    if scene.pog is not None:
        monitor.note("a POG holds no individual objects: figures of objects are left out")
    targets = TargetEngine(_traffic(scene))
    papers, found = (icra(), place3d()), list[Compared]()
    total = sum(len(paper.rigs) for paper in papers)
    with monitor.stage("Comparing with published detection") as progress:
        for paper in papers:
            done = sum(len(one.paper.rigs) for one in found)

            def tell(share: float, done: int = done, count: int = len(paper.rigs)) -> None:
                progress((done + share * count) / total)

            ours = surrogates(paper.rigs, engine, targets, USUAL, tell)
            found.append(Compared(paper, scene.pog is None, ours, agreements(paper, ours)))
    return found


def _traffic(scene: SceneOptions) -> Traffic:
    """Return a random sample of frames; none for a POG."""
    if scene.pog is not None:
        nothing = np.zeros((0, 3)), np.zeros((0, 3)), np.zeros((0, 3, 3))
        report = DataReport("a POG", 1, dict.fromkeys(CLASSES, 0))
        return traffic_of(report, np.zeros(0, np.int64), np.zeros(0, np.uint8), *nothing)
    traffic = load_traffic(scene, WITHIN_M)
    return traffic.frames_alone(np.arange(min(SAMPLE_FRAMES, traffic.frames)))


def papers_shown(found: Sequence[Compared]) -> Iterator[Block]:
    """Yield figures and rank correlations of each paper, and the conclusion."""
    for one in found:
        yield figures_table(one)
        yield ranks_table(one)
    yield from verdict(found)


def figures_table(one: Compared) -> ShownTable:
    """Return rigs as rows: published percent by class, and our figures, mean over the classes."""
    published = (f"paper\n{column.replace('pedestrian', 'pedestr.')}" for column in COLUMNS)
    ours = (
        f"10³ nat\n{_title(name).removeprefix('S-MS ')}"
        if name in _IN_NATS
        else "\n".join(("%", *_title(name).rsplit(" ", 1)))
        for name in _SHOWN
    )
    title = Styled(f"{one.paper.name}: published AP, our figures", "bold")
    dim = range(1, 1 + len(COLUMNS))
    shown = table("AP in %", *published, *ours, title=title, dense=True, dim=dim)
    for place, rig in enumerate(one.paper.rigs):
        percent = [f"{one.paper.of(name).mean(axis=0)[place]:.1f}" for name in COLUMNS]
        shown.add_row(rig.name, *percent, *(_figure(one, name, place) for name in _SHOWN))
    return shown


def _title(name: str) -> str:
    """Return a figure's short title, as within a sentence."""
    figure = figure_named(name)
    return _TITLES[name] if figure is None else in_sentence(figure.short)


def _figure(one: Compared, name: str, place: int) -> str:
    figure = figure_named(name)
    if figure is not None and figure.needs == "objects" and not one.has_objects:
        return NONE
    value = float(one.ours.of(name, MEAN)[place])
    return thousands(value, 2) if name in _IN_NATS else f"{100.0 * value:.1f}"


def ranks_table(one: Compared) -> ShownTable:
    """Return our figures as rows: Spearman's correlation with the published order by class, and its 95 % interval."""
    titles = (f"\n{column}" for column in COLUMNS)
    shown = table(f"{one.paper.name}\nρ (95 %)", *titles, words=range(1 + len(COLUMNS)), dense=True)
    by_key = {(it.surrogate, it.column): it.found for it in one.agreements}
    for name in _COMPARED:
        shown.add_row(_title(name), *(_rank(by_key[name, column]) for column in COLUMNS))
    return shown


def _rank(found: RankCorrelation | None) -> str:
    if found is None:
        return "–"
    star = "*" if found.p < SURE_P else " "
    return f"{found.value:+.2f}{star} ({found.low:+.1f}…{found.high:+.1f})".replace("-", "−")


def verdict(found: Sequence[Compared]) -> Iterable[str]:
    """Yield the meaning of the numbers, and how far the papers agree with themselves and each other."""
    yield "ρ is Spearman's; positive: rigs that see more detect better. The interval draws rigs and detectors;"
    yield f"* p < {SURE_P:g} among all orders of the rigs, each figure for itself."
    yield "Detectors of one paper agree on the order of rigs at τ, mean of pairs:"
    for one in found:
        agree = ", ".join(f"{column} {one.paper.detectors_agree(column):+.2f}" for column in COLUMNS)
        yield f"  {one.paper.name}: {agree}".replace("-", "−")
    yield "Mean car AP of the placements that both papers have:"
    for one in found:
        groups = one.paper.groups("car")
        order = " < ".join(f"{name} {groups[name]:.1f}" for name in sorted(groups, key=groups.__getitem__))
        yield f"  {one.paper.name}: {order}"
    yield "Both were trained once, without error bars; placements of one name differ in poses and views."


def csv_lines(found: Sequence[Compared]) -> Iterator[dict[str, object]]:
    """Yield a line per paper, rig and class: published percent of each detector's mean, and our figures."""
    for one in found:
        for place, rig in enumerate(one.paper.rigs):
            for column in COLUMNS:
                of = one.paper.of(column)[:, place]
                line: dict[str, object] = {"paper": one.paper.name, "rig": rig.name, "class": column}
                line |= {"ap_percent": f"{of.mean():.4f}"}
                line |= {"ap_least": f"{of.min():.2f}", "ap_most": f"{of.max():.2f}"}
                yield line | {name: repr(float(one.ours.of(name, column)[place])) for name in SURROGATES}


def write_papers(found: Sequence[Compared], path: Path) -> None:
    """Write the figures as CSV."""
    write_file(path, csv_text(list(csv_lines(found))))
