"""Cameras around an IMU: lenses that are fitted, against their published equations, and the axes of the IMU."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from riglens.core.formats.matrices import level_axes
from riglens.core.formats.mounts import ReadOptions
from riglens.core.formats.report import Notes
from riglens.core.rig.model import Camera, KannalaBrandt
from riglens.core.sensors.camera import project_px
from tests.core.formats.cases import SMALL, VEHICLE, optical, pose_matrix, read_files, transform
from tests.core.formats.test_reports import has

AT_ORIGIN = ReadOptions(vehicle=VEHICLE, origin_m=(0.0, 0.0, 0.0))
LEVEL = Rotation.identity()


@pytest.mark.parametrize(
    ("imu", "words"),
    [
        ("", "x forward, y left, z up"),
        ("x180", "x forward, y right, z down"),  # VIODE, simulated in NED
        ("y-90", "x up, y left, z backward"),
        ("z90", "x forward, y left, z up"),  # cameras stand upright: nothing says where forward is
    ],
)
def test_the_axes_of_an_imu_are_those_in_which_cameras_stand_upright(imu: str, words: str) -> None:
    turn = Rotation.from_euler(imu[0], float(imu[1:]), degrees=True) if imu else LEVEL
    pair = [optical(pose_matrix(((0.1, side, 0.0), (2.0, -3.0, 20.0 * side)))) for side in (1.0, -1.0)]
    notes = Notes()
    found = level_axes([transform(turn.inv(), (0.0, 0.0, 0.0)) @ pose for pose in pair], notes)
    expected = LEVEL if imu.startswith("z") else turn
    np.testing.assert_allclose(found, transform(expected, (0.0, 0.0, 0.0)), atol=1e-12)
    assert any(f"the IMU's axes are taken as {words}" in line for line in notes.report("").lines())


def unified(xi: float, theta: float) -> float:
    return math.sin(theta) / (math.cos(theta) + xi)


def double_sphere(xi: float, alpha: float, theta: float) -> float:
    high = xi + math.cos(theta)
    return math.sin(theta) / (alpha * math.hypot(math.sin(theta), high) + (1 - alpha) * high)


def extended(alpha: float, beta: float, theta: float) -> float:
    root = math.sqrt(beta * math.sin(theta) ** 2 + math.cos(theta) ** 2)
    return math.sin(theta) / (alpha * root + (1 - alpha) * math.cos(theta))


@pytest.mark.parametrize(
    ("model", "numbers", "project", "widest_deg"),
    [
        ("omni", "1.5, 800, 805", lambda t: unified(1.5, t), 56.0),
        ("ds", "-0.2, 0.59, 350, 352", lambda t: double_sphere(-0.2, 0.59, t), 47.0),
        ("eucm", "0.6, 1.1, 460, 463", lambda t: extended(0.6, 1.1, t), 38.0),
    ],
)
def test_lenses_by_way_of_a_sphere_are_fitted_within_a_tenth_of_a_pixel(
    model, numbers, project, widest_deg
) -> None:  # type: ignore[no-untyped-def]
    """They were pinholes of their focal lengths: a 93 degree lens had 20."""
    text = SMALL["kalibr"]["camchain.yaml"].partition("cam1:")[0]
    text = (
        text.replace("pinhole", model).replace("[458.6, 457.3, ", f"[{numbers}, ").replace("radtan", "none")
    )
    imported = read_files({"camchain.yaml": text}, options=AT_ORIGIN)
    (camera,) = imported.rig.sensors
    assert isinstance(camera, Camera) and isinstance(camera.distortion, KannalaBrandt)
    *_, fx, fy = (float(word) for word in numbers.split(","))
    for theta in np.radians(np.linspace(0.0, widest_deg, 30)):
        right, down = np.array(
            [[math.cos(theta), -math.sin(theta), 0.0], [math.cos(theta), 0.0, -math.sin(theta)]]
        )
        pixels = project_px(camera, np.stack([right, down]))
        assert pixels[0] == pytest.approx((367.2 + fx * project(theta), 248.4), abs=0.1)
        assert pixels[1] == pytest.approx((367.2, 248.4 + fy * project(theta)), abs=0.1)
    assert has(imported.report, "approximated", f"lens of model '{model}'", "pixels off")
