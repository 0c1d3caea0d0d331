"""Overlapping coverage and the losses by failures: part of `riglens review`."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Annotated, Any

from cyclopts import Group, Parameter
from rich.table import Table
from rich.text import Text

from riglens.app.terminal.console import progress_bar, results
from riglens.app.terminal.tables import table
from riglens.core.engine.engine import Engine
from riglens.core.metric.entropy import EntropyField
from riglens.core.review.documents import coverage_document
from riglens.core.review.redundancy import (
    COVERED,
    NO_EVIDENCE,
    Counter,
    Coverage,
    What,
    lost_share,
    share,
    target_counter,
    voxel_counter,
    with_halves,
)
from riglens.core.rig.model import FORMAT_VERSION, Rig
from riglens.core.rig.yaml.file import identity_of
from riglens.core.scene.boxes import CLASSES
from riglens.core.scene.sectors import SECTORS
from riglens.core.shown_text import visible
from riglens.core.shown_values import percent
from riglens.core.targets.engine import TargetEngine
from riglens.core.targets.settings import TargetSettings
from riglens.core.targets.traffic import Traffic
from riglens.evaluation.options import ScoreOptions
from riglens.evaluation.scenario import settings_of

FAILING = Group("Redundancy", sort_key=8)
SHOWN = 5
"""Pairs and half-blocked sensors that the terminal names, the worst first; the JSON has all."""
HEADINGS: dict[What, str] = {
    "sensor": "each sensor",
    "pair": f"worst {SHOWN} pairs",
    "group": "groups",
    "half": f"worst {SHOWN} half-blocked",
}


@Parameter(name="*")
@dataclass(frozen=True)
class RedundancyArguments:
    """Options of redundancy."""

    no_objects: Annotated[bool, Parameter(group=FAILING, negative="")] = False
    """Count voxels alone, no objects."""
    halves: Annotated[bool, Parameter(group=FAILING, negative="")] = False
    """Also list the losses by each sensor with half of its view blocked: left, right, upper, lower."""


@dataclass(frozen=True)
class Redundancy:
    """Coverage of voxels, and of objects where they were counted."""

    rig: Rig
    body: str
    field: EntropyField
    voxels: Coverage
    targets: Coverage | None
    min_points: int

    def document(self) -> dict[str, Any]:
        """Return the figures as plain data."""
        return {
            "riglens": FORMAT_VERSION,
            "body": self.body,
            "note": NO_EVIDENCE,
            "rig": identity_of(self.rig),
            "data": {"source": self.field.data.source, "sha256": self.field.data.sha256},
            "voxel_m": self.field.grid.voxel_m,
            "min_points": self.min_points,
            "voxels": coverage_document(self.voxels, "nat"),
            "objects": None if self.targets is None else coverage_document(self.targets, "objects"),
        }

    def show(self) -> None:
        """Print coverage by number of sensors and the losses by failures on standard output."""
        console = results()
        console.print(Text(f"{visible(self.rig.name)}: redundancy, body {self.body}"), soft_wrap=True)
        for title, found in (("entropy, in % of H(Ω)", self.voxels), ("objects, in % of all", self.targets)):
            if found is not None:
                console.print(_covered_table(found, title))
                console.print(_failures_table(found, title))
        console.print(
            "Covered: more is better; two kinds: by sensors of two kinds. Lost when it fails: less is better; worst "
            "sector: the 45° in which the largest share is lost.",
            soft_wrap=True,
        )
        if self.targets is not None:
            console.print(
                "Objects: 1 = detected by the rig; 2, 3 = by that many sensors, each on its own.",
                soft_wrap=True,
            )
        console.print(f"This is {NO_EVIDENCE}.", soft_wrap=True)


def redundancy_of(
    rig: Rig,
    field: EntropyField,
    traffic: Traffic | None,
    score: ScoreOptions,
    counting: TargetSettings,
    halves: bool = False,
) -> Redundancy:
    """Return a rig's coverage of voxels and, where there is traffic, of objects; with `halves` also the losses by
    half-blocked sensors."""
    settings, targets = settings_of(score), None

    def found(coverage: Counter) -> Coverage:
        return with_halves(coverage(rig), rig, coverage) if halves else coverage(rig)

    with progress_bar("Casting rays"):
        voxels = found(voxel_counter(Engine(field, score.threads), settings))
    if traffic is not None:
        with progress_bar("Counting objects"):
            how = replace(counting, body=settings.body)
            targets = found(target_counter(TargetEngine(traffic, score.threads), how))
    return Redundancy(rig, score.body_of(rig), field, voxels, targets, counting.min_points)


def _covered_table(found: Coverage, title: str) -> Table:
    titles = (name if name == "two kinds" else f"by {name}" for name in COVERED)
    made = table(f"covered: {title}", *titles, dense=True, widest=36)
    for cls, name in enumerate(CLASSES):
        total = int(found.total[:, cls].sum())
        cells = (percent(share(int(found.covered[:, k, cls].sum()), total)) for k in range(len(COVERED)))
        made.add_row(name, *cells)
    return made


def _failures_table(found: Coverage, title: str) -> Table:
    titles = (cell for name in CLASSES for cell in (name, "worst\nsector"))
    made = table(f"lost: {title}", *titles, dense=True, widest=36)
    for what, heading in HEADINGS.items():
        mine = [failure for failure in found.failures if failure.what == what]
        if what in ("pair", "half"):
            mine = sorted(mine, key=lambda failure: -int(failure.lost.sum()))[:SHOWN]
        if not mine:
            continue
        made.add_row(Text(heading, "bold"))
        for failure in mine:
            cells = []
            for cls in range(len(CLASSES)):
                by_sector = [lost_share(found, failure, cls, s) for s in range(len(SECTORS))]
                worst = max(range(len(SECTORS)), key=lambda s: by_sector[s])
                where = f"{SECTORS[worst]} {100.0 * by_sector[worst]:.0f} %" if by_sector[worst] else "-"
                cells += [percent(lost_share(found, failure, cls)), where]
            made.add_row(Text(f"  {visible(failure.name)}"), *cells)
        made.add_section()
    return made
