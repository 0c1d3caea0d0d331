"""Gather the parts of the second study of detection into the tables of docs/data, and print what its hypotheses became.

    python -m tools.detection_second FOLDER

FOLDER/PART holds the output of `riglens study detection --second PART`. Without a folder the tables stay as they are.
"""

from __future__ import annotations

import csv
import sys
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from riglens.core.study.detection.second import PROTOCOLS
from riglens.core.study.detection.statistics import MEAN
from riglens.core.study.ranks import spearman
from riglens.studies.files import csv_text

DATA = Path(__file__).resolve().parents[1] / "docs" / "data"
TABLES = ("", "-ranks", "-pairs", "-orders", "-recall")
BASELINES = ("seen", "rays", "share_1")
Line = dict[str, str]
Doubles = NDArray[np.float64]


def lines(path: Path) -> list[Line]:
    """Read a table."""
    with path.open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))


def gather(folder: Path, tables: Path = DATA) -> None:
    """Renew the lines of all parts that have ended in `folder`, with a column for the part; pairs and orders of mAP
    alone. Lines of other parts stay."""
    for table in TABLES:
        name = f"detection2{table}.csv"
        published = lines(tables / name) if (tables / name).exists() else []
        found = [
            line
            for part in PROTOCOLS
            for line in (
                _of_part(folder, part, table)
                if (folder / part / "detection.json").exists()
                else [one for one in published if one["part"] == part]
            )
        ]
        (tables / name).write_text(csv_text(found), encoding="utf-8")
    points = folder / "one-sweep" / "detection-recall-points.csv"  # of which the bundled recall is made
    if points.exists():
        (tables / "detection2-recall-points.csv").write_bytes(points.read_bytes())


def _of_part(folder: Path, part: str, table: str) -> list[Line]:
    return [
        {"part": part} | line
        for line in lines(folder / part / f"detection{table}.csv")
        if (table not in ("-pairs", "-orders") or line["class"] == MEAN)
        and line.get("statistic") != "kendall"
    ]


class Tables:
    """The tables of a study in docs/data."""

    def __init__(self, study: str = "detection2", tables: Path = DATA) -> None:
        self.rigs, self.ranks, self.pairs, self.orders = (
            lines(tables / f"{study}{table}.csv") for table in TABLES[:4]
        )
        self.parts = {line["part"] for line in self.rigs}

    def of(self, part: str, cls: str = MEAN) -> list[Line]:
        """Return the lines of a part's rigs."""
        return [line for line in self.rigs if (line["part"], line["class"]) == (part, cls)]

    def column(self, part: str, name: str, cls: str = MEAN) -> Doubles:
        """Return a figure of all rigs of a part, percent for average precision as for predicted AP."""
        scale = 100.0 if name == "predicted" else 1.0
        return np.array([scale * float(line[name]) for line in self.of(part, cls)])

    def rank(self, part: str, surrogate: str, among: str = "all rigs") -> float:
        """Return Spearman's coefficient of a figure with mAP."""
        key = (part, among, surrogate, MEAN)
        (found,) = (
            float(line["value"])
            for line in self.ranks
            if (line["part"], line["among"], line["surrogate"], line["class"]) == key
        )
        return found

    def right(self, surrogate: str, apart: str) -> float:
        """Return the share of resolved pairs that a figure orders as mAP of pillars does."""
        (line,) = (
            one
            for one in self.orders
            if (one["part"], one["surrogate"], one["apart"]) == ("pillars", surrogate, apart)
        )
        return int(line["right"]) / int(line["pairs"])

    def missed(self, part: str, chosen: slice = slice(None)) -> float:
        """Return the mean error of predicted mAP, percentage points."""
        apart = self.column(part, "predicted") - self.column(part, "ap")
        return float(np.abs(apart[chosen]).mean())


def outcomes(of: Tables) -> Iterator[tuple[int, bool, str]]:
    """Yield number, outcome and figures of each hypothesis whose parts have ended."""
    first = {name: of.rank("pillars", name) for name in ("on_target", "share_5", "s_ms", *BASELINES)}
    yield 1, first["on_target"] >= 0.9, f"on target {first['on_target']:.2f}"
    groups = dict.fromkeys(line["among"] for line in of.ranks if line["among"].startswith("budget"))
    within = {name: of.rank("pillars", "on_target", name) for name in groups}
    yield 2, min(within.values()) >= 0.7, f"on target within budgets {within}"
    lead = {name: first["on_target"] - first[name] for name in ("rays", "share_1")}
    yield 3, min(lead.values()) >= 0.02, f"on target less {lead}, {first}"
    yield 4, first["share_5"] >= 0.9, f"share of 5 points {first['share_5']:.2f}"
    is_fifth = first["on_target"] > first["seen"] and first["s_ms"] < 0.0
    yield 5, is_fifth, f"seen {first['seen']:.2f}, S-MS {first['s_ms']:.2f}"
    near = {name: of.right(name, "below 10 points") for name in ("on_target", *BASELINES)}
    is_sixth = near["on_target"] >= 0.8 and all(near["on_target"] > near[name] for name in BASELINES)
    yield 6, is_sixth, f"near pairs {near}"
    yield 7, of.missed("pillars") <= 3.0, f"error of predicted mAP {of.missed('pillars'):.2f} points"
    if "one-sweep" in of.parts:
        yield 8, of.missed("one-sweep") <= 3.0, f"error of predicted mAP {of.missed('one-sweep'):.2f} points"
        more = of.column("pillars", "ap") > of.column("one-sweep", "ap")
        yield 10, int(more.sum()) >= 20, f"three sweeps give more for {more.sum()} of {len(more)} rigs"
    if "range" in of.parts:
        alike = float(spearman(of.column("pillars", "ap"), of.column("range", "ap")))
        ranged = of.rank("range", "on_target")
        yield (
            9,
            alike >= 0.9 and ranged >= 0.85,
            f"mAP of both {alike:.2f}, on target with range {ranged:.2f}",
        )
    if "painted" in of.parts:
        yield 11, *_painted(of)


def _painted(of: Tables) -> tuple[bool, str]:
    names = [line["rig"] for line in of.of("painted")]
    ap = of.column("painted", "ap").reshape(3, 3)  # LiDARs by none, wide, narrow
    said = {
        frozenset((line["rig"], line["other"])): line["verdict"]
        for line in of.pairs
        if line["part"] == "painted"
    }
    gains = (ap[:, 1:] > ap[:, :1]).all()
    tied = all(said[frozenset((names[3 * k + 1], names[3 * k + 2]))] == "not resolved" for k in range(3))
    turned = False
    for one, other in ((0, 1), (0, 2), (1, 2)):
        signs = {
            np.sign(ap[one, c] - ap[other, c])
            for c in range(3)
            if said[frozenset((names[3 * one + c], names[3 * other + c]))] != "not resolved"
        }
        turned |= len(signs) > 1
    return bool(
        gains and tied and not turned
    ), f"gains {gains}, ties {tied}, turned {turned}, {ap.round(1).tolist()}"


def run(renew: Callable[[Path], None], found: Callable[[], Iterable[tuple[int, bool, str]]]) -> None:
    """Renew the tables if a folder is given, and print the outcomes."""
    if len(sys.argv) > 1:
        renew(Path(sys.argv[1]))
    for number, holds, figures in found():
        print(f"{number}: {'held' if holds else 'refuted'}: {figures}")


if __name__ == "__main__":
    run(gather, lambda: outcomes(Tables()))
