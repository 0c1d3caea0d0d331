"""What cameras tell of points: against the points' own classes from one place, and each error of the segmentation."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from riglens.core.rig.model import Camera, Rig
from riglens.core.simulate.painting import QUALITIES, Painter, Segmentation
from riglens.core.simulate.settings import SimulationSettings
from riglens.core.simulate.sweeps import STATIC, Simulator, Sweep
from riglens.core.simulate.world import Worlds
from tests.core.simulate.small import lidar, road_users

FLAWLESS = Segmentation(top=1.0, half_px=1e-9, mistaken=0.0, false_alarms=0.0, aim_px=0.0)
FRAME = 3


def camera(name: str = "CAM", yaw_deg: float = 0.0) -> Camera:
    """A camera at the LiDAR's position: both see the same objects; without the range law glass stops both."""
    return Camera(
        name=name, position=(0.0, 0.3, 1.9), rpy_deg=(0.0, 0.0, yaw_deg), hfov_deg=110.0, image=(1600, 900)
    )


@pytest.fixture(scope="module")
def worlds() -> Worlds:
    return Worlds(road_users(users=40), SimulationSettings(seed=3, clutter=300, noise_m=0.0, range_law=False))


@pytest.fixture(scope="module")
def sweep(worlds: Worlds) -> Sweep:
    return Simulator(Rig(name="eye", sensors=(lidar("left", 0.0),)), worlds).sweep(FRAME)


def painted(worlds: Worlds, sweep: Sweep, how: Segmentation, *cameras: Camera) -> np.ndarray:
    rig = Rig(name="eye", sensors=cameras or (camera(),))
    return Painter(rig, worlds, how).scores(FRAME, sweep.points_m)


def kinds(worlds: Worlds, sweep: Sweep) -> np.ndarray:
    """0 for what is no road user, else 1 + class, of each point."""
    own = worlds.truth(FRAME).cls[np.maximum(sweep.object, 0)].astype(int)
    return np.where(sweep.object >= 0, own + 1, 0)


def test_from_one_place_points_get_their_own_classes_but_at_edges(worlds: Worlds, sweep: Sweep) -> None:
    scores, kind = painted(worlds, sweep, FLAWLESS), kinds(worlds, sweep)
    seen = scores[:, 0] == 1.0
    off_deg = np.degrees(np.arctan2(sweep.points_m[:, 1] - 0.3, sweep.points_m[:, 0]))
    assert (np.abs(off_deg[seen]) < 55.01).all() and not scores[~seen].any()
    up = np.abs(sweep.points_m[:, 2] - 1.9) < 0.39 * sweep.points_m[:, 0]  # 42.7 degrees high in the middle
    assert seen[(np.abs(off_deg) < 54.9) & up].all()
    said = np.where(scores[:, 1:].any(axis=1), scores[:, 1:].argmax(axis=1) + 1, 0)
    users = seen & (kind > 0)
    assert len(np.unique(kind[users])) == 3 and users.sum() > 200
    assert (said == kind)[users].mean() > 0.9
    assert (said == kind)[seen & (kind == 0)].mean() > 0.99


def test_what_is_missed_mistaken_or_an_alarm(worlds: Worlds, sweep: Sweep) -> None:
    kind, own = kinds(worlds, sweep), painted(worlds, sweep, FLAWLESS)
    missed = painted(worlds, sweep, replace(FLAWLESS, top=0.0))
    assert (missed[:, 0] == own[:, 0]).all() and not missed[:, 1:].any()
    small = painted(worlds, sweep, replace(FLAWLESS, half_px=1e9))
    assert not small[:, 1:].any()
    mistaken = painted(worlds, sweep, replace(FLAWLESS, mistaken=1.0))
    assert (mistaken[:, 1:].sum(axis=1) == own[:, 1:].sum(axis=1)).all()
    assert not (mistaken[:, 1:] * own[:, 1:]).any()
    alarms = painted(worlds, sweep, replace(FLAWLESS, false_alarms=1.0))
    things = (sweep.object == STATIC) & (own[:, 0] == 1.0) & ~own[:, 1:].any(axis=1)
    assert things.sum() > 50 and alarms[things, 1:].any(axis=1).mean() > 0.9
    ground = (kind == 0) & ~things & (own[:, 0] == 1.0)
    assert (alarms[ground] == own[ground]).all(axis=1).mean() > 0.95


def test_an_error_of_aim_moves_labels_at_edges_alone(worlds: Worlds, sweep: Sweep) -> None:
    own, shifted = painted(worlds, sweep, FLAWLESS), painted(worlds, sweep, replace(FLAWLESS, aim_px=12.0))
    differ = (own != shifted).any(axis=1).mean()
    assert 0.0 < differ < 0.1


def test_several_cameras_are_averaged_and_each_errs_on_its_own(worlds: Worlds, sweep: Sweep) -> None:
    how = replace(FLAWLESS, top=0.5)
    one, two = camera("one"), camera("two", 20.0)
    alone = [painted(worlds, sweep, how, eye) for eye in (one, two)]
    both = painted(worlds, sweep, how, one, two)
    looks = alone[0][:, :1] + alone[1][:, :1]
    assert (both[:, :1] == np.minimum(looks, 1.0)).all()
    np.testing.assert_array_equal(both[:, 1:] * np.maximum(looks, 1.0), alone[0][:, 1:] + alone[1][:, 1:])
    assert set(np.unique(both[:, 1:])) == {0.0, 0.5, 1.0}
    assert (painted(worlds, sweep, how, one, two) == both).all()


def test_the_qualities_are_in_order_and_a_height_of_half_px_halves_what_is_found() -> None:
    heights = np.array([0.0, 5.0, 20.0, 35.0, 1e6])
    good, usual, poor = (QUALITIES[name].found(heights) for name in ("good", "usual", "poor"))
    assert good[0] == usual[0] == poor[0] == 0.0
    assert (good[1:] > usual[1:]).all() and (usual[1:] > poor[1:]).all() and (np.diff(good) > 0.0).all()
    assert usual[2] == pytest.approx(0.95 / 2) and poor[3] == pytest.approx(0.85 / 2)
    assert usual[4] == pytest.approx(0.95)
