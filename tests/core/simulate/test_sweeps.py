"""Sweeps: every ray against every part in plain numpy, the counts of the targets engine, draws that follow the seed."""

from dataclasses import replace

import numpy as np
import pytest

from riglens.core.errors import InputError
from riglens.core.kernels.objects.sweeps import count_inside
from riglens.core.rig.model import Lidar, LinearAngles, Rig
from riglens.core.simulate.clutter import Footprints, overlaps
from riglens.core.simulate.settings import USUAL_SIMULATION, SimulationSettings
from riglens.core.simulate.sweeps import GROUND, STATIC, Simulator, Sweep
from riglens.core.simulate.world import Worlds
from riglens.core.targets.engine import TargetEngine
from riglens.core.targets.traffic import Traffic
from riglens.core.vehicle.solid import solid_of
from tests.core.simulate import every_ray
from tests.core.simulate.small import BARE
from tests.core.targets.cases import random_rig, random_traffic, traffic

LIDAR = Lidar(
    name="top",
    position=(0.0, 0.0, 2.0),
    elevations_deg=LinearAngles(from_=-20.0, to=5.0, count=12),
    azimuths_deg=LinearAngles(from_=-180.0, to=180.0, count=180),
    range_m=(1.0, 100.0),
)
RIG = Rig(name="one", sensors=(LIDAR,))
STREET = traffic(
    [
        (0, 0, (12.0, 2.0, 0.8), (4.4, 1.8, 1.6), 0.2),
        (0, 2, (7.0, -3.0, 0.9), (0.6, 0.6, 1.8), 0.0),
        (2, 1, (-9.0, 1.0, 0.8), (1.8, 0.6, 1.6), 1.0),
    ],
    frames=3,
)


def tame(world: Traffic) -> Traffic:
    """Road users that are no larger than real ones, so that clutter fits between them."""
    return replace(world, size_m=world.size_m.clip(max=4.0))


@pytest.mark.parametrize("seed", range(8))
def test_every_ray_against_everything_that_stands_there(seed: int) -> None:
    rng = np.random.default_rng(seed)
    settings = SimulationSettings(
        seed, clutter=25, range_law=seed % 2 == 0, ground=("uneven", "flat", "none")[seed % 3]
    )
    rig, solid = Rig(name="some", sensors=(LIDAR, *random_rig(rng, 6).enabled_lidars())), None
    if seed % 4 == 3:
        settings, solid = replace(settings, body="blocks"), solid_of(rig.vehicle)
    simulator, seen = Simulator(rig, Worlds(tame(random_traffic(rng, 3)), settings)), set[int]()
    for frame in range(3):
        found, expected = simulator.sweep(frame), every_ray.sweep(rig, simulator.worlds, frame, solid)
        np.testing.assert_array_equal(found.object, expected.object)
        np.testing.assert_array_equal(found.ring, expected.ring)
        np.testing.assert_allclose(found.points_m, expected.points_m, atol=2e-5)
        seen |= set(np.minimum(found.object, 0).tolist())
    assert seen >= {STATIC, 0}
    assert (GROUND in seen) == (settings.ground != "none")


@pytest.mark.parametrize("law", [True, False])
def test_points_on_road_users_are_those_that_the_targets_engine_counts(law: bool) -> None:
    """Behind the car's body as well, with its draws, whatever ground there is."""
    rng = np.random.default_rng(5)
    world = random_traffic(rng, 6).within(1e6)
    rig = Rig(name="many", sensors=(LIDAR, *random_rig(rng, 8).enabled_lidars()))
    settings = replace(BARE, seed=7, range_law=law, ground="uneven", body="blocks")
    simulator, counted = (
        Simulator(rig, Worlds(world, settings)),
        TargetEngine(world).evaluate(rig, settings.targets()).objects,
    )
    points, alone = np.zeros((2, len(world.cls)), np.int64)
    for frame in range(world.frames):
        truth = simulator.worlds.truth(frame)
        sweep = simulator.sweep(frame)
        points[truth.row], alone[truth.row] = sweep.hits(len(truth.cls)), sweep.alone
        assert (sweep.alone >= sweep.reached).all() and (sweep.reached >= sweep.hits(len(truth.cls))).all()
    np.testing.assert_array_equal(alone[world.row[counted.box]], counted.points_alone)
    np.testing.assert_array_equal(points[world.row[counted.box]], counted.all_points)
    assert points.sum() > 200


