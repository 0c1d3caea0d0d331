"""Radars and ultrasonic sensors: closed forms, brute force, and what they leave alone."""

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from pydantic import ValidationError

from riglens.core.engine.audit import audit
from riglens.core.engine.engine import Engine
from riglens.core.engine.sight import sight
from riglens.core.metric.entropy import EntropyField
from riglens.core.metric.scores import MetricSettings
from riglens.core.review.profiles import Area, Profile, Shape
from riglens.core.review.redundancy import target_coverage
from riglens.core.review.verdicts import ObjectVisibility
from riglens.core.rig.model import Rig, Sensor, Vehicle
from riglens.core.rig.presets import preset
from riglens.core.rig.yaml.file import dumps, loads
from riglens.core.scene.boxes import CLASSES
from riglens.core.scene.columns import unpack
from riglens.core.sensing.rays import limits_m, local_directions, sensor_rays
from riglens.core.sensors.kind import Echo
from riglens.core.sensors.radar import RADAR, Radar, RadarScan, cells, range_share
from riglens.core.sensors.ultrasonic import Ultrasonic, reach_m
from riglens.core.targets.detection_range import SIZES_M
from riglens.core.targets.engine import TargetEngine
from riglens.core.targets.settings import EXACT
from riglens.core.targets.traffic import Traffic
from tests.core.builders import field_of, grid_of, random_field, rig_of, seen_ray_by_ray, triple
from tests.core.targets.brute_force import entries
from tests.core.targets.cases import random_traffic, traffic

FAR = RadarScan(
    azimuth_deg=(-9.0, 9.0), elevation_deg=(-7.0, 7.0), range_m=200.0, resolution_deg=2.0, resolution_m=2.0
)
NEAR = RadarScan(azimuth_deg=(-60.0, 60.0), elevation_deg=(-10.0, 10.0), range_m=50.0)
ALL_ROUND = ((-180.0, 180.0), (-60.0, 60.0))


def radar(position: Any = (0.0, 0.0, 1.0), *scans: RadarScan, name: str = "radar", **fields: Any) -> Radar:
    return Radar(name=name, position=position, scans=scans or (FAR, NEAR), **fields)


def sound(position: Any = (0.0, 0.0, 0.5), **fields: Any) -> Ultrasonic:
    return Ultrasonic(**({"name": "sound", "position": position} | fields))


# ---------------------------------------------------------------- rays and closed forms


def test_rays_fill_every_scan_from_edge_to_edge() -> None:
    sensor = radar()
    columns, rows = sensor.resolution
    assert (columns, rows) == (61, 2 * 11)
    x, y, z = local_directions(sensor, np.arange(sensor.ray_count)).T
    azimuth, elevation = np.degrees(np.arctan2(y, x)), np.degrees(np.arcsin(z))
    half = sensor.ray_count // 2
    for scan, part in ((FAR, slice(0, half)), (NEAR, slice(half, None))):
        assert (azimuth[part].min(), azimuth[part].max()) == pytest.approx(scan.azimuth_deg)
        assert (elevation[part].min(), elevation[part].max()) == pytest.approx(scan.elevation_deg)
    assert limits_m(sensor).tolist() == [200.0] * half + [50.0] * half


def test_unless_told_otherwise_sound_goes_as_far_to_one_side_as_to_the_other() -> None:
    for low, high in (sound().azimuth_deg, sound().elevation_deg):
        assert -low == high > 0.0


def test_a_sector_covers_the_area_that_its_angle_and_range_say() -> None:
    grid = grid_of(240, 240, 2, 0.5)
    flat = RadarScan(azimuth_deg=(-30.0, 30.0), elevation_deg=(-0.2, 0.2), range_m=40.0)
    seen = unpack(
        grid,
        Engine(field_of(grid), 1)
        .evaluate(rig_of(radar((0.01, 0.01, 0.51), flat, step_deg=0.25)))
        .seen["radar"],
    )
    area_m2 = float(seen.any(axis=2).sum()) * 0.25
    sector_m2 = math.pi * 40.0**2 * 60.0 / 360.0
    edge_m = 2 * 40.0 + math.radians(60.0) * 40.0  # columns that the border crosses count whole
    assert sector_m2 <= area_m2 <= sector_m2 + edge_m


