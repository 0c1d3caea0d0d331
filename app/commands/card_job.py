"""What `riglens card` does: make the card of a rig and say it as a table, as CSV, as a chart, as JSON."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import NamedTuple

from riglens.app.commands.scores_job import missing_rays
from riglens.app.evaluation.options import ScoreOptions
from riglens.app.studies.files import csv_text, write_text
from riglens.app.terminal.card import print_card
from riglens.app.terminal.console import note
from riglens.app.terminal.scores import mesh_called, rig_called
from riglens.core.engine.evaluation_json import to_text
from riglens.core.errors import InputError
from riglens.core.files import atomic_write, require_writable
from riglens.core.targets.card import CardPlan
from riglens.core.targets.card_making import card_of
from riglens.core.targets.card_table import card_document, card_lines
from riglens.core.targets.engine import warm_up


class Files(NamedTuple):
    """What to write: CSV, chart, JSON; "-" is standard output."""

    csv: Path | None
    chart: Path | None
    json: str | None


def card(name: str, plan: CardPlan, score: ScoreOptions, files: Files) -> None:
    """Print the card of a rig, also written to files; with "-" as JSON alone."""
    rig = rig_called(name)
    if files.chart is not None and files.chart.suffix.lower() not in (".png", ".svg"):
        raise InputError(f"--chart {files.chart}: found another ending, accepted are .png and .svg")
    for path in (files.csv, files.chart, None if files.json in (None, "-") else files.json):
        if path is not None:
            require_writable(path, (name,))
    for line in missing_rays(rig):
        note(line)
    mesh = mesh_called(name, rig)
    warm_up(score.threads)
    found = card_of(rig, plan, score.threads, mesh=mesh)
    if files.csv is not None:
        write_text(files.csv, csv_text(card_lines(found)))
    if files.chart is not None:
        from riglens.app.studies.card_chart import card_figure  # matplotlib
        from riglens.app.studies.pictures import PictureFormat, picture

        form: PictureFormat = "svg" if files.chart.suffix.lower() == ".svg" else "png"
        with atomic_write(files.chart) as stream:
            stream.write(picture(card_figure(found), form))
    if files.json == "-":
        sys.stdout.write(to_text(card_document(found)))
        return
    if files.json is not None:
        write_text(Path(files.json), to_text(card_document(found)))
    print_card(found)
