"""Gather the parts of the third study of detection, join LiDARs with cameras, and print what its hypotheses became.

    python -m tools.detection_third FOLDER

FOLDER/PART holds the output of `riglens study detection --third PART`. The tables go to docs/data; without a folder the
outcomes are those of the tables.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from riglens.core.detect.net import Machine
from riglens.core.detect.precision import Detections, Matched
from riglens.core.engine.engine import Engine
from riglens.core.monitor import SILENT
from riglens.core.scene.boxes import CLASSES
from riglens.core.study.detection.fusing import fused, reliable
from riglens.core.study.detection.pieces import Pieces, Study
from riglens.core.study.detection.protocol import entrants
from riglens.core.study.detection.result import Result, assemble
from riglens.core.study.detection.statistics import MEAN, precisions
from riglens.core.study.detection.surrogates import surrogates
from riglens.core.study.detection.third import MEETING, PARTS, fused_lidars, rigs_of_part, with_cameras
from riglens.core.study.ranks import spearman
from riglens.core.targets.engine import TargetEngine
from riglens.core.targets.settings import TargetSettings
from riglens.core.targets.traffic import WITHIN_M
from riglens.evaluation.loading import load_traffic
from riglens.evaluation.options import SceneOptions
from riglens.evaluation.scenario import load_scenario
from riglens.studies.detection_files import order_lines, pair_lines, rank_lines, rig_lines
from riglens.studies.files import csv_text
from tools import detection_second as second
from tools.detection_second import DATA

TABLES = {"": rig_lines, "-ranks": rank_lines, "-pairs": pair_lines, "-orders": order_lines}
Doubles = NDArray[np.float64]


def gather(folder: Path, tables: Path = DATA) -> None:
    """Write the tables of all three parts; ranks, pairs and orders of mAP alone."""
    results = _results(folder)
    for table, of in TABLES.items():
        found = [
            {"part": part} | line
            for part, result in results.items()
            for line in of(result)
            if not table or (line["class"] == MEAN and line.get("statistic") != "kendall")
        ]
        (tables / f"detection3{table}.csv").write_text(csv_text(found), encoding="utf-8")


def _results(folder: Path) -> dict[str, Result]:
    scene = replace(SceneOptions(), surroundings=True)
    traffic, engine = load_traffic(scene, WITHIN_M, SILENT), Engine(load_scenario(scene).field)
    found: dict[str, Result] = {}
    pieces: dict[str, Pieces] = {}
    for part, how in PARTS.items():
        told: dict[str, Any] = json.loads((folder / part / "detection.json").read_text(encoding="utf-8"))
        study = Study(entrants(rigs_of_part(part), how.kinds), how, traffic, Machine(**told["machine"]))
        pieces[part] = Pieces(study, folder / part / "pieces")
        every, hit = assemble(pieces[part], how.seeds)
        found[part] = Result(study, every, hit, _scores(study, engine))
    return found | {"fused": _fused(pieces["lidars"], pieces["cameras"], engine)}


def _scores(study: Study, engine: Engine) -> Any:
    settings = TargetSettings(body=study.protocol.simulation.body)
    targets = TargetEngine(study.tested)
    return surrogates(study.compared, engine, targets, settings, lambda share: None, study.judged)


def _fused(lidars: Pieces, cameras: Pieces, engine: Engine) -> Result:
    """Join what the nets of both parts have found, rig by rig."""
    half = lidars.study.split.sequence % 2 == 0
    by_part = []
    for pieces in (lidars, cameras):
        (net,) = pieces.study.nets
        judged = [pieces.judged(net, one) for one in pieces.study.compared]
        names = [one.name for one in pieces.study.compared]
        by_part.append(
            (dict(zip(names, judged, strict=True)), dict(zip(names, reliable(judged, half), strict=True)))
        )
    (truths, by_lidars), (_, by_cameras) = by_part
    nothing = Detections.joined([])
    rigs, matched = [], {}
    for rig in fused_lidars():
        truth, _ = truths[rig.name]
        for name in ("", *MEETING):
            both = with_cameras(rig, name) if name else rig
            found = fused(by_lidars[rig.name], by_cameras[name] if name else nothing)
            rigs.append(both)
            matched[both.name, 0] = tuple(
                Matched.of(truth, found, number, lidars.study.split.sequence)
                for number in range(len(CLASSES))
            )
    every = precisions([rig.name for rig in rigs], matched, 1)
    study = replace(lidars.study, compared=entrants(rigs, "lidars and cameras"))
    return Result(study, every, every, _scores(study, engine))


class Tables(second.Tables):
    """The tables of docs/data."""

    def __init__(self, tables: Path = DATA) -> None:
        super().__init__("detection3", tables)

    def gains(self, name: str) -> Doubles:
        """Return by how much a figure of the fused rigs rises with each set of cameras, (LiDARs, sets)."""
        of = self.column("fused", name).reshape(-1, 1 + len(MEETING))
        return of[:, 1:] - of[:, :1]

    def wide_or_narrow(self) -> Iterator[tuple[str, str, float, float]]:
        """Yield of each pair that differs in wide or narrow cameras alone: names, the verdict of mAP on the wide one,
        and by how much it leads in mAP and in seen by cameras."""
        held = {line["rig"]: line for line in (*self.of("cameras"), *self.of("fused"))}
        for line in self.pairs:
            wide, narrow = line["rig"], line["other"]
            if wide.endswith("6 surround") and narrow == wide.replace("6 surround", "6 narrow"):
                lead = float(held[wide]["seen_by_cameras"]) - float(held[narrow]["seen_by_cameras"])
                yield wide, line["verdict"], float(line["difference"]), lead


def outcomes(of: Tables) -> Iterator[tuple[int, bool, str]]:
    """Yield number, outcome and figures of each hypothesis."""
    fused_rank, alone_rank, lidar_rank = (
        of.rank(part, "predicted") for part in ("fused", "cameras", "lidars")
    )
    yield 1, fused_rank >= 0.9, f"{fused_rank:.2f}"
    yield 2, of.missed("fused") <= 4.0, f"{of.missed('fused'):.1f}"
    yield 3, alone_rank >= 0.8, f"{alone_rank:.2f}"
    pairs = list(of.wide_or_narrow())
    resolved = [(verdict, lead) for _, verdict, _, lead in pairs if verdict != "not resolved"]
    right = [(verdict == "better") == (lead > 0.0) for verdict, lead in resolved]
    yield 4, bool(right) and all(right), f"{sum(right)} of {len(right)} resolved pairs, of {len(pairs)}"
    dense = of.missed("lidars", slice(len(fused_lidars()), None))
    yield 5, dense <= 3.0, f"{dense:.1f}"
    yield 6, lidar_rank >= 0.9, f"{lidar_rank:.2f}"
    surround = MEETING.index("6 surround")
    gain = of.gains("ap")[:, surround]
    poorer = float(spearman(gain, of.column("fused", "ap")[:: 1 + len(MEETING)]))
    yield 7, bool((gain > 0.0).all()) and poorer <= -0.7, f"{(gain > 0.0).sum()} of {len(gain)}, {poorer:.2f}"
    apart = float(np.abs(of.gains("predicted") - of.gains("ap")).mean())
    yield 8, apart <= 3.0, f"{apart:.1f}"


if __name__ == "__main__":
    second.run(gather, lambda: outcomes(Tables()))
