"""The paper's scores in the terminal, and what rigs were scored on."""

from __future__ import annotations

from collections.abc import Sequence

from rich.table import Table
from rich.text import Text

from riglens.app.terminal.console import results, show
from riglens.app.terminal.tables import table
from riglens.core.engine.engine import Evaluation
from riglens.core.metric.entropy import EntropyField
from riglens.core.metric.scores import Reading
from riglens.core.rig.model import Rig
from riglens.core.scene.boxes import CLASSES
from riglens.core.sensors.registry import shown_kinds
from riglens.core.shown_text import numbered, visible
from riglens.core.shown_values import NONE, decimals, percent, thousands
from riglens.evaluation.options import ScoreOptions
from riglens.evaluation.scene_words import scene_lines

EXPLANATION: dict[Reading, str] = {
    "covered": (
        "S-MIG = minus the entropy seen, so S-MS falls as coverage grows; 'seen' is the share in % of H(Ω)."
    ),
    "residual": "S-MIG = minus the entropy unseen, so S-MS rises towards 0 as coverage grows.",
    "hits": "S-MIG counts a voxel once per ray through it; 'seen' still counts every voxel once.",
}


def print_scene(field: EntropyField, rigs: Sequence[Rig], score: ScoreOptions) -> None:
    """Print what was scored and how, on standard output."""
    show(scene_lines(field, rigs, score))


def print_scores(evaluations: Sequence[Evaluation], score: ScoreOptions) -> None:
    """Print the paper's scores on standard output."""
    console = results()
    console.print(Text("The paper's scores", "bold"))
    console.print(score_table(evaluations))
    console.print(EXPLANATION[score.reading], soft_wrap=True)


# ---------------------------------------------------------------- tables


def score_table(evaluations: Sequence[Evaluation]) -> Table:
    """Tabulate rigs as rows, one section per class: S-MIG of the kinds in S-MS, S-MS, and coverage by kind."""
    held = [sensor.kind for evaluation in evaluations for sensor in evaluation.rig.sensors]
    weighed, shown = (sorted(shown_kinds(names), key=lambda kind: kind.name) for names in ((), held))
    seen = [f"seen\n{title}" for title in (*(kind.title for kind in shown), "any")]
    made = table("10³ nat", *(f"S-MIG\n{kind.title}" for kind in weighed), "\nS-MS", *seen, widest=28)
    titles = numbered([visible(evaluation.rig.name) for evaluation in evaluations])
    for name in CLASSES:
        h_total = evaluations[0].scores.classes[name].h_total
        digits = max(2, decimals(h_total))  # never fewer than the leading figures have
        made.add_row(Text(f"{name}, H(Ω) {thousands(h_total, digits)}", "bold"))
        for evaluation, title in zip(evaluations, titles, strict=True):
            scores, sensors = evaluation.scores.classes[name], evaluation.rig.sensors
            own = {sensor.kind for sensor in sensors if sensor.enabled}
            made.add_row(
                Text(f"  {title}"),
                *(thousands(scores.kinds[kind.name].s_mig, digits) for kind in weighed),
                thousands(scores.s_ms, digits),
                *(percent(scores.kinds[kind.name].seen) if kind.name in own else NONE for kind in shown),
                percent(scores.any_seen),
            )
        made.add_section()
    return made
