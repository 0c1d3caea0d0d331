"""The car's own body before the traffic: a ray that it stops reaches no road user."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from riglens.core.errors import InputError
from riglens.core.rig.body_mesh import BodyMesh
from riglens.core.rig.model import Rig, Vehicle
from riglens.core.targets.engine import TargetEngine
from riglens.core.targets.settings import EXACT, USUAL, TargetSettings
from riglens.core.vehicle.solid import solid_of
from tests.core.builders import camera, lidar, rig_of
from tests.core.targets import brute_force
from tests.core.targets.cases import random_rig, random_traffic, traffic
from tests.core.vehicle.solids import body_ends

BLOCKED = replace(EXACT, body="blocks")
RNG = np.random.default_rng(21)
TRAFFIC = random_traffic(RNG, 12)
AHEAD = traffic([(0, 0, (20.0, 0.0, 1.0), (2.0, 2.0, 2.0), 0.0)])


def low(rig: Rig) -> Rig:
    """The same rig with every sensor close to the car, so that its body stops rays."""
    moved = [
        sensor.replace(position=(float(x), float(y), 1.3), name=f"S{number}")
        for number, (sensor, (x, y)) in enumerate(
            zip(rig.sensors, RNG.uniform(-1.4, 1.4, (9, 2)), strict=False)
        )
    ]
    return rig.replace(sensors=tuple(moved))


def counts(rig: Rig, settings: TargetSettings, threads: int = 1) -> np.ndarray:
    found = TargetEngine(TRAFFIC, threads).evaluate(rig, settings).objects
    return np.concatenate([found.points, found.pixels], axis=1)


def test_a_sensor_in_the_closed_car_reaches_nobody() -> None:
    inside = lidar((0.0, 0.0, 0.8))
    assert TargetEngine(AHEAD, 1).evaluate(rig_of(inside), EXACT).objects.all_points[0] > 0
    assert TargetEngine(AHEAD, 1).evaluate(rig_of(inside), BLOCKED).objects.all_points[0] == 0


def test_a_sensor_high_above_the_car_loses_nothing_ahead() -> None:
    above = lidar((0.0, 0.0, 3.0), elevations=[-6.0], azimuths=[0.0])
    for settings in (EXACT, BLOCKED):
        assert TargetEngine(AHEAD, 1).evaluate(rig_of(above), settings).objects.all_points.tolist() == [1]


@pytest.mark.parametrize("case", range(6))
def test_rays_that_the_body_stops_are_left_out_ray_by_ray(case: int) -> None:
    """The oracle leaves out the rays that meet the body before the box."""
    rig = low(random_rig(np.random.default_rng(case)))
    solid = solid_of(rig.vehicle)
    expected = brute_force.count(TRAFFIC, rig, BLOCKED, solid=solid)
    found = TargetEngine(TRAFFIC, 1).evaluate(rig, BLOCKED).objects
    rays = {sensor.name: expected.rays[found.box, k] for k, sensor in enumerate(rig.sensors)}
    for column, name in enumerate(found.lidars):
        assert found.points[:, column].tolist() == rays[name].tolist()
    assert found.cells.tolist() == expected.cells[found.box].tolist()
    assert any(np.isfinite(body_ends(sensor, solid)).any() for sensor in rig.sensors)


def test_an_empty_body_changes_nothing() -> None:
    far = Vehicle(length=0.2, width=0.2, height=0.2)
    rig = low(random_rig(np.random.default_rng(3)))
    above = rig.replace(vehicle=far, sensors=tuple(s.replace(position=(0.0, 0.0, 9.0)) for s in rig.sensors))
    upward = above.replace(sensors=tuple(s.replace(rpy_deg=(0.0, -89.0, 0.0)) for s in above.sensors))
    assert (counts(upward, BLOCKED) == counts(upward, EXACT)).all()


def test_the_body_never_adds_a_point() -> None:
    for case in range(4):
        rig = low(random_rig(np.random.default_rng(40 + case)))
        assert (counts(rig, BLOCKED) <= counts(rig, EXACT)).all()


def test_counts_do_not_depend_on_threads_or_on_what_was_asked_before() -> None:
    rig, usual = low(random_rig(np.random.default_rng(5))), replace(USUAL, body="blocks")
    engine = TargetEngine(TRAFFIC, 2)
    engine.evaluate(rig, USUAL)
    found = engine.evaluate(rig, usual).objects
    fresh = TargetEngine(TRAFFIC, threads=1).evaluate(rig, usual).objects
    assert (found.points == fresh.points).all() and (found.cells == fresh.cells).all()


def test_another_car_casts_all_sensors_again() -> None:
    rig = low(random_rig(np.random.default_rng(6)))
    tall = rig.replace(vehicle=Vehicle(body="van", length=5.2, width=2.0, height=2.4))
    engine = TargetEngine(TRAFFIC, 1)
    engine.evaluate(rig, BLOCKED)
    assert (engine.evaluate(tall, BLOCKED).objects.points == counts_of(tall)).all()


def counts_of(rig: Rig) -> np.ndarray:
    return np.asarray(TargetEngine(TRAFFIC, 1).evaluate(rig, BLOCKED).objects.points)


def test_a_mesh_that_was_not_read_cannot_block() -> None:
    rig = rig_of(camera((0.0, 0.0, 1.5))).replace(vehicle=Vehicle(body="car.stl"))
    with pytest.raises(InputError, match=r"car\.stl"):
        TargetEngine(AHEAD, 1).evaluate(rig, BLOCKED)
    assert TargetEngine(AHEAD, 1).evaluate(rig, EXACT) is not None


def test_a_mesh_blocks_as_a_parametric_body_does() -> None:
    wall = np.array([[[2.0, -9, 0], [2, 9, 0], [2, 9, 9]], [[2.0, -9, 0], [2, 9, 9], [2, -9, 9]]])
    rig = rig_of(lidar((0.0, 0.0, 1.0))).replace(vehicle=Vehicle(body="wall.stl"))
    normals = np.tile(np.array([[1.0, 0.0, 0.0]], np.float32), (6, 1))
    triangles = np.arange(6, dtype=np.int32).reshape(2, 3)
    mesh = BodyMesh(wall.reshape(-1, 3).astype(np.float32), normals, triangles)
    assert TargetEngine(AHEAD, 1).evaluate(rig, EXACT).objects.all_points.tolist() == [1]
    assert TargetEngine(AHEAD, 1).evaluate(rig.with_body_mesh(mesh), BLOCKED).objects.all_points.tolist() == [
        0
    ]
