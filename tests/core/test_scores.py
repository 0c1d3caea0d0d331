"""S-MIG, S-MS and `seen` in all readings, against plain sums over the voxels the oracle finds."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from riglens.core.metric.entropy import QUANTA_PER_NAT
from riglens.core.metric.scores import MetricSettings, Reading
from riglens.core.rig.model import Camera, Lidar
from riglens.core.scene.boxes import CLASSES
from tests.core.builders import (
    camera,
    dense_h,
    evaluate,
    field_of,
    grid_of,
    lidar,
    random_field,
    random_sensor,
    rig_of,
)
from tests.core.oracle import exact_visits

GRID = grid_of(8, 7, 66, 0.5)
seeds = st.integers(0, 2**32 - 1)


def plain_s_mig(h: np.ndarray, seen: np.ndarray, visits: np.ndarray, reading: Reading) -> float:
    """S-MIG of one kind of sensors as a plain sum over voxels, in whole quanta and then in nat."""
    parts = {"covered": h[seen], "residual": h[~seen], "hits": h * visits}
    return -int(parts[reading].sum()) / QUANTA_PER_NAT


@settings(max_examples=12)
@given(seed=seeds, reading=st.sampled_from(["covered", "residual", "hits"]))
def test_scores_are_plain_sums_over_the_covered_voxels(seed: int, reading: Reading) -> None:
    rng = np.random.default_rng(seed)
    field = random_field(GRID, rng, share=0.4)
    sensors = [random_sensor(GRID, rng, rays=10) for _ in range(4)]
    visits = {
        "camera": exact_visits(GRID, [s for s in sensors if isinstance(s, Camera)]),
        "lidar": exact_visits(GRID, [s for s in sensors if isinstance(s, Lidar)]),
    }
    seen = {kind: count > 0 for kind, count in visits.items()}
    seen["any"] = seen["camera"] | seen["lidar"]
    scores = evaluate(field, rig_of(*sensors), MetricSettings(reading=reading, camera_weight=0.25)).scores
    h_q = dense_h(field)
    for cls, name in enumerate(CLASSES):
        found, h = scores.classes[name], h_q[..., cls]
        assert found.h_total == h.sum() / QUANTA_PER_NAT
        assert found.camera.s_mig == plain_s_mig(h, seen["camera"], visits["camera"], reading)
        assert found.lidar.s_mig == plain_s_mig(h, seen["lidar"], visits["lidar"], reading)
        assert found.s_ms == 0.25 * found.camera.s_mig + found.lidar.s_mig
        assert found.camera.seen == h[seen["camera"]].sum() / h.sum()
        assert found.lidar.seen == h[seen["lidar"]].sum() / h.sum()
        assert found.any_seen == h[seen["any"]].sum() / h.sum()
    informative = h_q.any(axis=-1)
    counted = {kind: scores.covered_voxels[kind] for kind in seen}
    assert counted == {kind: int((mask & informative).sum()) for kind, mask in seen.items()}


def test_covered_and_residual_share_out_the_total() -> None:
    rng = np.random.default_rng(3)
    field = random_field(GRID, rng)
    rig = rig_of(*[random_sensor(GRID, rng) for _ in range(4)])
    covered, residual = (
        evaluate(field, rig, MetricSettings(reading=r)).scores for r in ("covered", "residual")
    )
    for name in CLASSES:
        one, other = covered.classes[name].lidar.s_mig, residual.classes[name].lidar.s_mig
        assert one + other == pytest.approx(-covered.classes[name].h_total, rel=1e-15)
        assert covered.classes[name].lidar.seen == residual.classes[name].lidar.seen


def test_hits_count_a_voxel_once_per_ray_and_covered_once() -> None:
    field = field_of(GRID)
    twice = rig_of(lidar((0.1, 0.1, 1.1), azimuths=[0.0, 0.0]))
    h = round(math.log(2.0) * QUANTA_PER_NAT) / QUANTA_PER_NAT
    voxels = 4
    assert evaluate(field, twice).scores.classes["car"].lidar.s_mig == -voxels * h
    assert (
        evaluate(field, twice, MetricSettings(reading="hits")).scores.classes["car"].lidar.s_mig
        == -2 * voxels * h
    )


def test_denormal_directions_count_in_the_hits_reading_too() -> None:
    field = field_of(GRID)
    plain = rig_of(lidar((0.1, 0.1, 1.1), azimuths=[0.0]))
    denormal = rig_of(lidar((0.1, 0.1, 1.1), azimuths=[1e-310]))
    hits = MetricSettings(reading="hits")
    assert evaluate(field, plain, hits).scores == evaluate(field, denormal, hits).scores


def test_cameras_weigh_a_tenth_by_default() -> None:
    scores = evaluate(field_of(GRID), rig_of(camera((0.0, 0.0, 3.0)))).scores.classes["pedestrian"]
    assert scores.s_ms == 0.1 * scores.camera.s_mig < 0.0


def test_a_scene_without_entropy_scores_zero_everywhere() -> None:
    field = field_of(GRID, np.zeros(GRID.shape, np.bool_))
    for reading in ("covered", "residual", "hits"):
        result = evaluate(field, rig_of(camera((0.0, 0.0, 3.0)), lidar()), MetricSettings(reading=reading))
        for scores in result.scores.classes.values():
            assert (scores.h_total, scores.camera.seen, scores.any_seen, scores.s_ms) == (0.0, 0.0, 0.0, 0.0)
