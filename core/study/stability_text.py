"""The stability study in words: names of settings, and the table of orders line by line."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from statistics import median

from riglens.core.scene.boxes import CLASSES
from riglens.core.study.accuracy_text import edge_text
from riglens.core.study.rankings import LETTERS, Ranking, RayLattice, agreement
from riglens.core.study.stability_metric import DEFAULT_LATTICE, MetricStudy, Variation

GROUPS = ", ".join(f"{letter} {name}" for letter, name in LETTERS.items())
READING_THE_TABLE = (
    "τ (Kendall) and ρ (Spearman) compare S-MS of the eight rigs with the first row, class by class. The "
    f"letters are the groups by S-MIG, lowest first: {GROUPS}. "
    "'Least' is the lowest correlation and the rarest order."
)


@dataclass(frozen=True)
class Line:
    """A line of the table of orders: a setting and what it gives, class by class."""

    setting: str
    cells: tuple[Cell, ...]


@dataclass(frozen=True)
class Cell:
    """Correlations with the default and orders of the groups as letters; None and "" without one."""

    tau: float | None
    rho: float | None
    lidars: str
    cameras: str
    lidars_as_default: bool
    cameras_as_default: bool


def setting_text(variation: Variation) -> str:
    """The name of a setting."""
    value = variation.value
    if isinstance(value, RayLattice):
        return lattice_text(value)
    if isinstance(value, str):
        return f"reading {value}"
    return edge_text(value) if variation.axis == "δ" else f"λ {value:g}"


def lattice_text(lattice: RayLattice) -> str:
    """Rays per camera and azimuths, as far as they are not the default's."""
    parts = []
    if lattice.cast != DEFAULT_LATTICE.cast:
        parts.append(f"{lattice.cast[0]} × {lattice.cast[1]} rays")
    if lattice.azimuths != DEFAULT_LATTICE.azimuths:
        parts.append(f"{lattice.azimuths} azimuths")
    return ", ".join(parts)


def default_text(study: MetricStudy) -> str:
    """The name of the reference."""
    return f"default: {edge_text(study.plan.voxel_m)}, λ {study.plan.camera_weight:g}"


def lines(study: MetricStudy) -> Iterator[Line]:
    """The table of orders: the default, every variation, the resampled frames in two lines."""
    yield _line(default_text(study), study.reference, study)
    for variation in sorted(study.variations, key=_position):
        yield _line(setting_text(variation), variation.ranking, study)
    if study.resamples:
        yield from _resample_lines(study)


def _position(variation: Variation) -> tuple[int, float]:
    axis = ("δ", "rays", "reading", "λ").index(variation.axis)
    return axis, -variation.value if isinstance(variation.value, float) and axis == 0 else 0.0


def _line(setting: str, ranking: Ranking, study: MetricStudy) -> Line:
    return Line(setting, tuple(_cell(ranking, study.reference, cls) for cls in CLASSES))


def _cell(ranking: Ranking, reference: Ranking, cls: str) -> Cell:
    found = agreement(ranking, reference, cls)
    lidars, cameras = ("".join(ranking.order(of, cls)) for of in ("lidars", "cameras"))
    default = ["".join(reference.order(of, cls)) for of in ("lidars", "cameras")]
    return Cell(found.tau, found.rho, lidars, cameras, lidars == default[0], cameras == default[1])


def _resample_lines(study: MetricStudy) -> Iterator[Line]:
    """Median and least correlation over the resamples, with the most frequent and the rarest order."""
    count = len(study.resamples)
    every = [_line("", drawn, study).cells for drawn in study.resamples]
    by_class = [*zip(*every, strict=True)]
    yield Line(f"frames resampled {count} times: median", tuple(_summary(cells, False) for cells in by_class))
    yield Line(f"frames resampled {count} times: least", tuple(_summary(cells, True) for cells in by_class))


def _summary(cells: Sequence[Cell], least: bool) -> Cell:
    taus = [cell.tau for cell in cells if cell.tau is not None]
    rhos = [cell.rho for cell in cells if cell.rho is not None]
    pick = min if least else median
    orders = [Counter(getattr(cell, of) for cell in cells).most_common() for of in ("lidars", "cameras")]
    lidars, cameras = (order[-1 if least else 0][0] for order in orders)
    as_default = [
        next(getattr(cell, f"{of}_as_default") for cell in cells if getattr(cell, of) == name)
        for of, name in (("lidars", lidars), ("cameras", cameras))
    ]
    return Cell(
        pick(taus) if taus else None,
        pick(rhos) if rhos else None,
        lidars,
        cameras,
        as_default[0],
        as_default[1],
    )


def caption(study: MetricStudy, source: str) -> str:
    """What the orders were computed on, in one line."""
    plan = study.plan
    return (
        f"{source}, {study.frames:,} frames · {edge_text(plan.voxel_m)}, λ {plan.camera_weight:g}, "
        f"{DEFAULT_LATTICE.cast[0]} × {DEFAULT_LATTICE.cast[1]} rays per camera, "
        f"{DEFAULT_LATTICE.azimuths} azimuths per LiDAR, reading covered"
    )
