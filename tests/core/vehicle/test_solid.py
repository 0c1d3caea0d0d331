"""The car as rays meet it: the tree of boxes finds what a search over all triangles finds, to the last bit."""

import math
import threading
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from riglens.core.errors import InputError
from riglens.core.kernels.body.solid import meet_listed
from riglens.core.rig.body_mesh import BodyMesh
from riglens.core.rig.model import PARAMETRIC_BODIES, Vehicle
from riglens.core.vehicle.body import body_parts
from riglens.core.vehicle.profile import reference_vehicle
from riglens.core.vehicle.solid import GLASS, MATERIALS, Solid, solid_of
from tests.core.vehicle.solids import box, brute_force, plate, soup
from tests.waiting import TIMEOUT_S


def random_directions(rng: np.random.Generator, count: int) -> np.ndarray:
    rays = rng.normal(size=(count, 3))
    rays[rng.random((count, 3)) < 0.05] = 0.0
    rays[np.abs(rays).max(axis=1) == 0.0] = 1.0
    return np.asarray(rays / np.linalg.norm(rays, axis=1, keepdims=True))


def assert_as_brute_force(solid: Solid, seed: int, rays: int, start_m: float = 0.0) -> None:
    rng = np.random.default_rng(seed)
    directions = random_directions(rng, rays)
    for kind in ("lidar", "camera"):
        barrier = solid.barrier(kind, start_m)  # type: ignore[arg-type]
        for origin in (rng.uniform(-3.0, 3.0, 3), np.round(rng.uniform(-3.0, 3.0, 3), 1)):
            found = meet_listed(
                origin, directions, barrier.tree, barrier.stops, np.full(rays, np.inf), start_m
            )
            numbers = np.flatnonzero(barrier.stops)
            t, number = brute_force(origin, directions, solid.triangles_m[numbers], start_m)
            np.testing.assert_array_equal(found[0], t)
            np.testing.assert_array_equal(found[1], np.where(number < 0, -1, numbers[number]))


@settings(max_examples=15)
@given(seed=st.integers(0, 2**32 - 1), start_m=st.sampled_from([0.0, 0.1, 1.5]))
def test_the_tree_finds_what_a_search_over_all_triangles_finds(seed: int, start_m: float) -> None:
    assert_as_brute_force(soup(seed), seed, 60, start_m)


@pytest.mark.slow
def test_on_a_million_rays_the_tree_and_a_search_over_all_triangles_agree() -> None:
    for seed in range(25):
        assert_as_brute_force(soup(seed, count=200), seed, 10_000, 0.05 * (seed % 3))


@pytest.mark.parametrize("body", PARAMETRIC_BODIES)
def test_on_a_car_the_tree_and_a_search_over_all_triangles_agree(body: str) -> None:
    solid = solid_of(reference_vehicle(body))
    rng = np.random.default_rng(1)
    directions = random_directions(rng, 25)
    barrier = solid.barrier("lidar", 0.0)
    for origin in (np.array([0.3, 0.2, 0.9]), np.array([-0.4, 0.2, 2.2])):
        t, number, _ = meet_listed(origin, directions, barrier.tree, barrier.stops, np.full(25, np.inf), 0.0)
        expected = brute_force(origin, directions, solid.triangles_m, 0.0)
        np.testing.assert_array_equal(t, expected[0])
        np.testing.assert_array_equal(number, expected[1])


def test_of_two_triangles_at_the_same_place_the_first_counts() -> None:
    twice = np.concatenate([plate(2.0), plate(2.0, facing=1), plate(2.0)])
    barrier = Solid.of(twice).barrier("lidar", 0.0)
    rays = np.array([[1.0, 0.0, 0.0], [0.8, 0.6, 0.0]])
    t, number, square = meet_listed(np.zeros(3), rays, barrier.tree, barrier.stops, np.full(2, np.inf), 0.0)
    np.testing.assert_allclose(t, [2.0, 2.5])
    assert number[0] == 0 and number[1] in (0, 1)
    np.testing.assert_allclose(square, [1.0, 0.8])


def test_a_ray_meets_a_plate_at_its_distance_from_either_side_and_only_beyond_the_start() -> None:
    solid = Solid.of(np.concatenate([plate(3.0), plate(-4.0)]))
    rays = np.array([[1.0, 0, 0], [-1.0, 0, 0], [math.cos(1.0), math.sin(1.0), 0.0], [0.0, 1.0, 0.0]])
    for start_m, expected in ((0.0, [3.0, 4.0, 3.0 / math.cos(1.0), math.inf]), (3.5, [math.inf, 4.0])):
        barrier = solid.barrier("lidar", start_m)
        found = meet_listed(
            np.zeros(3), rays, barrier.tree, barrier.stops, np.full(len(rays), np.inf), start_m
        )[0]
        np.testing.assert_allclose(found[: len(expected)], expected)


