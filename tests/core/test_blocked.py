"""Blocked sectors: no ray goes there, whatever the sensor, and everything else stays."""

from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from riglens.core.engine.audit import audit
from riglens.core.engine.engine import Engine
from riglens.core.engine.sight import sight
from riglens.core.errors import InputError
from riglens.core.formats.exchange import FORMATS, writable
from riglens.core.geometry import Pose
from riglens.core.metric.scores import MetricSettings
from riglens.core.rig.edits import damaged, in_step, linked
from riglens.core.rig.library import sensor_from_model
from riglens.core.rig.model import BrownConrady, Camera, Lidar, LinearAngles, Rig, Sensor
from riglens.core.rig.yaml.file import dumps, loads, new_rig_file, rig_sha256
from riglens.core.sensing.rays import local_directions, missing_ray_count, sensor_rays
from riglens.core.sensors.base import HALVES, Blocked
from riglens.core.sensors.radar import Radar, RadarScan
from riglens.core.sensors.ultrasonic import Ultrasonic
from riglens.core.simulate.settings import SimulationSettings
from riglens.core.simulate.sweeps import Simulator
from riglens.core.simulate.world import Worlds
from riglens.core.targets.engine import TargetEngine
from riglens.core.targets.settings import EXACT
from riglens.core.vehicle.solid import solid_of
from riglens.core.view.frames import FrameBoxes
from riglens.core.view.range_image import range_image
from tests.core.builders import grid_of, random_field, seen_by, seen_ray_by_ray, spinning
from tests.core.targets import brute_force
from tests.core.targets.cases import random_traffic
from tests.core.vehicle.solids import body_ends

GRID = grid_of(40, 40, 8, 0.5)
PLACE: dict[str, Any] = {"position": (0.2, 0.1, 1.7)}
SECTOR = Blocked(azimuth_deg=(-20.0, 35.0), elevation_deg=(-90.0, 5.0))
SENSORS: tuple[Sensor, ...] = (
    spinning((0.2, 0.1, 1.7), (0.0, 0.0, 10.0), beams=12, count=180).replace(name="upright"),
    spinning((0.2, 0.1, 1.7), (5.0, -4.0, 10.0), beams=12, count=500).replace(name="tilted"),
    Lidar(
        name="offsets",
        **PLACE,
        elevations_deg=LinearAngles(from_=-20.0, to=5.0, count=4),
        azimuth_offsets_deg=(0.0, 0.3, 0.0, 0.3),
    ),
    sensor_from_model("livox-avia-pattern", "pattern", Pose((0.2, 0.1, 1.7))),
    Camera(name="pinhole", **PLACE, hfov_deg=90.0, cast=(64, 40)),
    Camera(
        name="bent",
        **PLACE,
        image=(64, 48),
        cast=(64, 48),
        fx=40.0,
        fy=40.0,
        cx=32.0,
        cy=24.0,
        distortion=BrownConrady(k1=-0.1),
    ),
    Radar(
        name="radar",
        **PLACE,
        scans=(
            RadarScan(azimuth_deg=(-9.0, 9.0), elevation_deg=(-7.0, 7.0), range_m=20.0),
            RadarScan(azimuth_deg=(-60.0, 40.0), elevation_deg=(-10.0, 10.0), range_m=9.0),
        ),
    ),
    Ultrasonic(name="sound", **PLACE, azimuth_deg=(-50.0, 60.0)),
)


@pytest.mark.parametrize("sensor", SENSORS, ids=lambda sensor: sensor.name)
def test_the_rays_that_are_left_are_the_same_and_voxels_are_theirs(sensor: Sensor) -> None:
    dirty, every = sensor.replace(blocked=(SECTOR,)), np.arange(sensor.ray_count)
    clean, left = local_directions(sensor, every), local_directions(dirty, every)
    azimuth = np.degrees(np.arctan2(clean[:, 1], clean[:, 0]))
    elevation = np.degrees(np.arcsin(clean[:, 2]))
    inside = (azimuth >= -20.0) & (azimuth <= 35.0) & (elevation <= 5.0)
    assert 0 < inside.sum() < len(inside)
    np.testing.assert_array_equal(np.isnan(left[:, 0]), inside | np.isnan(clean[:, 0]))
    np.testing.assert_array_equal(left[~inside], clean[~inside])
    rays = sensor_rays(dirty)
    assert rays.far_m.size in (1, len(rays.directions))
    field = random_field(GRID, np.random.default_rng(2))
    before, after = seen_by(field, sensor), seen_by(field, dirty)
    np.testing.assert_array_equal(after, seen_ray_by_ray(field, dirty))
    assert after.sum() < before.sum() and not (after & ~before).any()
    assert missing_ray_count(dirty) == missing_ray_count(sensor)


