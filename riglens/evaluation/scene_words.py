"""Describe in lines what rigs are scored on: grid, data, metric, body."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from riglens.core.metric.entropy import EntropyField
from riglens.core.metric.scores import Body, common_body
from riglens.core.rig.model import Rig
from riglens.core.scene.boxes import CLASSES, DataReport
from riglens.core.shown_tables import Line, Styled
from riglens.core.shown_text import visible
from riglens.evaluation.options import ScoreOptions

BODY_TEXTS: dict[Body, str] = {
    "ignored": "ignored: rays pass through the car, as in the paper",
    "blocks": "blocks: rays end at the car",
}


def scene_lines(field: EntropyField, rigs: Sequence[Rig], score: ScoreOptions) -> Iterable[Line]:
    """Describe the scored scene in four lines: grid, data, metric, body."""
    nx, ny, nz = field.grid.shape
    length, width, height = field.grid.roi_m
    yield _line(
        "Grid",
        f"{nx} × {ny} × {nz} voxels of {field.grid.voxel_m:g} m ({length:g} × {width:g} × {height:g} m), "
        f"{field.index.count:,} informative",
    )
    yield _line("Data", data_line(field.data, field.data.short_source))
    yield _line(
        "Metric",
        f"{score.method} traversal, reading {score.reading}, λ = {score.camera_weight:g}: "
        f"S-MS = λ · S-MIG(camera) + S-MIG(LiDAR)",
    )
    yield _line("Body", body_text(rigs, score.body))


def body_text(rigs: Sequence[Rig], said: Body | None) -> str:
    """Return whether rays end at the cars of some rigs, and where that is set."""
    body = said or common_body(rig.body for rig in rigs)
    if body is None:
        return "as set in each rig: " + ", ".join(f"{visible(rig.name)} {rig.body}" for rig in rigs)
    housings = (
        " and at other sensors' housings" if body == "blocks" and any(r.obstacles for r in rigs) else ""
    )
    return BODY_TEXTS[body] + housings + (" (--body)" if said else " (as set in the rig)")


def data_line(data: DataReport, source: str) -> str:
    """Name, frames and boxes of a data set in one line."""
    boxes = ", ".join(f"{name} {data.boxes.get(name, 0):,}" for name in CLASSES)
    return f"{visible(source)}: {data.frames:,} frames; boxes: {boxes}"


def _line(label: str, text: str) -> Line:
    return Styled(f"{label:<8}", "bold"), text
