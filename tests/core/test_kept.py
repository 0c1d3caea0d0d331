"""Tables of rays are kept by their bytes: many small ones, few large ones, always the last."""

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
