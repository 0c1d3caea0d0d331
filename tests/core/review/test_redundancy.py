"""Redundancy: what failures cost is what rigs without the sensors lack, to the last bit."""

from itertools import combinations

import numpy as np
import pytest

from riglens.core.engine.engine import Engine
from riglens.core.figures.evaluated import EvaluationSettings, Evaluator
from riglens.core.metric.entropy import EntropyField
from riglens.core.metric.scores import Body, MetricSettings
from riglens.core.review.documents import coverage_document
from riglens.core.review.redundancy import (
    COVERED,
    Coverage,
    coverage_of,
    halves_of,
    lost_of,
    target_coverage,
    voxel_coverage,
)
from riglens.core.rig.edits import in_step
from riglens.core.rig.groups import groups_of
from riglens.core.rig.model import Rig, Vehicle, rays_of
from riglens.core.rig.yaml.file import dumps, loads, rig_sha256
from riglens.core.scene.boxes import CLASSES, DataReport
from riglens.core.scene.columns import unpack
from riglens.core.scene.grid import VoxelGrid
from riglens.core.scene.sectors import SECTORS
from riglens.core.sensors.base import HALVES
from riglens.core.targets.engine import TargetEngine
from riglens.core.targets.settings import HALF, TargetSettings
from riglens.core.targets.traffic import Traffic, traffic_of
from tests.core.builders import dense_h, random_field
from tests.core.review.scenes import random_rig

FLAT = VoxelGrid(0.5, (20.0, 16.0, 4.0))
HIGH = VoxelGrid(0.05, (3.0, 3.0, 4.0))


def grouped(rig: Rig) -> Rig:
    sensors = list(rig.sensors)
    sensors[0] = sensors[0].replace(fails_with=("bracket", "ecu"))
    sensors[1] = sensors[1].replace(fails_with=("ecu",))
    sensors[3] = sensors[3].replace(fails_with=("bracket", "ecu", "ecu"))
    return rig.replace(sensors=tuple(sensors))


def without(rig: Rig, members: tuple[str, ...]) -> Rig:
    return rig.replace(sensors=tuple(s for s in rig.sensors if s.name not in members))


def seen_q(field: EntropyField, rig: Rig, body: Body) -> np.ndarray:
    """Entropy that a rig sees (nx, ny, nz, classes) in units of 2^-32 nat, from scratch."""
    found = Engine(field).evaluate(rig, MetricSettings(body=body))
    return dense_h(field) * unpack(field.grid, found.seen_by_any())[..., None]


def coverage(field: EntropyField, rig: Rig, body: Body, threads: int | None = None) -> Coverage:
    engine = Engine(field, threads)
    engine.evaluate(rig, MetricSettings(body=body), False)
    return voxel_coverage(engine, rig)


def by_sector(field: EntropyField, dense: np.ndarray) -> np.ndarray:
    x, y = (field.grid.centres_m(axis) for axis in (0, 1))
    angle = np.degrees(np.arctan2(y[None, :], x[:, None]))
    place = (np.floor(angle / 45.0 + 0.5) % 8).astype(int)
    return np.array([dense[place == sector].sum(axis=(0, 1)) for sector in range(8)])


@pytest.mark.parametrize(("grid", "body"), [(FLAT, "ignored"), (FLAT, "blocks"), (HIGH, "ignored")])
def test_what_failures_cost_is_what_rigs_without_the_sensors_lack(grid: VoxelGrid, body: Body) -> None:
    rng = np.random.default_rng(11)
    field = random_field(grid, rng, share=0.3)
    rig = grouped(random_rig(rng, 5)).replace(vehicle=Vehicle(length=3.0, width=1.4, height=1.2))
    found = coverage(field, rig, body)
    whole = seen_q(field, rig, body)
    failing = {f.name: f for f in found.failures}
    expected = [(name,) for name in (s.name for s in rig.sensors)]
    expected += list(combinations((s.name for s in rig.sensors), 2))
    assert [f.members for f in found.failures if f.what != "group"] == expected
    assert {name: failing[name].members for name in ("bracket", "ecu")} == {
        "bracket": ("s0", "s3"),
        "ecu": ("s0", "s1", "s3"),
    }
    for failure in found.failures:
        lost = whole - seen_q(field, without(rig, failure.members), body)
        np.testing.assert_array_equal(failure.lost, by_sector(field, lost))
    assert any(failure.lost.any() for failure in found.failures)


