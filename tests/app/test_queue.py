"""The queue of a background thread: the newest of each kind, urgent ones first, the others in the time that is left."""

from __future__ import annotations

from riglens.app.background.queue import BackgroundRequest, Priority, RequestQueue
from tests.hand_clock import HandClock

Item = str | BackgroundRequest


def later(name: str, group: str = "a") -> BackgroundRequest:
    return BackgroundRequest(group, name)


def filled(*requests: Item, rest_s: float = 0.0, clock: HandClock | None = None) -> RequestQueue[Item]:
    queue = RequestQueue[Item](clock or HandClock(leaps=True), rest_s)
    for request in requests:
        queue.put(request, Priority.EDIT if isinstance(request, str) else Priority.BACKGROUND)
    return queue


def taken(queue: RequestQueue[Item]) -> Item:
    job = queue.next_job()
    assert job is not None
    return job.request


def test_of_urgent_requests_the_newest_is_handed_out() -> None:
    assert taken(filled("first", "second")) == "second"


def test_loads_go_before_edits_and_edits_before_the_background() -> None:
    queue = filled(later("one"), "edit")
    queue.put("scene", Priority.LOAD)
    assert [taken(queue) for _ in range(3)] == ["scene", "edit", later("one")]


def test_background_requests_keep_their_order_and_are_replaced_by_name() -> None:
    queue = filled(later("one"), later("two"), later("one"))
    assert [taken(queue) for _ in range(2)] == [later("two"), later("one")]
    assert queue.waiting(Priority.BACKGROUND) is None


def test_a_background_job_gives_way_and_comes_first_afterwards() -> None:
    queue = filled(later("one"), later("two"))
    job = queue.next_job()
    assert job is not None and not queue.is_stale(job)
    queue.put("edit")
    assert queue.is_stale(job)
    queue.put_back(job)
    assert [taken(queue) for _ in range(3)] == ["edit", later("one"), later("two")]


def test_a_job_in_parts_lets_the_others_go_first_and_is_gone_when_dropped() -> None:
    queue = filled(later("one"), later("two"))
    job = queue.next_job()
    assert job is not None
    queue.put_back(job, last=True)
    assert taken(queue) == later("two") and queue.next_job() is job
    queue.drop(Priority.BACKGROUND)
    assert job.is_dropped and queue.is_stale(job)
    queue.put_back(job)
    assert queue.waiting(Priority.BACKGROUND) is None


def test_what_is_dropped_is_not_handed_out() -> None:
    queue = filled(later("one", "old"), later("two", "new"), later("three", "old"))
    dropped = queue.drop(
        Priority.BACKGROUND, lambda request: request in (later("one", "old"), later("three", "old"))
    )
    assert dropped == [later("one", "old"), later("three", "old")]
    assert taken(queue) == later("two", "new")


def test_an_edit_is_stale_once_a_newer_one_waits_and_at_the_end() -> None:
    queue = filled("edit")
    job = queue.next_job()
    assert job is not None and not queue.is_stale(job)
    queue.put("newer")
    assert queue.is_stale(job) and queue.is_followed(Priority.EDIT)
    queue = filled("edit")
    job = queue.next_job()
    queue.close()
    assert job is not None and queue.is_stale(job) and queue.next_job() is None


def test_what_is_held_waits_and_does_not_count_as_work() -> None:
    queue = filled("edit", later("one"))
    queue.hold(Priority.EDIT)
    assert taken(queue) == later("one")
    assert queue.take(Priority.EDIT) is None
    queue.release(Priority.EDIT)
    assert not queue.wait_until_idle(0.0)
    assert taken(queue) == "edit"


def test_the_background_rests_after_every_edit() -> None:
    clock = HandClock()
    queue = filled(later("one"), "edit", rest_s=1.0, clock=clock)
    assert taken(queue) == "edit"
    clock.advance(0.9)
    assert queue.take(Priority.BACKGROUND) is None
    clock.advance(0.2)
    assert taken(queue) == later("one")


def test_a_job_within_another_one_ends_by_itself() -> None:
    queue = filled("edit")
    queue.put("scene", Priority.LOAD)
    assert taken(queue) == "scene"
    inner = queue.take(Priority.EDIT)
    assert inner is not None and queue.is_running(Priority.EDIT)
    assert queue.finish() is inner
    assert queue.is_running(Priority.LOAD) and not queue.is_running(Priority.EDIT)