def test_a_cone_meets_the_ground_where_its_lowest_elevation_says() -> None:
    sensor = sound((0.0, 0.0, 0.5), elevation_deg=(-20.0, 20.0), wall_range_m=50.0, pole_range_m=50.0)
    ahead = sensor_rays(sensor).directions
    ring_m = 0.5 / np.tan(-np.arcsin(ahead[ahead[:, 2] < 0.0, 2]))
    assert ring_m.min() == pytest.approx(0.5 / math.tan(math.radians(20.0)))


def test_the_range_grows_with_the_fourth_root_of_the_cross_section() -> None:
    sensor = radar(cross_sections_dbsm=(10.0, 10.0 - 40.0 * math.log10(2.0), -30.0))
    assert [range_share(sensor, Echo(cls)) for cls in CLASSES] == pytest.approx([1.0, 0.5, 0.1])
    assert range_share(sensor.replace(reference_dbsm=0.0), Echo("car")) == pytest.approx(10.0**0.25)
    assert limits_m(sensor, Echo("bicycle"))[0] == pytest.approx(100.0)


def test_a_wide_object_is_heard_from_farther_away() -> None:
    sensor = sound(pole_range_m=2.0, wall_range_m=5.7)
    assert [reach_m(sensor, Echo(width_m=w)) for w in (None, 0.01, 0.075, 0.3, 1.0, 4.0)] == pytest.approx(
        [2.0, 2.0, 2.0, 2.9, 5.7, 5.7]
    )


@pytest.mark.parametrize(
    ("scan", "said"),
    [
        ({"azimuth_deg": (9.0, -9.0)}, "azimuth_deg must rise"),
        ({"elevation_deg": (5.0, 5.0)}, "elevation_deg must rise"),
        ({"range_m": 0.0}, "range_m"),
    ],
)
def test_wrong_scans_are_refused(scan: dict[str, Any], said: str) -> None:
    with pytest.raises(ValidationError, match=said):
        RadarScan(**({"azimuth_deg": (-9.0, 9.0), "elevation_deg": (-7.0, 7.0), "range_m": 200.0} | scan))


def test_a_wall_is_never_heard_from_nearer_than_a_pole() -> None:
    with pytest.raises(ValidationError, match="wall_range_m must be at least pole_range_m, 3"):
        sound(pole_range_m=3.0, wall_range_m=2.0)


def test_a_rig_file_gives_them_back() -> None:
    rig = Rig(sensors=(radar(step_deg=0.5, reference_dbsm=0.0), sound(azimuth_deg=(-35.0, 35.0))))
    assert loads(dumps(rig)).rig == rig


# ---------------------------------------------------------------- voxels


def random_sensors(rng: np.random.Generator) -> list[Sensor]:
    """A radar of one to three scans and an ultrasonic sensor, anywhere near the car."""
    scans = tuple(
        RadarScan(
            azimuth_deg=tuple(sorted(rng.uniform(-80.0, 80.0, 2).tolist())),
            elevation_deg=tuple(sorted(rng.uniform(-30.0, 30.0, 2).tolist())),
            range_m=float(rng.uniform(2.0, 60.0)),
            resolution_deg=float(rng.uniform(1.0, 20.0)),
            resolution_m=float(rng.uniform(0.2, 4.0)),
        )
        for _ in range(rng.integers(1, 4))
    )
    places = rng.uniform([-2.5, -1.5, 0.2], [2.5, 1.5, 2.0], (2, 3))
    turns = rng.uniform([-10.0, -20.0, -180.0], [10.0, 20.0, 180.0], (2, 3))
    poses = [
        {"position": triple(p), "rpy_deg": triple(t), "step_deg": 4.0}
        for p, t in zip(places, turns, strict=True)
    ]
    return [radar(poses[0].pop("position"), *scans, **poses[0]), sound(**poses[1])]


