"""Several sweeps: objects that move smear, what stands stays, however the car drives."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

import numpy as np
import pytest

from riglens.core.errors import InputError
from riglens.core.geometry import Pose
from riglens.core.rig.library import sensor_from_model
from riglens.core.rig.model import Rig
from riglens.core.scene.boxes import DataReport, FrameLabels, rotations_from_yaw
from riglens.core.scene.occluders import MapPose
from riglens.core.simulate.motion import Motion, motion_of
from riglens.core.simulate.settings import SimulationSettings
from riglens.core.simulate.sweeps import GROUND, STATIC, Simulator, Sweep
from riglens.core.simulate.world import Worlds
from riglens.core.targets.traffic import Traffic, traffic_of

SIZES = np.array([[4.4, 1.9, 1.5], [4.2, 1.8, 1.5], [0.6, 0.6, 1.8]])
"""A car that drives, one that is parked, and a pedestrian who walks; all seen from a car that turns."""
CAR_MS, TURN_RAD_S, DRIVES_MS, WALKS_MS = 10.0, 0.2, 5.0, 1.5
POSES = {("drive", k): MapPose("town", (2.0 * k * CAR_MS, 0.0, 0.0), 2.0 * k * TURN_RAD_S) for k in range(3)}


def traffic(kept: tuple[int, ...] = (0, 1, 2)) -> Traffic:
    """Three frames two seconds apart, without the objects that are left out in the first."""
    frame, cls, centre, rotation = [], [], [], []
    for k in range(3):
        pose = POSES["drive", k]
        turn = rotations_from_yaw(np.array([pose.yaw_rad]))[0]
        at = np.array(
            [
                [30.0 + DRIVES_MS * 2 * k, 8.0, 0.75],
                [25.0, -6.0, 0.75],
                [20.0, 5.0 + WALKS_MS * 2 * k, 0.9],
            ]
        )
        for place in range(3) if k else kept:
            frame.append(k)
            cls.append((0, 0, 2)[place])
            centre.append((at[place] - pose.position_m) @ turn)
            rotation.append(turn.T)
    size = np.array([SIZES[place] for k in range(3) for place in (range(3) if k else kept)])
    labels = FrameLabels(("drive",), np.zeros(3, np.int64), np.arange(3))
    report = DataReport("three frames", 3, {}, sha256="three", sequences=1, labels=labels)
    return traffic_of(
        report, np.array(frame), np.array(cls, np.uint8), np.array(centre), size, np.array(rotation)
    )


def on_map(traffic: Traffic, motion: Motion, k: int) -> tuple[np.ndarray, np.ndarray]:
    """Velocities of the car (2,) and of the boxes (n, 2) of frame k in the map."""
    place = int(np.flatnonzero(traffic.frame == k)[0])
    turn = rotations_from_yaw(np.array([POSES["drive", k].yaw_rad]))[0, :2, :2]
    boxes = slice(traffic.starts[place], traffic.starts[place + 1])
    return motion.car_m_s[place] @ turn.T, motion.boxes_m_s[boxes] @ turn.T


@pytest.mark.parametrize("k", [0, 1, 2])
def test_velocities_are_those_between_frames(k: int) -> None:
    told = traffic()
    motion = motion_of(told, POSES, 2.0)
    car, boxes = on_map(told, motion, k)
    assert car == pytest.approx([CAR_MS, 0.0])
    assert motion.turn_rad_s == pytest.approx([TURN_RAD_S] * 3)
    assert boxes == pytest.approx(np.array([[DRIVES_MS, 0.0], [0.0, 0.0], [0.0, WALKS_MS]]))


def test_an_object_that_was_not_there_moves_as_until_the_next_frame() -> None:
    told = traffic(kept=(1, 2))
    _, boxes = on_map(told, motion_of(told, POSES, 2.0), 1)
    assert boxes[0] == pytest.approx([DRIVES_MS, 0.0])


def test_a_missing_pose_is_one_line() -> None:
    with pytest.raises(InputError, match="need the pose of the car in every frame"):
        motion_of(traffic(), {}, 2.0)
    without = replace(traffic(), data=replace(traffic().data, labels=None))
    with pytest.raises(InputError, match="needs named sequences"):
        motion_of(without, POSES, 2.0)


def sweep(ago: int, settings: SimulationSettings, k: int = 1) -> Sweep:
    told = traffic()
    roof = sensor_from_model("velodyne-vlp-32c", "LIDAR", Pose((0.0, 0.0, 1.9), (0.0, 0.0, 0.0)))
    worlds = Worlds(told, settings, motion_of(told, POSES, 2.0))
    return Simulator(Rig(name="roof", sensors=(roof,)), worlds).sweep(k, ago)


def middle(of: Sweep, place: int) -> np.ndarray:
    """Middle of the extent of an object's points."""
    points = of.points_m[of.object == place]
    assert len(points) > 40
    return np.asarray((points.min(axis=0) + points.max(axis=0)) / 2)