@pytest.mark.parametrize("sensor", SENSORS, ids=lambda sensor: sensor.name)
def test_two_halves_make_a_whole_and_both_blocked_see_nothing(sensor: Sensor) -> None:
    field = random_field(GRID, np.random.default_rng(2))
    halves = [seen_by(field, sensor.replace(blocked=(HALVES[side],))) for side in ("left", "right")]
    whole = seen_by(field, sensor)
    assert not ((halves[0] | halves[1]) & ~whole).any()
    blind = sensor.replace(blocked=(HALVES["left"], HALVES["right"]))
    assert not seen_by(field, blind).any()
    held = random_traffic(np.random.default_rng(1), 2).within(1e6)
    scores = TargetEngine(held).evaluate(Rig(sensors=(blind,)), EXACT)
    assert not any(found.any() for found in scores.objects.detected(1).values())
    with_body = MetricSettings(body="blocks")
    assert Engine(field, 1).evaluate(Rig(sensors=(blind,)), with_body).scores.classes is not None
    assert audit(Engine(field), Rig(sensors=(blind,))) is not None


@pytest.mark.parametrize("seed", range(3))
def test_objects_are_those_of_every_ray_left_against_every_box(seed: int) -> None:
    rng = np.random.default_rng(seed)
    held = random_traffic(rng, 4, 30).within(1e6)
    rig = Rig(sensors=tuple(s.replace(name=f"{n}", blocked=(SECTOR,)) for n, s in enumerate(SENSORS[:6])))
    found, truth = TargetEngine(held).evaluate(rig, EXACT).objects, brute_force.count(held, rig, EXACT)
    assert truth.rays.sum() > 0
    np.testing.assert_array_equal(found.points, truth.rays[:, :4])
    scale = [np.prod(np.divide(c.image, c.resolution)) for c in rig.enabled_cameras()]
    np.testing.assert_array_equal(found.pixels, truth.rays[:, 4:] * scale)
    np.testing.assert_array_equal(found.cells, truth.cells)


def test_ends_at_the_car_are_those_of_the_rays_that_are_left() -> None:
    solid = solid_of(Rig().vehicle)
    for sensor in SENSORS:
        low = sensor.replace(position=(0.0, 0.0, 1.6), rpy_deg=(0.0, 20.0, 0.0))
        dirty = low.replace(blocked=(SECTOR,))
        every = np.arange(low.ray_count)
        exists = ~np.isnan(local_directions(low, every)[:, 0])
        left = ~np.isnan(local_directions(dirty, every)[exists, 0])
        np.testing.assert_allclose(body_ends(dirty, solid), body_ends(low, solid)[left], rtol=1e-12)


def test_pictures_of_a_sensor_lack_what_is_blocked() -> None:
    clean = SENSORS[0]
    assert isinstance(clean, Lidar)
    dirty = clean.replace(blocked=(HALVES["left"],))
    image, whole = (range_image(one, FrameBoxes.none(), solid_of(Rig().vehicle)) for one in (dirty, clean))
    left = (image.azimuths_deg > 0.0) & (image.azimuths_deg < 180.0)
    assert not np.isfinite(image.range_m[:, left]).any()
    right = (image.azimuths_deg < 0.0) & (image.azimuths_deg > -180.0)
    np.testing.assert_array_equal(image.range_m[:, right], whole.range_m[:, right])
    settings = SimulationSettings(noise_m=0.0, dropout=0.0)
    sweeps = [
        Simulator(Rig(sensors=(s,)), Worlds(random_traffic(np.random.default_rng(3), 1), settings)).sweep(0)
        for s in (dirty, clean)
    ]
    assert 0 < len(sweeps[0].ring) < len(sweeps[1].ring)
    seen = {tuple(place) for place in sweeps[1].points_m.tolist()}
    assert all(tuple(place) in seen for place in sweeps[0].points_m.tolist())


