"""`riglens review`: all parts of a safety review of a rig, with one set of defaults."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Annotated

from cyclopts import Group, Parameter
from rich.text import Text

from riglens.app.commands.audit import print_audit
from riglens.app.commands.blind import BlindArguments, BlindTables
from riglens.app.commands.detection_range import RangeArguments, RangeTables, print_range
from riglens.app.commands.footprint import print_footprints
from riglens.app.commands.mounts import print_mounts
from riglens.app.commands.options import (
    Json,
    RigArguments,
    RigName,
    SceneArguments,
    ScoreArguments,
    all_of,
    command,
)
from riglens.app.commands.output import Part, deliver, require_outputs
from riglens.app.commands.redundancy import print_redundancy
from riglens.app.commands.tolerance import ToleranceArguments, WorstCase, print_tolerance
from riglens.app.terminal.console import TERMINAL, note, progress_bar, results
from riglens.core.blind.zones import BlindSettings
from riglens.core.engine.audit import audit as audit_rig
from riglens.core.engine.audit import audit_document
from riglens.core.errors import InputError
from riglens.core.figures.evaluated import Evaluator
from riglens.core.footprint.document import footprints_document, footprints_of
from riglens.core.footprint.ground import EN_62676_4, checked_limits
from riglens.core.metric.entropy import EntropyField
from riglens.core.option_help import OptionHelp
from riglens.core.review.documents import mounts_review_document
from riglens.core.review.profiles import Profile, profiles_in
from riglens.core.review.tolerance import ToleranceOptions
from riglens.core.rig.edits import damaged as damaged_rig
from riglens.core.rig.model import FORMAT_VERSION, Rig
from riglens.core.targets.detection_range import USUAL_PLAN, RangePlan, around
from riglens.core.targets.detection_range_table import range_document
from riglens.core.targets.settings import TargetSettings
from riglens.core.targets.traffic import WITHIN_M, Traffic
from riglens.evaluation.loading import load_rigs, load_scene, load_traffic
from riglens.evaluation.options import SceneOptions, ScoreOptions
from riglens.jobs.reviewing import detection_range, drawn, evaluator_of, redundancy_of

REVIEW, FAILING = Group("Review", sort_key=5), Group("Redundancy", sort_key=8)


@dataclass(frozen=True)
class PartOptions:
    """Options of which parts a review has, and of what several of them count."""

    only: Annotated[
        str | None,
        OptionHelp(
            "PART,PART...",
            "Parts to run: blind, range, redundancy, tolerance, audit, mounts, footprint (all).",
        ),
    ] = None
    min_points: Annotated[
        int,
        OptionHelp(
            "N",
            "LiDAR points that detect an object, for detection range and redundancy; a camera needs 25 px of height.",
        ),
    ] = 5
    within_m: Annotated[
        float,
        OptionHelp(
            "M", "Count objects within this distance of the car, in metres, for redundancy and tolerance."
        ),
    ] = WITHIN_M
    damaged: Annotated[
        tuple[str, ...],
        OptionHelp(
            "SENSOR[=HALF]",
            "Sensor that has failed or, with =left, =right, =upper or =lower, is blocked by half; may be repeated.",
        ),
    ] = ()
    no_objects: Annotated[bool, OptionHelp("", "Count voxels alone, no objects.")] = False
    halves: Annotated[
        bool,
        OptionHelp(
            "",
            "Also list the losses by each sensor with half of its view blocked: left, right, upper, lower.",
        ),
    ] = False

    def named(self) -> list[str]:
        """Return the parts that were named, in the order of all."""
        named = list(PARTS) if self.only is None else [name.strip() for name in self.only.split(",")]
        if unknown := [name for name in named if name not in PARTS]:
            raise InputError(f"must be some of {','.join(PARTS)} (got '{unknown[0]}')", "only")
        return [name for name in PARTS if name in named]


PartArguments = Annotated[
    PartOptions, all_of(PartOptions, REVIEW, {"no_objects": FAILING, "halves": FAILING})
]


@command
def review(
    rig: RigName,
    /,
    *,
    parts: PartArguments = PartOptions(),
    px_per_m: Annotated[tuple[float, ...], Parameter(group=REVIEW, metavar="N", consume_multiple=True)] = (
        EN_62676_4
    ),
    blind: BlindArguments = BlindSettings(),
    blind_tables: BlindTables = BlindTables(),
    distances: RangeArguments = USUAL_PLAN,
    range_tables: RangeTables = RangeTables(),
    tolerance: ToleranceArguments = ToleranceOptions(),
    worst_case: WorstCase = WorstCase(),
    scene: SceneArguments = SceneOptions(),
    score: ScoreArguments = ScoreOptions(),
    reading: RigArguments = RigArguments(),
    json: Json = None,
) -> None:
    """Review a rig: blind zones, detection range, redundancy, tolerance, ray outcomes, mounts, footprints.

    Parameters
    ----------
    px_per_m
        Least pixels per metre of each band of a camera's footprint, falling; EN 62676-4 by default.
    json
        Also write one JSON document, with a key per part, to a file; with - to standard output, instead of the tables.
    """
    named = parts.named()
    outputs = {"blind": blind_tables.files, "range": range_tables.files, "tolerance": worst_case.files}
    for part, files in outputs.items():
        for option, path in files.items():
            if path is not None and part not in named:
                raise InputError(f"needs {part} in", option, "only")
    if score.body == "ignored" and not {"redundancy", "tolerance"} & set(named):
        score.solid(score.body)
    limits = checked_limits(px_per_m)
    profiles = profiles_in(blind_tables.profiles)  # what is wrong is said before rigs are read
    plan = replace(distances, min_points=parts.min_points, bearings_deg=around(range_tables.directions))
    (opened,) = load_rigs([rig], score.solid(), TERMINAL, reading.libraries, reading.housings)
    opened = damaged_rig(opened, parts.damaged)
    paths = [path for files in outputs.values() for path in files.values()]
    require_outputs((rig, *blind_tables.profiles, *scene.files), json, *paths)
    found = Review(
        named, opened, scene, score, parts, blind, blind_tables, profiles, plan, range_tables, tolerance,
        worst_case, limits,
    )  # fmt: skip
    made = {name: PARTS[name](found) for name in named}
    document = {"riglens": FORMAT_VERSION} | {name: part for name, (part, _) in made.items()}

    def show() -> None:
        for name, (_, print_part) in made.items():
            results().print(Text(f"== {name} ==", "bold"))
            print_part()

    deliver(document, json, show)


@dataclass(frozen=True)
class Review:
    """A rig under review; scene and traffic are loaded once, when the first part needs them."""

    named: list[str]
    rig: Rig
    scene: SceneOptions
    score: ScoreOptions
    parts: PartOptions
    blind_settings: BlindSettings
    blind_tables: BlindTables
    profiles: tuple[Profile, ...]
    plan: RangePlan
    range_tables: RangeTables
    drawing: ToleranceOptions
    worst_case: WorstCase
    px_per_m: tuple[float, ...]

    @cached_property
    def field(self) -> EntropyField:
        """The entropies of the scene."""
        return load_scene(self.scene, TERMINAL, [self.rig], self.score)[1]

    @cached_property
    def traffic(self) -> Traffic | None:
        """The objects of the scene; None, with a note, where it has none."""
        if self.scene.pog is not None:
            note("objects are not counted: a stored POG has none")
            return None
        return load_traffic(self.scene, self.parts.within_m, TERMINAL)

    def blind(self) -> Part:
        """Find blind zones and judge test objects."""
        return self.blind_tables.find(self.rig, self.blind_settings, self.profiles, self.score.threads)

    def range(self) -> Part:
        """Find detection ranges."""
        found = detection_range(self.rig, self.plan, self.score.threads)
        self.range_tables.write(found)
        return range_document(found), lambda: print_range(found)

    @cached_property
    def evaluate(self) -> Evaluator:
        """The evaluator of all parts: with objects if one of them counts any."""
        counts = ("redundancy" in self.named and not self.parts.no_objects) or (
            "tolerance" in self.named and self.drawing.sample > 0
        )
        return evaluator_of(self.field, self.traffic if counts else None, self.score)

    def redundancy(self) -> Part:
        """Find what failures cost."""
        counting, with_objects = TargetSettings(min_points=self.parts.min_points), not self.parts.no_objects
        found = redundancy_of(self.evaluate, self.rig, counting, with_objects, self.parts.halves, TERMINAL)
        return found.document(), lambda: print_redundancy(found)

    def tolerance(self) -> Part:
        """Draw errors and find how figures spread."""
        with progress_bar("Sampling mount errors") as progress:
            found, document = drawn(self.evaluate, self.rig, self.drawing, progress)
        self.worst_case.write(found)
        return document, lambda: print_tolerance(found, document["body"])

    def audit(self) -> Part:
        """Follow every ray."""
        with progress_bar("Tracing rays"):
            found = audit_rig(self.evaluate.voxels, self.rig)
        return audit_document(found), lambda: print_audit(found)

    def mounts(self) -> Part:
        """Say where sensors sit."""
        return mounts_review_document(self.rig), lambda: print_mounts(self.rig)

    def footprint(self) -> Part:
        """Say what cameras resolve and other sensors reach on the ground."""
        found = footprints_of(self.rig, self.px_per_m)
        return footprints_document(self.rig, found), lambda: print_footprints(self.rig, found)


PARTS: dict[str, Callable[[Review], Part]] = {
    "blind": Review.blind,
    "range": Review.range,
    "redundancy": Review.redundancy,
    "tolerance": Review.tolerance,
    "audit": Review.audit,
    "mounts": Review.mounts,
    "footprint": Review.footprint,
}
