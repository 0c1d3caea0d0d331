"""`riglens optimise`: propose rigs with sensors added or moved, with a bound and checks of the gain."""

from __future__ import annotations

import math
from dataclasses import replace
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
    number,
)
from riglens.app.commands.output import deliver, require_outputs
from riglens.app.terminal.console import TERMINAL, progress_bar, results
from riglens.app.terminal.loading import load_rigs, load_scene, load_traffic
from riglens.core.errors import InputError
from riglens.core.figures.text import change_text, in_sentence, in_unit, value_text
from riglens.core.optimise.mounts import Move, moves_of
from riglens.core.optimise.objectives import objective_named
from riglens.core.optimise.results import OptimiseResult, check_folder
from riglens.core.optimise.run import finished
from riglens.core.review.mounts import SIDES, MountLimits, Overhang
from riglens.core.shown_text import visible
from riglens.core.shown_values import NONE
from riglens.core.targets.traffic import WITHIN_M, Traffic
from riglens.evaluation.options import SceneOptions, ScoreOptions
from riglens.evaluation.search_options import HIGHEST_M, SearchOptions, numbers_of
from riglens.jobs.checking import CheckInputs, scene_for, unmet_by

ADDED = Group("Added sensors", sort_key=14)
MOVED = Group("Moved sensors", sort_key=15)
GOAL = Group("Objective", sort_key=16)
FRAMES = Group("Frames and checks", sort_key=17)
_GOALS = ("objective", "weight", "blind_m")
SearchArguments = Annotated[
    SearchOptions,
    all_of(SearchOptions, ADDED, dict.fromkeys(_GOALS, GOAL) | {"frames": FRAMES}),
]


@command
def optimise(
    rig: RigName,
    /,
    *,
    search: SearchArguments = SearchOptions(),
    inside: Annotated[str | None, Parameter(name="--box", group=ADDED, metavar="X0,X1,Y0,Y1,Z0,Z1")] = None,
    requirements: Annotated[Path | None, Parameter(metavar="FILE")] = None,
    move: Annotated[tuple[str, ...], Parameter(group=MOVED, metavar="NAME[=M]", show_default=False)] = (),
    exchange: Annotated[
        tuple[str, ...], Parameter(group=MOVED, metavar="NAME=MODEL", show_default=False)
    ] = (),
    within_m: Annotated[float, Parameter(name="--within", group=GOAL, metavar="M")] = WITHIN_M,
    surroundings: Surroundings = None,
    against: Annotated[str | None, Parameter(group=FRAMES, metavar="RIG")] = None,
    held_out: Annotated[int, number(FRAMES)] = 1000,
    check_boxes: Annotated[
        tuple[Path, ...], Parameter(group=FRAMES, metavar="FILE", show_default=False)
    ] = (),
    seed: Annotated[int, number(FRAMES)] = 0,
    scene: SourceArguments = SceneOptions(),
    score: ThreadArguments = ScoreOptions(),
    reading: RigArguments = RigArguments(),
    out: Annotated[Path | None, Parameter(metavar="DIR")] = None,
    json: Json = None,
) -> None:
    """Propose where to add or move sensors on the car's skin, with a bound on the gain of any other choice.

    Parameters
    ----------
    rig
        Rig file or preset name.
    inside
        Mount sensors in the air in this box, in metres, instead of on the skin.
    requirements
        File of requirements, as for `riglens check`: each mount keeps its limits, the whole rig is checked.
    surroundings
        block: houses, walls and poles of the bundled scenario hide objects too (ignored).
    move
        Let a sensor of the rig and its mirror partner go anywhere on the skin, or M metres far; may be repeated.
    exchange
        Let a sensor of the rig be exchanged for a model, in its place unless it may move; may be repeated.
    within_m
        Objects count up to this distance from the car.
    against
        Rig that gains are compared with, instead of mounts chosen by hand.
    held_out
        Number of other frames to check the gain in.
    check_boxes
        Also check the gain on this box data set; may be repeated.
    seed
        Seed of mounts, LiDAR phases and lost rays.
    out
        Folder for the proposed rigs as YAML and a table of them as CSV.
    json
        Also write the result as JSON to a file; with - to standard output, instead of the table.
    """
    rules, moves = search.rules(), _moves(move, exchange)
    score = score.solid()
    (opened,) = load_rigs([rig], score, reading.libraries, reading.housings)
    asked = None if requirements is None else CheckInputs.of(requirements, (), [opened])
    if asked is not None:
        rules = rules if asked.required.mounts is None else _stricter(rules, asked.required.mounts)
    additions = search.additions(rules, _box(inside))
    reference = (
        None if against is None else load_rigs([against], score, reading.libraries, reading.housings)[0]
    )
    require_outputs((rig, *scene.files, *check_boxes), json)
    if out is not None:
        check_folder(out)
    scene = scene.surrounded(surroundings)
    problem = search.problem(
        opened,
        load_traffic(scene, within_m),
        additions,
        held_out=held_out,
        seed=seed,
        reference=reference,
        moves=moves,
        voxels=load_scene(scene)[1] if objective_named(search.objective).figure.needs == "voxels" else None,
        checks=_other_traffic(scene, check_boxes, within_m),
    )
    if asked is not None:
        subject = scene_for(scene, [opened], score, asked.required, TERMINAL)
        problem = replace(problem, unmet=lambda one: unmet_by(one, score, subject, asked))
    with progress_bar("Casting, choosing, checking") as progress:
        found = finished(problem, score.threads, progress)
    if out is not None:
        found.save(out)
    deliver(found.to_dict(), json, lambda: print_proposals(found))


