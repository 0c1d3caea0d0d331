"""The page of the second study says what its tables say."""

from __future__ import annotations

from pathlib import Path
from statistics import mean

import pytest

from tools.detection_second import Line, Tables, lines, outcomes

DOCS = Path(__file__).resolve().parents[4] / "docs"
PAGE = (DOCS / "study-detection-2.md").read_text(encoding="utf-8")
LABELS = {
    "pillars": "`pillars`, three sweeps",
    "one-sweep": "`one-sweep`",
    "range": "`range`",
    "painted": "`painted`",
}


def rows(table: str, **of: str) -> list[Line]:
    return [
        line
        for line in lines(DOCS / "data" / f"detection2{table}.csv")
        if all(line[key] == value for key, value in of.items())
    ]


def test_outcomes_of_all_hypotheses_are_those_of_the_tables() -> None:
    said = {number: holds for number, holds, _ in outcomes(Tables())}
    assert sorted(said) == list(range(1, 12))
    for number, holds in said.items():
        (line,) = (line for line in PAGE.splitlines() if line.startswith(f"| {number} |"))
        assert f"**{'held' if holds else 'refuted'}**" in line


@pytest.mark.parametrize("part", LABELS)
def test_errors_of_predicted_ap(part: str) -> None:
    cells = []
    for name in ("car", "bicycle", "pedestrian", "mean"):
        apart = [
            100 * float(line["predicted"]) - float(line["ap"])
            for line in rows("", part=part, **{"class": name})
        ]
        cells.append(f"{mean(map(abs, apart)):.1f} ({mean(apart):+.1f})".replace("-", "−"))
    assert f"| {LABELS[part]} | {' | '.join(cells)} |" in PAGE


def test_the_error_of_predicted_ap_follows_the_quality_of_the_rig() -> None:
    said = []
    for part in ("one-sweep", "pillars"):
        of = sorted(rows("", part=part, **{"class": "mean"}), key=lambda line: float(line["ap"]))
        apart = [100 * float(line["predicted"]) - float(line["ap"]) for line in of]
        said.append([f"{mean(some):+.1f}".replace("-", "−") for some in (apart[:8], apart[8:15], apart[15:])])
    one, three = said
    page = " ".join(PAGE.split())
    assert f"{one[0]} points for the eight poorest rigs, {one[1]} for seven in between and {one[2]}" in page
    assert f"three sweeps: {', '.join(three)})" in page


@pytest.mark.parametrize(
    ("surrogate", "label"),
    [
        ("on_target", "on target"),
        ("share_5", "share with ≥ 5 points"),
        ("share_1", "share with ≥ 1 point"),
        ("predicted", "predicted AP"),
        ("seen", "*seen*"),
        ("rays", "number of rays"),
        ("s_ms", "S-MS"),
    ],
)
def test_rank_correlations_of_the_parts(surrogate: str, label: str) -> None:
    cells = []
    for part in ("one-sweep", "range"):
        of = {"part": part, "among": "all rigs", "surrogate": surrogate, "class": "mean"}
        (line,) = rows("-ranks", **of)
        cells.append(
            "{value} [{low}, {high}]".format_map(
                {key: f"{float(line[key]):.2f}" for key in ("value", "low", "high")}
            )
        )
    figures = " | ".join(cells).replace("-", "−")
    assert f"| {label} | {figures} |" in PAGE


def test_painted_rigs() -> None:
    found = rows("", part="painted", **{"class": "mean"})
    for start in (0, 3, 6):
        cells = [
            f"{float(one['ap']):.1f} [{float(one['ap_low']):.1f}, {float(one['ap_high']):.1f}]"
            for one in found[start : start + 3]
        ]
        assert f" | {' | '.join(cells)} |" in PAGE


@pytest.mark.parametrize("name", ["car", "bicycle", "pedestrian"])
def test_recall_by_points(name: str) -> None:
    found = rows("-recall", part="one-sweep", ring="all", **{"class": name})
    assert all(
        float(line["recall"]) == pytest.approx(int(line["found"]) / int(line["objects"]), abs=1e-4)
        for line in found
    )
    cells = [f"{100 * float(line['recall']):.1f}" for line in found]
    assert f"| {name} | {' | '.join(cells)} |" in PAGE
