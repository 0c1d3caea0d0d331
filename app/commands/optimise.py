"""`riglens optimise`: propose rigs with sensors added or moved, with a bound and checks of the gain."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Group, Parameter
from rich import box
from rich.table import Table
from rich.text import Text

from riglens.app.commands.options import (
    Json,
    RigArguments,
    RigName,
    SourceArguments,
    Surroundings,
    ThreadArguments,
    all_of,
    command,
)
from riglens.app.commands.output import deliver, require_outputs
from riglens.app.terminal.console import TERMINAL, results
from riglens.core.figures.text import change_text, in_sentence, in_unit, value_text
from riglens.core.optimise.results import OptimiseResult, check_folder
from riglens.core.shown_text import visible
from riglens.core.shown_values import NONE
from riglens.core.targets.traffic import WITHIN_M
from riglens.evaluation.loading import load_rigs
from riglens.evaluation.options import SceneOptions, ScoreOptions
from riglens.evaluation.search_options import SearchOptions
from riglens.jobs.optimising import optimised

ADDED = Group("Added sensors", sort_key=14)
MOVED = Group("Moved sensors", sort_key=15)
GOAL = Group("Objective", sort_key=16)
FRAMES = Group("Frames and checks", sort_key=17)
_GROUPS = (
    dict.fromkeys(("objective", "weight", "blind_m"), GOAL)
    | dict.fromkeys(("move", "exchange"), MOVED)
    | dict.fromkeys(("frames", "held_out", "seed"), FRAMES)
)
SearchArguments = Annotated[SearchOptions, all_of(SearchOptions, ADDED, _GROUPS)]


@command
def optimise(
    rig: RigName,
    /,
    *,
    search: SearchArguments = SearchOptions(),
    requirements: Annotated[Path | None, Parameter(metavar="FILE")] = None,
    within_m: Annotated[float, Parameter(name="--within", group=GOAL, metavar="M")] = WITHIN_M,
    surroundings: Surroundings = None,
    against: Annotated[str | None, Parameter(group=FRAMES, metavar="RIG")] = None,
    check_boxes: Annotated[
        tuple[Path, ...], Parameter(group=FRAMES, metavar="FILE", show_default=False)
    ] = (),
    scene: SourceArguments = SceneOptions(),
    score: ThreadArguments = ScoreOptions(),
    reading: RigArguments = RigArguments(),
    out: Annotated[Path | None, Parameter(metavar="DIR")] = None,
    json: Json = None,
) -> None:
    """Propose where to add or move sensors on the car's skin, with a bound on the gain of any other choice.

    Parameters
    ----------
    requirements
        File of requirements, as for `riglens check`: each mount keeps its limits, the whole rig is checked.
    within_m
        Objects count up to this distance from the car.
    against
        Rig that gains are compared with, instead of typical mounts.
    check_boxes
        Also check the gain on this box data set; may be repeated.
    out
        Folder for the proposed rigs as YAML and a table of them as CSV.
    json
        Also write the result as JSON to a file; with - to standard output, instead of the table.
    """
    score = score.solid()
    named = [rig] if against is None else [rig, against]
    opened, *reference = load_rigs(named, score, TERMINAL, reading.libraries, reading.housings)
    require_outputs((rig, *scene.files, *check_boxes), json)
    if out is not None:
        check_folder(out)
    found = optimised(
        opened, search, scene.surrounded(surroundings), score, TERMINAL, within_m=within_m,
        requirements=requirements, reference=reference[0] if reference else None, check_boxes=check_boxes,
    )  # fmt: skip
    if out is not None:
        found.save(out)
    deliver(found.to_dict(), json, lambda: print_proposals(found))


def print_proposals(found: OptimiseResult) -> None:
    """Print the best proposal, its bound, its checks, and the front if there is one, on standard output."""
    console, problem = results(), found.problem
    title = in_sentence(problem.goal.title)
    before, after = (value_text(found.figure, value) for value in (found.before, found.best.value))
    where = f" (in the {problem.frames} frames of choice)" if problem.goal.of_objects else ""
    console.print(
        Text(f"{visible(problem.rig.name)}: {title} {before}, proposed {after}{where}"), soft_wrap=True
    )
    console.print(Text(problem.goal.question), soft_wrap=True)
    console.print(_sensors(found))
    console.print(Text(f"{found.sentence()[0].upper()}{found.sentence()[1:]}."), soft_wrap=True)
    if found.unmet is not None:
        missed = ", ".join(found.unmet)
        said = f"Requirements not met by any set tried: {missed}." if missed else "All requirements are met."
        console.print(Text(f"Every mount keeps the limits of mounts. {said}"), soft_wrap=True)
    console.print(Text(f"Gain over {visible(found.reference.name)}:"), soft_wrap=True)
    console.print(_checks(found))
    weak = ", ".join(f"{one.case} ({one.share:.0%})" for one in found.best.weak)
    console.print(
        Text(f"Verdict: {found.best.verdict}." + (f" Less than half is left with: {weak}." if weak else ""))
    )
    if found.front:
        unseen = (
            f"ground where an object of {problem.blind_m:g} m is unseen ({found.before_blind_m2:.1f} m² now)"
        )
        console.print(Text(f"Front of {title} and {unseen}:"), soft_wrap=True)
        console.print(_front(found))


def _sensors(found: OptimiseResult) -> Table:
    table = Table(box=box.SIMPLE_HEAD)
    for name in ("sensor" if found.problem.moves else "added sensor", "x, y, z [m]", "roll, pitch, yaw [°]"):
        table.add_column(name)
    for name in ("cost", "adds"):
        table.add_column(name, justify="right")
    for one, gain in zip(found.best.added, found.best.adds, strict=True):
        for place_in_pair, sensor in enumerate(one.sensors):
            place, turn = (
                ", ".join(f"{v:.2f}" for v in values) for values in (sensor.position, sensor.rpy_deg)
            )
            more = NONE if place_in_pair else change_text(found.figure, gain)
            table.add_row(visible(sensor.name), place, turn, f"{one.cost / len(one.sensors):g}", more)
    return table


def _checks(found: OptimiseResult) -> Table:
    table = Table(box=box.SIMPLE_HEAD)
    table.add_column("checked in")
    for name in ("gain", "SE", "kept"):
        table.add_column(name, justify="right")
    figure = found.figure
    if found.problem.goal.of_objects:
        table.add_row("frames of choice", change_text(figure, found.gain), NONE, NONE)
    for one in found.best.guard:
        error = f"{in_unit(figure, one.se):.2f}" if one.se else NONE
        table.add_row(one.case, change_text(figure, one.gain), error, f"{one.share:.0%}")
    return table


def _front(found: OptimiseResult) -> Table:
    table = Table(box=box.SIMPLE_HEAD)
    for name in ("proposal", in_sentence(found.problem.goal.title), "unseen [m²]", "cost"):
        table.add_column(name, justify="right")
    for place in found.front:
        one = found.proposals[place]
        table.add_row(
            str(place + 1), value_text(found.figure, one.value), f"{one.blind_m2:.1f}", f"{one.cost:g}"
        )
    return table
