"""The targets engine against every ray and every box, equal to the last count."""

import numpy as np
import pytest

from riglens.core.geometry import Pose
from riglens.core.kernels.objects.returns import MOST_RAYS
from riglens.core.kernels.rays.tiles import OWN_RAYS
from riglens.core.metric.scores import Body
from riglens.core.rig.library import default_library, sensor_from_model
from riglens.core.rig.model import BrownConrady, Camera, Rig
from riglens.core.sensors.radar import Radar, RadarScan
from riglens.core.sensors.ultrasonic import Ultrasonic
from riglens.core.targets.beams import beams_of
from riglens.core.targets.counts import Counted
from riglens.core.targets.engine import TargetEngine
from riglens.core.targets.settings import EXACT, TargetSettings
from riglens.core.targets.traffic import Traffic
from riglens.core.vehicle.housings import car_of
from tests.core.builders import rig_of, spinning
from tests.core.targets import brute_force
from tests.core.targets.cases import random_rig, random_traffic, rig_of_every_kind, traffic


def check(held: Traffic, rig: Rig, settings: TargetSettings = EXACT) -> Counted:
    everything, solid = held.within(1e6), car_of(rig) if settings.body == "blocks" else None
    scores = TargetEngine(everything).evaluate(rig, settings)
    truth, found = brute_force.count(everything, rig, settings, solid=solid), scores.objects
    lidar, camera = (
        np.array([sensor.kind == kind for sensor in rig.sensors]) for kind in ("lidar", "camera")
    )
    for kind, returns in found.returns.items():
        mine = np.array([sensor.kind == kind for sensor in rig.sensors])
        np.testing.assert_array_equal(returns.counts, truth.rays[:, mine])
    per_ray = np.array([np.divide(c.image, c.resolution) for c in rig.enabled_cameras()]).reshape(-1, 2)
    scale, height = per_ray.prod(axis=1), per_ray[:, 1]
    np.testing.assert_array_equal(found.points, truth.rays[:, lidar])
    np.testing.assert_array_equal(found.pixels, truth.rays[:, camera] * scale)
    np.testing.assert_array_equal(found.points_alone, truth.alone[:, lidar].sum(axis=1))
    np.testing.assert_array_equal(found.pixels_alone, (truth.alone[:, camera] * scale).sum(axis=1))
    np.testing.assert_array_equal(found.height_px, (truth.rows[:, camera] * height).max(axis=1, initial=0.0))
    np.testing.assert_array_equal(found.cells, truth.cells)
    return scores


@pytest.mark.parametrize("seed", range(12))
def test_random_rigs_in_random_frames(seed):
    rng = np.random.default_rng(seed)
    scores = check(random_traffic(rng, 4), random_rig(rng, 6))
    assert scores.objects.all_points.sum() > 0


@pytest.mark.parametrize("seed", range(3))
def test_random_phases_shift_the_rays_of_the_oracle_as_well(seed):
    rng = np.random.default_rng(100 + seed)
    settings = TargetSettings(shape="box", range_law=False, seed=seed)
    check(random_traffic(rng, 4), random_rig(rng, 5), settings)


@pytest.mark.parametrize("seed", range(8))
def test_road_users_of_several_parts(seed):
    """In every other case with rays that get lost or pass through glass."""
    rng = np.random.default_rng(300 + seed)
    settings = TargetSettings(shape="class", range_law=seed % 2 == 1, seed=seed)
    check(random_traffic(rng, 4), random_rig(rng, 5), settings)


@pytest.mark.parametrize("seed", range(4))
def test_pictures_wider_than_a_word_of_bits(seed):
    """Pinholes, whose rays are told by outlines; one of 1 x 200 and one upright, whose rows run along the horizon."""
    rng = np.random.default_rng(400 + seed)
    settings = TargetSettings(shape=("box", "class")[seed % 2], range_law=False)
    upright = {"position": (0.5, 0.0, 1.5), "rpy_deg": (0.0, 0.0, float(rng.uniform(-180.0, 180.0)))}
    turned = {"position": (0.0, 0.5, 1.8), "rpy_deg": tuple(rng.uniform(-30.0, 30.0, 3).tolist())}
    rig = Rig(
        sensors=(
            Camera(name="upright", **upright, hfov_deg=90.0, cast=(191, 41)),
            Camera(name="turned", **turned, hfov_deg=110.0, cast=(128, 30)),
            Camera(name="thin", **turned, hfov_deg=60.0, cast=(200, 1)),
        )
    )
    assert check(random_traffic(rng, 5, 30), rig, settings).objects.pixels.sum() > 0


