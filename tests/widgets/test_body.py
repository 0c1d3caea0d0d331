"""The car body: exactly the vehicle's size, recognisably a car, wheels where the axles are."""

import numpy as np
import pytest

from core.errors import InputError
from core.rig.model import Vehicle
from widgets.viewport.body import body_parts

VEHICLES = [
    Vehicle(),
    Vehicle(length=5.2, width=2.0, height=1.5, rear_axle_x=-1.6),
    Vehicle(length=3.6, width=1.6),
]


def points_of(vehicle: Vehicle, *materials: str) -> np.ndarray:
    return np.concatenate([part.mesh.points for part in body_parts(vehicle) if part.material in materials])


@pytest.mark.parametrize("vehicle", VEHICLES)
def test_the_body_has_the_length_width_and_height_of_the_vehicle(vehicle):
    points = points_of(vehicle, "paint", "glass", "trim", "plate", "lamp", "tail")
    mirrors = (np.abs(points[:, 1]) > vehicle.width / 2 + 1e-3) & (points[:, 2] > 0.5 * vehicle.height)
    points = points[~mirrors]
    assert np.allclose(points[:, 0].min(), -vehicle.length / 2, atol=2e-3)
    assert np.allclose(points[:, 0].max(), vehicle.length / 2, atol=2e-3)
    assert np.allclose(np.abs(points[:, 1]).max(), vehicle.width / 2, atol=2e-3)
    assert np.allclose(points[:, 2].max(), vehicle.height, atol=2e-3)


@pytest.mark.parametrize("vehicle", VEHICLES)
def test_the_wheels_stand_on_the_ground_at_the_axles_inside_the_width(vehicle):
    tyres = points_of(vehicle, "tyre")
    wheelbase_m = 2.7 * vehicle.length / 4.6
    assert tyres[:, 2].min() == pytest.approx(0.0, abs=1e-4)
    assert np.abs(tyres[:, 1]).max() <= vehicle.width / 2
    rear, front = tyres[tyres[:, 0] < 0.0], tyres[tyres[:, 0] > 0.0]
    assert rear[:, 0].mean() == pytest.approx(vehicle.rear_axle_x, abs=0.02)
    assert front[:, 0].mean() == pytest.approx(vehicle.rear_axle_x + wheelbase_m, abs=0.02)


def test_the_body_is_the_same_on_both_sides():
    for part in body_parts(Vehicle()):
        low, high = part.mesh.bounds[2:4]
        assert low == pytest.approx(-high, abs=1e-3), part.material


def test_lamps_are_in_front_tail_lights_behind_and_glass_above_the_doors():
    vehicle = Vehicle()
    assert points_of(vehicle, "lamp")[:, 0].min() > 1.7
    assert points_of(vehicle, "tail")[:, 0].max() < -1.7
    assert points_of(vehicle, "glass")[:, 2].min() > 0.6 * vehicle.height


def test_windscreen_and_rear_window_slope_as_on_a_sedan():
    glass = points_of(Vehicle(), "glass")
    glass = glass[np.abs(glass[:, 1]) < 0.3]
    low, high = glass[glass[:, 2] < 1.06], glass[glass[:, 2] > 1.30]
    assert low[:, 0].max() > high[:, 0].max() + 0.3
    assert low[:, 0].min() < high[:, 0].min() - 0.3


def test_nothing_but_tyres_and_housings_hangs_below_the_sills():
    body = points_of(Vehicle(), "paint", "glass", "trim", "plate", "lamp", "tail")
    assert body[:, 2].min() > 0.12


def test_shading_normals_point_outwards():
    vehicle = Vehicle()
    for part in body_parts(vehicle):
        if part.material in ("paint", "glass"):
            normals = np.asarray(part.mesh.point_data["Normals"])
            outwards = part.mesh.points - np.array([0.0, 0.0, 0.6])
            assert ((normals * outwards).sum(axis=1) > -0.05).mean() > 0.9, part.material


def test_an_unknown_body_is_refused_in_one_line_that_names_the_known_ones():
    with pytest.raises(InputError, match=r"^vehicle\.body: found 'hovercraft', accepted is sedan$"):
        body_parts(Vehicle(body="hovercraft"))
