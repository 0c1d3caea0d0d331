"""List what a search may improve: the figures that have a direction, and two that only searches have."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Literal

from riglens.core.errors import InputError
from riglens.core.figures.coverage import BLIND_GROUND, S_MS, VoxelFigure, seen_by
from riglens.core.figures.figure import Figure
from riglens.core.figures.hits import ON_TARGET, TALL
from riglens.core.figures.objects import ObjectFigure
from riglens.core.figures.registry import figures
from riglens.core.optimise.chances import made_of_chances
from riglens.core.rig.model import Rig, Sensor
from riglens.core.sensors.lidar import LIDAR

Tables = Literal["cells", "heights", "chances", "voxels", "entropies", "ground", "none"]
"""Things that candidates cover, of which tables are made; "none": each set is evaluated anew, and nothing bounds it."""
_TABLES: dict[str, Tables] = {
    ON_TARGET.key: "cells",
    TALL.key: "heights",
    BLIND_GROUND.key: "ground",
}
WORST = "worst_failure"


@dataclass(frozen=True)
class Objective:
    """A figure that a search improves: its key and words, what its tables are made of, and the kinds of the sensors
    that make it, empty for any; one_fails: it counts with the one sensor failed that is missed most."""

    key: str
    title: str
    question: str
    figure: Figure
    tables: Tables
    kinds: tuple[str, ...] = ()
    one_fails: bool = False

    @property
    def of_objects(self) -> bool:
        """Return whether it is measured in frames of traffic; others are exact."""
        return self.figure.needs == "objects"

    @property
    def sign(self) -> float:
        """1 where more is better, else -1."""
        return -1.0 if self.figure.better == "less" else 1.0

    def sensors_of(self, rig: Rig) -> tuple[Sensor, ...]:
        """Return the enabled sensors of a rig that make the figure."""
        return tuple(one for one in rig.sensors if one.enabled and (not self.kinds or one.kind in self.kinds))


def objectives() -> Mapping[str, Objective]:
    """Return the objectives by key, in the order of the registry of figures."""
    found, of_chances = dict[str, Objective](), made_of_chances()
    for figure in figures():
        if (tables := _tables_of(figure, of_chances)) is not None:
            found[figure.key] = Objective(
                figure.key, figure.title, figure.question, figure, tables, _kinds_of(figure)
            )
        if figure is ON_TARGET:
            title, question = (
                "On target with one LiDAR failed",
                "On target with the LiDAR failed that is missed most.",
            )
            found[WORST] = Objective(WORST, title, question, figure, "cells", figure.kinds, one_fails=True)
        if figure is S_MS:
            seen, question = (
                seen_by(LIDAR),
                "Entropy of all classes that LiDARs see, as a share: S-MS but for a constant.",
            )
            found[S_MS.key] = Objective(
                S_MS.key, "S-MS of LiDARs", question, seen, "entropies", (LIDAR.name,)
            )
    return found


def objective_named(key: str) -> Objective:
    """Return the objective with a key; raise InputError when there is none."""
    known = objectives()
    if key not in known:
        raise InputError(f"must be one of {', '.join(known)} (got '{key}')", "objective")
    return known[key]


def _tables_of(figure: Figure, of_chances: Collection[str]) -> Tables | None:
    """Return what tables of a figure are made of; None for one that no search can improve."""
    if figure.key in _TABLES:
        return _TABLES[figure.key]
    if figure.key in of_chances:
        return "chances"
    if isinstance(figure, VoxelFigure):
        return None if figure.covered_by is None else "voxels"
    is_mean = isinstance(figure, ObjectFigure) and not figure.is_median and not figure.in_domain
    return "none" if is_mean and figure.better != "neither" else None


def _kinds_of(figure: Figure) -> tuple[str, ...]:
    if isinstance(figure, VoxelFigure):
        return figure.covered_by or ()
    return figure.kinds if isinstance(figure, ObjectFigure) else ()