@pytest.mark.parametrize("body", ["ignored", "blocks"])
def test_a_half_blocked_sensor_costs_what_the_rig_with_its_sector_blocked_lacks(body: Body) -> None:
    rng = np.random.default_rng(12)
    field = random_field(FLAT, rng, share=0.3)
    rig = random_rig(rng, 3).replace(vehicle=Vehicle(length=3.0, width=1.4, height=1.2))
    settings = MetricSettings(body=body)
    evaluate = Evaluator(field, settings=EvaluationSettings(settings))
    plain, found = (coverage_of(evaluate, rig, "voxels", halves) for halves in (False, True))
    same = zip(found.failures, plain.failures, strict=False)
    assert plain.failures and all((a.name, a.lost.tolist()) == (b.name, b.lost.tolist()) for a, b in same)
    halves = [failure for failure in found.failures if failure.what == "half"]
    assert len(halves) == len(rig.sensors) * len(HALVES)
    whole = seen_q(field, rig, body)
    for sensor in rig.sensors:
        for half, sector in HALVES.items():
            failure = next(one for one in halves if one.name == f"{sensor.name}={half}")
            assert failure.members == (sensor.name,)
            blocked = rig.with_sensor(sensor.name, sensor.replace(blocked=(*sensor.blocked, sector)))
            lost = whole - seen_q(field, blocked, body)
            np.testing.assert_array_equal(failure.lost, by_sector(field, lost))
    assert any(failure.lost.any() for failure in halves)
    assert "half" in coverage_document(found, "nat")["classes"]["car"]["worst"]
    assert "half" not in coverage_document(plain, "nat")["classes"]["car"]["worst"]


def test_covered_counts_sensors_and_kinds_voxel_by_voxel() -> None:
    rng = np.random.default_rng(2)
    field = random_field(FLAT, rng, share=0.4)
    rig = random_rig(rng, 5)
    found = coverage(field, rig, "ignored")
    h = dense_h(field)
    own = [seen_q(field, rig.replace(sensors=(s,)), "ignored").any(axis=-1) for s in rig.sensors]
    count = np.sum(own, axis=0)
    kinds = [
        np.any([m for m, s in zip(own, rig.sensors, strict=True) if s.kind == k], axis=0)
        for k in ("camera", "lidar")
    ]
    wanted = [count >= 1, count >= 2, count >= 3, kinds[0] & kinds[1]]
    for level, flags in enumerate(wanted):
        np.testing.assert_array_equal(found.covered[:, level], by_sector(field, h * flags[..., None]))
    np.testing.assert_array_equal(found.total, by_sector(field, h))
    assert found.total.sum(axis=0).tolist() == list(field.totals_q)


def test_threads_do_not_matter_nor_switched_off_sensors_and_no_sensors_lose_nothing() -> None:
    rng = np.random.default_rng(4)
    field = random_field(FLAT, rng)
    rig = grouped(random_rig(rng, 5))
    one, many = coverage(field, rig, "ignored", 1), coverage(field, rig, "ignored", 3)
    assert coverage_document(one, "nat") == coverage_document(many, "nat")
    off = rig.with_sensor("s2", rig.sensors[2].replace(enabled=False))
    assert coverage_document(coverage(field, off, "ignored"), "nat") == coverage_document(
        coverage(field, without(rig, ("s2",)), "ignored"), "nat"
    )
    empty = coverage(field, Rig(), "ignored")
    assert empty.failures == () and not empty.covered.any() and empty.worst("sensor", 0) is None


def some_traffic(rng: np.random.Generator, boxes: int = 60) -> Traffic:
    frame = np.sort(rng.integers(0, 12, boxes))
    place = np.column_stack([rng.uniform(-25.0, 25.0, (boxes, 2)), np.full(boxes, 0.8)])
    turn = rng.uniform(0.0, 2.0 * np.pi, boxes)
    rotation = np.zeros((boxes, 3, 3))
    rotation[:, 0, 0] = rotation[:, 1, 1] = np.cos(turn)
    rotation[:, 1, 0], rotation[:, 0, 1], rotation[:, 2, 2] = np.sin(turn), -np.sin(turn), 1.0
    cls = rng.integers(0, 3, boxes).astype(np.uint8)
    data = DataReport("made", 12, dict.fromkeys(CLASSES, 1))
    return traffic_of(data, frame, cls, place, np.tile([1.8, 0.8, 1.6], (boxes, 1)), rotation)


