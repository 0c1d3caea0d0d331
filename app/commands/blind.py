"""`riglens blind`: where an object beside the car stands unseen, and which test objects a rig sees."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Group, Parameter

from riglens.app.commands.options import SCORE, LibraryArguments, Rig, SolidBody, Whole, check_json
from riglens.app.evaluation.options import ScoreOptions, require_solid

ZONES = Group("Blind zones", sort_key=20)


def blind(
    rig: Rig,
    /,
    *,
    width: Annotated[float, Parameter(group=ZONES, metavar="M")] = 0.3,
    within: Annotated[float, Parameter(group=ZONES, metavar="M")] = 20.0,
    voxel: Annotated[float, Parameter(group=ZONES, metavar="M")] = 0.1,
    by: Annotated[Literal["any", "lidar", "camera"], Parameter(group=ZONES, metavar="NAME")] = "any",
    sensors: Annotated[Literal[1, 2], Parameter(group=ZONES, metavar="1|2")] = 1,
    profile: Annotated[tuple[Path, ...], Parameter(group=ZONES, metavar="FILE", show_default=False)] = (),
    body: SolidBody = None,
    threads: Annotated[Whole, Parameter(group=SCORE)] = None,
    libraries: LibraryArguments = LibraryArguments(),
    out: Annotated[Path | None, Parameter(metavar="FILE.csv|.png")] = None,
    json: Annotated[str | None, Parameter(allow_leading_hyphen=True, metavar="FILE|-")] = None,
) -> None:
    """Say where beside the car an object stands unseen, and which objects of profiles a rig sees. The car is solid.

    Parameters
    ----------
    rig
        Rig file or preset name.
    width
        Width of the object in metres; 0 looks at single columns of voxels.
    within
        Look so far from the car's outline, in metres.
    voxel
        Edge of a voxel in metres.
    by
        Sensors of which the table and the map tell; the JSON tells of all.
    sensors
        How many sensors have to see the object; the JSON tells of 1 and 2.
    profile
        A file of profiles of your own, instead of those that ship with the program; may be given many times.
    threads
        Threads to use (all cores). The figures do not depend on it.
    out
        Also write the lowest visible height around the car, as a table or as a picture.
    json
        Also write the figures as JSON to a file; with - to standard output, instead of the table.
    """
    check_json(json)
    libraries.use()
    ScoreOptions(threads=threads)
    require_solid(body)
    from riglens.app.commands import blind_job
    from riglens.core.review.blind import BlindSettings

    settings = BlindSettings(voxel, width, within_m=within)
    blind_job.blind(rig, settings, blind_job.Asked(by, sensors, profile, threads, out, json))