def test_the_same_seed_gives_the_same_bytes_in_any_order_and_another_one_does_not() -> None:
    one, other = Simulator(RIG, Worlds(STREET)), Simulator(RIG, Worlds(STREET))
    first = [one.sweep(frame) for frame in (0, 1, 2)]
    again = [other.sweep(frame) for frame in (2, 0, 1)]
    assert as_bytes(first[0]) == as_bytes(again[1])
    assert as_bytes(first[2]) == as_bytes(again[0])
    assert as_bytes(first[0]) != as_bytes(Simulator(RIG, Worlds(STREET, SimulationSettings(seed=1))).sweep(0))
    assert as_bytes(first[0]) != as_bytes(first[1])


def as_bytes(sweep: Sweep) -> bytes:
    columns = (sweep.points_m, sweep.intensity, sweep.ring, sweep.sensor, sweep.object)
    return b"".join(column.tobytes() for column in columns)


def test_noise_and_losses_are_as_large_as_they_are_said_to_be() -> None:
    ring = LIDAR.replace(
        elevations_deg=(-30.0,), azimuths_deg=LinearAngles(from_=-180.0, to=180.0, count=20_000)
    )
    rig = Rig(name="ring", sensors=(ring,))
    settings = replace(BARE, ground="flat", range_law=False, noise_m=0.05, dropout=0.2)
    sweep = Simulator(rig, Worlds(traffic([], frames=1), settings)).sweep(0)
    range_m = np.linalg.norm(sweep.points_m.astype(np.float64) - [0.0, 0.0, 2.0], axis=1)
    assert len(range_m) / 20_000 == pytest.approx(0.8, abs=0.012)
    assert range_m.mean() == pytest.approx(4.0, abs=0.002)
    assert range_m.std() == pytest.approx(0.05, rel=0.03)
    assert np.abs(range_m - 4.0).max() < 0.05 * 3.5


def test_intensity_tells_nothing_of_the_class() -> None:
    """Cars and pedestrians are as bright as one another, and as bushes: drawn from one range for each thing."""
    rng = np.random.default_rng(3)
    world = tame(random_traffic(rng, 40))
    bright = [Worlds(world, USUAL_SIMULATION).world(frame) for frame in range(40)]
    by_class = [
        np.concatenate([one.reflectivity.bright[one.boxes.cls == cls] for one in bright]) for cls in (0, 2, 3)
    ]
    assert max(part.mean() for part in by_class) - min(part.mean() for part in by_class) < 12.0
    assert all(part.min() >= 10.0 and part.max() <= 130.0 for part in by_class)


def test_no_clutter_stands_in_road_users_or_in_the_car() -> None:
    """Points drawn in each footprint lie in no other."""
    rng = np.random.default_rng(9)
    worlds = Worlds(tame(random_traffic(rng, 12)), SimulationSettings(clutter=200))
    met = 0
    for frame in range(12):
        boxes, looks, _, kind = worlds.world(frame)
        for thing in np.flatnonzero(kind >= 0) + looks.users:
            inside = rng.uniform(-1.0, 1.0, (60, 3)) * boxes.halves[thing] * [1.0, 1.0, 0.0]
            places = boxes.centres[thing, :2] + (inside @ boxes.rotations[thing].T)[:, :2]
            assert not ((np.abs(places) < [4.0, 2.0]).all(axis=1)).any()
            for user in range(looks.users):
                turn = boxes.rotations[user]
                if turn[2, 2] == 1.0:
                    local = (places - boxes.centres[user, :2]) @ turn[:2, :2]
                    assert not (np.abs(local) < boxes.halves[user, :2]).all(axis=1).any()
                    met += 1
    assert met > 1000


