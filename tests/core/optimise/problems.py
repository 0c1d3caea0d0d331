"""Random set functions and limits, and proposals without most cases of the guard."""

import numpy as np
import pytest
from numpy.typing import NDArray

from riglens.core.errors import Cancelled
from riglens.core.optimise.makers import hit_shares, worth_of
from riglens.core.optimise.problem import Problem
from riglens.core.optimise.results import OptimiseResult, Progress
from riglens.core.optimise.run import optimise
from riglens.core.optimise.search import Limits
from riglens.core.optimise.tables import CoverTable
from riglens.core.optimise.weights import EVEN


def proposed(problem: Problem) -> OptimiseResult:
    """The result of one thread once its gain is checked in held-out frames, without the cases after them."""
    found = list[OptimiseResult]()

    def enough(step: Progress) -> None:
        if step.result is not None:
            found.append(step.result)
            raise Cancelled

    with pytest.raises(Cancelled):
        optimise(problem, 1, enough)
    return found[0]


def hit_worth(cls: NDArray[np.uint8]) -> NDArray[np.int64]:
    """The worth of objects that weigh the same, by class."""
    row, worth = worth_of(hit_shares(), cls, np.ones(len(cls)), EVEN)
    assert (row == cls).all()
    return worth


def random_table(rng: np.random.Generator, size: int, workers: int = 1) -> CoverTable:
    """Candidates that hit some cells of some objects of all classes."""
    objects = int(rng.integers(1, 30))
    owner = np.repeat(np.arange(objects), rng.integers(1, 15, objects)).astype(np.int32)
    reach = rng.random(size) * 0.6
    cells = [np.flatnonzero(rng.random(len(owner)) < share).astype(np.int32) for share in reach]
    cls = rng.integers(0, 3, objects).astype(np.uint8)
    known = rng.integers(0, 6, objects).astype(np.int32)
    return CoverTable(cells, owner, known, cls, hit_worth(cls), workers)


def random_columns(rng: np.random.Generator, size: int) -> CoverTable:
    """Candidates that see some of 60 columns, each worth 1."""
    cells = [np.flatnonzero(rng.random(60) < share).astype(np.int32) for share in rng.random(size) * 0.6]
    worth = np.arange(61, dtype=np.int64)[None]
    return CoverTable(cells, np.zeros(60, np.int32), np.zeros(1, np.int32), np.zeros(1, np.uint8), worth, 1)


def random_limits(rng: np.random.Generator, size: int, count: int) -> Limits:
    """Conflicts of some pairs, a budget that most single candidates fit in, and in half of them slots, in half of these
    of sensors and pairs."""
    conflicts = rng.random((size, size)) < 0.2
    conflicts = conflicts | conflicts.T | np.eye(size, dtype=np.bool_)
    costs = np.round(rng.uniform(0.5, 3.0, size), 1)
    budget = float(rng.choice([np.inf, 1.0, 2.0, 4.0, 6.0]))
    if rng.random() < 0.5:
        return Limits(count, costs, budget, conflicts)
    slot, room = rng.integers(0, 3, size), rng.integers(0, 3, 3)
    costs[slot == 2] = 0.0
    sizes = rng.integers(1, 3, size) if rng.random() < 0.5 else np.ones(size, np.int64)
    return Limits(int(room.sum()), costs, budget, conflicts, slot, room, sizes)
