"""Renew the figures of the published study of detection that need no detector, from its average precision in docs/data.

    python -m tools.detection_tables

Figures of rigs are computed again; rank correlations get intervals from normal draws of average precision, with the
variances of its 95 % intervals and the covariances that follow from those of the differences of all pairs.
"""

from __future__ import annotations

from itertools import combinations

import numpy as np

from riglens.core.detect.net import Machine
from riglens.core.engine.engine import Engine
from riglens.core.study.detection.pieces import Study
from riglens.core.study.detection.protocol import Protocol, entrants
from riglens.core.study.detection.published import CAMERA_PROTOCOL, PROTOCOL, camera_rigs, published_rigs
from riglens.core.study.detection.result import Result
from riglens.core.study.detection.statistics import COLUMNS, REPLICAS, Precisions
from riglens.core.study.detection.surrogates import surrogates
from riglens.core.targets.engine import TargetEngine
from riglens.core.targets.settings import TargetSettings
from riglens.core.targets.traffic import WITHIN_M
from riglens.evaluation.options import SceneOptions
from riglens.evaluation.scenario import load_scenario
from riglens.evaluation.traffic import load_traffic
from riglens.studies.detection_chart import chart
from riglens.studies.detection_files import order_lines, rank_lines
from riglens.studies.files import csv_text
from riglens.studies.table2 import compare_papers
from tools.detection_second import DATA, Line, lines

IMAGES = DATA.parent / "images"
OF_OBJECTS = ("on_target", "share_5", "share_1")
FROM_DETECTIONS = ("s_ms", "residual", "hits", "seen", "on_target_60m", "share_5_60m")
"""Figures whose correlations were computed when the study ran; the last two are those of objects within 60 m."""
_WIDTH = 2 * 1.959964
"""Standard deviations of a normal distribution between the ends of its 95 % interval."""


def precisions(prefix: str, protocol: Protocol, sequences: int) -> Precisions:
    """Average precision of the tables, with replicas drawn from what its intervals say."""
    table, seeds = lines(DATA / f"{prefix}.csv"), lines(DATA / f"{prefix}-seeds.csv")
    rigs = tuple(dict.fromkeys(line["rig"] for line in table))
    shape = (len(rigs), len(COLUMNS))
    value = np.array([float(line["ap"]) for line in table]).reshape(shape)
    spread = np.array([_spread(line, "ap") for line in table]).reshape(shape)
    by_seed = np.array([[float(line[column]) for column in COLUMNS] for line in seeds])
    apart = {
        (line["rig"], line["other"], line["class"]): _spread(line, "difference")
        for line in lines(DATA / f"{prefix}-pairs.csv")
    }
    replicas = np.empty((REPLICAS, *shape))
    rng = np.random.default_rng(0)
    for number, column in enumerate(COLUMNS):
        variance = spread[:, number] ** 2
        covariance = np.diag(variance)
        for one, other in combinations(range(len(rigs)), 2):
            mine = (variance[one] + variance[other] - apart[rigs[one], rigs[other], column] ** 2) / 2
            covariance[one, other] = covariance[other, one] = mine
        replicas[:, :, number] = rng.multivariate_normal(
            value[:, number], covariance, REPLICAS, check_valid="ignore"
        )
    return Precisions(
        rigs, protocol.seeds, sequences, value, by_seed.reshape(len(rigs), protocol.seeds, -1), replicas
    )


def _spread(line: Line, name: str) -> float:
    return (float(line[f"{name}_high"]) - float(line[f"{name}_low"])) / _WIDTH


def renew(prefix: str, study: Study, engine: Engine) -> Result:
    """Compute the figures of a study's rigs, and write its table of rigs; return what is known of it."""
    targets, settings = TargetEngine(study.tested), TargetSettings(body=study.protocol.simulation.body)
    found = surrogates(study.compared, engine, targets, settings, lambda share: None, study.judged)
    table = lines(DATA / f"{prefix}.csv")
    for number, line in enumerate(table):
        place, column = divmod(number, len(COLUMNS))
        for name in ("s_ms", "seen"):  # the rigs are those that were measured
            now, then = float(found.values[name][place, column]), float(line[name])
            if abs(now - then) > 1e-4 * max(1.0, abs(then)):
                raise SystemExit(f"{line['rig']}: {name} was {then}, is {now}")
        line |= {name: str(round(float(found.values[name][place, column]), 4)) for name in OF_OBJECTS}
    (DATA / f"{prefix}.csv").write_text(csv_text(table), encoding="utf-8")
    every = precisions(prefix, study.protocol, len(study.split.sequences))
    return Result(study, every, every, found)


def ranks(result: Result) -> list[dict[str, object]]:
    """Rank correlations: those that were computed from the detections stay, the others are made anew."""
    kept: list[dict[str, object]] = [
        dict(line)
        for line in lines(DATA / "detection-ranks.csv")
        if line["surrogate"] in FROM_DETECTIONS and line["among"] in ("all rigs", "equal ray count")
    ]
    names = ("among", "class", "surrogate", "statistic")
    known = {tuple(line[name] for name in names) for line in kept}
    return kept + [line for line in rank_lines(result) if tuple(line[name] for name in names) not in known]


def placements(engine: Engine, scene: SceneOptions) -> list[dict[str, object]]:
    """Rank correlations of our figures with published average precision of placements."""
    found = []
    for one in compare_papers(engine, scene):
        for it in one.agreements:
            line: dict[str, object] = {"paper": it.paper, "rigs": len(one.paper.rigs), "class": it.column}
            line |= {"surrogate": it.surrogate, "value": "", "low": "", "high": "", "p": ""}
            if it.found is not None:
                values = (it.found.value, it.found.low, it.found.high, it.found.p)
                line |= {k: round(v, 4) for k, v in zip(("value", "low", "high", "p"), values, strict=True)}
            found.append(line)
    return found


def main() -> None:
    """Renew the tables of both studies, and the chart of the first."""
    scene = SceneOptions()
    engine, traffic = Engine(load_scenario(scene).field), load_traffic(scene, WITHIN_M)
    machine = Machine("cpu", False, "not asked")
    study = Study(entrants(published_rigs()), PROTOCOL, traffic, machine)
    result = renew("detection", study, engine)
    (DATA / "detection-ranks.csv").write_text(csv_text(ranks(result)), encoding="utf-8")
    (DATA / "detection-orders.csv").write_text(csv_text(list(order_lines(result))), encoding="utf-8")
    (DATA / "detection-placements.csv").write_text(csv_text(placements(engine, scene)), encoding="utf-8")
    (IMAGES / "study-detection.png").write_bytes(chart(result))
    renew(
        "detection-cameras",
        Study(entrants(camera_rigs(), "lidars and cameras"), CAMERA_PROTOCOL, traffic, machine),
        engine,
    )


if __name__ == "__main__":
    main()
