"""Add labels to pictures of the 3D view; the same for the window's screenshots and `riglens render`."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from riglens.core.figures.registry import leading_figures
from riglens.core.figures.text import UNITS, estimate_text
from riglens.core.figures.values import Values, values_of_scores
from riglens.core.metric.scores import MetricSettings, Scores
from riglens.core.rig.model import Rig
from riglens.core.scene.boxes import CLASSES
from riglens.core.sensors.registry import shown_kinds
from riglens.evaluation.requests import failed_text
from riglens.widgets.viewport.scene_state import Caption, SceneState

if TYPE_CHECKING:
    from riglens.core.metric.entropy import EntropyField

SIGN = "S-MS falls as coverage grows."


@dataclass(frozen=True)
class PictureWords:
    """Labels over the scene: colour bar, name of the rig, table of scores."""

    legend: bool = True
    title: bool = False
    scores: bool = False


@dataclass(frozen=True)
class Findings:
    """Content of the labels: the rig, its scores and their inputs."""

    rig: Rig
    scores: Scores
    settings: MetricSettings
    entropy: EntropyField
    is_changed: bool = False
    """True if the rig differs from the file of its name."""
    objects: Values = field(default_factory=dict)
    """Figures of objects by key and class, where they were counted."""

    @property
    def title(self) -> str:
        """The rig's name, and that it is not as saved under it."""
        return f"{self.rig.name} (changed)" if self.is_changed else self.rig.name


def with_words(state: SceneState, words: PictureWords, found: Findings | None) -> SceneState:
    """Return the state for a picture: with legend, name and scores as chosen, without handles or selection."""
    failed = failed_text(state.failed)
    caption = Caption(failed)  # no picture of a rig with failed sensors goes about without saying so
    if found is not None:
        caption = Caption(
            title=found.title if words.title else failed,
            subtitle=" · ".join(filter(None, [subtitle(found), failed])) if words.title else "",
            table=score_rows(found) if words.scores else (),
            note=score_note(found.settings) if words.scores else "",
        )
    return replace(
        state, show_legend=words.legend, caption=caption, show_gizmo=False, show_selection=False, ghosts=()
    )


def subtitle(found: Findings) -> str:
    """Return the sensors, voxel edge and data as one line."""
    present = shown_kinds(sensor.kind for sensor in found.rig.sensors if sensor.enabled)
    shown = sorted(present, key=lambda kind: kind.name)
    counts = [(kind, len(found.rig.enabled_of(kind.model))) for kind in shown]
    sensors = ", ".join(f"{count} {kind.title if count == 1 else kind.plural}" for kind, count in counts)
    data = f"{found.entropy.data.short_source}, {found.entropy.data.frames:,} frames"
    return f"{sensors} · δ = {found.entropy.grid.voxel_m:g} m · {data}"


def score_rows(found: Findings) -> tuple[tuple[str, ...], ...]:
    """Return the leading figures that are known as rows of text, with a heading on the car's body."""
    known = {**values_of_scores(found.scores), **found.objects}
    shown = [figure for figure in leading_figures() if figure.key in known]
    heads = (f"{one.title}, {UNITS[one.unit]}" if one.unit == "nat" else one.title for one in shown)
    rows: list[tuple[str, ...]] = [(f"body {found.settings.body or found.rig.body}", *heads)]
    rows += [(cls, *(estimate_text(one, known[one.key][cls]) for one in shown)) for cls in CLASSES]
    return tuple(rows)


def score_note(settings: MetricSettings) -> str:
    """Return a note on the columns of the table."""
    weight = f"S-MS = {settings.camera_weight:g} · S-MIG camera + S-MIG LiDAR"
    if settings.reading != "covered":
        return f"{weight}, reading {settings.reading}"
    return f"{weight}. {SIGN}"
