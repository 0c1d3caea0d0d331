"""Published average precision of rigs against our figures of the same rigs: do they put rigs in the same order?

Two papers of the same author: the ICRA paper's Table II, eight rigs of cameras and LiDARs, and Place3D ("Is Your LiDAR
Placement Optimized for 3D Scene Understanding?", 2024; table "3D Object Detection" in the README of
github.com/ywyeli/Place3D of July 2025; poses and fields of view of five of its placements in
carla_nus/hyperparams/4x16.toml there, left-handed, mirrored here). Both trained four detectors on CARLA data, each
once: neither has error bars.
"""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from riglens.assets import asset_path
from riglens.core.rig.model import Lidar, LinearAngles, Rig
from riglens.core.rig.presets import PAPER_RIGS, preset
from riglens.core.scene.boxes import CLASSES
from riglens.core.study.detection.protocol import Entrant
from riglens.core.study.detection.statistics import COLUMNS, MEAN
from riglens.core.study.detection.surrogates import LOWER_IS_MORE, SURROGATES, Surrogates
from riglens.core.study.ranks import RankCorrelation, kendall, rank_correlation

Doubles = NDArray[np.float64]
GROUPS = {"Center": "C", "Pyramid": "P", "Line": "L", "Trapezoid": "T"}
"""LiDAR placements that both papers have, by name, and their letter in the names of rigs. Poses differ."""
REPLICAS = 2000
AZIMUTHS = 720
"""Of Place3D's LiDARs: 14,400 points a second and beam, 20 turns a second."""
BEAMS, RANGE_M = 16, 200.0


@dataclass(frozen=True)
class Paper:
    """Published results of a paper: rigs by name; detectors; percent (classes, detectors, rigs) of average
    precision."""

    name: str
    rigs: tuple[Entrant, ...]
    detectors: tuple[str, ...]
    percent: Doubles

    def of(self, column: str) -> Doubles:
        """Average precision (detectors, rigs) of a class, or the mean over classes."""
        return np.asarray(
            self.percent.mean(axis=0) if column == MEAN else self.percent[CLASSES.index(column)]
        )

    def detectors_agree(self, column: str) -> float:
        """Return Kendall's tau between the orders of rigs by two detectors, mean over their pairs."""
        of = self.of(column)
        return float(np.mean([kendall(one, other) for one, other in combinations(of, 2)]))

    def groups(self, column: str) -> dict[str, float]:
        """Return mean average precision of the LiDAR placements that both papers have, percent."""
        of = self.of(column).mean(axis=0)
        names = [entrant.name for entrant in self.rigs]
        rigs = {
            name: [k for k, rig in enumerate(names) if rig == name or rig.endswith(f"+{letter}")]
            for name, letter in GROUPS.items()
        }
        return {name: float(of[places].mean()) for name, places in rigs.items()}


@dataclass(frozen=True)
class Agreement:
    """Agreement of one of our figures with a paper's order of rigs: positive where rigs with more coverage detect
    better; None if it cannot be computed."""

    paper: str
    column: str
    surrogate: str
    found: RankCorrelation | None


def icra() -> Paper:
    """Return the ICRA paper's Table II."""
    rigs = tuple(Entrant(name, preset(name)) for name in PAPER_RIGS)
    lines = _lines("detection_map.csv")
    for line in lines:
        line["detector"] = f"{line['model']}, {line['backbone']}"
    return _paper("ICRA, Table II", rigs, lines, "rig")


def place3d() -> Paper:
    """Return Place3D's table, of the placements whose poses are published."""
    poses: dict[str, list[dict[str, str]]] = {}
    for line in _lines("place3d_lidars.csv"):
        poses.setdefault(line["placement"], []).append(line)
    rigs = tuple(Entrant(name, _place3d_rig(name, lines)) for name, lines in poses.items())
    lines = [line | {"detector": line["model"]} for line in _lines("place3d_map.csv")]
    return _paper("Place3D", rigs, lines, "placement")


def _lines(name: str) -> list[dict[str, str]]:
    with asset_path("paper", name).open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))


def _place3d_rig(name: str, lines: Sequence[Mapping[str, str]]) -> Rig:
    return Rig(
        name=f"Place3D {name}",
        sensors=tuple(
            Lidar(
                name=f"LIDAR_{number}",
                position=(float(line["x_m"]), float(line["y_m"]), float(line["z_m"])),
                elevations_deg=LinearAngles(
                    from_=float(line["lower_deg"]), to=float(line["upper_deg"]), count=BEAMS
                ),
                azimuths_deg=LinearAngles(from_=-180.0, to=180.0, count=AZIMUTHS),
                range_m=(0.0, RANGE_M),
            )
            for number, line in enumerate(lines, 1)
        ),
    )


def _paper(name: str, rigs: tuple[Entrant, ...], lines: Sequence[Mapping[str, str]], key: str) -> Paper:
    detectors = tuple(dict.fromkeys(line["detector"] for line in lines))
    by_key = {(line["class"], line["detector"], line[key]): float(line["map_percent"]) for line in lines}
    percent = [[[by_key[cls, one, rig.name] for rig in rigs] for one in detectors] for cls in CLASSES]
    return Paper(name, rigs, detectors, np.array(percent))


def agreements(paper: Paper, ours: Surrogates) -> list[Agreement]:
    """Compare each of our figures with the detections of the paper, class by class."""
    found = []
    for column in COLUMNS:
        of = paper.of(column)
        draws = np.random.default_rng(0).integers(0, len(of), (REPLICAS, len(of)))
        replicas = of[draws].mean(axis=1)  # detectors drawn with replacement
        for name in SURROGATES:
            values = ours.of(name, column) * (-1.0 if name in LOWER_IS_MORE else 1.0)
            correlation = rank_correlation("spearman", values, of.mean(axis=0), replicas)
            found.append(Agreement(paper.name, column, name, correlation))
    return found