def test_voxels_are_those_of_rays_that_end_at_their_scans_range() -> None:
    rng = np.random.default_rng(11)
    field = random_field(grid_of(40, 40, 8, 0.5), rng)
    for _ in range(4):
        for sensor in random_sensors(rng):
            seen = Engine(field, 1).evaluate(Rig(sensors=(sensor,))).seen[sensor.kind]
            assert np.array_equal(unpack(field.grid, seen), seen_ray_by_ray(field, sensor))
            rays = sensor_rays(sensor)
            far = _cut_by_hand(field, sensor, rays.directions, np.asarray(rays.far_m))
            assert np.array_equal(unpack(field.grid, seen) & far, unpack(field.grid, seen))


def _cut_by_hand(
    field: EntropyField, sensor: Sensor, ahead: NDArray[np.float64], far_m: NDArray[np.float64]
) -> NDArray[np.bool_]:
    """Voxels near points on rays, every centimetre up to the range of each: all that its rays could meet."""
    near = np.zeros(field.grid.shape, np.bool_)
    for t in np.arange(0.0, far_m.max() + 0.01, 0.05):
        points = np.array(sensor.position) + np.minimum(t, far_m)[:, None] * ahead
        for shift in np.array([(0, 0, 0), *np.eye(3) * 0.06, *-np.eye(3) * 0.06]):
            cell = np.floor((points + shift - field.grid.origin_m) / field.grid.voxel_m).astype(int)
            inside = ((cell >= 0) & (cell < field.grid.shape)).all(axis=1)
            near[tuple(cell[inside].T)] = True
    return near


def test_a_voxel_beyond_the_range_of_its_scan_is_out_of_range() -> None:
    grid, sensor = grid_of(120, 120, 4, 1.0), radar((0.5, 0.5, 1.5), step_deg=0.25)

    def reason(x_m: float, y_m: float) -> str:
        i, j, k = (int(place) for place in grid.to_grid((x_m, y_m, 1.5)))
        return sight(sensor, grid, (i, j, k), False).verdict

    assert reason(40.5, 40.5) == "range"  # the far scan of 200 m does not look there
    assert reason(30.5, 30.5) != "range"


def test_a_kind_of_weight_0_changes_no_score_of_the_paper() -> None:
    field, known = random_field(grid_of(60, 60, 10, 0.5), np.random.default_rng(3)), preset("W+T")
    more = known.model_copy(update={"sensors": (*known.sensors, radar((2.0, 0.0, 0.5)), sound())})
    without, found = (Engine(field, 1).evaluate(rig).scores for rig in (known, more))
    for name in CLASSES:
        old, new = without.classes[name], found.classes[name]
        assert (new.s_ms, new.camera, new.lidar) == (old.s_ms, old.camera, old.lidar)
        assert new.kinds["radar"].seen > 0.0 and new.kinds["ultrasonic"].seen > 0.0
        assert new.any_seen >= old.any_seen


def test_edits_give_the_scores_of_evaluations_from_scratch() -> None:
    rng = np.random.default_rng(5)
    field = random_field(grid_of(40, 40, 8, 0.5), rng)
    engine = Engine(field, 1)
    for body in ("ignored", "blocks") * 6:
        rig, settings = rig_of(*random_sensors(rng), *random_sensors(rng)), MetricSettings(body=body)
        assert engine.evaluate(rig, settings).scores == Engine(field, 1).evaluate(rig, settings).scores