@pytest.mark.parametrize("hfov_deg", [70.0, 170.0])
def test_pictures_of_what_stands_beside_the_camera(hfov_deg):
    """Boxes that reach from before the camera to behind it, as cars in the next lane do, some of them very near."""
    rng = np.random.default_rng(int(hfov_deg))
    sizes = rng.uniform([3.0, 0.5, 1.0], [30.0, 3.0, 4.0], (40, 3))
    boxes = []
    for number, size in enumerate(sizes):
        aside = rng.choice([-1.0, 1.0]) * (0.03 + size[1] / 2.0 + rng.uniform(0.0, 3.0))
        boxes.append(
            (number // 4, 0, (rng.uniform(-6.0, 6.0), aside, 1.0), tuple(size), rng.uniform(-0.3, 0.3))
        )
    place = {"position": (0.0, 0.0, 1.3), "rpy_deg": (3.0, -4.0, 5.0)}
    rig = Rig(sensors=(Camera(name="camera", **place, hfov_deg=hfov_deg, cast=(150, 60)),))
    settings = TargetSettings(shape="class", range_law=False)
    assert check(traffic(boxes, 10), rig, settings).objects.pixels.sum() > 0


@pytest.mark.parametrize("off", [-1e-12, 0.0, 1e-12])
def test_boxes_with_edges_along_rays_of_a_picture(off):
    """Rays that miss or enter a box by less than the outline can tell are tried one by one."""
    place = {"position": (0.0, 0.0, 1.0), "fx": 32.0, "fy": 32.0, "cx": 32.0, "cy": 24.0}
    rig = Rig(sensors=(Camera(name="camera", **place, image=(64, 48), cast=(64, 48)),))
    boxes = []
    for number, (ahead, column) in enumerate([(4.0, 3), (8.0, 12), (6.0, 20)]):
        wide = 2.0 * ahead * (column + 0.5) / 32.0 * (1.0 + off)
        boxes.append((number, 0, (ahead + 1.0, 0.0, 1.0), (2.0, wide, 0.9), 0.0))
    settings = TargetSettings(shape="box", range_law=False)
    assert check(traffic(boxes, 3), rig, settings).objects.pixels.all()


def test_a_frame_of_thousands_of_boxes():
    """More than are compared with each other: one begins near and reaches far, so that no distance settles anything."""
    rng, wall = np.random.default_rng(9), (0, 0, (0.0, -4.0, 1.0), (300.0, 0.5, 2.0), 0.0)
    places = rng.uniform([-50.0, 2.0, 0.5], [50.0, 55.0, 1.5], (4_400, 3))
    boxes = [(0, 2, tuple(place.tolist()), (0.4, 0.4, 1.0), 0.3) for place in places]
    sensors = spinning((0.0, 0.0, 1.2), beams=3, count=90), Camera(
        name="camera", position=(0.0, 0.0, 1.2), rpy_deg=(0.0, 0.0, 90.0), hfov_deg=80.0, cast=(20, 4)
    )  # fmt: skip
    assert check(traffic([*boxes, wall]), rig_of(*sensors)).objects.all_points.sum() > 30


def test_a_bent_lens_of_many_rays_is_met_tile_by_tile():
    rng = np.random.default_rng(3)
    eye = Camera(
        name="C", position=(0.3, -0.2, 1.4), rpy_deg=(2.0, 3.0, 30.0), fx=700.0, fy=700.0, cx=790.0, cy=460.0,
        cast=(230, 75), distortion=BrownConrady(k1=-0.1),
    )  # fmt: skip
    assert np.count_nonzero(beams_of(eye).tiles[:, OWN_RAYS]) > 6
    assert check(random_traffic(rng, 2, 9), rig_of(eye)).objects.pixels.sum() > 0


@pytest.mark.parametrize("seed", range(4))
def test_rigs_of_every_kind(seed):
    """Every other one on a solid car."""
    check_every_kind(seed, 5)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(20))
def test_many_rigs_of_every_kind_in_many_frames(seed):
    check_every_kind(1000 + seed, 100)


