"""`riglens review`: all parts of a safety review of a rig, with one set of defaults."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Any

from cyclopts import Group, Parameter
from rich.text import Text

from riglens.app.commands.audit import print_audit
from riglens.app.commands.blind import print_blind
from riglens.app.commands.detection_range import print_range
from riglens.app.commands.mounts import print_mounts
from riglens.app.commands.options import (
    Json,
    Profiles,
    RigArguments,
    RigName,
    SceneArguments,
    ScoreArguments,
    command,
    number,
)
from riglens.app.commands.output import deliver, require_outputs
from riglens.app.commands.redundancy import print_redundancy
from riglens.app.commands.tolerance import Drawing, drawn, print_tolerance
from riglens.app.terminal.console import TERMINAL, note, progress_bar, results
from riglens.app.terminal.loading import load_rigs, load_scene, load_traffic
from riglens.core.blind.zones import BlindSettings
from riglens.core.engine.audit import audit as audit_rig
from riglens.core.engine.audit import audit_document
from riglens.core.errors import InputError
from riglens.core.metric.entropy import EntropyField
from riglens.core.review.documents import blind_document, mounts_review_document
from riglens.core.review.profiles import Profile, profiles_in
from riglens.core.rig.edits import damaged as damaged_rig
from riglens.core.rig.model import FORMAT_VERSION, Rig
from riglens.core.targets.detection_range import RangePlan
from riglens.core.targets.detection_range_table import range_document
from riglens.core.targets.settings import TargetSettings
from riglens.core.targets.traffic import WITHIN_M, Traffic
from riglens.evaluation.options import SceneOptions, ScoreOptions
from riglens.jobs.reviewing import blind_zones, detection_range, redundancy_of

REVIEW = Group("Review", sort_key=5)
Part = tuple[dict[str, Any], Callable[[], None]]
"""The JSON of a part, and what prints its tables."""


@command
def review(
    rig: RigName,
    /,
    *,
    only: Annotated[str | None, Parameter(group=REVIEW, metavar="PART,PART...")] = None,
    min_points: Annotated[int, number(REVIEW)] = 5,
    profiles: Annotated[Profiles, Parameter(group=REVIEW)] = (),
    errors: Annotated[str, Parameter(group=REVIEW, metavar="NAME")] = "assembly",
    draws: Annotated[int, number(REVIEW)] = 256,
    seed: Annotated[int, number(REVIEW)] = 0,
    sample: Annotated[int, number(REVIEW)] = 100,
    damaged: Annotated[
        tuple[str, ...], Parameter(group=REVIEW, metavar="SENSOR[=HALF]", show_default=False)
    ] = (),
    halves: Annotated[bool, Parameter(group=REVIEW, negative="")] = False,
    scene: SceneArguments = SceneOptions(),
    score: ScoreArguments = ScoreOptions(),
    reading: RigArguments = RigArguments(),
    json: Json = None,
) -> None:
    """Review a rig: blind zones, detection range, redundancy, tolerance, ray outcomes, mounts.

    Parameters
    ----------
    only
        Parts to run: blind, range, redundancy, tolerance, audit, mounts (all).
    min_points
        LiDAR points that detect an object.
    profiles
        File of your own blind zone profiles, instead of the bundled ones; may be repeated.
    errors
        Errors of the tolerance: assembly, service, brackets, ride or load.
    draws
        Draws of the tolerance; they take most of the time.
    seed
        Seed of the draws.
    sample
        Number of frames in which objects are counted for the tolerance; 0 for none.
    damaged
        Sensor that has failed or, with =left, =right, =upper or =lower, is blocked by half; may be repeated.
    halves
        Redundancy also lists the losses by each sensor with half of its view blocked.
    json
        Also write one JSON document, with a key per part, to a file; with - to standard output, instead of the tables.
    """
    parts = parts_of(only)
    asked = RangePlan(min_points), profiles_in(profiles), Drawing.of(errors, draws, seed, sample)
    (opened,) = load_rigs([rig], score.solid(), reading.libraries, reading.housings)
    opened = damaged_rig(opened, damaged)
    require_outputs((rig, *profiles, *scene.files), json)
    found = Review(opened, scene, score, *asked, TargetSettings(min_points=min_points), halves)
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
    plan: RangePlan
    profiles: tuple[Profile, ...]
    drawing: Drawing
    counting: TargetSettings
    halves: bool = False

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
        return load_traffic(self.scene, WITHIN_M)

    def blind(self) -> Part:
        """Find blind zones and judge test objects."""
        settings = BlindSettings()
        found, judged = blind_zones(self.rig, settings, self.profiles, self.score.threads, TERMINAL)
        return blind_document(found, judged), lambda: print_blind(found, judged, "any", 1)

    def range(self) -> Part:
        """Find detection ranges."""
        found = detection_range(self.rig, self.plan, self.score.threads)
        return range_document(found), lambda: print_range(found)

    def redundancy(self) -> Part:
        """Find what failures cost."""
        found = redundancy_of(
            self.rig, self.field, self.traffic, self.score, self.counting, self.halves, TERMINAL
        )
        return found.document(), lambda: print_redundancy(found)

    def tolerance(self) -> Part:
        """Draw errors and find how figures spread."""
        traffic = self.traffic if self.drawing.sample else None
        found, document = drawn(self.rig, self.field, traffic, self.score, self.drawing)
        return document, lambda: print_tolerance(found, document["body"])

    def audit(self) -> Part:
        """Follow every ray."""
        with progress_bar("Tracing rays"):
            found = audit_rig(self.field, self.rig, "blocks", self.score.threads)
        return audit_document(found), lambda: print_audit(found)

    def mounts(self) -> Part:
        """Say where sensors sit."""
        return mounts_review_document(self.rig), lambda: print_mounts(self.rig)


PARTS: dict[str, Callable[[Review], Part]] = {
    "blind": Review.blind,
    "range": Review.range,
    "redundancy": Review.redundancy,
    "tolerance": Review.tolerance,
    "audit": Review.audit,
    "mounts": Review.mounts,
}


def parts_of(only: str | None) -> list[str]:
    """Return the parts that were named, in the order of all."""
    named = list(PARTS) if only is None else [name.strip() for name in only.split(",")]
    if unknown := [name for name in named if name not in PARTS]:
        raise InputError(f"must be some of {','.join(PARTS)} (got '{unknown[0]}')", "only")
    return [name for name in PARTS if name in named]