def test_from_inside_a_closed_box_no_ray_escapes() -> None:
    """Not through edges and corners either: the rays go right at them."""
    solid = Solid.of(box((-1.0, -1.0, -1.0), (1.0, 1.0, 1.0)))
    sides = np.array([(x, y, z) for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1) if x or y or z])
    rays = np.concatenate([sides / np.linalg.norm(sides, axis=1, keepdims=True)])
    barrier = solid.barrier("camera", 0.0)
    t = meet_listed(np.zeros(3), rays, barrier.tree, barrier.stops, np.full(len(rays), np.inf), 0.0)[0]
    np.testing.assert_allclose(t, np.linalg.norm(sides, axis=1))


def test_triangles_without_an_area_are_left_out_and_none_at_all_stop_nothing() -> None:
    needle = np.array([[[0.0, 0, 0], [1, 0, 0], [2, 0, 0]]])
    for triangles in (needle, np.zeros((0, 3, 3))):
        solid = Solid.of(triangles)
        assert solid.count == 0 and solid.tree.skip.size == 0


@pytest.mark.parametrize("body", PARAMETRIC_BODIES)
def test_glass_lets_cameras_through_and_stops_lidars(body: str) -> None:
    solid = solid_of(reference_vehicle(body))
    glass = solid.materials == GLASS
    assert 0.005 < glass.mean() < 0.2
    np.testing.assert_array_equal(solid.barrier("camera", 0.0).stops, ~glass)
    assert solid.barrier("lidar", 0.0).stops.all()


def test_the_same_body_gives_the_same_solid_and_every_difference_another_fingerprint() -> None:
    assert solid_of(Vehicle()) is solid_of(Vehicle())
    prints = {
        solid_of(vehicle).fingerprint for vehicle in (Vehicle(), Vehicle(length=4.601), Vehicle(body="suv"))
    }
    assert len(prints) == 3
    one = plate(1.0)
    assert Solid.of(one).fingerprint != Solid.of(one, np.full(2, MATERIALS.index("tyre"))).fingerprint


def test_threads_that_want_the_same_body_at_once_get_the_same_solid(monkeypatch: pytest.MonkeyPatch) -> None:
    vehicle, made, both_make = Vehicle(length=4.31), [], threading.Barrier(2)

    def slow(vehicle: Vehicle) -> list[object]:
        made.append(vehicle)
        with suppress(threading.BrokenBarrierError):
            both_make.wait(0.5)  # in vain: the other one waits for this one
        return body_parts(vehicle)

    monkeypatch.setattr("riglens.core.vehicle.solid.body_parts", slow)
    with ThreadPoolExecutor(2) as pool:
        both = [pool.submit(solid_of, vehicle) for _ in range(2)]
        one, other = (each.result(TIMEOUT_S) for each in both)
    assert one is other and made == [vehicle]


def test_a_solid_that_is_known_is_not_waited_for_while_another_one_is_made(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    known, begun, may_end = solid_of(Vehicle(length=4.32)), threading.Event(), threading.Event()

    def slow(vehicle: Vehicle) -> list[object]:
        begun.set()
        assert may_end.wait(TIMEOUT_S)
        return body_parts(vehicle)

    monkeypatch.setattr("riglens.core.vehicle.solid.body_parts", slow)
    with ThreadPoolExecutor(2) as pool:
        other = pool.submit(solid_of, Vehicle(length=4.33))
        assert begun.wait(TIMEOUT_S)
        assert pool.submit(solid_of, Vehicle(length=4.32)).result(TIMEOUT_S) is known
        may_end.set()
        assert other.result(TIMEOUT_S) is not known


def test_a_mesh_of_a_file_is_placed_and_one_that_is_missing_is_said_to_be() -> None:
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32)
    mesh = BodyMesh(points, np.zeros((3, 3), np.float32), np.array([[0, 1, 2]], np.int32))
    vehicle = Vehicle(body="car.glb", mesh={"scale": 2.0, "offset": (0.0, 0.0, 1.0)})  # type: ignore[arg-type]
    solid = solid_of(vehicle.with_body_mesh(mesh))
    np.testing.assert_allclose(solid.triangles_m, [[[0, 0, 1], [2, 0, 1], [0, 2, 1]]])
    with pytest.raises(InputError, match=r"^vehicle\.body: the mesh 'car\.glb' has not been read$"):
        solid_of(vehicle)
