"""The page of the third study says what its tables say."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from riglens.core.study.detection.third import MEETING, PARTS
from tools.detection_second import Line
from tools.detection_third import Tables, outcomes

DOCS = Path(__file__).resolve().parents[4] / "docs"
PAGE = (DOCS / "study-detection-3.md").read_text(encoding="utf-8")
PARTS_AND_FUSED = (*PARTS, "fused")


@pytest.fixture(scope="module")
def tables() -> Tables:
    return Tables()


def interval(line: Line) -> str:
    return f"{float(line['ap']):.1f} [{float(line['ap_low']):.1f}, {float(line['ap_high']):.1f}]"


def predicted(line: Line) -> str:
    return f"{100.0 * float(line['predicted']):.1f}"


def test_outcomes_of_all_hypotheses_are_those_of_the_tables(tables: Tables) -> None:
    said = {number: holds for number, holds, _ in outcomes(tables)}
    assert sorted(said) == list(range(1, 9))
    for number, holds in said.items():
        (line,) = (line for line in PAGE.splitlines() if line.startswith(f"| {number} |"))
        assert f"**{'held' if holds else 'refuted'}**" in line
    assert all(verdict == "not resolved" for _, verdict, *_ in tables.wide_or_narrow())


def test_rigs_of_lidars_and_of_cameras(tables: Tables) -> None:
    for line in tables.of("lidars"):
        rays = f"{int(float(line['rays'])):,}"
        assert f"| {line['rig']} | {rays} | {interval(line)} | {predicted(line)} |" in PAGE
    for line in tables.of("cameras"):
        seen = f"{float(line['seen_by_cameras']):.2f}"
        assert f"| {line['rig']} | {interval(line)} | {predicted(line)} | {seen} |" in PAGE


def test_fused_rigs(tables: Tables) -> None:
    lines, count = tables.of("fused"), 1 + len(MEETING)
    for start in range(0, len(lines), count):
        cells = (f"{float(line['ap']):.1f} ({predicted(line)})" for line in lines[start : start + count])
        assert f"| {lines[start]['rig']} | {' | '.join(cells)} |" in PAGE


def test_errors_of_predicted_ap(tables: Tables) -> None:
    for part in PARTS_AND_FUSED:
        cells = []
        for name in ("car", "bicycle", "pedestrian", "mean"):
            apart = tables.column(part, "predicted", name) - tables.column(part, "ap", name)
            cells.append(f"{np.abs(apart).mean():.1f} ({apart.mean():+.1f})".replace("-", "−"))
        assert f"| `{part}` | {' | '.join(cells)} |" in PAGE


@pytest.mark.parametrize(
    ("surrogate", "label"),
    [
        ("predicted", "predicted AP"),
        ("on_target", "on target"),
        ("seen_by_cameras", "seen by cameras"),
        ("perception", "perception entropy (Ma et al. 2021)"),
        ("seen", "*seen*"),
        ("rays", "number of rays"),
        ("s_ms", "S-MS"),
    ],
)
def test_rank_correlations_of_the_parts(tables: Tables, surrogate: str, label: str) -> None:
    cells = []
    for part in PARTS_AND_FUSED:
        (line,) = (
            line
            for line in tables.ranks
            if (line["part"], line["among"], line["surrogate"]) == (part, "all rigs", surrogate)
        )
        found = [f"{float(line[key]):.2f}" for key in ("value", "low", "high") if line[key]]
        cells.append("{} [{}, {}]".format(*found).replace("-", "−") if found else "–")
    assert f"| {label} | {' | '.join(cells)} |" in PAGE
