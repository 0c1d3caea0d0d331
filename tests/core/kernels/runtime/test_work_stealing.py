"""Work taken as it comes: every piece once, whoever does it; and the sets of single workers, which end up empty."""

from __future__ import annotations

import numba
import numpy as np
import pytest

from riglens.core.kernels.rays import cast
from riglens.core.kernels.runtime import jit
from riglens.core.kernels.runtime.work_stealing import new_counter, take


@numba.njit(parallel=True)
def _do_each(pieces: int, workers: int, done: np.ndarray) -> None:
    """Count how often each piece is done."""
    counter = new_counter()
    for _ in numba.prange(workers):
        piece = take(counter)
        while piece < pieces:
            done[piece] += 1
            piece = take(counter)


@pytest.mark.parametrize("workers", [1, 2, 4])
@pytest.mark.parametrize("pieces", [0, 1, 3, 10_000])
def test_every_piece_is_done_once(pieces: int, workers: int) -> None:
    done = np.zeros(pieces, np.int64)
    jit.use_threads(workers)
    _do_each(pieces, workers, done)
    assert (done == 1).all()


@pytest.mark.parametrize("words", [1, cast.WORDS_AT_ONCE, 2 * cast.WORDS_AT_ONCE + 3])
def test_what_single_workers_marked_is_added_and_their_sets_are_empty_again(words: int) -> None:
    rng = np.random.default_rng(words)
    marks, spare = rng.integers(0, 1 << 60, words, np.uint64), rng.integers(0, 1 << 60, (2, words), np.uint64)
    expected = marks | spare[0] | spare[1]
    cast.add_marks(spare, marks, 3)
    assert np.array_equal(marks, expected)
    assert not spare.any()
