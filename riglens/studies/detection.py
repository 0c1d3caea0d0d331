"""`riglens study detection`: sweeps of rigs, a small detector trained on them, and which score predicts it."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path

import numpy as np

from riglens.core.detect.net import Device, machine
from riglens.core.engine.engine import Engine
from riglens.core.errors import InputError
from riglens.core.files import write_file
from riglens.core.formats.opening import open_rig
from riglens.core.metric.scores import Body
from riglens.core.monitor import Monitor
from riglens.core.pieces.backend import Backend
from riglens.core.pieces.resumable import resumable
from riglens.core.pieces.work import Workers
from riglens.core.rig.model import Rig
from riglens.core.scene.boxes import CLASSES
from riglens.core.shown_tables import Block, Paragraph, ShownTable, Styled, table
from riglens.core.shown_text import visible
from riglens.core.simulate.motion import motion_of
from riglens.core.simulate.painting import Quality
from riglens.core.study.detection.pieces import Pieces, Study, jobs
from riglens.core.study.detection.protocol import WORDING, Protocol, entrants
from riglens.core.study.detection.published import CAMERA_PROTOCOL, PROTOCOL, camera_rigs, published_rigs
from riglens.core.study.detection.recall import Recall, Tally, recall_of, tallies_of
from riglens.core.study.detection.result import Result, assemble, finished_seeds
from riglens.core.study.detection.run import StudyProgress, run
from riglens.core.study.detection.second import PERIOD_S, PROTOCOLS, Arm, rigs_of
from riglens.core.study.detection.statistics import COLUMNS, LEAST_DIFFERENCE, MEAN, Estimate
from riglens.core.study.detection.surrogates import Surrogates, surrogates
from riglens.core.study.detection.third import PARTS, Part, rigs_of_part
from riglens.core.study.ranks import FEWEST_RIGS
from riglens.core.targets.engine import TargetEngine
from riglens.core.targets.settings import TargetSettings
from riglens.core.targets.traffic import WITHIN_M
from riglens.evaluation.loading import load_traffic, with_meshes
from riglens.evaluation.options import SceneOptions
from riglens.evaluation.scenario import load_scenario
from riglens.evaluation.traffic import car_poses
from riglens.studies.detection_chart import chart, correlation, painted_words, pair_chart
from riglens.studies.detection_files import (
    RECALL_COLUMNS,
    TALLY_COLUMNS,
    as_json,
    order_lines,
    pair_lines,
    rank_lines,
    recall_lines,
    rig_lines,
    seed_lines,
)
from riglens.studies.files import csv_text, require_folder

CHART, PAIRS = "detection.png", "detection-pairs.png"
NAMES = (
    "detection.csv", "detection-seeds.csv", "detection-ranks.csv", "detection-pairs.csv", "detection.json",
    CHART, PAIRS, "detection-orders.csv", "detection-recall.csv", "detection-recall-points.csv",
)  # fmt: skip
PIECES, MAP = "pieces", "mAP"


@dataclass(frozen=True)
class Plan:
    """Plan of a study; None for seeds is the protocol's number. second, third: a part of these published studies.
    cameras: quality of the segmentation that gives points their classes; None: cameras are left out."""

    quick: bool = False
    per_rig: bool = False
    published: bool = False
    second: Arm | None = None
    third: Part | None = None
    seeds: int | None = None
    backend: Backend = field(default_factory=lambda: Backend(1))
    device: Device | None = None
    body: Body | None = None
    cameras: Quality | None = None

    def rigs(self, names: Sequence[str]) -> tuple[Rig, ...]:
        """Return the rigs that are compared: those named, or those of the published study."""
        if self.second is not None:
            return rigs_of(self.second)
        if self.third is not None:
            return rigs_of_part(self.third)
        if not self.published:
            return tuple(open_rig(name).rig for name in names)
        return published_rigs() if self.cameras is None else camera_rigs()

    def protocol(self) -> Protocol:
        """Return the protocol of the study; raise InputError for seeds that are none."""
        protocol = Protocol()
        if self.second is not None:
            protocol = PROTOCOLS[self.second]
        elif self.third is not None:
            protocol = PARTS[self.third]
        elif self.published:
            protocol = replace(PROTOCOL if self.cameras is None else CAMERA_PROTOCOL, cameras=self.cameras)
        else:
            simulation = replace(protocol.simulation, body=self.body)
            protocol = replace(protocol, cameras=self.cameras, simulation=simulation)
        protocol = protocol.per_rig() if self.per_rig else protocol
        protocol = protocol.quick() if self.quick else protocol
        return replace(protocol, seeds=self.seeds) if self.seeds is not None else protocol


def study(rigs: Sequence[str], scene: SceneOptions, plan: Plan, out: Path, monitor: Monitor) -> list[Block]:
    """Run the missing parts of a study, write tables and charts, and return the results."""
    if (plan.published, plan.second is not None, plan.third is not None, bool(rigs)).count(True) != 1:
        raise InputError(
            "specify rigs to compare, or --published, --second or --third for those of a published study"
        )
    machine(plan.device)  # what it lacks is reported first
    return compare(plan.rigs(rigs), rigs, scene, plan, out, monitor)


def compare(
    rigs: Sequence[Rig],
    names: Sequence[str],
    scene: SceneOptions,
    plan: Plan,
    out: Path,
    monitor: Monitor,
) -> list[Block]:
    """Run a study of rigs; a mesh file is found next to the rig file of that name."""
    protocol = plan.protocol()
    rigs = with_meshes(rigs, names or ["."] * len(rigs), protocol.simulation.body, monitor)
    compared = entrants(rigs, protocol.kinds)
    if plan.second is not None or plan.third is not None:
        scene = replace(scene, surroundings=True)
    require_folder(out, NAMES)
    traffic = load_traffic(scene, WITHIN_M, monitor)
    motion = motion_of(traffic, car_poses(scene), PERIOD_S) if protocol.sweeps > 1 else None
    asked = Study(compared, protocol, traffic, machine(plan.device), motion)
    _ = asked.split  # says in one line what the data lack, before anything takes time
    # a cluster that is not there is reported before anything takes time
    with resumable(out / PIECES, plan.backend, len(jobs(asked)), monitor) as workers:
        result = _result(asked, _surrogates(asked, scene, monitor), workers, out, monitor)
    return [*shown(result), f"{out}: {', '.join(NAMES)}"]


def _result(asked: Study, scores: Surrogates, workers: Workers, out: Path, monitor: Monitor) -> Result:
    """Compute the missing parts; tables and charts are written whenever another seed is complete."""
    pieces, shown = Pieces(asked, out / PIECES), 0

    def tell(told: StudyProgress) -> None:
        nonlocal shown
        progress(told.share)
        if told.finished is None:
            return
        monitor.note(f"done: {told.finished.title} ({told.done} of {told.pieces})")
        seeds = finished_seeds(pieces) if told.finished.is_found else shown
        if shown < seeds < asked.protocol.seeds:
            shown = seeds
            found = Result(asked, *assemble(pieces, seeds), scores)
            write(found, recall_of(pieces, seeds), tallies_of(pieces, seeds), out)

    with monitor.stage("Detection") as progress:
        run(asked, pieces.folder, workers, tell)
    result = Result(asked, *assemble(pieces, asked.protocol.seeds), scores)
    seeds = asked.protocol.seeds
    write(result, recall_of(pieces, seeds), tallies_of(pieces, seeds), out)
    return result


def _surrogates(asked: Study, scene: SceneOptions, monitor: Monitor) -> Surrogates:
    """Return the scores of the rigs; objects are those that average precision is over."""
    with monitor.stage("Scores of the rigs") as progress:
        engine, counts = Engine(load_scenario(scene).field), TargetEngine(asked.tested)
        settings = TargetSettings(body=asked.protocol.simulation.body)
        return surrogates(asked.compared, engine, counts, settings, progress, asked.judged)


def write(result: Result, recalls: Iterable[Recall], tallies: Iterable[Tally], out: Path) -> None:
    """Write tables, JSON and charts into a folder."""
    texts = {
        NAMES[0]: csv_text(list(rig_lines(result))),
        NAMES[1]: csv_text(list(seed_lines(result))),
        NAMES[2]: csv_text(list(rank_lines(result))),
        NAMES[4]: json.dumps(as_json(result), indent=1) + "\n",
    }
    pairs = list(pair_lines(result))
    texts[NAMES[3]] = csv_text(pairs, () if pairs else ("rig", "other", "class", "difference"))
    texts[NAMES[7]] = csv_text(list(order_lines(result)))
    texts[NAMES[8]] = csv_text(list(recall_lines(recalls)), RECALL_COLUMNS)
    texts[NAMES[9]] = csv_text([asdict(one) for one in tallies], TALLY_COLUMNS)
    for name, text in texts.items():
        write_file(out / name, text)
    for name, picture in ((NAMES[5], chart(result)), (NAMES[6], pair_chart(result))):
        write_file(out / name, picture)


def shown(result: Result) -> Iterator[Block]:
    """Yield tables and sentences on the result."""
    every = result.every
    yield _precision_table(result)
    for name in CLASSES:
        if np.isnan(every.value[:, COLUMNS.index(name)]).any():
            yield f"{name}: no objects in the region of the test frames: no AP, and not part of mAP"
    spread = every.seed_spread(MEAN)
    said = (
        "one seed: the spread between seeds is unknown"
        if spread is None
        else f"SD between seeds {spread:.1f}"
    )
    yield Paragraph(
        f"On hit: mAP over objects with a LiDAR point only. 95 % intervals over {every.sequences} test "
        f"sequences and seeds; {said}."
    )
    if result.study.protocol.cameras is not None:
        words = painted_words(result.study.protocol.cameras)
        yield f"{words.capitalize()}; S-MS and seen are of all sensors."
    yield _pairs_text(result)
    missed = ", ".join(
        f"{MAP if name == MEAN else name} {value:.1f}" for name, value in result.missed.items()
    )
    yield f"Mean error of AP predicted by the bundled calibration, points: {missed}."
    if len(every.rigs) < FEWEST_RIGS:
        yield f"Rank correlations need {FEWEST_RIGS} rigs or more; there are {len(every.rigs)}."
    else:
        yield _rank_table(result)
        yield _order_table(result)
    yield Styled(f"{WORDING}.", "bold")


def _precision_table(result: Result) -> ShownTable:
    every, scores = result.every, result.surrogates
    shown = table("AP in percent", "rays", *CLASSES, MAP, "on hit", "S-MS", "seen", "on target")
    for place in np.argsort(-every.value[:, -1], kind="stable").tolist():
        by_class = [_value(every.value[place, number]) for number in range(len(CLASSES))]
        shown.add_row(
            visible(every.rigs[place]),
            f"{result.study.compared[place].rays:,}",
            *by_class,
            _interval(every.estimate(place, MEAN)),
            _value(result.hit.value[place, -1]),
            f"{scores.of('s_ms', MEAN)[place]:,.0f}",
            f"{100 * scores.of('seen', MEAN)[place]:.1f} %",
            f"{scores.of('on_target', MEAN)[place]:.3f}",
        )
    return shown


def _value(found: float) -> str:
    return "–" if np.isnan(found) else f"{found:.1f}"


def _interval(found: Estimate) -> str:
    return "–" if np.isnan(found.value) else f"{found.value:.1f} [{found.low:.1f}, {found.high:.1f}]"


def _pairs_text(result: Result) -> str:
    count, resolved = 0, 0
    for one in range(len(result.every.rigs)):
        for other in range(one):
            count += 1
            resolved += result.every.verdict(one, other, MEAN) != "not resolved"
    if not count:
        return "A single rig: nothing to compare it with."
    return (
        f"By mAP {resolved} of {count} pairs are resolved: the interval of the difference excludes 0, and the "
        f"difference is {LEAST_DIFFERENCE[MEAN]:g} points or more (bicycle {LEAST_DIFFERENCE['bicycle']:g})."
    )


def _rank_table(result: Result) -> ShownTable:
    shown = table("Spearman with AP", *CLASSES, MAP)
    for among, places in result.groups().items():
        shown.add_row(Styled(f"{among}, {len(places)}", "bold"))
        mine = [one for one in result.ranks if one.among == among and one.kind == "spearman"]
        for name in dict.fromkeys(one.surrogate for one in mine):
            found = [one.found for one in mine if one.surrogate == name]  # in the order of COLUMNS
            shown.add_row(f"  {name}", *("–" if one is None else correlation(one) for one in found))
        shown.add_section()
    return shown


def _order_table(result: Result) -> ShownTable:
    """Return the share of the resolved pairs that each figure orders as mAP does, by how far apart they are."""
    mine = [one for one in result.orders if one.column == MEAN]
    pairs = {one.apart: one.pairs for one in reversed(mine)}
    apart = dict.fromkeys(one.apart for one in mine)
    shown = table("Resolved pairs in the order of mAP", *(f"{name}, {pairs[name]}" for name in apart))
    for name in dict.fromkeys(one.surrogate for one in mine):
        found = [one for one in mine if one.surrogate == name]
        shown.add_row(name, *(f"{100 * one.right / one.pairs:.0f} %" if one.pairs else "–" for one in found))
    return shown
