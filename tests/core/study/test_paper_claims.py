"""The paper's claims follow from its own tables, and λ is found where a pencil finds it."""

from __future__ import annotations

import numpy as np
import pytest

from riglens.core.metric.scores import DEFAULT_LAMBDA
from riglens.core.rig.presets import PAPER_RIGS
from riglens.core.scene.boxes import CLASSES
from riglens.core.study.paper_claims import EVERY, MOST_LAMBDA, Claims, claims, sweeps
from riglens.core.study.ranks import spearman
from riglens.core.study.table1 import Figures, published_table1
from riglens.core.study.table2 import Paper, icra


@pytest.fixture(scope="module")
def found() -> Claims:
    return claims(icra(), published_table1(), DEFAULT_LAMBDA)


def test_s_ms_of_the_paper_ranks_the_mean_of_its_detectors_as_fig_5_shows(found: Claims) -> None:
    assert [round(found.fig5[cls][EVERY], 2) for cls in CLASSES] == [0.98, 1.0, 0.98]
    alone = [rho for cls in CLASSES for name, rho in found.fig5[cls].items() if name != EVERY]
    assert len(alone) == 12 and min(alone) == pytest.approx(0.74, abs=0.005)


def test_percentages_of_the_paper_are_points_of_its_table(found: Claims) -> None:
    largest = max(found.spread, key=lambda one: one.points)
    assert round(largest.points, 1) == 28.7 and (largest.best, largest.worst) == ("W+T", "N+C")
    assert [round(value, 1) for value in found.wide_leads] == [0.5, 10.9]
    assert found.wide_ahead == (48, 48)


def test_the_best_weight_lies_in_its_range_and_no_tried_one_is_better(found: Claims) -> None:
    table, paper = published_table1(), icra()
    assert len(found.sweeps) == 3 * 5
    for one in found.sweeps:
        ap = paper.of(one.cls)
        ap = ap.mean(axis=0) if one.detector == EVERY else ap[paper.detectors.index(one.detector)]
        camera, lidar = (
            np.array([getattr(table[rig][one.cls], name) for rig in PAPER_RIGS])
            for name in ("camera_s_mig", "lidar_s_mig")
        )

        def rank(weight: float, camera=camera, lidar=lidar, ap=ap) -> float:  # type: ignore[no-untyped-def]
            return float(spearman(weight * camera + lidar, ap))

        inside = np.linspace(one.low, one.high, 7)[1:-1]
        assert [rank(weight) for weight in inside] == pytest.approx([one.best] * 5)
        tried = [rank(weight) for weight in np.geomspace(1e-3, MOST_LAMBDA * 0.999, 400)]
        assert max(tried) <= one.best + 1e-9
        assert one.usual == pytest.approx(rank(DEFAULT_LAMBDA)) and one.usual <= one.best + 1e-9


def test_a_detector_that_sees_cameras_alone_wants_a_great_weight() -> None:
    paper = icra()
    rng = np.random.default_rng(0)
    camera = rng.permutation(8).astype(float)
    table = {
        rig: {cls: Figures(camera[k], 0.001 * k, 0.0) for cls in CLASSES} for k, rig in enumerate(PAPER_RIGS)
    }
    percent = np.broadcast_to(camera, paper.percent.shape)
    of = sweeps(Paper(paper.name, paper.rigs, paper.detectors, percent), table, DEFAULT_LAMBDA)
    assert all(one.best == pytest.approx(1.0) and one.high == MOST_LAMBDA for one in of)


def test_rigs_of_equal_s_mig_have_no_best_weight() -> None:
    table = {rig: dict.fromkeys(CLASSES, Figures(-1.0, -1.0, -1.1)) for rig in PAPER_RIGS}
    assert all(np.isnan(one.best) and np.isnan(one.low) for one in sweeps(icra(), table, DEFAULT_LAMBDA))
