"""What sensors look like: spinning, solid-state and camera, and how they show what is going on with them."""

import itertools

import numpy as np
import pytest

from riglens.core.geometry import Pose
from riglens.core.rig.library import default_library, sensor_from_model
from riglens.core.rig.model import Camera, Lidar, LinearAngles
from riglens.widgets.sensors.appearance import colour_of
from riglens.widgets.sensors.bodies import SensorBody, sensor_body, sensor_mesh
from riglens.widgets.theme import DARK, LIGHT

SPINNING = Lidar(name="roof", position=(0.2, -0.5, 2.2), elevations_deg=(-10.0, 0.0))
FORWARD = SPINNING.replace(azimuths_deg=LinearAngles(**{"from": -60.0, "to": 60.0, "count": 600}))
CAMERA = Camera(name="front", position=(0.5, 0.0, 1.8), hfov_deg=70.0, cast=(352, 128))
COLOUR = colour_of("lidar")
SENSORS = [SPINNING, FORWARD, CAMERA]


def test_a_lidar_that_sees_all_round_is_a_puck_and_one_that_looks_one_way_a_box():
    assert [sensor_body(sensor).shape for sensor in SENSORS] == ["puck", "box", "lens"]
    listed = SPINNING.replace(azimuths_deg=tuple(range(-180, 180)))
    assert sensor_body(listed).shape == "puck"


@pytest.mark.parametrize("sensor", SENSORS)
def test_a_sensor_is_larger_than_life_but_stays_at_its_origin(sensor):
    bounds = np.array(sensor_mesh(sensor_body(sensor), COLOUR, DARK).bounds).reshape(3, 2).T
    assert (bounds[0] < 0.0).all() and (bounds[1] > 0.0).all()
    assert (np.abs(bounds) < 0.2).all()
    assert np.allclose(bounds, sensor_body(sensor).box_m(), atol=0.02)


@pytest.mark.parametrize("shape", ["lens", "box"])
def test_a_camera_and_a_solid_state_lidar_look_ahead_with_dark_glass(shape):
    mesh = sensor_mesh(SensorBody(shape), COLOUR, DARK)
    ahead = mesh["rgb"][np.argsort(np.asarray(mesh.points)[:, 0])[-4:]]
    assert (ahead.max(axis=1) < 140).all()


@pytest.mark.parametrize("palette", [DARK, LIGHT])
@pytest.mark.parametrize(
    ("shape", "kind"), [("puck", "lidar"), ("box", "lidar"), ("lens", "camera"), ("box", "probe")]
)
def test_selected_hovered_switched_off_and_ordinary_sensors_look_different(shape, kind, palette):
    states = [("", True), ("hovered", True), ("selected", True), ("", False)]
    looks = [
        sensor_mesh(SensorBody(shape), colour_of(kind), palette, mark, on)["rgb"].mean(axis=0)
        for mark, on in states
    ]
    for one, other in itertools.combinations(looks, 2):
        assert np.abs(one - other).max() > 12


def test_a_model_whose_size_the_library_knows_has_its_true_size():
    puck = sensor_from_model("velodyne-vlp-16", "puck", Pose())
    assert sensor_body(puck).shape == "puck"
    assert np.ptp(sensor_body(puck).box_m(), axis=0) == pytest.approx([0.1032, 0.1032, 0.0717])
    bounds = np.array(sensor_mesh(sensor_body(puck), COLOUR, DARK).bounds).reshape(3, 2)
    assert np.ptp(bounds, axis=1) == pytest.approx([0.1032, 0.1032, 0.0717], rel=0.15)


def test_every_model_of_the_library_has_a_body():
    for entry in default_library().entries():
        box_m = sensor_body(entry.sensor("s", Pose())).box_m()
        assert (box_m[0] < 0.0).all() and (box_m[1] > 0.0).all() and np.ptp(box_m, axis=0).max() < 0.6, (
            entry.name
        )
