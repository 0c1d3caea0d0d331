"""Rays of LiDARs and of cameras on plain boxes against Open3D's RaycastingScene (Embree), where that is installed."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from riglens.core.rig.model import Sensor
from riglens.core.scene.readers.bundled import bundled_source
from riglens.core.sensing.rays import sensor_rays
from riglens.core.targets.engine import TargetEngine, warm_up
from riglens.core.targets.settings import TargetSettings
from riglens.core.targets.traffic import Traffic, read_traffic
from tests.bench.race import Goal, Race
from tests.bench.scenes import wide_trapezoid

FRAMES = 100
PLAIN = TargetSettings(shape="box", range_law=False, phase="0", body="ignored")
CORNERS = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
SIDES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
TRIANGLES = np.array([three for a, b, c, d in SIDES for three in ((a, b, c), (a, c, d))], np.uint32)


@pytest.mark.parametrize("kind", ["lidar", "camera"])
def test_rays_on_boxes(race: Race, kind: str) -> None:
    """One thread each; the peer's scenes are built before, and both count the rays that first meet each object."""
    peer: Any = pytest.importorskip("open3d", reason="pip install open3d, or a folder of it in PYTHONPATH")
    warm_up(1)
    traffic = read_traffic(bundled_source())
    both = wide_trapezoid()
    sensors = tuple(sensor for sensor in both.sensors if sensor.kind == kind)
    rig = both.model_copy(update={"sensors": sensors})
    per_ray = np.prod([np.divide(one.image, one.resolution) for one in rig.enabled_cameras()], axis=1)
    rays = np.concatenate([_rays_of(sensor) for sensor in sensors])
    scenes = [_scene(peer, traffic, frame) for frame in range(FRAMES)]

    def ours(_: int) -> NDArray[np.int64]:
        found = TargetEngine(traffic, 1).evaluate(rig, PLAIN, FRAMES).objects
        return (
            found.all_points if kind == "lidar" else np.rint((found.pixels / per_ray).sum(axis=1)).astype(int)
        )

    def theirs(_: int) -> NDArray[np.int64]:
        hits = [
            scene.cast_rays(peer.core.Tensor(rays), nthreads=1)["geometry_ids"].numpy() for scene in scenes
        ]
        found = [
            np.bincount(one[one < number], minlength=number)
            for one, number in zip(hits, numbers, strict=True)
        ]
        return np.concatenate(found)[traffic.counts[: traffic.starts[FRAMES]]]

    numbers = np.diff(traffic.starts[: FRAMES + 1]).tolist()
    mine, its = ours(0), theirs(0)
    differ = f"{np.count_nonzero(mine != its)} of {np.count_nonzero(its)} objects met differ"
    by = f"{np.abs(mine - its).sum()} of {its.sum():,} rays"
    work = f"{kind}s of W+T on plain boxes, {FRAMES} frames, one thread; {differ}, by {by}"
    race.run(Goal("peer", work, 2.0), iter(range(1000)), ours, theirs)


def _rays_of(sensor: Sensor) -> NDArray[np.float32]:
    found = sensor_rays(sensor)
    starts = np.broadcast_to(found.origin_m, found.directions.shape)
    return np.concatenate([starts, found.directions], axis=1).astype(np.float32)


def _scene(peer: Any, traffic: Traffic, frame: int) -> Any:
    """Return the boxes of a frame, numbered as they come in the data."""
    scene = peer.t.geometry.RaycastingScene(nthreads=1)
    for box in range(traffic.starts[frame], traffic.starts[frame + 1]):
        corners = traffic.centre_m[box] + (CORNERS * traffic.half_m[box]) @ traffic.rotation[box].T
        scene.add_triangles(peer.core.Tensor(corners.astype(np.float32)), peer.core.Tensor(TRIANGLES))
    return scene
