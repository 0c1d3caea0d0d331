"""`riglens redundancy`: what how many sensors see, and what is lost when one, two or a group of them fail."""

from __future__ import annotations

from typing import Annotated

from cyclopts import Group, Parameter

from riglens.app.commands.options import (
    LibraryArguments,
    Rig,
    SceneArguments,
    ScoreArguments,
    check_json,
    whole_number,
)

FAILING = Group("Redundancy", sort_key=15)


def redundancy(
    rig: Rig,
    /,
    *,
    scene: SceneArguments = SceneArguments(),
    score: ScoreArguments = ScoreArguments(),
    road_users: Annotated[bool, Parameter(group=FAILING, negative="--no-road-users")] = True,
    min_points: Annotated[int, Parameter(converter=whole_number, group=FAILING, metavar="N")] = 5,
    within: Annotated[float, Parameter(group=FAILING, metavar="M")] = 60.0,
    libraries: LibraryArguments = LibraryArguments(),
    json: Annotated[str | None, Parameter(allow_leading_hyphen=True, metavar="FILE|-")] = None,
) -> None:
    """Say what one, two and three sensors see, and what is lost when sensors, pairs or groups of them fail.

    Parameters
    ----------
    rig
        Rig file or preset name.
    road_users
        Also count road users, not only voxels; a stored POG has none.
    min_points
        So many LiDAR points detect a road user; a camera does by 25 px of height.
    within
        Count road users within this distance of the car, in metres.
    json
        Also write the figures as JSON to a file; with - to standard output, instead of the table.
    """
    check_json(json)
    libraries.use()
    from riglens.app.commands import redundancy_job
    from riglens.core.targets.settings import TargetSettings

    asked = redundancy_job.Asked(road_users, within, TargetSettings(min_points=min_points), json)
    redundancy_job.redundancy(rig, scene.options(), score.options(), asked)
