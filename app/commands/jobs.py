"""What the commands that draw nothing do: score rigs, list presets, repeat Table I."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

from riglens.app.commands import tables
from riglens.app.commands.console import note, note_report, progress_bar, results
from riglens.app.evaluation.options import SceneOptions, ScoreOptions
from riglens.app.evaluation.scenario import load_scenario, remarks_on, settings_of
from riglens.core.engine import evaluation_json
from riglens.core.engine.engine import Engine, Evaluation, evaluate_from_scratch
from riglens.core.engine.warm_up import WARM_UP
from riglens.core.files import atomic_write, require_writable
from riglens.core.metric.entropy import EntropyField
from riglens.core.rig.model import Rig
from riglens.core.rig.opening import open_rig
from riglens.core.rig.presets import PAPER_RIGS, PRESETS, preset
from riglens.core.rig.yaml.file import dumps
from riglens.core.scene.pog import Pog
from riglens.core.sensing.rays import missing_ray_count
from riglens.core.study import table1 as study


def rig_called(name: str) -> Rig:
    """The rig of a preset, a rig file or a file of another program; what became of that is noted."""
    opened = open_rig(name)
    note_report(opened.report)
    return opened.rig


def load_with_progress(options: SceneOptions) -> tuple[Pog, EntropyField]:
    """The scene, with a bar while its POG is built, and notes on what does not count and what was picked."""
    with progress_bar("Building the POG") as progress:
        found = load_scenario(options, progress)
    for line in remarks_on(found.field.data):
        note(line)
    if found.choice is not None:
        note(f"voxel auto: {found.choice.reason()}")
        for line in found.choice.lines():
            note(line)
    return found.pog, found.field


def score_rigs(
    rigs: Sequence[Rig], field: EntropyField, options: ScoreOptions, with_seen: bool = False
) -> list[Evaluation]:
    """Evaluations of the rigs in the order given; each from scratch, so that their times can be compared."""
    evaluations = []
    with progress_bar("Casting rays") as progress:
        found = evaluate_from_scratch(
            field, [WARM_UP, *rigs], settings_of(options), options.threads, with_seen
        )
        next(found)
        for evaluation in found:
            evaluations.append(evaluation)
            progress(len(evaluations) / len(rigs))
    return evaluations


def evaluate(names: Sequence[str], scene: SceneOptions, score: ScoreOptions, json_target: str | None) -> None:
    """Print the scores of some rigs as a table, also written to a JSON file; with "-" as JSON alone."""
    rigs = [rig_called(name) for name in names]
    if json_target not in (None, "-"):
        require_writable(json_target, (*names, *scene.files))
    for line in (line for rig in rigs for line in missing_rays(rig)):
        note(line)
    _, field = load_with_progress(scene.for_rigs(rigs, score))
    evaluations = score_rigs(rigs, field, score)
    document = evaluation_json.evaluation_document(field, settings_of(score), evaluations)
    if json_target == "-":
        sys.stdout.write(evaluation_json.to_text(document))
        return
    if json_target is not None:
        with atomic_write(json_target, "w") as stream:
            stream.write(evaluation_json.to_text(document))
    print_scores(evaluations, field, score)


def missing_rays(rig: Rig) -> Iterator[str]:
    """One line for each enabled camera whose lens model gives some of its pixels no direction."""
    for camera in rig.cameras():
        missing = missing_ray_count(camera)
        if missing:
            share = f"{missing:,} of {camera.ray_count:,} rays lie beyond what its lens model can say"
            yield f"{rig.name}: {camera.name}: {share}, and are left out"


def table1(scene: SceneOptions, score: ScoreOptions, csv_target: Path | None) -> None:
    """Print the paper's Table I beside our figures, and say where the orders agree; also write it as CSV."""
    if csv_target is not None:
        require_writable(csv_target, scene.files)
    _, field = load_with_progress(scene.for_rigs([preset(name) for name in PAPER_RIGS], score))
    with progress_bar("Casting rays") as progress:
        table = study.table1(Engine(field, score.threads), settings_of(score), progress)
    if csv_target is not None:
        with atomic_write(csv_target, "w") as stream:
            stream.write(table.to_csv())
    console = results()
    print_scene(field, score)
    console.print(tables.table1_figures(table))
    console.print(tables.table1_orders(table))
    for line in tables.table1_verdict(table):
        console.print(line, soft_wrap=True)


def print_scene(field: EntropyField, score: ScoreOptions) -> None:
    """What was scored and how, on standard output."""
    for line in tables.scene_lines(field, settings_of(score), field.data.short_source):
        results().print(line, soft_wrap=True)


def print_scores(evaluations: Sequence[Evaluation], field: EntropyField, score: ScoreOptions) -> None:
    """The scores with what they were computed on, on standard output."""
    console = results()
    print_scene(field, score)
    console.print(tables.score_table(evaluations))
    console.print(tables.EXPLANATION[score.reading], soft_wrap=True)


def presets(name: str | None, out: Path | None) -> None:
    """List the presets, print one as rig YAML, or write it to a file."""
    if name is None:
        rows = ((p.name, p.description, *_counts(p.rig())) for p in PRESETS.values())
        results().print(tables.preset_table(rows))
        return
    text = dumps(preset(name))
    if out is None:
        sys.stdout.write(text)
        return
    with atomic_write(out, "w") as stream:
        stream.write(text)
    results().print(f"{out}: preset {name}", soft_wrap=True, markup=False)


def _counts(rig: Rig) -> tuple[int, int]:
    return len(rig.cameras()), len(rig.lidars())