def check_every_kind(seed, frames):
    rng = np.random.default_rng(seed)
    body: Body = "blocks" if seed % 2 else "ignored"
    settings = TargetSettings(shape=("class", "box")[seed // 2 % 2], range_law=seed % 3 == 0, body=body)
    objects = check(random_traffic(rng, frames, 20), rig_of_every_kind(rng), settings).objects
    assert sum(one.counts.sum() for one in objects.returns.values()) > 0 or frames < 100


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(20))
def test_many_random_rigs_in_many_random_frames(seed):
    rng = np.random.default_rng(1000 + seed)
    check(random_traffic(rng, 200), random_rig(rng, 4))


@pytest.mark.slow
@pytest.mark.parametrize(
    "model", [entry.name for kind in ("lidar", "camera") for entry in default_library().entries(kind)]
)
def test_every_model_of_the_library(model):
    """Tilted a little, so that no window is exact by chance."""
    rng = np.random.default_rng(len(model))
    pose = Pose((0.4, -0.3, 2.1), (1.0, 2.0, 30.0))
    sensor = sensor_from_model(model, "S", pose)
    if isinstance(sensor, Camera):
        sensor = sensor.replace(cast=(352, 128))
    check(random_traffic(rng, 2, 9), Rig(sensors=(sensor,)))


@pytest.mark.parametrize(("seed", "law"), [(0, False), (1, True)])
def test_parts_of_near_road_users_under_dense_sensors(seed, law):
    """So many rays meet them that each part has a window of its own."""
    rng = np.random.default_rng(500 + seed)
    rpy = tuple(rng.uniform([-25.0, -25.0, -180.0], [25.0, 25.0, 180.0]).tolist())
    lidar = spinning((0.3, 0.2, 2.0), rpy if seed else (0.0, 0.0, 0.0), 24, 400)
    camera = Camera(
        name="C", position=(0.0, 0.0, 1.6), rpy_deg=rpy, image=(220, 160), hfov_deg=110.0, cast=(220, 160)
    )
    world, rig = random_traffic(rng, 16, 14), rig_of(lidar, camera)
    found = check(world, rig, TargetSettings(range_law=law))
    assert found.objects.all_points.max() > 100 and found.objects.pixels.max() > 400


@pytest.mark.parametrize("law", [False, True])
def test_an_object_met_by_more_rays_than_are_judged_at_once(law):
    """A car and what hides a part of it, within the range of a LiDAR that gets few returns from its end."""
    world = traffic(
        [(0, 0, (4.0, 0.5, 0.8), (4.5, 1.8, 1.5), 0.4), (0, 2, (2.5, 0.2, 0.9), (0.3, 0.5, 1.8), 0.0)]
    )
    lidar = spinning((0.0, 0.0, 1.6), (1.0, 2.0, 3.0), 60, 900).replace(range_m=(0.0, 9.0))
    settings = TargetSettings(shape="class", range_law=law)
    assert check(world, rig_of(lidar), settings).objects.all_points.max() > 2 * MOST_RAYS


@pytest.mark.parametrize("side", [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1)])
def test_ranges_that_end_within_what_stands_on_every_side(side):
    """Boxes as long as wide as tall, in the direction that sectors and a picture look at; some are out of range."""
    x, y, z = (9.0 * part for part in side)
    rpy = (5.0, 90.0 * side[2], float(np.degrees(np.arctan2(-y, -x))))
    world = traffic([(n, n % 3, (-x, -y, 10.0 - z), (6.0, 6.0, 6.0), 0.2 * n) for n in range(4)], 4)
    sector = {"azimuth_deg": (-40.0, 40.0), "elevation_deg": (-40.0, 40.0)}
    for end in (4.0, 6.5, 8.0, 11.0, 13.5):
        place = {"position": (0.0, 0.0, 10.0), "rpy_deg": rpy, "range_m": (0.0, end)}
        rig = rig_of(
            Camera(name="C", **place, hfov_deg=90.0, cast=(40, 24)),
            Radar(name="R", **place, scans=(RadarScan(**sector, range_m=end),), step_deg=3.0),
            Ultrasonic(name="U", **place, **sector, pole_range_m=end, wall_range_m=end, step_deg=3.0),
            Ultrasonic(name="V", **place, **sector, pole_range_m=0.6 * end, wall_range_m=end, step_deg=0.5),
            Ultrasonic(
                name="W", **place | {"range_m": (0.75 * end, end)}, **sector, pole_range_m=0.6 * end,
                wall_range_m=end, step_deg=0.5,
            ),
        )  # fmt: skip
        found = check(world, rig, TargetSettings(shape="box", range_law=False))
        assert bool(found.objects.pixels.sum()) == (end > 5.0)
