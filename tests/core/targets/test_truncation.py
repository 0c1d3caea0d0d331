"""The share of an object that cameras show, against directions drawn around each object one by one."""

import numpy as np
import pytest
from numpy.typing import NDArray

from riglens.core.rig.model import BrownConrady, Camera, KannalaBrandt, Rig
from riglens.core.sensors.base import Blocked
from riglens.core.sensors.camera import project_px
from riglens.core.targets.engine import TargetEngine
from riglens.core.targets.settings import TargetSettings
from riglens.core.targets.traffic import Traffic
from tests.core.targets import brute_force
from tests.core.targets.cases import random_rig, random_traffic, traffic

Doubles = NDArray[np.float64]
SIDE, FINER, FEW = 80, 5, 400
"""Directions along each axis of the window around an object; times as many where fewer than FEW meet it."""
AHEAD = {"position": (0.0, 0.0, 1.5), "rpy_deg": (0.0, 0.0, 0.0)}


def directions_around(corners: Doubles, side: int, rng: np.random.Generator) -> Doubles:
    """Directions (side^2, 3), evenly over a cap that holds a box with corners (8, 3) seen from the origin."""
    middle, corners = corners.mean(axis=0), corners / np.linalg.norm(corners, axis=1, keepdims=True)
    middle /= np.linalg.norm(middle)
    cos = float((corners @ middle).min())
    cos = -1.0 if cos < 0.1 else cos  # a cone narrower than a half space holds what lies between corners
    aside = np.cross(middle, [0.0, 0.0, 1.0] if abs(middle[2]) < 0.9 else [1.0, 0.0, 0.0])
    aside /= np.linalg.norm(aside)
    u, v = ((np.indices((side, side)) + rng.random((2, side, side))) / side).reshape(2, -1)
    along, turn = cos + (1.0 - cos) * u, 2.0 * np.pi * v
    flat = np.sqrt(1.0 - along**2)
    up = np.cross(middle, aside)
    return np.outer(along, middle) + np.outer(flat * np.cos(turn), aside) + np.outer(flat * np.sin(turn), up)


def share_in_picture(
    held: Traffic, camera: Camera, box: int, settings: TargetSettings, rng: np.random.Generator
) -> float:
    """The share of the directions that meet a box without anything before it that fall on the picture."""
    rotation, one = camera.pose.rotation(), slice(box, box + 1)
    signs = np.array([[i, j, k] for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)])
    corners = signs * held.size_m[box] / 2.0 @ held.rotation[box].T + held.centre_m[box]
    for side in (SIDE, FINER * SIDE):
        local = directions_around((corners - np.array(camera.position)) @ rotation, side, rng)
        parts = brute_force.parts_of(settings.shape, held.cls[one], held.size_m[one])
        endless = camera.replace(range_m=(0.0, np.inf))
        entry = brute_force._entries(held, one, parts, endless, local @ rotation.T)[0]
        met = np.isfinite(entry).any(axis=1)
        if np.count_nonzero(met) > FEW:
            break
    inside = (project_px(camera, local) >= 0.0) & (project_px(camera, local) <= np.array(camera.image))
    return float((inside.all(axis=1) & ~camera.blocked_rays(local))[met].mean()) if met.any() else 1.0


def check(held: Traffic, rig: Rig, settings: TargetSettings, seed: int) -> int:
    """Compare the shares that each camera shows; return how many objects cross the edge of a picture."""
    rng, everything = np.random.default_rng(seed), held.within(1e6)
    found = TargetEngine(everything).evaluate(rig, settings).objects
    truth, crossing, misses = brute_force.count(everything, rig, settings), 0, list[float]()
    column_of = {sensor.name: column for column, sensor in enumerate(rig.sensors)}
    for column, camera in enumerate(rig.enabled_cameras()):
        rays, alone = (one[:, column_of[camera.name]] for one in (truth.rays, truth.alone))
        assert not found.shown[rays == 0, column].any()
        for box in np.flatnonzero(rays).tolist():
            share = share_in_picture(everything, camera, box, settings, rng)
            crossing += share < 1.0
            misses.append(found.shown[box, column] - rays[box] / alone[box] * share)
    # both draw directions: they agree within some hundredths, and in the mean
    assert np.abs(misses).max(initial=0.0) < 0.08 and abs(np.mean(misses or [0.0])) < 2e-3
    assert (found.visible == found.shown.max(axis=1, initial=0.0)).all()
    return crossing