def test_earlier_sweeps_show_objects_where_they_were_and_standing_ones_in_place() -> None:
    bare = SimulationSettings(noise_m=0.0, dropout=0.0, clutter=0, range_law=False)
    now, then = sweep(0, bare), sweep(5, bare)
    turn = rotations_from_yaw(np.array([POSES["drive", 1].yaw_rad]))[0, :2, :2]
    for place, ms in enumerate(([DRIVES_MS, 0.0], [0.0, 0.0], [0.0, WALKS_MS])):
        gone = (middle(now, place) - middle(then, place))[:2] @ turn.T
        assert gone == pytest.approx(0.5 * np.array(ms), abs=0.25), place


def test_clutter_and_the_ground_stay_where_they_are() -> None:
    rough = SimulationSettings(noise_m=0.0, dropout=0.0, clutter=200, range_law=False)
    then, world = sweep(3, rough), Worlds(traffic(), rough).world(1)
    ground = then.points_m[then.object == GROUND].astype(np.float64)
    x, y, z = ground[np.hypot(*ground[:, :2].T) < 20.0].T
    bumps = sum(a * np.sin(u * x + v * y + phase) for a, u, v, phase in world.surface.waves)
    assert len(z) > 1000 and z == pytest.approx(world.surface.height + bumps, abs=0.02)
    points = then.points_m[then.object == STATIC].astype(np.float64)
    inside = np.zeros(len(points), np.bool_)
    for centre, half, turn in zip(*world.boxes[1:4], strict=True):
        inside |= (np.abs((points - centre) @ turn) <= half + 0.3).all(axis=1)
    assert len(points) > 100 and inside.all()


@pytest.mark.parametrize("ground", ["none", "flat", "uneven"])
def test_things_stand_on_the_ground_below_them(ground: Literal["none", "flat", "uneven"]) -> None:
    world = Worlds(traffic(), SimulationSettings(clutter=200, ground=ground)).world(1)
    scattered = world.kind >= 0
    centres, half = (of[-len(world.kind) :][scattered] for of in (world.boxes.centres, world.boxes.halves))
    bumps = [
        sum(a * np.sin(u * x + v * y + phase) for a, u, v, phase in world.surface.waves)
        for x, y in centres[:, :2]
    ]
    assert scattered.sum() > 100 and (np.ptp(bumps) > 0.01) == (ground == "uneven")
    assert centres[:, 2] - half[:, 2] == pytest.approx(world.surface.height + np.array(bumps), abs=1e-9)


def test_sweeps_of_a_frame_have_noise_of_their_own() -> None:
    usual = SimulationSettings(clutter=0)
    assert (sweep(0, usual).points_m == sweep(0, usual).points_m).all()
    assert len(sweep(1, usual).points_m) != len(sweep(2, usual).points_m)
