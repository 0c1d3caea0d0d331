"""Where rays go: every ray counts once; lost to the body is what evaluations with and without it differ by."""

import numpy as np
import pytest

from riglens.core.engine.audit import RAY_OUTCOMES, _outcomes, audit
from riglens.core.engine.caster import Caster
from riglens.core.engine.engine import Engine
from riglens.core.kernels.runtime.jit import use_threads
from riglens.core.metric.scores import MetricSettings
from riglens.core.rig.model import Lidar, LinearAngles, Rig, Vehicle
from riglens.core.sensing.body_ends import barrier_of
from tests.core.audit_by_ray import fates_by_ray
from tests.core.builders import camera, field_of, grid_of, random_field, random_sensor, rig_of, spinning
from tests.core.vehicle.solids import soup

GRID = grid_of(40, 40, 8, 0.5)
LOW = Vehicle(length=3.0, width=1.5, height=1.2)


def test_the_shares_of_each_sensor_add_up_to_one_and_rays_count_once() -> None:
    field = random_field(GRID, np.random.default_rng(3), share=0.05)
    rig = rig_of(spinning((0.0, 0.0, 1.4)), spinning((0.3, 0.2, 1.4)), camera((0.0, 0.0, 1.4))).replace(
        vehicle=LOW
    )
    for body in ("ignored", "blocks"):
        for sensor, found in zip(rig.sensors, audit(Engine(field), rig, body).sensors, strict=True):  # type: ignore[arg-type]
            assert found.rays == sensor.ray_count and tuple(found.counts) == RAY_OUTCOMES
            assert sum(found.shares.values()) == pytest.approx(1.0, abs=1e-12)
            assert body == "blocks" or found.counts["hits_car"] == 0


def test_inside_a_closed_car_every_beam_hits_it_and_all_is_lost() -> None:
    rig = Rig(
        vehicle=Vehicle(body="suv", length=4.66, width=1.9, height=1.7),
        sensors=(
            Lidar(
                name="in", position=(0.2, 0.0, 1.3), elevations_deg=LinearAngles(from_=-25, to=25, count=9)
            ),
        ),
    )
    field = field_of(GRID)
    (found,) = audit(Engine(field), rig).sensors
    assert found.shares["hits_car"] == 1.0 and found.status.problem.endswith("m inside the body")
    free, cut = (
        Engine(field).evaluate(rig, MetricSettings(body=body)).scores.classes["car"].lidar  # type: ignore[arg-type]
        for body in ("ignored", "blocks")
    )
    assert (
        found.lost_nat["car"] == cut.s_mig - free.s_mig > 0.98 * -free.s_mig
    )  # but for what is in the cabin
    assert found.lost_share["car"] == pytest.approx(free.seen - cut.seen)


@pytest.mark.parametrize(
    ("elevation", "informative", "fate"),
    [
        (-60.0, True, "brings_new"),
        (-60.0, False, "ground"),
        (30.0, False, "meets_nothing"),
        (0.0, True, "brings_new"),
    ],
)
def test_a_single_ray_has_the_fate_that_geometry_gives_it(
    elevation: float, informative: bool, fate: str
) -> None:
    mask = np.full(GRID.shape, informative)
    mask[0, 0, 0] = True
    ray = Lidar(name="a", position=(3.0, 0.1, 2.0), elevations_deg=(elevation,), azimuths_deg=(0.0,))
    (found,) = audit(Engine(field_of(GRID, mask)), rig_of(ray), "ignored").sensors
    assert found.counts[fate] == 1 and found.shares[fate] == 1.0


def test_what_two_sensors_both_see_is_new_with_neither_and_what_passes_by_never_enters() -> None:
    ray = Lidar(name="a", position=(3.0, 0.1, 2.0), elevations_deg=(0.0,), azimuths_deg=(0.0,))
    away = ray.replace(position=(30.0, 0.1, 2.0))
    found = audit(Engine(field_of(GRID)), rig_of(ray, ray.replace(name="b"), away), "ignored").sensors
    outcomes = [next(fate for fate in RAY_OUTCOMES if sensor.counts[fate]) for sensor in found]
    assert outcomes == ["seen_by_others", "seen_by_others", "never_enters"]


@pytest.mark.parametrize("seed", range(12))
def test_every_ray_has_the_fate_that_python_gives_it_on_any_number_of_threads(seed: int) -> None:
    """Sensors anywhere and turned anyhow, in and out of the grid, with ranges, one or two words to a column."""
    use_threads(3)
    rng = np.random.default_rng(seed)
    field = random_field(grid_of(20, 15, (8, 70)[seed % 2], 0.5), rng, share=float(rng.choice([0.02, 0.3])))
    sensor = random_sensor(field.grid, rng, rays=40)
    others = field.index.words & rng.integers(0, 2**64, field.index.words.size, np.uint64)
    barrier = barrier_of(sensor, soup(seed, 40)) if seed % 3 else None
    expected = fates_by_ray(Caster(field), sensor, barrier, others)
    for workers in (1, 3):
        np.testing.assert_array_equal(_outcomes(Caster(field, workers), sensor, barrier, others), expected)


def test_rays_that_kernels_leave_open_have_their_fates_too() -> None:
    """Angles so small that only rational numbers can tell: along a beam, and down at the ground."""
    field = field_of(GRID)
    ray = Lidar(name="a", position=(0.1, 0.1, 2.0), elevations_deg=(1e-200, -60.0), azimuths_deg=(1e-200,))
    nothing = np.zeros_like(field.index.words)
    found = _outcomes(Caster(field), ray, None, nothing)
    np.testing.assert_array_equal(found, fates_by_ray(Caster(field), ray, None, nothing))