def test_a_voxel_there_is_said_to_be_blocked() -> None:
    for sensor in SENSORS:
        dirty = sensor.replace(rpy_deg=(0.0, 0.0, 0.0), blocked=(Blocked(azimuth_deg=(-30.0, 30.0)),))
        assert sight(dirty, GRID, (28, 20, 3), False).verdict == "blocked"
        assert (
            sight(dirty.replace(blocked=tuple(HALVES.values())[:2]), GRID, (28, 20, 3), False).verdict
            == "blocked"
        )


def test_a_rig_file_gives_them_back_and_a_clean_rig_keeps_its_text_and_hash() -> None:
    clean = Rig(sensors=SENSORS)
    dirty = clean.with_sensor("radar", clean.sensor("radar").replace(blocked=(SECTOR, HALVES["upper"])))
    assert "blocked" not in dumps(clean)
    assert loads(dumps(dirty)).rig == dirty
    assert rig_sha256(dirty) != rig_sha256(clean)
    file = new_rig_file(clean).updated(dirty)
    assert "blocked: [{azimuth_deg: [-20.0, 35.0]" in file.text and loads(file.text).rig == dirty
    assert loads(file.updated(clean).text).rig == clean


@pytest.mark.parametrize("name", [name for name in writable() if name != "riglens"])
def test_other_formats_say_that_they_leave_them_out(name: str) -> None:
    report = FORMATS[name].write(Rig(sensors=(SENSORS[4].replace(blocked=(SECTOR,)),))).report
    assert any(line.startswith("ignored: blocked sectors") for line in report.lines())


@pytest.mark.parametrize(
    "sector",
    [{"azimuth_deg": (10.0, -10.0)}, {"elevation_deg": (-95.0, 0.0)}, {"azimuth_deg": (float("nan"), 1.0)}],
)
def test_wrong_sectors_are_refused(sector: dict[str, Any]) -> None:
    with pytest.raises(ValidationError):
        SENSORS[0].replace(blocked=(sector,))


def test_damage_fails_a_sensor_or_blocks_half_of_it() -> None:
    rig = linked(Rig(sensors=(SENSORS[7], SENSORS[7].replace(name="a=b", mirror_of=None))), "sound", "a=b")
    one, other = damaged(rig, ["sound", "a=b=left"]).sensors
    assert not one.enabled and other.enabled and other.blocked == (HALVES["left"],)
    assert not damaged(rig, ["a=b"]).sensors[1].enabled and rig.sensors[1].enabled
    for wrong in ("no", "sound=front", "=left", "sound=", ""):
        with pytest.raises(InputError, match="must be the name of a sensor, or NAME="):
            damaged(rig, [wrong])


def test_mirror_pairs_exchange_left_and_right() -> None:
    radar = SENSORS[6].replace(name="left", position=(1.0, 0.8, 0.5), blocked=(SECTOR,))
    rig = Rig(sensors=(radar, radar.replace(name="right", blocked=())))
    image = linked(rig, "left", "right").sensor("right")
    assert isinstance(image, Radar)
    assert image.blocked[0].azimuth_deg == (-35.0, 20.0)
    assert [scan.azimuth_deg for scan in image.scans] == [(-9.0, 9.0), (-40.0, 60.0)]
    assert image.mirrored().with_pose(radar.pose).replace(name="left", mirror_of=None) == radar
    sound = SENSORS[7]
    assert isinstance(sound, Ultrasonic)
    pair = linked(
        Rig(sensors=(sound, sound.replace(name="other", position=(0.0, -1.0, 0.5)))), "sound", "other"
    )
    turned = pair.with_sensor("other", pair.sensor("other").replace(azimuth_deg=(-10.0, 30.0)))
    assert getattr(in_step(pair, turned).sensor("sound"), "azimuth_deg") == (-30.0, 10.0)  # noqa: B009
