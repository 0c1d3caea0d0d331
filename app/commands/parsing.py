"""Every command of `riglens` by its name, and how the words of a command line become a call."""

from __future__ import annotations

import os
from collections.abc import Sequence
from difflib import get_close_matches

from cyclopts import App, CycloptsError, Parameter, UnusedCliTokensError

from riglens.app.commands.audit import audit
from riglens.app.commands.blind import blind
from riglens.app.commands.card import card
from riglens.app.commands.check import check
from riglens.app.commands.data import data, pog
from riglens.app.commands.picture import render
from riglens.app.commands.redundancy import redundancy
from riglens.app.commands.report import report
from riglens.app.commands.rigs import convert, library, presets
from riglens.app.commands.scores import evaluate, window
from riglens.app.commands.simulate import simulate
from riglens.app.commands.studies import accuracy, detection, stability, table1
from riglens.app.commands.studies import targets as study_targets
from riglens.app.commands.targets import targets
from riglens.app.commands.tolerance import tolerance
from riglens.core.errors import InputError
from riglens.version import installed_version

app = App(
    name="riglens",
    help="Place LiDARs and cameras on a car and score how well they see traffic (S-MS). "
    "RIG is a rig file or the name of a preset (W+T); see `riglens presets`.",
    help_format="plaintext",
    usage="Usage: riglens [RIG] [OPTIONS]\n       riglens COMMAND [OPTIONS] [ARGS]\n",
    version=installed_version,
    default_parameter=Parameter(negative=()),
    suppress_keyboard_interrupt=False,
)
study = App(name="study", help="Repeat studies of the paper.", help_format="plaintext")

app.default(window)
app.command(study)
app.command(evaluate, sort_key=1)
app.command(targets, sort_key=2)
app.command(audit, sort_key=2)
app.command(blind, sort_key=2)
app.command(card, sort_key=2)
app.command(check, sort_key=2)
app.command(redundancy, sort_key=2)
app.command(report, sort_key=2)
app.command(tolerance, sort_key=2)
app.command(pog, sort_key=2)
app.command(data, sort_key=3)
app.command(simulate, sort_key=4)
app.command(render, sort_key=4)
app.command(presets, sort_key=5)
app.command(convert, sort_key=5)
app.command(library, sort_key=7)
for command in (table1, accuracy, stability, detection):
    study.command(command)
study.command(study_targets, name="targets")


def run(tokens: Sequence[str]) -> object:
    """Run the command; what it returns. InputError for words that fit none."""
    _check_words(tokens)
    try:
        return app(tokens, exit_on_error=False, print_error=False, result_action="return_value")
    except UnusedCliTokensError as error:
        words = " ".join(error.unused_tokens or ())
        raise InputError(f"found {words}, where no more is expected") from error
    except CycloptsError as error:
        raise InputError(str(error)) from error


def _check_words(tokens: Sequence[str]) -> None:
    """Refuse a name that is empty, which would be the working folder, and a misspelt command, which would be a rig."""
    if "" in tokens:
        raise InputError("found an empty word '', accepted is the name of a file, a rig or a command")
    word = tokens[0] if tokens else ""
    meant = meant_command(word)
    if meant is not None and not os.path.exists(word):
        raise InputError(f"found '{word}', which is no command; did you mean riglens {meant}?")


def meant_command(word: str) -> str | None:
    """The command that a misspelt one was probably meant to be; None for a command, and for anything else."""
    known = [name for name in app if name.isalpha()]
    if not word.isalpha() or word in known:
        return None
    if word.lower() == "help":
        return "--help"
    close = get_close_matches(word.lower(), known, 1, cutoff=0.75)
    return close[0] if close else None