def test_rectangles_overlap_where_a_fine_lattice_of_one_lies_in_the_other() -> None:
    """And crossing, touching in a corner, side by side, as a pencil says."""
    east, north = (1.0, 0.0), (0.0, 1.0)
    long = Footprints(np.array([[0.0, 0.0]]), np.array([[5.0, 0.2]]), np.array([east]))
    others = Footprints(
        np.array([[0.0, 0.5], [0.0, 0.5], [0.0, 0.3], [5.1, 0.0], [6.0, 0.0]]),
        np.array([[5.0, 0.2]] * 5),
        np.array([east, north, east, north, north]),
    )
    assert overlaps(long, others).tolist() == [[False, True, True, True, False]]
    rng = np.random.default_rng(2)
    some, more = random_footprints(rng, 40), random_footprints(rng, 40)
    found, lattice = (
        overlaps(some, more),
        np.stack(np.meshgrid(*[np.linspace(-1.0, 1.0, 61)] * 2), axis=-1).reshape(-1, 2),
    )
    for k in range(40):
        places = local_to_ground(some, k, lattice * some.half_m[k])
        for n in range(40):
            offset, ahead = places - more.centre_m[n], more.ahead[n]
            along, beside = offset @ ahead, offset @ np.array([-ahead[1], ahead[0]])
            inside = ((np.abs(along) < more.half_m[n, 0]) & (np.abs(beside) < more.half_m[n, 1])).any()
            assert found[k, n] or not inside
            if found[k, n] and not inside:  # a sliver between two points of the lattice
                assert not overlaps(shrunk(some, k), shrunk(more, n)).any()


def random_footprints(rng: np.random.Generator, count: int) -> Footprints:
    turn = rng.uniform(-np.pi, np.pi, count)
    ahead = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    return Footprints(rng.uniform(-4.0, 4.0, (count, 2)), rng.uniform(0.3, 2.5, (count, 2)), ahead)


def local_to_ground(some: Footprints, k: int, local: np.ndarray) -> np.ndarray:
    ahead = some.ahead[k]
    return np.asarray(some.centre_m[k] + local @ np.array([ahead, [-ahead[1], ahead[0]]]))


def shrunk(some: Footprints, k: int) -> Footprints:
    """One of them, smaller by more than the lattice is coarse: what it meets, the lattice meets."""
    return Footprints(some.centre_m[[k]], some.half_m[[k]] - 0.2, some.ahead[[k]])


def test_points_in_a_box_are_counted_by_where_they_are() -> None:
    truth = Worlds(STREET).truth(2)
    ahead, up = truth.rotation[0][:, 0], np.array([0.0, 0.0, 1.0])
    points = truth.centre_m[0] + np.array([0.0 * ahead, 0.89 * ahead, 0.91 * ahead, -0.79 * up, 0.81 * up])
    counts = np.zeros(len(truth.cls), np.int64)
    count_inside(points.astype(np.float32), truth.centre_m, truth.size_m / 2.0, truth.rotation, counts)
    assert counts.tolist() == [3]


def test_a_frame_with_nothing_and_a_rig_without_lidars() -> None:
    assert len(Simulator(RIG, Worlds(STREET, BARE)).sweep(1).points_m) == 0
    empty = Simulator(Rig(name="none"), Worlds(STREET)).sweep(0)
    assert empty.points_m.shape == (0, 3) and empty.hits(2).tolist() == [0, 0]
    with pytest.raises(IndexError):
        Simulator(RIG, Worlds(STREET)).sweep(3)


def test_the_ground_lies_under_the_road_users() -> None:
    """Data whose road is not at z = 0 still stand on the ground."""
    lifted = replace(STREET, centre_m=STREET.centre_m + np.array([0.0, 0.0, 0.4]))
    three = traffic([(0, 2, (8.0, y, 1.3), (0.6, 0.6, 1.8), 0.0) for y in (-3.0, 0.0, 3.0)])
    assert Worlds(three, USUAL_SIMULATION).world(0).surface.height == pytest.approx(0.4)
    assert Worlds(lifted, USUAL_SIMULATION).world(0).surface.height == 0.0  # two say too little


@pytest.mark.parametrize(
    ("changes", "name"),
    [
        ({"seed": -1}, "seed"),
        ({"noise_m": float("nan")}, "noise_m"),
        ({"noise_m": -0.1}, "noise_m"),
        ({"dropout": 1.0}, "dropout"),
        ({"clutter": -1}, "clutter"),
        ({"clutter": 10_000_000}, "clutter"),
    ],
)
def test_settings_that_make_no_sense_are_refused(changes: dict[str, float], name: str) -> None:
    with pytest.raises(InputError, match=name):
        replace(USUAL_SIMULATION, **changes)  # type: ignore[arg-type]
