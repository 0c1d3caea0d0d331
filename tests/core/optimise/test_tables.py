"""Cells of candidates against the engine of targets, bit for bit, and ground against the blind map."""

import numpy as np
import pytest

from riglens.core.blind.zones import BlindEngine, BlindSettings
from riglens.core.errors import Cancelled, never_stale
from riglens.core.optimise.makers import GroundTableMaker, HitTableMaker, Objects
from riglens.core.optimise.tables import UNIT
from riglens.core.optimise.weights import EVEN
from riglens.core.rig.model import Lidar, LinearAngles, Rig, Vehicle
from riglens.core.targets.engine import TargetEngine
from riglens.core.targets.settings import TargetSettings
from riglens.core.vehicle.solid import solid_of
from tests.core.optimise.problems import hit_worth, random_table
from tests.core.targets.cases import random_rig, random_traffic

SETTINGS = (
    TargetSettings(body="ignored"),
    TargetSettings(body="blocks", seed=3),
    TargetSettings(body="ignored", range_law=False, phase="0", shape="box"),
)


@pytest.mark.parametrize("seed", range(20))
def test_cells_of_a_set_are_those_that_the_engine_counts(seed: int) -> None:
    rng = np.random.default_rng(seed)
    traffic, rig, settings = random_traffic(rng, 8), random_rig(rng, 7), SETTINGS[seed % 3]
    solid = solid_of(rig.vehicle) if settings.body == "blocks" else None
    maker = HitTableMaker(Objects(traffic, 6, settings, solid, 2, EVEN))
    lidars = rig.enabled_lidars()
    base, rest = lidars[:1], lidars[1:]
    cells = [maker.cells_of([one], never_stale) for one in rest]
    table = maker.table(maker.cells_of(base, never_stale), cells)
    chosen = [place for place in range(len(rest)) if rng.random() < 0.6]
    sensors = (*base, *(rest[place] for place in chosen))
    engine = TargetEngine(traffic, 1)
    objects = engine.evaluate(rig.model_copy(update={"sensors": sensors}), settings, 6).objects
    assert (table.state(chosen).known == objects.cells).all()
    cls = traffic.cls[objects.box]
    there = np.unique(cls)
    value = float(np.mean([objects.on_target[cls == one].mean() for one in there])) if len(there) else 0.0
    assert table.value(chosen) / UNIT == pytest.approx(value, abs=1e-9)


def test_a_pair_is_the_union_of_its_sensors() -> None:
    rng = np.random.default_rng(4)
    traffic, lidars = random_traffic(rng, 6), random_rig(rng, 8).enabled_lidars()[:2]
    maker = HitTableMaker(Objects(traffic, 6, SETTINGS[0], None, 1, EVEN))
    one, other, both = (maker.cells_of(some, never_stale) for some in (lidars[:1], lidars[1:], lidars))
    assert len(lidars) == 2
    assert (both == np.union1d(one, other)).all()


def test_casting_ends_when_nobody_waits_any_more() -> None:
    rng = np.random.default_rng(4)
    maker = HitTableMaker(Objects(random_traffic(rng, 6), 6, SETTINGS[0], None, 1, EVEN))
    lidars = random_rig(rng, 8).enabled_lidars()
    with pytest.raises(Cancelled):
        maker.cells_of(lidars, lambda: True)
    with pytest.raises(Cancelled):
        list(maker.each([lidars, lidars], lambda: True))


def test_sets_cast_side_by_side_cover_what_they_do_one_by_one() -> None:
    rng = np.random.default_rng(7)
    rig = random_rig(rng, 8)
    sets = [[one] for one in rig.enabled_lidars()] + [list(rig.enabled_lidars()), []]
    solid = solid_of(rig.vehicle)
    maker = HitTableMaker(Objects(random_traffic(rng, 6), 6, SETTINGS[1], solid, 2, EVEN))
    for some, cells in zip(sets, maker.each(sets), strict=True):
        assert (cells == maker.cells_of(some)).all()


@pytest.mark.parametrize("seed", range(6))
def test_losses_of_pairs_are_what_their_gains_lack_of_their_sum(seed: int) -> None:
    table = random_table(np.random.default_rng(seed), 12, 1 + seed % 2)
    by_group, every = table.losses(), np.arange(12)
    assert by_group is not None and len(by_group) > 1
    losses, alone = by_group.sum(axis=0), table.gains([], every)
    assert (losses.diagonal() == alone).all()
    assert (losses == losses.T).all()
    for one in range(12):
        others = np.delete(every, one)
        assert (alone[others] - losses[one, others] == table.gains([one], others)).all()


def test_worth_rises_by_ever_less_and_ends_at_one() -> None:
    worth = hit_worth(np.array([0, 0, 1, 2, 2, 2], np.uint8))
    steps = np.diff(worth, axis=1)
    assert (steps >= 0).all() and (np.diff(steps, axis=1) <= 0).all()
    assert (worth[:, -1] * [2, 1, 3]).sum() == pytest.approx(UNIT, rel=1e-9)


def test_ground_that_a_set_sees_is_what_it_takes_from_the_blind_map() -> None:
    def lidar(name: str, x_m: float, y_m: float) -> Lidar:
        turn = LinearAngles(from_=-180.0, to=180.0, count=180)
        return Lidar(
            name=name, position=(x_m, y_m, 1.2), elevations_deg=(-30.0, -20.0, -10.0), azimuths_deg=turn
        )

    rig = Rig(vehicle=Vehicle(), sensors=(lidar("front", 2.0, 0.0),))
    added = [(lidar("left", 0.0, 1.0), lidar("right", 0.0, -1.0)), (lidar("rear", -2.2, 0.0),)]
    settings = BlindSettings(voxel_m=0.25, within_m=5.0)
    maker = GroundTableMaker(rig, 0.3, settings=settings)
    base = maker.cells_of(rig.sensors)
    table = maker.table(base, [maker.cells_of(sensors) for sensors in added])
    for chosen in ([], [0], [1], [0, 1]):
        whole = rig.replace(sensors=(*rig.sensors, *(s for one in chosen for s in added[one])))
        unseen = float(BlindEngine(rig.vehicle, settings).evaluate(whole).area_m2(0.3).sum())
        assert maker.shown(table.value(chosen)) == pytest.approx(unseen)
    assert table.value([0, 1]) > table.value([0]) > 0
