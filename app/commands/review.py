"""`riglens review`: all parts of a safety review of a rig, with one set of defaults."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated

from cyclopts import Group, Parameter
from rich.text import Text

from riglens.app.commands.audit import print_audit
from riglens.app.commands.blind import BlindArguments
from riglens.app.commands.detection_range import RangeArguments, print_range
from riglens.app.commands.footprint import print_footprints
from riglens.app.commands.mounts import print_mounts
from riglens.app.commands.options import (
    Json,
    RigArguments,
    RigName,
    SceneArguments,
    ScoreArguments,
    command,
    number,
)
from riglens.app.commands.output import Part, deliver, require_outputs
from riglens.app.commands.redundancy import RedundancyArguments, print_redundancy
from riglens.app.commands.tolerance import ToleranceArguments, print_tolerance
from riglens.app.terminal.console import TERMINAL, note, progress_bar, results
from riglens.app.terminal.loading import load_rigs, load_scene, load_traffic
from riglens.core.engine.audit import audit as audit_rig
from riglens.core.engine.audit import audit_document
from riglens.core.errors import InputError
from riglens.core.footprint.document import footprints_document, footprints_of
from riglens.core.footprint.ground import EN_62676_4, checked_limits
from riglens.core.metric.entropy import EntropyField
from riglens.core.review.documents import mounts_review_document
from riglens.core.review.profiles import Profile, profiles_in
from riglens.core.rig.edits import damaged as damaged_rig
from riglens.core.rig.model import FORMAT_VERSION, Rig
from riglens.core.targets.detection_range import RangePlan
from riglens.core.targets.detection_range_table import range_document
from riglens.core.targets.settings import TargetSettings
from riglens.core.targets.traffic import WITHIN_M, Traffic
from riglens.evaluation.options import SceneOptions, ScoreOptions
from riglens.jobs.reviewing import detection_range, drawn, redundancy_of

REVIEW = Group("Review", sort_key=5)


@command
def review(
    rig: RigName,
    /,
    *,
    only: Annotated[str | None, Parameter(group=REVIEW, metavar="PART,PART...")] = None,
    min_points: Annotated[int, number(REVIEW)] = 5,
    within: Annotated[float, Parameter(group=REVIEW, metavar="M")] = WITHIN_M,
    px_per_m: Annotated[tuple[float, ...], Parameter(group=REVIEW, metavar="N", consume_multiple=True)] = (
        EN_62676_4
    ),
    damaged: Annotated[
        tuple[str, ...], Parameter(group=REVIEW, metavar="SENSOR[=HALF]", show_default=False)
    ] = (),
    blind: BlindArguments = BlindArguments(),
    distances: RangeArguments = RangeArguments(),
    redundancy: RedundancyArguments = RedundancyArguments(),
    tolerance: ToleranceArguments = ToleranceArguments(),
    scene: SceneArguments = SceneOptions(),
    score: ScoreArguments = ScoreOptions(),
    reading: RigArguments = RigArguments(),
    json: Json = None,
) -> None:
    """Review a rig: blind zones, detection range, redundancy, tolerance, ray outcomes, mounts, footprints.

    Parameters
    ----------
    only
        Parts to run: blind, range, redundancy, tolerance, audit, mounts, footprint (all).
    min_points
        LiDAR points that detect an object, for detection range and redundancy; a camera needs 25 px of height.
    within
        Count objects within this distance of the car, in metres, for redundancy and tolerance.
    px_per_m
        Least pixels per metre of each band of a camera's footprint, falling; EN 62676-4 by default.
    damaged
        Sensor that has failed or, with =left, =right, =upper or =lower, is blocked by half; may be repeated.
    json
        Also write one JSON document, with a key per part, to a file; with - to standard output, instead of the tables.
    """
    parts = parts_of(only)
    outputs = {"blind": blind.files, "range": distances.files, "tolerance": tolerance.files}
    for part, files in outputs.items():
        for option, path in files.items():
            if path is not None and part not in parts:
                raise InputError(f"needs {part} in", option, "only")
    if score.body == "ignored" and not {"redundancy", "tolerance"} & set(parts):
        score.solid(score.body)
    limits = checked_limits(px_per_m)
    blind.settings()  # what is wrong with options is said before rigs are read
    plan, profiles = distances.plan(min_points), profiles_in(blind.profiles)
    (opened,) = load_rigs([rig], score.solid(), reading.libraries, reading.housings)
    opened = damaged_rig(opened, damaged)
    paths = [path for files in outputs.values() for path in files.values()]
    require_outputs((rig, *blind.profiles, *scene.files), json, *paths)
    found = Review(
        opened, scene, score, TargetSettings(min_points=min_points), within,
        blind, profiles, plan, distances, redundancy, tolerance, limits,
    )  # fmt: skip
    made = {name: PARTS[name](found) for name in parts}
    document = {"riglens": FORMAT_VERSION} | {name: part for name, (part, _) in made.items()}

    def show() -> None:
        for name, (_, print_part) in made.items():
            results().print(Text(f"== {name} ==", "bold"))
            print_part()

    deliver(document, json, show)


@dataclass(frozen=True)
class Review:
    """A rig under review; scene and traffic are loaded once, when the first part needs them."""

    rig: Rig
    scene: SceneOptions
    score: ScoreOptions
    counting: TargetSettings
    within_m: float
    blind_options: BlindArguments
    profiles: tuple[Profile, ...]
    plan: RangePlan
    range_options: RangeArguments
    redundancy_options: RedundancyArguments
    tolerance_options: ToleranceArguments
    px_per_m: tuple[float, ...]

    @cached_property
    def field(self) -> EntropyField:
        """The entropies of the scene."""
        return load_scene(self.scene, [self.rig], self.score)[1]

    @cached_property
    def traffic(self) -> Traffic | None:
        """The objects of the scene; None, with a note, where it has none."""
        if self.scene.pog is not None:
            note("objects are not counted: a stored POG has none")
            return None
        return load_traffic(self.scene, self.within_m)

    def blind(self) -> Part:
        """Find blind zones and judge test objects."""
        return self.blind_options.find(self.rig, self.profiles, self.score.threads)

    def range(self) -> Part:
        """Find detection ranges."""
        found = detection_range(self.rig, self.plan, self.score.threads)
        self.range_options.write(found)
        return range_document(found), lambda: print_range(found)

    def redundancy(self) -> Part:
        """Find what failures cost."""
        traffic = None if self.redundancy_options.no_objects else self.traffic
        halves = self.redundancy_options.halves
        found = redundancy_of(self.rig, self.field, traffic, self.score, self.counting, halves, TERMINAL)
        return found.document(), lambda: print_redundancy(found)

    def tolerance(self) -> Part:
        """Draw errors and find how figures spread."""
        asked = self.tolerance_options
        traffic = self.traffic if asked.sample else None
        with progress_bar("Drawing errors") as progress:
            found, document = drawn(
                self.rig, self.field, traffic, self.score, asked.errors, asked.draws, asked.seed, asked.sample,
                asked.sensitivities, progress,
            )  # fmt: skip
        asked.write(found)
        return document, lambda: print_tolerance(found, document["body"])

    def audit(self) -> Part:
        """Follow every ray."""
        with progress_bar("Tracing rays"):
            found = audit_rig(self.field, self.rig, "blocks", self.score.threads)
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


def parts_of(only: str | None) -> list[str]:
    """Return the parts that were named, in the order of all."""
    named = list(PARTS) if only is None else [name.strip() for name in only.split(",")]
    if unknown := [name for name in named if name not in PARTS]:
        raise InputError(f"must be some of {','.join(PARTS)} (got '{unknown[0]}')", "only")
    return [name for name in PARTS if name in named]
