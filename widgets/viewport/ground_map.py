"""Map on the ground of the scene: cells in a few colours, and their key."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from riglens.widgets.theme import rgb

NOTHING = 255
"""The step of a cell that is left out."""


class GroundStep(NamedTuple):
    """Meaning of the cells of one colour; `opacity` from 0 to 1."""

    words: str
    colour: str
    opacity: float


@dataclass(frozen=True, eq=False)
class GroundMap:
    """steps uint8 (nx, ny): index into `meanings` of a cell, NOTHING for none; `origin_m` is the lower corner of the
    first cell of `cell_m`. `title` names the quantity, with unit and direction."""

    origin_m: tuple[float, float]
    cell_m: float
    steps: NDArray[np.uint8]
    meanings: tuple[GroundStep, ...]
    title: str

    def pixels(self) -> NDArray[np.uint8]:
        """Return colours (ny, nx, 4) of the cells, red, green, blue and opacity: rows from right to left, as y
        grows."""
        table = np.zeros((256, 4), np.uint8)
        for step, (_, colour, opacity) in enumerate(self.meanings):
            table[step] = np.rint(255.0 * np.array([*rgb(colour), opacity]))
        return np.asarray(table[self.steps.T])
