"""First hits of rays agree with plain geometry: planes of boxes, the ground, every triangle one by one."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from riglens.core.vehicle.solid import Solid
from riglens.core.view.frames import FrameBoxes
from riglens.core.view.hits import BODY, GROUND, NOTHING, cast
from tests.core.view.view_cases import frame_of, random_frame

NO_BODY = Solid.of(np.zeros((0, 3, 3))).barrier("lidar", 0.0)
EYE = (0.3, -0.2, 1.7)
FAR = (0.0, math.inf)


def random_rays(seed: int, count: int = 200) -> np.ndarray:
    rays = np.random.default_rng(seed).normal(size=(count, 3)) * (1.0, 1.0, 0.15)
    return np.asarray(rays / np.linalg.norm(rays, axis=1, keepdims=True))


def nearest_side(origin: np.ndarray, ray: np.ndarray, boxes: FrameBoxes) -> tuple[float, int]:
    """Distance and number of the nearest box, from the planes of its six sides."""
    best = (math.inf, NOTHING)
    for box in range(len(boxes.cls)):
        turn, half = boxes.rotation[box], boxes.size_m[box] / 2
        for axis in range(3):
            for sign in (-1.0, 1.0):
                normal = sign * turn[:, axis]
                height = normal @ (boxes.centre_m[box] - origin) + half[axis]
                if abs(normal @ ray) < 1e-12 or height / (normal @ ray) <= 0.0:
                    continue
                t = height / (normal @ ray)
                local = turn.T @ (origin + t * ray - boxes.centre_m[box])
                others = [i for i in range(3) if i != axis]
                if (np.abs(local[others]) <= half[others]).all() and t < best[0]:
                    best = (t, box)
    return best


@settings(max_examples=5)
@given(seed=st.integers(0, 2**32 - 1))
def test_rays_hit_the_nearest_box_or_the_ground(seed: int) -> None:
    boxes, rays = random_frame(seed), random_rays(seed)
    hits = cast(EYE, rays, boxes, NO_BODY, FAR)
    for ray, range_m, what in zip(rays, hits.range_m, hits.what, strict=True):
        t, box = nearest_side(np.array(EYE), ray, boxes)
        ground = EYE[2] / -ray[2] if ray[2] < 0.0 else math.inf
        assert range_m == pytest.approx(min(t, ground), rel=1e-9)
        if abs(t - ground) > 1e-9:
            assert what == (box if t < ground else GROUND if ground < math.inf else NOTHING)


@settings(max_examples=5)
@given(seed=st.integers(0, 2**32 - 1))
def test_rays_hit_the_triangle_that_a_search_over_all_finds(seed: int) -> None:
    rng = np.random.default_rng(seed)
    triangles = rng.uniform(-3, 3, (150, 1, 3)) + rng.uniform(-1, 1, (150, 3, 3)) + [4.0, 0.0, 0.0]
    rays = random_rays(seed, 100)
    hits = cast(
        EYE, rays, FrameBoxes.none(), Solid.of(triangles).barrier("lidar", 0.0), FAR, has_ground=False
    )
    for ray, range_m, what in zip(rays, hits.range_m, hits.what, strict=True):
        a, u, v = triangles[:, 0], triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
        matrix = np.stack([u, v, np.broadcast_to(-ray, u.shape)], axis=-1)
        met = np.linalg.solve(matrix, (np.array(EYE) - a)[..., None])[..., 0]
        good = (met[:, 0] >= 0) & (met[:, 1] >= 0) & (met[:, 0] + met[:, 1] <= 1) & (met[:, 2] > 0)
        expected = met[good, 2].min(initial=math.inf)
        assert range_m == pytest.approx(expected, rel=1e-9)
        assert what == (BODY if good.any() else NOTHING)


def test_a_surface_met_squarely_faces_the_ray_and_a_grazed_one_does_not() -> None:
    wall = np.array([[[5.0, -9, -9], [5, 9, -9], [5, 0, 9]]])
    rays = np.array([[1.0, 0, 0], [math.cos(0.5), math.sin(0.5), 0]])
    hits = cast(
        (0.0, 0, 0), rays, FrameBoxes.none(), Solid.of(wall).barrier("lidar", 0.0), FAR, has_ground=False
    )
    np.testing.assert_allclose(hits.facing, [1.0, math.cos(0.5)])
    np.testing.assert_allclose(hits.range_m, [5.0, 5.0 / math.cos(0.5)])


def test_what_is_too_near_blocks_the_ray_but_gives_no_return() -> None:
    boxes = frame_of((0, (3.0, 0, 1.7), (1, 1, 1), 0.0), (1, (20.0, 0, 1.7), (1, 1, 1), 0.0))
    ray = np.array([[1.0, 0.0, 0.0]])
    assert cast((0.0, 0, 1.7), ray, boxes, NO_BODY, (0.0, 100.0)).what.tolist() == [0]
    assert cast((0.0, 0, 1.7), ray, boxes, NO_BODY, (5.0, 100.0)).what.tolist() == [NOTHING]
    assert cast((10.0, 0, 1.7), ray, boxes, NO_BODY, (5.0, 100.0)).what.tolist() == [1]
    assert cast((10.0, 0, 1.7), ray, boxes, NO_BODY, (0.0, 9.0)).range_m.tolist() == [math.inf]


def test_a_box_around_the_sensor_hides_nothing() -> None:
    boxes = frame_of((0, (0.0, 0, 1.5), (6, 3, 3), 0.4), (2, (10.0, 0, 1.5), (1, 1, 3), 0.0))
    assert cast((0.0, 0, 1.5), np.array([[1.0, 0, 0]]), boxes, NO_BODY, FAR).what.tolist() == [1]


def test_below_the_ground_there_is_no_ground() -> None:
    rays = np.array([[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]])
    assert cast((0.0, 0, -0.5), rays, FrameBoxes.none(), NO_BODY, FAR).what.tolist() == [NOTHING, NOTHING]
