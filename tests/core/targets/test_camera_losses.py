"""What hides objects from cameras, against rays and directions followed one by one."""

from dataclasses import replace

import numpy as np
import pytest

from riglens.core.figures.heatmaps import LOST_BEHIND_CAR, LOST_BEHIND_TRAFFIC, LOST_OUTSIDE
from riglens.core.rig.model import Camera, Rig
from riglens.core.targets.camera_losses import CameraLosses
from riglens.core.targets.counts import Counted
from riglens.core.targets.engine import TargetEngine
from riglens.core.targets.settings import TargetSettings
from riglens.core.targets.traffic import Traffic
from riglens.core.vehicle.solid import solid_of
from tests.core.builders import rig_of, spinning
from tests.core.targets import brute_force
from tests.core.targets.cases import random_traffic, traffic
from tests.core.targets.test_truncation import share_in_picture

SETTINGS = TargetSettings(shape="box", range_law=False, body="blocks")
RIG = Rig(
    sensors=tuple(
        Camera(name=f"C{yaw:g}", position=(x, y, z), rpy_deg=(0.0, 5.0, yaw), hfov_deg=fov, cast=(90, 60))
        for x, y, z, yaw, fov in (
            (-0.6, 0.0, 1.5, 0.0, 110.0),
            (0.2, 0.5, 1.46, 80.0, 90.0),
            (-0.2, -0.4, 1.5, -150.0, 70.0),
        )
    )
)


def losses(held: Traffic, rig: Rig, settings: TargetSettings = SETTINGS) -> tuple[Counted, CameraLosses]:
    counted = TargetEngine(held, 1).evaluate(rig, settings, with_losses=True)
    assert counted.losses is not None
    return counted, counted.losses


@pytest.mark.parametrize("case", range(3))
def test_each_share_is_that_of_rays_and_directions_one_by_one(case: int) -> None:
    rng = np.random.default_rng(90 + case)
    held = random_traffic(rng, 16, 12).within(1e6)
    counted, found = losses(held, RIG)
    solid = solid_of(RIG.vehicle)
    free, blocked = (
        brute_force.count(held, RIG, SETTINGS),
        brute_force.count(held, RIG, SETTINGS, solid=solid),
    )
    cameras, misses, kinds = RIG.enabled_cameras(), list[np.ndarray](), np.zeros(3)
    for place, box in enumerate(counted.objects.box.tolist()):
        parts = []
        for column, camera in enumerate(cameras):
            alone, left, seen = free.alone[box, column], free.rays[box, column], blocked.rays[box, column]
            inside = share_in_picture(held, camera, box, SETTINGS, rng) if alone else 0.0
            parts.append(inside * np.array([alone, left, seen]) / max(alone, 1))
        shares = np.array(parts)
        is_near = np.sort(shares[:, 2])[-1] - np.sort(shares[:, 2])[-2] < 0.1
        if is_near and shares[:, 0].max() > 0.0:
            continue  # drawn directions do not tell which camera shows most
        best = shares[int(shares[:, 2].argmax() if shares.any() else 0)]
        expected = np.array([1.0 - best[0], best[0] - best[1], best[1] - best[2]])
        misses.append(expected - [found.outside[place], found.traffic[place], found.car[place]])
        kinds += expected > 0.0
    assert np.abs(misses).max() < 0.08 and np.abs(np.mean(misses, axis=0)).max() < 5e-3
    assert (kinds > 0).all(), "edge, traffic and car all hide something"


@pytest.mark.parametrize("threads", [1, 2])
def test_losses_and_the_visible_share_add_up_and_figures_stay_as_they_are(threads: int) -> None:
    held = random_traffic(np.random.default_rng(3), 30)
    plain = TargetEngine(held, threads).evaluate(RIG, SETTINGS)
    counted = TargetEngine(held, threads).evaluate(RIG, SETTINGS, with_losses=True)
    assert plain.losses is None and counted.losses is not None
    assert (plain.objects.shown == counted.objects.shown).all()
    found = counted.losses
    total = found.outside + found.traffic + found.car + counted.objects.visible
    assert np.abs(total - 1.0).max() < 1e-12
    assert min(one.min() for one in (found.outside, found.traffic, found.car)) >= 0.0
    part = TargetEngine(held, threads).evaluate(RIG, SETTINGS, range(7, 19), with_losses=True)
    where = np.isin(counted.objects.box, part.objects.box)
    assert part.losses is not None and (part.losses.traffic == found.traffic[where]).all()


def test_a_hidden_object_is_lost_to_traffic_and_one_outside_every_picture_to_its_edge() -> None:
    wall, far = ((8.0, 0.0, 1.5), (1.0, 6.0, 3.0)), ((20.0, 0.0, 1.0), (1.0, 1.0, 1.0))
    behind = ((-20.0, 0.0, 1.0), (1.0, 1.0, 1.0))
    held = traffic([(0, 0, centre, size, 0.0) for centre, size in (far, wall, behind)])
    eye = Camera(name="C", position=(0.0, 0.0, 1.8), hfov_deg=60.0, cast=(90, 50))
    _, found = losses(held, rig_of(eye), replace(SETTINGS, body="ignored"))
    assert found.traffic.tolist() == pytest.approx([1.0, 0.0, 0.0])
    assert found.outside.tolist() == pytest.approx([0.0, 0.0, 1.0], abs=0.02)
    assert not found.car.any()


def test_a_rig_without_cameras_loses_nothing_that_could_be_shown() -> None:
    counted, found = losses(random_traffic(np.random.default_rng(3), 5), rig_of(spinning((0.0, 0.0, 1.9))))
    assert np.isnan(found.outside).all() and len(found.outside) == len(counted.objects.box)
    for heat in (LOST_OUTSIDE, LOST_BEHIND_TRAFFIC, LOST_BEHIND_CAR):
        assert np.isnan(heat.figure.values(counted)).all()
