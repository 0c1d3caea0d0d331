"""The sentences about the published study say what its tables and its page say."""

from __future__ import annotations

import csv
import re
from itertools import pairwise
from math import sqrt
from pathlib import Path
from statistics import mean, variance

import numpy as np
import pytest

from riglens.core.study.detection.published import PROTOCOL, published_rigs
from riglens.core.study.evidence import EVIDENCE, PAGE
from riglens.core.study.ranks import spearman

DOCS = Path(__file__).resolve().parents[4] / "docs"


def lines(name: str) -> list[dict[str, str]]:
    with (DOCS / "data" / name).open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))


def told(among: str, name: str) -> str:
    (found,) = (
        row
        for row in lines("detection-ranks.csv")
        if (row["among"], row["surrogate"], row["class"], row["statistic"])
        == (among, name, "mean", "spearman")
    )
    value, low, high = (float(found[key]) for key in ("value", "low", "high"))
    return f"{value:.2f} [{low:.2f}, {high:.2f}]".replace("-", "−")


@pytest.mark.parametrize("name", list(EVIDENCE))
@pytest.mark.parametrize("among", ["all rigs", "equal ray count"])
def test_a_sentence_has_the_figures_of_the_table_and_so_has_the_page(name: str, among: str) -> None:
    figures = told(among, name)
    assert figures in EVIDENCE[name]
    assert figures in (DOCS / PAGE).read_text(encoding="utf-8")


def test_the_tables_are_those_of_the_registered_rigs_and_seeds() -> None:
    rigs = {row["rig"] for row in lines("detection.csv")}
    assert rigs == {rig.name for rig in published_rigs()}
    assert {int(row["seed"]) for row in lines("detection-seeds.csv")} == set(range(1, PROTOCOL.seeds + 1))
    by_mean = {row["rig"]: float(row["ap"]) for row in lines("detection.csv") if row["class"] == "mean"}
    ladder = [
        "1 x 16 low in front",
        "1 x 16 on the roof",
        "2 x 16 on the roof",
        "Trapezoid",
        "velodyne-vlp-32c",
    ]
    assert all(by_mean[low] + 3.0 < by_mean[high] for low, high in pairwise(ladder))


LABELS = {
    "on_target": "on target",
    "share_5": "share with ≥ 5 points",
    "share_1": "share with ≥ 1 point",
    "seen": "*seen*",
    "rays": "number of rays",
    "s_ms": "S-MS",
    "residual": "S-MS, `residual`",
    "hits": "S-MS, `hits`",
    "on_target_60m": "on target within 60 m",
    "share_5_60m": "≥ 5 points within 60 m",
}
COLUMNS = ("car", "bicycle", "pedestrian", "mean")


def with_interval(row: dict[str, str], name: str = "value", low: str = "low", high: str = "high") -> str:
    if not row[name]:
        return "–"
    value, least, most = (float(row[key]) for key in (name, low, high))
    return f"{value:.2f} [{least:.2f}, {most:.2f}]".replace("-", "−")


def test_the_page_has_the_rank_correlations_of_the_table() -> None:
    page = (DOCS / PAGE).read_text(encoding="utf-8")
    rows = {
        (row["among"], row["surrogate"], row["class"]): with_interval(row)
        for row in lines("detection-ranks.csv")
        if row["statistic"] == "spearman"
    }
    for name, label in LABELS.items():
        among = ("all rigs", "equal ray count", "LiDAR groups", "random rigs")
        said = [rows[group, name, "mean"] for group in among if (group, name, "mean") in rows]
        shown = 4 if name in ("on_target", "share_5", "share_1", "seen", "s_ms") else 2
        assert f"| {label} | {' | '.join(said[:shown])} |" in page, name


def test_figures_of_a_rig_are_the_means_of_its_classes() -> None:
    by_rig: dict[str, dict[str, dict[str, str]]] = {}
    for row in lines("detection.csv"):
        by_rig.setdefault(row["rig"], {})[row["class"]] = row
    for of in by_rig.values():
        for name in ("on_target", "share_5", "share_1", "seen"):
            by_class = mean(float(of[cls][name]) for cls in COLUMNS[:3])
            assert float(of["mean"][name]) == pytest.approx(by_class, abs=2e-4)


def test_the_page_has_the_least_and_the_largest_map() -> None:
    page = (DOCS / PAGE).read_text(encoding="utf-8")
    of_mean = sorted(
        (float(row["ap"]), float(row["ap_low"]), float(row["ap_high"]))
        for row in lines("detection.csv")
        if row["class"] == "mean"
    )
    for value, low, high in (of_mean[0], of_mean[-1]):
        assert f"{value:.1f} [{low:.1f}, {high:.1f}]" in page