def test_a_bumpers_skin_lets_radar_pass_and_the_rest_of_the_body_does_not() -> None:
    field, car = field_of(grid_of(60, 60, 8, 0.5)), Vehicle()
    behind_skin = radar((car.length / 2.0 - 0.05, 0.0, 0.5), NEAR)
    (ahead,) = audit(Engine(field), Rig(vehicle=car, sensors=(behind_skin,))).sensors
    (back,) = audit(
        Engine(field), Rig(vehicle=car, sensors=(behind_skin.replace(rpy_deg=(0.0, 0.0, 180.0)),))
    ).sensors
    assert ahead.shares["hits_car"] < 0.05 < 0.9 < back.shares["hits_car"]


# ---------------------------------------------------------------- objects


def towards(held: Traffic, part: slice, sensor: Sensor, ahead: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Which rays go into a cone around a box, and so may meet it."""
    away = held.centre_m[part] - np.array(sensor.position)
    far, radius = np.linalg.norm(away, axis=1), np.linalg.norm(held.size_m[part], axis=1) / 2.0
    least = np.where(radius < far, np.sqrt(np.maximum(far**2 - radius**2, 0.0)), -far)
    return np.asarray((ahead @ away.T >= least - 1e-6 * (1.0 + far)).any(axis=1))


def met_by_hand(held: Traffic, sensor: Sensor) -> NDArray[np.int64]:
    """Rays on each box: every ray of the finest lattice against every box, then one box for each resolution cell."""
    fine, found = sensor.finest(), np.zeros(len(held.cls), np.int64)
    local = local_directions(fine, np.arange(fine.ray_count))
    rotation = fine.pose.rotation()
    ahead = np.stack(
        [(r[0] * local[:, 0] + r[1] * local[:, 1]) + r[2] * local[:, 2] for r in rotation], axis=1
    )
    limits = np.stack([limits_m(fine, Echo(cls, min(SIZES_M[cls][:2]))) for cls in CLASSES])
    for frame in range(held.frames):
        part = slice(int(held.starts[frame]), int(held.starts[frame + 1]))
        if part.start == part.stop:
            continue
        at = np.full((len(ahead), part.stop - part.start), np.inf)
        near = towards(held, part, fine, ahead)
        at[near] = entries(held, part, fine, ahead[near])
        first, distance = at.argmin(axis=1), at.min(axis=1)
        cls = held.cls[part][first]
        hit = np.isfinite(distance) & (distance <= limits[cls, np.arange(len(cls))])
        rays = np.bincount(first[hit], minlength=part.stop - part.start)
        if isinstance(fine, Radar):
            own = (held.centre_m[part] - np.array(fine.position)) @ rotation
            cell, reach = cells(fine, own), [limits[c].max() for c in held.cls[part]]
            order = sorted(np.flatnonzero(rays), key=lambda box: (-reach[box], -rays[box], box))
            taken = set[tuple[int, ...]]()
            for box in order:
                key = tuple(cell[box].tolist())
                rays[box] = 0 if key in taken else rays[box]
                taken.add(key)
        found[part] = rays
    return found


@pytest.mark.parametrize(("rigs", "frames"), [(2, 10), pytest.param(20, 200, marks=pytest.mark.slow)])
def test_objects_are_those_that_every_ray_against_every_box_finds(rigs: int, frames: int) -> None:
    rng = np.random.default_rng(17)
    for _ in range(rigs):
        held = random_traffic(rng, frames, 8).within(1e6)
        rig = Rig(sensors=tuple(random_sensors(rng)))
        found = TargetEngine(held, 1).evaluate(rig, EXACT).objects
        for sensor in rig.sensors:
            assert found.returns[sensor.kind].counts[:, 0].tolist() == met_by_hand(held, sensor).tolist()


def detected(held: Traffic, sensor: Sensor) -> list[bool]:
    """Which boxes a sensor detects, in the order in which they were given."""
    everything = held.within(1e6)
    found = TargetEngine(everything, 1).evaluate(Rig(sensors=(sensor,)), EXACT).objects
    flags = np.zeros(len(everything.cls), np.bool_)
    flags[everything.row[found.box]] = found.returns[sensor.kind].counts[:, 0] > 0
    return [bool(flag) for flag in flags]


def test_an_object_is_detected_up_to_the_range_of_its_class() -> None:
    for cls, name in enumerate(CLASSES):
        reach = 50.0 * range_share(radar(), Echo(name))
        size = (0.4, 0.8, 1.7)
        places = [(k, cls, (reach + gap, 0.0, 0.85), size, 0.0) for k, gap in enumerate((-1.0, 1.5))]
        only = radar((0.0, 0.0, 1.0), NEAR)
        assert detected(traffic(places, 2), only) == [True, False]


def test_objects_in_one_resolution_cell_count_once() -> None:
    one = RadarScan(
        azimuth_deg=(-40.0, 40.0),
        elevation_deg=(-20.0, 20.0),
        range_m=80.0,
        resolution_deg=10.0,
        resolution_m=2.0,
    )
    man, car = (0.6, 0.6, 1.7), (4.0, 1.8, 1.5)
    beside = [(0, 2, (20.5, 1.0, 0.85), man, 0.0), (0, 2, (20.5, 2.5, 0.85), man, 0.0)]
    apart = [(1, 2, (20.5, 1.0, 0.85), man, 0.0), (1, 2, (20.5, 6.0, 0.85), man, 0.0)]
    hidden = [(2, 2, (20.5, 3.2, 0.85), man, 0.0), (2, 0, (20.7, 1.0, 0.75), car, 0.0)]
    seen = detected(traffic([*beside, *apart, *hidden], 3), radar((0.0, 0.0, 1.0), one))
    assert sum(seen[:2]) == 1 and seen[2:4] == [True, True]
    assert seen[4:] == [False, True]  # the car outshines who stands beside it


def test_traffic_hides_what_is_behind_it() -> None:
    wall = [(0, 0, (10.0, 0.0, 1.5), (1.0, 10.0, 3.0), 0.0), (0, 2, (15.0, 0.0, 0.85), (0.6, 0.6, 1.7), 0.0)]
    assert detected(traffic(wall), radar()) == [True, False]


def test_redundancy_counts_them_as_kinds_of_their_own() -> None:
    held = traffic([(0, 0, (4.0, 0.0, 0.75), (4.0, 1.8, 1.5), 0.0)]).within(1e6)
    rig = Rig(sensors=(radar(), sound((1.9, 0.0, 0.5))))
    found = TargetEngine(held, 1).evaluate(rig, EXACT)
    covered = target_coverage(found)
    assert covered.covered.sum(axis=(0, 2)).tolist() == [1, 1, 0, 1]


def test_regulation_cylinders_are_heard_within_the_range_of_their_width() -> None:
    car = Vehicle()
    place = {"height": 0.8, "diameter": 0.3}
    across: Any = {"title": "a title", "source": "a source", "object": Shape(**place), "by": "ultrasonic"}
    rear = sound((-car.length / 2.0, 0.0, 0.5), rpy_deg=(0.0, 0.0, 180.0), pole_range_m=1.0, wall_range_m=3.0)
    limit = reach_m(rear, Echo(width_m=0.3))
    for behind, is_seen in ((limit - 0.1, True), (limit + 0.4, False)):
        at = Area(behind=(behind, behind + 0.001), right=(-car.width / 2.0, -car.width / 2.0 + 0.001))
        found = ObjectVisibility(Rig(vehicle=car, sensors=(rear,)), "blocks").verdict(
            Profile(name="one", field=at, share=0.2, **across)
        )
        assert {one.is_seen for one in found.objects} == {is_seen}


def test_their_weight_in_s_ms_is_0() -> None:
    assert RADAR.score_weight == 0.0
