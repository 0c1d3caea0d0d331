"""`riglens targets`: what rigs get onto road users."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Group, Parameter

from riglens.app.commands.options import (
    BODY,
    SCENE,
    SCORE,
    BoxArguments,
    LibraryArguments,
    Whole,
    check_json,
    whole_number,
)
from riglens.app.evaluation.options import SceneOptions, ScoreOptions

COUNT = Group("Count", sort_key=20)
_TwoFiles = Parameter(group=SCENE, metavar="OCCLUDERS POSES", show_default=False)
_Number = Parameter(converter=whole_number, group=COUNT, metavar="N")


def targets(
    *rigs: Annotated[str, Parameter(name="RIG", required=True)],
    boxes: Annotated[Path | None, Parameter(group=SCENE, metavar="PATH", show_default=False)] = None,
    how: BoxArguments = BoxArguments(),
    within: Annotated[float, Parameter(group=SCENE, metavar="M")] = 60.0,
    surroundings: Annotated[Literal["ignored", "block"] | None, Parameter(group=SCENE)] = None,
    occluders: Annotated[tuple[Path, Path] | None, _TwoFiles] = None,
    sample: Annotated[int | None, _Number] = None,
    shape: Annotated[Literal["class", "box"], Parameter(group=COUNT)] = "class",
    range_law: Annotated[Literal["on", "off"], Parameter(group=COUNT)] = "on",
    phase: Annotated[Literal["random", "0"], Parameter(group=COUNT)] = "random",
    seed: Annotated[int, _Number] = 0,
    body: Annotated[Literal["ignored", "blocks"] | None, BODY] = None,
    min_points: Annotated[int, _Number] = 5,
    threads: Annotated[Whole, Parameter(group=SCORE)] = None,
    libraries: LibraryArguments = LibraryArguments(),
    objects: Annotated[Path | None, Parameter(metavar="FILE.csv|.parquet")] = None,
    json: Annotated[str | None, Parameter(allow_leading_hyphen=True, metavar="FILE|-")] = None,
) -> None:
    """Count the points and pixels that rigs get onto road users, behind the traffic before them.

    Parameters
    ----------
    rigs
        Rig files or preset names.
    boxes
        Box data set, as for `riglens evaluate`. Without it: the bundled scenario.
    within
        Road users count up to this distance from the car, in metres.
    surroundings
        block: houses, walls and poles of the bundled scenario hide road users too (ignored).
    occluders
        What stands around your own --boxes, and where the car is in each frame; it blocks.
    sample
        Use so many frames, drawn fairly, and say with ± how far that may be off (all frames).
    shape
        class: cars have glass and a gap below, cyclists and pedestrians are slim; box: plain boxes.
    range_law
        on: rays of LiDARs that come from far, or meet a face at a slant, may get lost.
    phase
        random turns each LiDAR in each frame by a part of its azimuth step; 0 casts azimuths as listed.
    seed
        What the random draws follow from.
    body
        Whether rays pass through the car's own body or end at it, for this run (as each rig says).
    min_points
        A road user with so many LiDAR points counts as detectable.
    threads
        Threads to use (all cores). The counts do not depend on it.
    objects
        Also write one row per road user to a table; for one rig.
    json
        Also write the figures as JSON to a file; with - to standard output, instead of the table.
    """
    check_json(json)
    libraries.use()
    scene = SceneOptions(boxes, how.origin, how.frames, how.classes, find_ground=how.ground == "auto")
    blocks = surroundings == "block" or (surroundings is None and occluders is not None)
    scene = replace(scene, surroundings=blocks, occluders=occluders)
    from riglens.app.commands import targets_job
    from riglens.core.targets.settings import TargetSettings

    settings = TargetSettings(shape, range_law == "on", phase, seed, min_points)
    score = ScoreOptions(threads=threads, body=body)
    targets_job.targets(rigs, scene, targets_job.Counting(settings, within, sample, score), objects, json)