def test_orders_are_those_of_the_tables_of_rigs_and_pairs() -> None:
    page = (DOCS / PAGE).read_text(encoding="utf-8")
    figures = {row["rig"]: row for row in lines("detection.csv") if row["class"] == "mean"}
    bands = {"all": (0.0, 100.0), "below 10 points": (0.0, 10.0), "from 10 points": (10.0, 100.0)}
    counted: dict[tuple[str, str], list[bool]] = {}
    near: dict[int, list[bool]] = {}
    for row in lines("detection-pairs.csv"):
        if row["class"] != "mean":
            continue
        one, other = figures[row["rig"]], figures[row["other"]]
        lead = float(one["ap"]) - float(other["ap"])
        apart = float(one["on_target"]) - float(other["on_target"])
        near.setdefault(sum(abs(apart) >= edge for edge in (0.01, 0.04)), []).append(apart * lead > 0.0)
        if row["verdict"] == "not resolved":
            continue
        for name in set(LABELS) & set(one):
            right = (float(one[name]) - float(other[name])) * lead > 0.0
            for band, (low, high) in bands.items():
                if low <= abs(lead) < high:
                    counted.setdefault((name, band), []).append(right)
    rows = {
        (row["surrogate"], row["apart"]): (int(row["pairs"]), int(row["right"]))
        for row in lines("detection-orders.csv")
        if row["class"] == "mean"
    }
    for key, (pairs, right) in rows.items():
        assert pairs == len(counted[key]) and abs(right - sum(counted[key])) <= 1, key  # figures are rounded
    for name in ("on_target", "share_5", "share_1", "seen", "rays", "s_ms"):
        said = (
            f"{rows[name, band][1]} ({100 * rows[name, band][1] / rows[name, band][0]:.0f} %)"
            for band in bands
        )
        assert f"| {LABELS[name]} | {' | '.join(said)} |" in page, name
    shares = [100 * mean(near[band]) for band in range(3)]
    assert f"in {shares[0]:.0f} %, from 0.01 to 0.04 in {shares[1]:.0f} %, beyond in all" in page
    assert shares[2] == 100.0


def test_published_placements_stand_beside_ours() -> None:
    page = (DOCS / PAGE).read_text(encoding="utf-8")
    rows = {
        (row["paper"], row["surrogate"], row["class"]): with_interval(row)
        for row in lines("detection-placements.csv")
    }
    for paper in ("Place3D", "ICRA, Table II"):
        assert all(rows[paper, "on_target", of] in page for of in ("car", "mean")), paper


def test_seeds_differ_by_less_than_a_point_and_by_what_the_page_says() -> None:
    rows, page = lines("detection-seeds.csv"), (DOCS / PAGE).read_text(encoding="utf-8")
    spread = {}
    for column in ("mean", "car", "bicycle", "pedestrian"):
        by_rig: dict[str, list[float]] = {}
        for row in rows:
            by_rig.setdefault(row["rig"], []).append(float(row[column]))
        spread[column] = sqrt(mean(variance(values) for values in by_rig.values()))
    assert spread["mean"] <= 1.0
    said = "{mean:.1f} points for mAP (car {car:.1f}, bicycle {bicycle:.1f}, pedestrian {pedestrian:.1f})"
    assert said.format(**spread) in page


def test_nets_of_their_own_rank_rigs_as_the_shared_one_does() -> None:
    rows, page = lines("detection-own.csv"), (DOCS / PAGE).read_text(encoding="utf-8")
    shared = {(row["rig"], row["class"]): float(row["ap"]) for row in lines("detection.csv")}
    said = []
    for column in ("mean", "car", "bicycle", "pedestrian"):
        pairs = [
            (float(row["shared"]), float(row["own"]), row["rig"]) for row in rows if row["class"] == column
        ]
        assert len(pairs) == 8
        assert all(one == pytest.approx(shared[rig, column], abs=1e-3) for one, _, rig in pairs)
        said.append(float(spearman(*(np.array([pair[k] for pair in pairs]) for k in (0, 1)))))
    assert said[0] >= 0.9
    for value, name in zip(said, ("mAP", "cars", "bicycles", "pedestrians"), strict=True):
        assert re.search(rf"{value:.2f} \[\S+ \S+\] for\s{name}", page), name


def test_the_page_tells_what_the_tables_say_of_cameras() -> None:
    page = (DOCS / PAGE).read_text(encoding="utf-8")
    ap = {(row["rig"], row["class"]): row for row in lines("detection-cameras.csv")}
    apart = {(row["rig"], row["other"], row["class"]): row for row in lines("detection-cameras-pairs.csv")}
    groups = ("Center", "Pyramid", "Line", "Trapezoid")
    for group in groups:
        wide, narrow = f"W+{group[0]}", f"N+{group[0]}"
        of = [ap[rig, "mean"] for rig in (wide, narrow, group)]
        told_of = (f"{float(r['ap']):.1f} [{float(r['ap_low']):.1f}, {float(r['ap_high']):.1f}]" for r in of)
        assert f"| {group} | {' | '.join(told_of)} |" in page
        lead = apart.get((wide, narrow, "mean")) or apart[narrow, wide, "mean"]
        assert 0.55 <= abs(float(lead["difference"])) < 0.95 and lead["verdict"] == "not resolved"
    gains = {
        name: mean(float(ap[f"W+{g[0]}", name]["ap"]) - float(ap[g, name]["ap"]) for g in groups)
        for name in ("bicycle", "pedestrian", "car")
    }
    assert "by {bicycle:.1f} and {pedestrian:.1f} points of AP, cars by {car:.1f}".format(**gains) in page
