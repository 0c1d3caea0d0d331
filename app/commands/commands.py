"""Every command of `riglens` by its name, in the order in which they are listed."""

from __future__ import annotations

from cyclopts import App, Parameter

from riglens.app.commands.data import data, pog
from riglens.app.commands.picture import render
from riglens.app.commands.rigs import convert, library, presets
from riglens.app.commands.scores import evaluate
from riglens.app.commands.studies import accuracy, stability, table1
from riglens.app.commands.window import window
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
app.command(pog, sort_key=2)
app.command(data, sort_key=3)
app.command(render, sort_key=4)
app.command(presets, sort_key=5)
app.command(convert, sort_key=5)
app.command(library, sort_key=7)
for command in (table1, accuracy, stability):
    study.command(command)
