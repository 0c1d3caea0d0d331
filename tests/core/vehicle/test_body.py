"""The car body: exactly the vehicle's size, recognisably a car, wheels where the axles are."""

import tomllib

import numpy as np
import pytest

from riglens.assets import asset_path
from riglens.core.errors import InputError
from riglens.core.rig.model import PARAMETRIC_BODIES, Vehicle
from riglens.core.vehicle.body import body_parts
from riglens.core.vehicle.profile import profile_of, reference_vehicle

BODIES = [reference_vehicle(body) for body in PARAMETRIC_BODIES]
VEHICLES = [
    *BODIES,
    Vehicle(length=5.2, width=2.0, height=1.5, rear_axle_x=-1.6),
    Vehicle(length=3.6, width=1.6),
    Vehicle(body="truck", length=12.0, width=2.55, height=3.9, rear_axle_x=-3.5),
]


def points_of(vehicle: Vehicle, *materials: str) -> np.ndarray:
    return np.concatenate([surface.points for name, surface in body_parts(vehicle) if name in materials])


@pytest.mark.parametrize("vehicle", VEHICLES)
def test_the_body_has_the_length_width_and_height_of_the_vehicle(vehicle):
    points = points_of(vehicle, "paint", "panel", "glass", "trim", "plate", "lamp", "tail", "dark")
    mirrors = (np.abs(points[:, 1]) > vehicle.width / 2 + 1e-3) & (points[:, 2] > 0.4 * vehicle.height)
    points = points[~mirrors]
    assert np.allclose(points[:, 0].min(), -vehicle.length / 2, atol=2e-3)
    assert np.allclose(points[:, 0].max(), vehicle.length / 2, atol=2e-3)
    assert np.allclose(np.abs(points[:, 1]).max(), vehicle.width / 2, atol=2e-3)
    assert np.allclose(points[:, 2].max(), vehicle.height, atol=2e-3)


@pytest.mark.parametrize("vehicle", VEHICLES)
def test_the_wheels_stand_on_the_ground_at_the_axles_inside_the_width(vehicle):
    tyres = points_of(vehicle, "tyre")
    profile = profile_of(vehicle.body)
    wheelbase_m = (profile.axle_x[1] - profile.axle_x[0]) * vehicle.length / profile.length_m
    assert tyres[:, 2].min() == pytest.approx(0.0, abs=1e-4)
    assert np.abs(tyres[:, 1]).max() <= vehicle.width / 2
    rear, front = tyres[tyres[:, 0] < 0.0], tyres[tyres[:, 0] > 0.0]
    assert rear[:, 0].mean() == pytest.approx(vehicle.rear_axle_x, abs=0.02)
    assert front[:, 0].mean() == pytest.approx(vehicle.rear_axle_x + wheelbase_m, abs=0.02)


@pytest.mark.parametrize("vehicle", BODIES)
def test_the_body_is_the_same_on_both_sides(vehicle):
    for material, surface in body_parts(vehicle):
        y = surface.points[:, 1]
        low, high = y.min(), y.max()
        assert low == pytest.approx(-high, abs=1e-3), material


@pytest.mark.parametrize("vehicle", BODIES)
def test_lamps_are_in_front_tail_lights_behind_and_glass_above_the_doors(vehicle):
    assert points_of(vehicle, "lamp")[:, 0].min() > 0.36 * vehicle.length
    assert points_of(vehicle, "tail")[:, 0].max() < -0.36 * vehicle.length
    assert points_of(vehicle, "glass")[:, 2].min() > 0.4 * vehicle.height


def test_windscreen_and_rear_window_slope_as_on_a_sedan():
    glass = points_of(Vehicle(), "glass")
    glass = glass[np.abs(glass[:, 1]) < 0.3]
    low, high = glass[glass[:, 2] < 1.06], glass[glass[:, 2] > 1.30]
    assert low[:, 0].max() > high[:, 0].max() + 0.3
    assert low[:, 0].min() < high[:, 0].min() - 0.3


def test_a_truck_is_a_cab_and_a_box_with_a_gap_between_them():
    vehicle = reference_vehicle("truck")
    paint, box = points_of(vehicle, "paint"), points_of(vehicle, "panel")
    cab = paint[np.abs(paint[:, 1]) < 1.2]
    assert cab[:, 0].min() > box[:, 0].max() + 0.1
    assert np.ptp(box[:, 0]) > 0.7 * vehicle.length and box[:, 2].max() == pytest.approx(
        vehicle.height, abs=1e-3
    )
    assert box[:, 2].min() > 0.95


@pytest.mark.parametrize("vehicle", BODIES)
def test_nothing_but_tyres_and_housings_hangs_below_the_sills(vehicle):
    body = points_of(vehicle, "paint", "panel", "glass", "trim", "plate", "lamp", "tail")
    assert body[:, 2].min() > 0.12


@pytest.mark.parametrize("vehicle", BODIES)
def test_shading_normals_point_outwards(vehicle):
    for material, surface in body_parts(vehicle):
        if material in ("paint", "glass") or (material == "panel" and vehicle.body == "truck"):
            outwards = surface.points - surface.points.mean(axis=0)
            assert ((surface.normals * outwards).sum(axis=1) > -0.05).mean() > 0.85, material


def test_an_unknown_body_is_refused_in_one_line_that_names_the_known_ones():
    with pytest.raises(
        InputError, match=r"^vehicle\.body must be sedan or suv or truck or van .got 'hovercraft'.$"
    ):
        body_parts(Vehicle(body="hovercraft"))


def test_every_body_that_a_rig_file_may_name_can_be_drawn():
    assert tuple(tomllib.loads(asset_path("bodies.toml").read_text("utf-8"))) == PARAMETRIC_BODIES
    assert reference_vehicle("sedan") == Vehicle()


def test_an_suv_has_mirrors_on_arms_a_windscreen_edge_and_a_bonnet_line_across():
    vehicle = reference_vehicle("suv")
    glass, trim, gaps = (points_of(vehicle, material) for material in ("glass", "trim", "gap"))
    for side in (1.0, -1.0):
        mirror = glass[(side * glass[:, 1] > 0.9) & (glass[:, 0] < 0.7) & (glass[:, 0] > 0.5)]
        assert len(mirror) and mirror[:, 2].max() < 1.3
        arm = trim[
            (side * trim[:, 1] > 0.75) & (abs(trim[:, 0] - 0.675) < 0.06) & (abs(trim[:, 2] - 1.105) < 0.03)
        ]
        assert np.ptp(arm[:, 1]) > 0.15, "from inside the door to the mirror"
    windscreen = glass[(glass[:, 0] > 0.3) & (np.abs(glass[:, 1]) < 0.2)]
    above = trim[
        (trim[:, 2] > windscreen[:, 2].max() - 1e-6) & (trim[:, 0] > 0.0) & (np.abs(trim[:, 1]) < 0.2)
    ]
    below = trim[
        (trim[:, 0] > windscreen[:, 0].max() - 0.1) & (trim[:, 2] > 1.1) & (np.abs(trim[:, 1]) < 0.2)
    ]
    assert len(above) and len(below)
    bonnet = gaps[(gaps[:, 0] > 2.1) & (gaps[:, 2] > 0.9)]
    assert bonnet[:, 1].min() < -0.4 and bonnet[:, 1].max() > 0.4 and (np.abs(bonnet[:, 1]) < 0.05).any()
