"""`riglens optimise`: propose rigs with sensors added to the car's skin, with a bound and checks of the gain."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Group, Parameter
from pydantic import ValidationError
from rich import box
from rich.table import Table
from rich.text import Text

from riglens.app.commands.options import Json, Libraries, RigName, SourceArguments, ThreadArguments, number
from riglens.app.commands.output import deliver, require_outputs
from riglens.app.terminal.console import progress_bar, results
from riglens.app.terminal.loading import load_rigs, load_traffic
from riglens.core.errors import InputError
from riglens.core.optimise.mounts import Additions
from riglens.core.optimise.results import OptimiseResult, Problem, check_folder
from riglens.core.optimise.run import finished
from riglens.core.review.mounts import MountLimits
from riglens.core.rig.yaml.problems import problems
from riglens.core.shown_text import visible
from riglens.core.targets.traffic import WITHIN_M

ADDED = Group("Added sensors", sort_key=14)
FRAMES = Group("Frames and checks", sort_key=15)
HIGHEST_M = 100.0
OPTIONS = {"height_m": "lowest", "spacing_m": "spacing", "beyond_m": "beyond"}
"""Options of the rules of mounts."""


def optimise(
    rig: RigName,
    /,
    *,
    add: Annotated[tuple[str, ...], Parameter(group=ADDED, metavar="MODEL", required=True)],
    count: Annotated[int, number(ADDED, "K")] = 1,
    singles: Annotated[bool, Parameter(group=ADDED)] = False,
    cost: Annotated[tuple[str, ...], Parameter(group=ADDED, metavar="MODEL=COST", show_default=False)] = (),
    budget: Annotated[float | None, Parameter(group=ADDED, metavar="COST")] = None,
    spots: Annotated[float, Parameter(group=ADDED, metavar="M")] = 0.2,
    lowest: Annotated[float, Parameter(group=ADDED, metavar="M")] = 0.4,
    spacing: Annotated[float, Parameter(group=ADDED, metavar="M")] = 0.25,
    beyond: Annotated[float | None, Parameter(group=ADDED, metavar="M")] = None,
    objective: Annotated[str, Parameter(metavar="NAME")] = "on_target",
    blind: Annotated[float | None, Parameter(metavar="M")] = None,
    against: Annotated[str | None, Parameter(group=FRAMES, metavar="RIG")] = None,
    frames: Annotated[int, number(FRAMES)] = 100,
    held_out: Annotated[int, number(FRAMES)] = 1000,
    seed: Annotated[int, number(FRAMES)] = 0,
    scene: SourceArguments = SourceArguments(),
    score: ThreadArguments = ThreadArguments(),
    libraries: Libraries = (),
    out: Annotated[Path | None, Parameter(metavar="DIR")] = None,
    json: Json = None,
) -> None:
    """Propose where to add LiDARs on the car's skin, with a bound on the gain of any other choice.

    Every sensor of the rig stays where it is. The gain of the proposal over mounts chosen by hand is checked in other
    frames and under other assumptions.

    Parameters
    ----------
    rig
        Rig file or preset name.
    add
        Library model to add; may be repeated to choose among models.
    count
        Number of mirror pairs to add, at most.
    singles
        Add single sensors instead of mirror pairs.
    cost
        Cost of one sensor of a model (1).
    budget
        Limit of the cost of all added sensors.
    spots
        Distance between neighbouring mounts on the skin.
    lowest
        Least height of a sensor over the ground.
    spacing
        Least distance between two sensors.
    beyond
        Largest overhang of housings over the car's outline at front, rear and sides.
    objective
        Figure to maximise: on_target, the mean over classes of the hit coverage of objects.
    blind
        Also trade it against the area where an object of this height is in no sensor's view.
    against
        Rig that gains are compared with, instead of mounts chosen by hand.
    frames
        Number of frames to choose by.
    held_out
        Number of other frames to check the gain in.
    seed
        Seed of mounts, LiDAR phases and lost rays.
    out
        Folder for the proposed rigs as YAML and a table of them as CSV.
    json
        Also write the result as JSON to a file; with - to standard output, instead of the table.
    """
    limit, rules = float("inf") if budget is None else budget, _rules(lowest, spacing, beyond)
    additions = Additions(add, count, not singles, _costs(cost), limit, rules, spots)
    score = score.solid()
    (opened,) = load_rigs([rig], score, libraries)
    reference = None if against is None else load_rigs([against], score, libraries)[0]
    require_outputs((rig, *scene.files), json)
    if out is not None:
        check_folder(out)
    traffic = load_traffic(scene, WITHIN_M)
    problem = Problem(opened, traffic, additions, objective, frames, held_out, seed, reference, blind)
    with progress_bar("Casting, choosing, checking") as progress:
        found = finished(problem, score.threads, progress)
    if out is not None:
        found.save(out)
    deliver(found.to_dict(), json, lambda: print_proposals(found))


def _rules(lowest_m: float, spacing_m: float, beyond_m: float | None) -> MountLimits:
    """Return the rules of mounts in metres; raise InputError for a number outside its limits."""
    out = dict.fromkeys(("front", "rear", "left", "right"), beyond_m)
    rules = {"height_m": (lowest_m, HIGHEST_M), "spacing_m": spacing_m, "beyond_m": out}
    try:
        return MountLimits.model_validate(rules)
    except ValidationError as error:
        problem = problems(error, rules)[0]
        raise InputError(problem.complaint.strip(), OPTIONS[str(problem.path[0])]) from error


def _costs(words: tuple[str, ...]) -> dict[str, float]:
    costs = {}
    for word in words:
        model, _, cost = word.partition("=")
        try:
            costs[model] = float(cost)
        except ValueError:
            raise InputError(f"must be MODEL=COST (got '{word}')", "cost") from None
    return costs


def print_proposals(found: OptimiseResult) -> None:
    """Print the best proposal, its bound, its checks, and the front if there is one, on standard output."""
    console, problem = results(), found.problem
    heading = f"{visible(problem.rig.name)}: hit coverage {found.before:.3f}, proposed {found.best.value:.3f}"
    console.print(f"{heading} (in the {problem.frames} frames of choice)", soft_wrap=True)
    console.print(_sensors(found))
    console.print(Text(f"{found.sentence()[0].upper()}{found.sentence()[1:]}."), soft_wrap=True)
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
        console.print(Text(f"Front of hit coverage and {unseen}:"), soft_wrap=True)
        console.print(_front(found))


def _sensors(found: OptimiseResult) -> Table:
    table = Table(box=box.SIMPLE_HEAD)
    for name in ("added sensor", "x, y, z [m]", "roll, pitch, yaw [°]"):
        table.add_column(name)
    for one in found.best.added:
        for sensor in one.sensors:
            place, turn = (
                ", ".join(f"{v:.2f}" for v in values) for values in (sensor.position, sensor.rpy_deg)
            )
            table.add_row(visible(sensor.name), place, turn)
    return table


def _checks(found: OptimiseResult) -> Table:
    table = Table(box=box.SIMPLE_HEAD)
    table.add_column("checked in")
    for name in ("gain", "± 1 SE", "kept"):
        table.add_column(name, justify="right")
    gain = found.best.value - found.reference_value
    table.add_row("frames of choice", f"{gain:+.4f}", "—", "—")
    for one in found.best.guard:
        table.add_row(one.case, f"{one.gain:+.4f}", f"{one.se:.4f}", f"{one.share:.0%}")
    return table


def _front(found: OptimiseResult) -> Table:
    table = Table(box=box.SIMPLE_HEAD)
    for name in ("proposal", "hit coverage", "unseen [m²]", "cost"):
        table.add_column(name, justify="right")
    for place in found.front:
        one = found.proposals[place]
        table.add_row(str(place + 1), f"{one.value:.4f}", f"{one.blind_m2:.1f}", f"{one.cost:g}")
    return table