def _stricter(rules: MountLimits, asked: MountLimits) -> MountLimits:
    """Return the limits that keep those of options and of a file; zones of the file replace the usual ones."""

    def least(of: str, *both: MountLimits | Overhang) -> float | None:
        return min((limit for limit in (getattr(one, of) for one in both) if limit is not None), default=None)

    (low, high), (lowest, highest) = (one.height_m or (-HIGHEST_M, HIGHEST_M) for one in (rules, asked))
    if low > highest:
        raise InputError(f"must be at most {highest:g} m, as the requirements say (got {low:g})", "lowest")
    sizes = ("gap_m", "length_m", "width_m", "total_height_m")
    return MountLimits(
        **{name: least(name, rules, asked) for name in sizes},
        height_m=(max(low, lowest), min(high, highest)),
        spacing_m=max(rules.spacing_m or 0.0, asked.spacing_m or 0.0),
        beyond_m=Overhang(**{side: least(side, rules.beyond_m, asked.beyond_m) for side in SIDES}),
        keep_out=asked.keep_out,
    )


def _box(word: str | None) -> tuple[tuple[float, float], ...] | None:
    if word is None:
        return None
    try:
        x0, x1, y0, y1, z0, z1 = map(float, word.split(","))
    except ValueError:
        raise InputError(f"must be X0,X1,Y0,Y1,Z0,Z1 (got '{word}')", "box_m") from None
    return (x0, x1), (y0, y1), (z0, z1)


def _moves(move: tuple[str, ...], exchange: tuple[str, ...]) -> tuple[Move, ...]:
    """Return the moves, with the models that their sensors may be exchanged for."""
    models: dict[str, list[str]] = {}
    for word in exchange:
        name, _, model = word.rpartition("=")
        if not name:
            raise InputError(f"must be NAME=MODEL (got '{word}')", "exchange")
        models.setdefault(name, []).append(model)
    radius_m: dict[str, float] = {}
    for word in move:
        name, _, far = word.rpartition("=")
        radius_m |= numbers_of("move", (word,)) if name else {far: math.inf}
    return moves_of(radius_m, models)


def _other_traffic(scene: SceneOptions, more: tuple[Path, ...], within_m: float) -> dict[str, Traffic]:
    """Return other traffic by the name of its case: that of the bundled town with its surroundings, or without."""
    found = {}
    if scene.boxes is None:
        name = "surroundings ignored" if scene.surroundings else "surroundings block"
        found[name] = load_traffic(replace(scene, surroundings=not scene.surroundings), within_m)
    for path in more:
        found[path.stem] = load_traffic(
            replace(scene, boxes=path, surroundings=False, occluders=None), within_m
        )
    return found


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