def test_road_users_lost_are_those_that_rigs_without_the_sensors_do_not_detect() -> None:
    rng = np.random.default_rng(9)
    traffic, rig = some_traffic(rng), grouped(random_rig(rng, 5))
    settings = TargetSettings(min_points=3)

    def detected(of: Rig) -> np.ndarray:
        objects = TargetEngine(traffic).evaluate(of, settings).objects
        return (objects.all_points >= 3) | (objects.visible >= HALF)

    counted = TargetEngine(traffic).evaluate(rig, settings)
    objects, found = counted.objects, target_coverage(counted)
    whole = detected(rig)
    for failure in found.failures:
        lost = whole & ~detected(without(rig, failure.members))
        for cls in range(len(CLASSES)):
            assert lost_of(failure, cls) == (lost & (traffic.cls[objects.box] == cls)).sum()
    assert sum(int(f.lost.sum()) for f in found.failures) > 0
    alone = np.sum([detected(rig.replace(sensors=(s,))) for s in rig.sensors], axis=0)
    assert found.covered[:, COVERED.index("2")].sum() == (alone >= 2).sum()
    assert found.covered[:, 0].sum() == whole.sum() and found.total.sum() == len(objects.box)


def test_the_worst_failure_is_named_by_class_and_sector() -> None:
    rng = np.random.default_rng(6)
    found = coverage(random_field(FLAT, rng), grouped(random_rig(rng, 5)), "ignored")
    document = coverage_document(found, "nat")
    for name in CLASSES:
        worst = document["classes"][name]["worst"]["pair"]
        losses = {f["name"]: f["lost"][name] for f in document["failures"] if f["what"] == "pair"}
        assert worst["lost"] == max(losses.values()) == losses[worst["name"]]
        for place in range(len(SECTORS)):
            there = document["classes"][name]["worst_by_sector"]["sensor"][place]
            singles = [f for f in document["failures"] if f["what"] == "sensor"]
            assert there["lost"] == max(f["lost_by_sector"][name][place] for f in singles)


def test_what_sensors_fail_with_is_kept_in_files_and_decides_no_ray() -> None:
    rig = grouped(random_rig(np.random.default_rng(0), 4))
    again = loads(dumps(rig)).rig
    assert again == rig and groups_of(again.sensors)["ecu"] == ("s0", "s1", "s3")
    plain = rig.replace(sensors=tuple(s.replace(fails_with=None) for s in rig.sensors))
    assert "fails_with" not in dumps(plain) and rig_sha256(plain) != rig_sha256(rig)
    assert rays_of(rig.sensors[0]) == rays_of(plain.sensors[0])
    edited = loads(dumps(rig)).updated(plain)
    assert "fails_with" not in edited.text and edited.updated(rig).rig == rig
    one = rig.sensors[0].replace(name="a", mirror_of=None)
    other = one.replace(name="b", mirror_of="a", fails_with=("other",))
    pair = Rig(sensors=(one, other))
    moved = in_step(pair, pair.with_sensor("a", one.replace(position=(0.0, 0.5, 1.0))))
    assert moved.sensor("b").fails_with == ("other",) and moved.sensor("b").position == (0.0, -0.5, 1.0)


@pytest.mark.parametrize("value", ["[]", "bracket", "[1]", '[""]'])
def test_a_wrong_list_of_what_a_sensor_fails_with_is_refused(value: str) -> None:
    text = (
        "riglens: 1\nsensors:\n  - {name: C, kind: camera, position: [0, 0, 1], hfov_deg: 70,\n"
        f"     fails_with: {value}}}\n"
    )
    with pytest.raises(ValueError, match=r'4: camera "C": fails_with.* must'):
        loads(text)


def test_halves_are_those_of_enabled_sensors() -> None:
    rig = random_rig(np.random.default_rng(5), 3)
    first, *others = rig.sensors
    rig = rig.with_sensor(first.name, first.replace(enabled=False))
    names = [f"{sensor.name}={half}" for sensor in others for half in HALVES]
    assert [name for name, _ in halves_of(rig)] == names