def lenses() -> tuple[Camera, ...]:
    """A narrow pinhole, a wide one, a barrel, a fisheye whose picture ends inside the image, and a blocked one."""
    fish = {"fx": 300.0, "fy": 300.0, "cx": 800.0, "cy": 450.0, "distortion": KannalaBrandt(k1=0.01)}
    barrel = {
        "fx": 800.0,
        "fy": 800.0,
        "cx": 790.0,
        "cy": 460.0,
        "distortion": BrownConrady(k1=-0.2, k2=0.02),
    }
    sector = Blocked(azimuth_deg=(-10.0, 60.0), elevation_deg=(-40.0, 40.0))
    return (
        Camera(name="narrow", **AHEAD, hfov_deg=30.0, cast=(80, 45)),
        Camera(
            name="wide", position=(0.3, 0.2, 1.4), rpy_deg=(4.0, 7.0, 80.0), hfov_deg=120.0, cast=(90, 50)
        ),
        Camera(name="barrel", position=(0.0, 0.4, 1.6), rpy_deg=(0.0, 5.0, 150.0), **barrel, cast=(90, 50)),
        Camera(name="fish", position=(-1.0, 0.0, 1.2), rpy_deg=(0.0, 0.0, -120.0), **fish, cast=(90, 50)),
        Camera(name="blocked", **AHEAD, hfov_deg=90.0, cast=(80, 45), blocked=(sector,)),
    )


@pytest.mark.parametrize("shape", ["box", "class"])
def test_cameras_show_the_share_of_the_whole_silhouette(shape):
    settings = TargetSettings(shape=shape, range_law=False)
    held = random_traffic(np.random.default_rng(7), 12, 10)
    assert check(held, Rig(sensors=lenses()), settings, 1) > 20


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(20))
def test_random_rigs_in_a_hundred_frames(seed):
    rng = np.random.default_rng(700 + seed)
    settings = TargetSettings(shape=("box", "class")[seed % 2], range_law=False)
    check(random_traffic(rng, 100), random_rig(rng, 6), settings, seed)


def test_an_object_half_outside_the_picture_is_half_visible():
    camera = Camera(name="C", **AHEAD, image=(400, 400), hfov_deg=90.0, cast=(400, 400))
    post, hidden = (0, 0, (20.0, 20.0, 1.5), (1.0, 1.0, 2.0), np.pi / 4.0), (2.0, 1.0, 4.0)
    wall = (1, 0, (10.0, 10.0, 1.5), hidden, np.pi / 4.0)
    settings = TargetSettings(shape="box", range_law=False)
    found = TargetEngine(traffic([post], 1)).evaluate(Rig(sensors=(camera,)), settings)
    assert found.objects.visible[0] == pytest.approx(0.5, abs=0.02)
    behind = traffic([(0, 0, (30.0, 30.0, 1.5), (1.0, 1.0, 2.0), 0.0), (0, *wall[1:])], 1)
    covered = TargetEngine(behind).evaluate(Rig(sensors=(camera,)), settings).objects
    assert covered.visible[0] == 0.0 < covered.visible[1]


def test_the_best_camera_counts_and_no_camera_shows_what_lies_outside_every_picture():
    left = Camera(
        name="L", position=(0.0, 0.0, 1.5), rpy_deg=(0.0, 0.0, 50.0), hfov_deg=90.0, cast=(200, 100)
    )
    held = traffic([(0, 0, (15.0, y, 1.0), (2.0, 1.0, 1.6), 0.0) for y in (4.0, 1.0)] + [
        (0, 0, (-15.0, 0.0, 1.0), (2.0, 1.0, 1.6), 0.0)
    ])  # fmt: skip
    ahead = left.replace(name="A", rpy_deg=(0.0, 0.0, 0.0))
    one, both = (
        TargetEngine(held).evaluate(Rig(sensors=sensors), TargetSettings(shape="box")).objects
        for sensors in ((left,), (left, ahead))
    )
    assert 0.0 < one.visible[1] < 1.0 == both.visible[1]
    assert both.visible[2] == 0.0
