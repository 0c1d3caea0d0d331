"""Tables of rays are kept by their bytes: many small ones, few large ones, always the last."""

import threading
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from riglens.core.rig.model import BrownConrady, Camera
from riglens.core.sensing.kept import RAYS, KeptAnswers
from riglens.core.sensing.rays import lattice


def test_many_small_answers_are_kept_and_few_large_ones():
    kept = KeptAnswers(10_000)
    asked = []

    @kept.of
    def zeros(count: int) -> tuple[np.ndarray, list[int]]:
        asked.append(count)
        return np.zeros(count, np.uint8), []

    for count in (*range(20), *range(20)):
        assert zeros(count) is zeros(count)
    assert asked == [*range(20)]
    first = zeros(6_000)
    assert zeros(6_000) is first
    zeros(5_000)  # both together are too large
    assert zeros(6_000) is not first
    large = zeros(30_000)
    assert zeros(30_000) is large  # alone it is kept, however large


def test_functions_share_the_room_and_what_is_forgotten_is_made_again():
    kept = KeptAnswers(10_000)
    one, other = (kept.of(lambda count: np.zeros(count, np.uint8)) for _ in "ab")
    first = one(6_000)
    other(3_000)
    assert one(6_000) is first
    second = other(4_001)  # the oldest answer goes, whose it was does not matter
    assert one(6_000) is not first and kept.size_bytes <= 10_000
    second = other(4_000)
    assert other(4_000) is second
    kept.forget()
    assert kept.size_bytes == 0 and other(4_000) is not second


def test_what_was_not_used_since_the_last_release_goes_until_little_is_left():
    kept = KeptAnswers(10_000)
    zeros = kept.of(lambda count: np.zeros(count, np.uint8))
    oldest, first, second, _ = (zeros(count) for count in (1_500, 4_000, 3_000, 600))
    kept.release_unused()
    assert zeros(4_000) is first and kept.size_bytes == 9_100
    kept.release_unused()
    assert kept.size_bytes == 4_000 and zeros(4_000) is first
    kept.release_unused()
    kept.release_unused()
    assert kept.size_bytes == 0
    assert zeros(1_500) is not oldest and zeros(3_000) is not second
    small = zeros(600)
    for _ in range(3):
        kept.release_unused()
    assert zeros(600) is small


def test_bytes_are_those_of_all_arrays_in_tuples_and_fields_each_once():
    RAYS.forget()
    camera = Camera(
        name="bent", position=(0.0, 0.0, 2.0), image=(64, 32), fx=64.0, fy=64.0, cx=32.0, cy=16.0,
        distortion=BrownConrady(k1=-0.1),
    )  # fmt: skip
    table = lattice(camera)
    assert table.exists is not None and lattice(camera) is table
    assert RAYS.size_bytes == table.rows.nbytes + table.planes.nbytes + table.exists.nbytes
    before = RAYS.size_bytes
    RAYS.of(lambda _: (table, None))(0)
    assert RAYS.size_bytes == before


class _Asked:
    """Equal to all of its kind; says when it is compared with another one."""

    def __init__(self, compared: threading.Event) -> None:
        self._compared = compared

    def __hash__(self) -> int:
        return 1

    def __eq__(self, other: object) -> bool:
        self._compared.set()
        return isinstance(other, _Asked)


def test_of_two_threads_that_ask_for_the_same_one_waits_for_the_other():
    begun, compared, made = threading.Event(), threading.Event(), list[int]()

    def find(_: _Asked) -> np.ndarray:
        made.append(1)
        begun.set()
        assert compared.wait(30.0)
        return np.zeros(3)

    found = KeptAnswers(1000).of(find)
    with ThreadPoolExecutor(2) as threads:
        one = threads.submit(found, _Asked(compared))
        assert begun.wait(30.0)
        other = threads.submit(found, _Asked(compared))
        assert one.result() is other.result()
    assert made == [1]
