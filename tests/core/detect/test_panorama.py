"""The range image: which pixel a point lies in, which point counts, mirrors, and a net that learns from it."""

from __future__ import annotations

import numpy as np
import pytest

from riglens.core.detect.net import Training, detect, machine, train, use_one_thread
from riglens.core.detect.panorama import FEATURES, PLACE_M, RANGE_M, Panorama
from riglens.core.detect.pillars import ACROSS_X, Region
from riglens.core.detect.precision import Matched
from tests.core.detect.scenes import PANORAMA, REGION, samples, truth_of

WIDE, USUAL = Region(), Panorama()


def pixels(points: list[list[float]]) -> tuple[np.ndarray, np.ndarray]:
    places = np.array(points, np.float32)
    age = np.arange(len(places), dtype=np.float64)[:, None]
    return USUAL.pixels(places, np.full(len(places), 51.0, np.float32), WIDE, age)


def test_a_point_lies_in_the_pixel_of_its_angles() -> None:
    (cell,), (figures,) = pixels([[10.0, 0.05, 1.9]])
    row, column = divmod(int(cell), 720)
    assert (row, column) == (37, 360)  # 35 of 45 degrees up, straight ahead
    assert figures[0] * RANGE_M == pytest.approx(10.0, abs=0.01)
    assert figures[1] * 2.0 == pytest.approx(1.9, abs=0.01) and figures[2] == pytest.approx(0.2, abs=1e-3)
    assert figures[ACROSS_X] * PLACE_M[0] == pytest.approx(10.0, abs=0.01)
    assert len(figures) == FEATURES + 1


def test_the_nearest_point_of_a_pixel_counts_and_the_farthest_is_known() -> None:
    _, (figures,) = pixels([[20.0, 0.02, 1.92], [10.0, 0.02, 1.91]])
    assert figures[0] * RANGE_M == pytest.approx(10.0, abs=0.01)
    assert figures[4] * RANGE_M == pytest.approx(20.0, abs=0.02)
    assert figures[FEATURES] == 1.0  # of the second point given


def test_points_beyond_the_region_or_above_are_left_out() -> None:
    cell, figures = pixels([[31.0, 0.0, 1.0], [0.0, -21.0, 1.0], [5.0, 0.0, 4.5]])
    assert cell.shape == (0,) and figures.shape == (0, FEATURES + 1)


@pytest.mark.parametrize("mirror", [1, 2, 3])
def test_a_mirrored_image_is_the_image_of_mirrored_points(mirror: int) -> None:
    rng = np.random.default_rng(3)
    points = rng.uniform([-29.0, -19.0, 0.0], [29.0, 19.0, 3.0], (40, 3))
    signs = np.array([-1.0 if mirror & 2 else 1.0, -1.0 if mirror & 1 else 1.0, 1.0])
    ours = [int(USUAL.mirrored(pixels([one])[0], mirror)[0]) for one in points.tolist()]
    theirs = [int(pixels([one])[0][0]) for one in (points * signs).tolist()]
    assert ours == theirs


def test_a_net_learns_from_range_images_the_same_each_time() -> None:
    torch = pytest.importorskip("torch", reason="make test-detect")
    threads = torch.get_num_threads()
    use_one_thread()
    try:
        held, unseen = samples(120, 1, PANORAMA), samples(40, 2, PANORAMA)
        on, plan = machine("cpu"), Training(epochs=8, batch=4)
        half = train([held], REGION, plan, on, until=4, panorama=PANORAMA)
        state = train([held], REGION, plan, on, half, panorama=PANORAMA)
        again = train([held], REGION, plan, on, panorama=PANORAMA)
        found = detect(state, unseen, REGION, on, PANORAMA)
    finally:
        torch.use_deterministic_algorithms(False)
        torch.set_num_threads(threads)
    assert all((state[key] == again[key]).all() for key in state)
    one = np.zeros(len(unseen), np.int64)
    found_ap = [float(Matched.of(truth_of(unseen), found, number, one).precision()[0]) for number in range(3)]
    assert min(found_ap) > 0.5
