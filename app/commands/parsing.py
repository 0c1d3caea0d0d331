"""Every command of `riglens` by its name, and how the words of a command line become a call."""

from __future__ import annotations

import os
from collections.abc import Sequence
from difflib import get_close_matches
from typing import NamedTuple

from cyclopts import App, CycloptsError, Parameter, UnusedCliTokensError

from riglens.app.commands.options import (
    Libraries,
    RigName,
    SceneArguments,
    WindowArguments,
    command,
    shown_default,
)
from riglens.core.errors import InputError
from riglens.evaluation.options import DEFAULT_RIG, SceneOptions, ScoreOptions
from riglens.version import installed_version


class Command(NamedTuple):
    """Command: its module, which is loaded when it is called, and its line in the list of commands."""

    place: str
    help: str


COMMANDS = {
    "evaluate": Command(
        "evaluate:evaluate", "Evaluate rigs: the leading figures, objects, and the paper's scores."
    ),
    "review": Command(
        "review:review", "Blind zones, detection range, redundancy, tolerance, rays and mounts of a rig."
    ),
    "optimise": Command(
        "optimise:optimise",
        "Propose where to add or move sensors, with an upper bound on every alternative and checks of the gain.\n\n"
        'Example: riglens optimise "nuScenes car" --add velodyne-vlp-16 --out proposals. Needs --add or --move; '
        "`riglens list sensors` has the models. All other sensors of the rig stay. See docs/optimise.md.",
    ),
    "sweep": Command(
        "sweep:sweep",
        "Evaluate many rigs that differ in some fields, into one table.\n\n"
        'Example: riglens sweep "nuScenes car" --vary LIDAR_TOP.z=1.6:2.2:13 --out height.parquet. The figures are '
        "those of `riglens evaluate --targets`. After an interruption the same command resumes and gives the same "
        "file. See docs/sweep.md.",
    ),
    "check": Command(
        "check:check",
        "Check rigs against requirements; exit code 1 when one is not met.\n\n"
        "Exit code 0 when all are met, 1 when one is not, is not shown or not applicable, 2 for bad input, 3 for a "
        "failure of the program. Blind zones, test objects and mounts always have a solid car.",
    ),
    "calibrate": Command(
        "calibrate:calibrate", "Fit a detector's recall by points, for predicted detection of rigs."
    ),
    "report": Command("report:report", "Write a page or PDF about rigs, or check an earlier one."),
    "render": Command("render:render", "Draw a rig, its rays and the heatmap of a class into a PNG file."),
    "convert": Command("convert:convert", "Convert a rig between formats, reporting every lossy conversion."),
    "simulate": Command(
        "simulate:simulate",
        (
            "Simulate sweeps and pictures of rigs in traffic, in nuScenes' format.\n\nSweeps of all "
            "LiDARs together and of each, pictures of the cameras with labels and depth, and the "
            "tables that the official development kit loads and evaluates. After an interruption the "
            "same command resumes. See docs/simulate.md."
        ),
    ),
}
GROUPS = {
    "data": (
        "Build a POG from box data, or describe box data.",
        {
            "build": Command(
                "data:build",
                "Build the POG of box data sets together and store it for --pog.\n\n"
                "Many logs or tables are built at once. After an interruption the same command resumes.",
            ),
            "show": Command(
                "data:show", "Show classes, directions, distances, sizes and ground of box data."
            ),
        },
    ),
    "list": (
        "Built-in rigs and sensor models.",
        {
            "rigs": Command("list:rigs", "List the built-in rigs, or write one as rig YAML."),
            "sensors": Command("list:sensors", "List the sensor models, or show every figure of one."),
        },
    ),
    "study": (
        "Studies of the paper, and of the metric itself.",
        {
            "table1": Command("study:table1", "The paper's Tables I and II next to ours."),
            "accuracy": Command("study:accuracy", "Time and error of the methods that can score a rig."),
            "stability": Command(
                "study:stability", "Failures of methods, and how stable the order of rigs is."
            ),
            "targets": Command(
                "study:targets", "Predicted against true points on the objects of a recording."
            ),
            "external": Command(
                "study:external", "Published changes of sensors against figures of the same rigs."
            ),
            "detection": Command(
                "study:detection",
                "Score against detection, with a small detector trained here.\n\n"
                "It compares rigs and does not predict the AP of your stack. About an hour of one core for two rigs; "
                "after an interruption the same command resumes.",
            ),
            "predicted": Command(
                "study:predicted", "Calibrate predicted detection on the rigs of the detection study."
            ),
        },
    ),
}


