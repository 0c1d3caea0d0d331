"""Find where a figure of objects is worst: class, sector, and the distance from which it is worse than one half."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import NDArray

from riglens.core.figures.figure import ALL, CLASSES_AND_ALL, Figure
from riglens.core.figures.objects import ObjectFigure
from riglens.core.figures.text import value_text
from riglens.core.scene.boxes import CLASSES
from riglens.core.scene.sectors import SECTORS
from riglens.core.targets.settings import HALF

if TYPE_CHECKING:  # loads the compiler
    from riglens.core.targets.counts import Counted

FEWEST = 30
"""Parts with fewer objects do not count: the standard error of their share may be more than 9 points. Our choice."""


@dataclass(frozen=True)
class Weakest:
    """The worst class of `ALL` and the worst sector, each with its value, and the distance from which on a share is
    worse than one half in every ring, 0 if in all of them; None if in none."""

    cls: tuple[str, float] | None = None
    sector: tuple[str, float] | None = None
    half_from_m: float | None = None

    def as_dict(self) -> dict[str, Any]:
        """Return it as plain data: names and values, null where there is none."""
        cls, sector = (one or (None, None) for one in (self.cls, self.sector))
        return {
            "class": cls[0], "class_value": cls[1], "sector": sector[0], "sector_value": sector[1],
            "half_from_m": self.half_from_m,
        }  # fmt: skip

    @classmethod
    def of_dict(cls, plain: Mapping[str, Any]) -> Self:
        """Return what `as_dict` made."""
        worst, sector = (
            None if plain[name] is None else (plain[name], plain[f"{name}_value"])
            for name in ("class", "sector")
        )
        return cls(worst, sector, plain["half_from_m"])


NOWHERE = Weakest()


def weakest_by_class(figure: ObjectFigure, counted: Counted) -> dict[str, Weakest]:
    """Return where a figure with a direction is worst, by class and for `ALL`; nowhere for a figure that the rig does
    not have, and of parts with fewer than FEWEST objects."""
    if figure.better == "neither" or figure.lacks(counted):
        return dict.fromkeys(CLASSES_AND_ALL, NOWHERE)
    total, sectors, rings = figure.means_by(counted, ("all", "sector", "ring"))
    edges_m = counted.groups.edges_m.tolist()
    is_less = figure.better == "less"

    def found(who: str) -> Weakest:
        row = CLASSES_AND_ALL.index(who)
        classes = (total[0][1:, 0], total[1][1:, 0])
        half_m = (
            _half_from(rings[0][row], rings[1][row], edges_m, is_less) if figure.unit == "share" else None
        )
        return Weakest(
            _worst(CLASSES, *classes, is_less) if who == ALL else None,
            _worst(SECTORS, sectors[0][row], sectors[1][row], is_less),
            half_m,
        )

    return {who: found(who) for who in CLASSES_AND_ALL}


def weakest_text(figure: Figure, found: Weakest) -> str:
    """Say where a figure is worst: "worst: bicycle 28.6 %, rear-left 12.1 %; below half from 20 m"; empty where nothing
    is known."""
    worst = [
        f"{name} {value_text(figure, value, 1)}" for name, value in filter(None, (found.cls, found.sector))
    ]
    said = [f"worst: {', '.join(worst)}"] if worst else []
    return "; ".join([*said, *filter(None, (half_text(figure, found),))])


def worst_names(found: Weakest) -> str:
    """Return the names of the worst parts, for where space is short: "worst: bicycle, rear-left"."""
    names = ", ".join(one[0] for one in (found.cls, found.sector) if one is not None)
    return names and f"worst: {names}"


def half_text(figure: Figure, found: Weakest, is_short: bool = False) -> str:
    """Say from which distance on a share is worse than one half, "below half from 30 m" or in short "< ½ from 30 m";
    empty where it is not."""
    if found.half_from_m is None:
        return ""
    where = f"from {found.half_from_m:g} m" if found.half_from_m else "everywhere"
    is_less = figure.better == "less"
    sides = ("> ½", "< ½") if is_short else ("above half", "below half")
    return f"{sides[not is_less]} {where}"


def _known(objects: NDArray[np.int64]) -> list[int]:
    return np.flatnonzero(objects >= FEWEST).tolist()


def _worst(
    names: Sequence[str], objects: NDArray[np.int64], values: NDArray[np.float64], is_less: bool
) -> tuple[str, float] | None:
    """Return the name and value of the worst of at least two parts, the first of equal ones."""
    known = _known(objects)
    if len(known) < 2:
        return None
    place = max(known, key=lambda one: values[one] if is_less else -values[one])
    return names[place], float(values[place])


def _half_from(
    objects: NDArray[np.int64], values: NDArray[np.float64], edges_m: Sequence[float], is_less: bool
) -> float | None:
    """Return where the rings begin that are all worse than one half, up to the farthest; None without any."""
    start = None
    known = _known(objects)
    for place in reversed(known):
        if (values[place] > HALF) if is_less else (values[place] < HALF):
            start = place
        else:
            break
    return None if start is None else 0.0 if start == known[0] else edges_m[start]
