"""Pictures: every pixel against everything that stands there, the counts of the targets engine, colours."""

from dataclasses import replace

import numpy as np
import pytest

from riglens.core.kernels.objects.pictures import NO_RAY, OWN_CAR, SKY
from riglens.core.kernels.objects.sweeps import GROUND, STATIC
from riglens.core.rig.model import Camera, Rig
from riglens.core.sensing.body_ends import barrier_of
from riglens.core.sensing.rays import local_directions
from riglens.core.simulate.pictures import LABELS, Cameras, class_labels
from riglens.core.simulate.settings import SimulationSettings
from riglens.core.simulate.world import Worlds
from riglens.core.targets.beams import stops_of
from riglens.core.targets.engine import TargetEngine
from riglens.core.vehicle.solid import solid_of
from tests.core.simulate import every_ray
from tests.core.simulate.small import BARE, CAMERA, rig, road_users
from tests.core.targets.cases import random_rig, random_traffic


def wide(camera: Camera) -> Camera:
    """From 0 to infinity, as real cameras see."""
    return camera.model_copy(update={"range_m": (0.0, np.inf)})


@pytest.mark.parametrize("seed", range(5))
def test_every_pixel_against_everything_that_stands_there(seed: int) -> None:
    rng = np.random.default_rng(40 + seed)
    settings = SimulationSettings(seed, clutter=25, ground="flat", body="blocks" if seed % 2 else "ignored")
    some = tuple(wide(camera) for camera in random_rig(rng, 8).enabled_cameras())
    cameras = (CAMERA, *some, CAMERA.model_copy(update={"name": "low", "position": (0.3, 0.0, 1.5)}))
    of = Rig(name="cameras", sensors=cameras)
    world = random_traffic(rng, 2)
    worlds = Worlds(replace(world, size_m=world.size_m.clip(max=4.0)), settings)
    solid, seen = solid_of(of.vehicle) if seed % 2 else None, set[int]()
    drawn = Cameras(of, worlds, is_native=False)
    assert cameras
    for number, camera in enumerate(cameras):
        picture, here = drawn.picture(number, 1), worlds.world(1)
        local = local_directions(camera, np.arange(camera.ray_count))
        exists = ~np.isnan(local[:, 0])
        d = np.nan_to_num(local) @ camera.pose.rotation().T
        d[~exists] = [0.0, 0.0, 1.0]
        origin = np.array(camera.position)
        entry, _ = every_ray.entries(here, origin, d, camera.range_m)
        part = entry.argmin(axis=1)
        t, box = entry.min(axis=1), every_ray.parts_of_world(here).box[part]
        what = np.where(box < here.reflectivity.users, box, STATIC)
        ground = every_ray.ground_m(here, origin, d)
        what = np.where(np.isfinite(t), what, np.where(np.isfinite(ground), GROUND, SKY))
        t = np.where(np.isfinite(t), t, ground)
        if solid is not None:
            ends = stops_of(camera, barrier_of(camera, solid))
            if len(ends):
                what, t = (
                    np.where(ends <= t, np.where(np.isfinite(ends), OWN_CAR, what), what),
                    np.minimum(t, ends),
                )
        what = np.where(exists, what, NO_RAY)
        np.testing.assert_array_equal(picture.what.ravel(), what)
        depth = np.where(
            exists & np.isfinite(t), np.where(np.isfinite(t), t, 0.0) * np.nan_to_num(local[:, 0]), np.inf
        )
        np.testing.assert_allclose(picture.depth_m.ravel(), depth, rtol=1e-4)
        seen |= set(np.minimum(what, 0).tolist())
    assert seen >= {0, STATIC, GROUND, SKY} and (OWN_CAR in seen) == (solid is not None)


def test_pixels_on_road_users_are_those_that_the_targets_engine_counts() -> None:
    world, of = road_users().within(1e6), rig()
    counted = TargetEngine(world).evaluate(of, BARE.targets()).objects
    drawn, worlds = Cameras(of, Worlds(world, BARE), is_native=False), Worlds(world, BARE)
    pixels, alone = np.zeros((2, len(world.cls)))
    for frame in range(world.frames):
        picture, row = drawn.picture(0, frame), worlds.truth(frame).row
        pixels[row], alone[row] = (
            picture.pixels * 4,
            picture.alone * 4,
        )  # a pixel of the lattice is four native ones
        for user, (x0, y0, x1, y1) in enumerate(picture.bounds_px.tolist()):
            rows, columns = np.nonzero(picture.what == user)
            assert len(rows) == picture.pixels[user]
            if len(rows):
                assert (x0, x1, y0, y1) == (columns.min(), columns.max() + 1, rows.min(), rows.max() + 1)
    place = world.row[counted.box]
    np.testing.assert_array_equal(pixels[place], counted.pixels[:, 0])
    np.testing.assert_array_equal(alone[place], counted.pixels_alone)
    assert pixels.sum() > 1000


def test_things_stand_out_from_the_road_and_the_same_seed_paints_the_same() -> None:
    """Sky above, road below, and no road user in the colour of the road behind it."""
    world, of = road_users(), rig()
    one, other = (Cameras(of, Worlds(world, SimulationSettings(seed=2))).picture(0, 3) for _ in range(2))
    assert one.rgb.tobytes() == other.rgb.tobytes() and one.rgb.shape == (90, 160, 3)
    assert one.what[0, 0] == SKY and one.rgb[0, 0, 2] > one.rgb[0, 0, 0] + 20  # blue
    assert one.what[-1, 80] == GROUND
    road = one.rgb[-1, 80].astype(int)
    for user in np.flatnonzero(one.pixels > 20).tolist():
        assert np.abs(one.rgb[one.what == user].mean(axis=0) - road).max() > 8
        assert one.rgb[one.what == user].max(axis=0).min() > 30, "lit from somewhere"


def test_labels_of_every_kind() -> None:
    what = np.array([[NO_RAY, OWN_CAR, SKY, STATIC, GROUND, 0, 1, 2]], np.int32)
    names = [LABELS[k] for k in class_labels(what, np.array([2, 0, 1], np.uint8))[0]]
    assert names == ["none", "own car", "sky", "static", "ground", "pedestrian", "car", "bicycle"]
