"""Writes docs/figures.md, every figure of the registry with its key, unit, direction and question, and the table of
heatmaps in docs/heatmap.md.

Run it from the root of the project after a figure or heatmap has changed: python -m tools.write_figures
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from riglens.core.figures.figure import Figure
from riglens.core.figures.heatmaps import HeatMap
from riglens.core.figures.registry import figures, heat_maps

TARGET, HEATMAPS = Path("docs/figures.md"), Path("docs/heatmap.md")
HEAD = """# Figures

A *figure* is a number about a rig. Each is defined once, in `core/figures`, and shown under one
title, unit and direction in the window, `riglens evaluate`, reports, pictures, sweeps and Python.
Its *key* names it in JSON (`figures`), [requirements](check.md) (`figure:`), [sweeps](sweep.md),
[objectives](optimise.md) and `rl.score(rig, scene, traffic)["car"].figures[KEY]`.

Where a rig or the data have nothing to measure, a reason stands in place of a number; a figure
outside the domain that it was shown for is grey, or in brackets, and says why. ± is two standard
errors: of the frames that were sampled and, for a prediction, of its calibration. A difference
below the last column does not tell two rigs apart.
"""
HEATMAP_HEAD = """| heatmap | key | shortcut | a cell shows | unit | better |
|---|---|---|---|---|---|
"""
SECTIONS = (
    ("The leading figures", lambda one: one.leads),
    ("Objects", lambda one: one.needs == "objects" and not one.leads),
    ("Voxels", lambda one: one.needs == "voxels" and not one.leads),
    ("Ground", lambda one: one.needs == "ground" and not one.leads),
)


def page() -> str:
    """Return the page."""
    parts = [HEAD]
    for title, belongs in SECTIONS:
        rows = "\n".join(_row(one) for one in figures() if belongs(one))
        parts.append(
            f"## {title}\n\n| figure | key | unit | better | question | tells apart from |\n"
            f"|---|---|---|---|---|---|\n{rows}\n"
        )
    return "\n".join(parts)


def _row(figure: Figure) -> str:
    return f"| {' | '.join(_cells(figure))} |"


def _cells(figure: Figure) -> Iterator[str]:
    unit = {"share": "%", "nat": "10³ nat"}.get(figure.unit, figure.unit)
    apart = f"{100.0 * figure.resolved:g} pp" if figure.resolved else "any difference"
    yield figure.title
    yield f"`{figure.key}`"
    yield unit
    yield figure.better if figure.better != "neither" else "—"
    yield figure.question.replace("|", "\\|")
    yield apart if figure.better != "neither" else "—"


def with_table(text: str) -> str:
    """Return the page of heatmaps with its table made anew."""
    before, _, rest = text.partition(HEATMAP_HEAD)
    after = rest.partition("\n\n")[2]
    rows = "\n".join(f"| {' | '.join(_heat_cells(heat))} |" for heat in heat_maps())
    return f"{before}{HEATMAP_HEAD}{rows}\n\n{after}"


def _heat_cells(heat: HeatMap) -> Iterator[str]:
    yield heat.title
    yield f"`{heat.key}`"
    yield heat.shortcut or "—"
    yield heat.question.replace("|", "\\|")
    yield heat.unit or "—"
    yield heat.better if heat.better != "neither" else "—"


if __name__ == "__main__":
    TARGET.write_text(page(), encoding="utf-8")
    HEATMAPS.write_text(with_table(HEATMAPS.read_text(encoding="utf-8")), encoding="utf-8")
