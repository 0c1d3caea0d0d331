"""Shares of work run side by side, each once, whatever the other threads do."""

import threading

import pytest

from riglens.core.in_threads import in_threads
from tests.waiting import TIMEOUT_S


def test_shares_run_side_by_side_and_are_returned_in_order():
    together = threading.Barrier(2)

    def work(share: int) -> tuple[int, int]:
        together.wait(TIMEOUT_S)
        return share, threading.get_ident()

    (first, caller), (second, helper) = in_threads(2, work)
    assert (first, second) == (0, 1) and caller == threading.get_ident() != helper


def test_shares_within_shares_end_though_every_thread_waits_for_its_own():
    found = in_threads(9, lambda share: in_threads(9, lambda inner: 10 * share + inner))
    assert found == [[10 * share + inner for inner in range(9)] for share in range(9)]


@pytest.mark.parametrize("failing", [0, 1])
def test_an_error_is_raised_when_no_share_is_at_work_any_more(failing):
    at_work = []

    def work(share: int) -> None:
        if share == failing:
            raise ValueError("no")
        at_work.append(share)
        threading.Event().wait(0.01)
        at_work.remove(share)

    with pytest.raises(ValueError):
        in_threads(2, work)
    assert not at_work