app = App(
    name="riglens",
    help="Place LiDARs and cameras on a car and score how well they cover traffic. "
    "RIG is a rig file or the name of a preset (W+T); see `riglens list rigs`.",
    help_format="plaintext",
    usage="Usage: riglens [RIG] [OPTIONS]\n       riglens COMMAND [OPTIONS] [ARGS]\n",
    version=installed_version,
    default_parameter=Parameter(negative=(), show_default=shown_default),
    suppress_keyboard_interrupt=False,
)


@app.default
@command
def window(
    rig: RigName = DEFAULT_RIG,
    /,
    *,
    scene: SceneArguments = SceneOptions(),
    score: WindowArguments = ScoreOptions(),
    libraries: Libraries = (),
) -> int:
    """Open the window on RIG (nuScenes car). Without a display: the scores, and a picture, YAML and JSON in out/."""
    if libraries:
        from riglens.core.rig.library import use_libraries

        use_libraries(libraries)
    from riglens.app.commands.start import start

    return start(rig, scene, score)


def _add(to: App, name: str, command: Command, order: int) -> None:
    to.command(f"riglens.app.commands.{command.place}", name=name, help=command.help, sort_key=order)


for _order, (_name, _command) in enumerate(COMMANDS.items()):
    _add(app, _name, _command, _order)
for _order, (_name, (_help, _members)) in enumerate(GROUPS.items(), len(COMMANDS)):
    _group = App(name=_name, help=_help, help_format="plaintext", sort_key=_order)
    for _place, (_member, _command) in enumerate(_members.items()):
        _add(_group, _member, _command, _place)
    app.command(_group)


def run(tokens: Sequence[str]) -> object:
    """Run the command and return its result. Raise InputError for words that do not fit."""
    from riglens.app.terminal.console import notes_once

    _check_words(tokens)
    try:
        with notes_once():
            return app(tokens, exit_on_error=False, print_error=False, result_action="return_value")
    except UnusedCliTokensError as error:
        raise InputError(f"unexpected words: {' '.join(error.unused_tokens or ())}") from error
    except CycloptsError as error:
        raise InputError(str(error)) from error


def _check_words(tokens: Sequence[str]) -> None:
    """Refuse a name that is empty, which would be the working folder, and an unknown command, which would be a rig."""
    if "" in tokens:
        raise InputError("empty word '': name a file, a rig or a command")
    word = tokens[0] if tokens else ""
    if not word.isalpha() or word in app or os.path.exists(word) or _is_preset(word):
        return
    if meant := meant_command(word):
        raise InputError(f"unknown command '{word}' (did you mean 'riglens {meant}'?)")
    if len(tokens) > 1 and not tokens[1].startswith("-"):
        raise InputError(f"unknown command '{word}'; 'riglens --help' lists all commands")


def _is_preset(word: str) -> bool:
    from riglens.core.rig.presets import PRESETS  # the model of rigs takes its time

    return word in PRESETS


def meant_command(word: str) -> str | None:
    """Return the command that a misspelt one was probably meant to be; None for anything else."""
    if word.lower() == "help":
        return "--help"
    close = get_close_matches(word.lower(), [name for name in app if name.isalpha()], 1, cutoff=0.75)
    return close[0] if close else None
