"""Published detection against our figures: the published facts, and rank correlations that a pencil can check."""

import numpy as np
import pytest

from riglens.core.scene.boxes import CLASSES
from riglens.core.study.detection.statistics import COLUMNS
from riglens.core.study.detection.surrogates import SURROGATES, Surrogates
from riglens.core.study.table2 import Agreement, Paper, agreements, icra, place3d


def test_the_icra_paper_has_eight_rigs_and_four_detectors() -> None:
    paper = icra()
    assert paper.percent.shape == (3, 4, 8) and len(set(paper.detectors)) == 4
    car = paper.of("car")
    assert car[0].tolist() == [87.08, 83.87, 89.08, 89.27, 85.44, 83.1, 87.62, 88.74]


def test_place3d_has_the_five_placements_whose_poses_are_published() -> None:
    """Figures and poses as in its repository; y to the left here, to the right there."""
    paper = place3d()
    assert [rig.name for rig in paper.rigs] == ["Center", "Line", "Pyramid", "Square", "Trapezoid"]
    assert paper.detectors == ("PointPillars", "CenterPoint", "BEVFusion-L", "FSTR")
    assert paper.of("car")[1].tolist() == [55.8, 54.0, 55.9, 54.0, 55.4]
    assert paper.of("pedestrian")[3].tolist() == [27.7, 30.2, 29.4, 30.3, 30.0]
    pyramid = paper.rigs[2].rig.enabled_lidars()
    assert [lidar.position for lidar in pyramid] == [
        (-0.8, 0.6, 1.8), (0.2, 0.0, 2.0), (-0.6, 0.0, 2.4), (-0.8, -0.6, 1.8)
    ]  # fmt: skip
    assert [lidar.elevations()[[0, -1]].tolist() for lidar in pyramid] == [
        [-14, 2],
        [-25, 5],
        [-25, 5],
        [-14, 2],
    ]
    assert all(rig.rays == 4 * 16 * 720 for rig in paper.rigs)


def test_the_papers_put_the_same_placements_in_other_orders() -> None:
    """Mean car AP over detectors, as each of them prints it, but for the last digit."""
    one, other = icra().groups("car"), place3d().groups("car")
    assert {name: round(value, 1) for name, value in one.items()} == {
        "Center": 77.3, "Pyramid": 78.1, "Line": 80.7, "Trapezoid": 82.0
    }  # fmt: skip
    assert {name: round(value, 2) for name, value in other.items()} == pytest.approx(
        {"Center": 52.53, "Pyramid": 52.18, "Line": 49.65, "Trapezoid": 50.93}, abs=0.01
    )
    assert sorted(one, key=one.__getitem__)[0] == "Center" == sorted(other, key=other.__getitem__)[-1]


def test_detectors_agree_as_counted_by_hand() -> None:
    """Of three rigs, detector A says 1 < 2 < 3 and B says 1 < 3 < 2: two pairs agree, one does not: τ = 1/3."""
    paper = small([[1.0, 2.0, 3.0], [1.0, 3.0, 2.0]])
    assert paper.detectors_agree("car") == pytest.approx(1 / 3)


def small(percent: list[list[float]]) -> Paper:
    full = icra()
    rigs = len(percent[0])
    return Paper("small", full.rigs[:rigs], ("A", "B"), np.array([percent] * 3))


def found(paper: Paper, values: list[float], name: str) -> Agreement:
    zeros = {one: np.zeros((len(values), len(COLUMNS))) for one in SURROGATES}
    ours = Surrogates(zeros | {name: np.tile(np.array(values)[:, None], len(COLUMNS))})
    return next(it for it in agreements(paper, ours) if (it.column, it.surrogate) == ("car", name))


def test_positive_means_that_rigs_which_see_more_detect_better() -> None:
    paper = small([[10.0, 20.0, 30.0, 40.0, 50.0, 60.0], [11.0, 21.0, 31.0, 41.0, 51.0, 61.0]])
    rising = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]
    for name, expected in {
        "seen": 1.0,
        "on_target": 1.0,
        "residual": 1.0,
        "s_ms": -1.0,
        "hits": -1.0,
    }.items():
        correlation = found(paper, rising, name).found
        assert correlation is not None and correlation.value == pytest.approx(expected)
        assert correlation.p == pytest.approx(2 / 720) and correlation.exact
        assert correlation.low == pytest.approx(expected) == correlation.high


def test_figures_that_are_the_same_for_all_rigs_and_too_few_rigs_say_nothing() -> None:
    paper = small([[10.0, 20.0, 30.0, 40.0, 50.0], [11.0, 21.0, 31.0, 41.0, 51.0]])
    assert found(paper, [0.5] * 5, "seen").found is None
    few = small([[10.0, 20.0, 30.0, 40.0], [11.0, 21.0, 31.0, 41.0]])
    assert found(few, [0.1, 0.2, 0.3, 0.4], "seen").found is None


def test_every_figure_is_compared_for_every_class_and_the_mean() -> None:
    paper = icra()
    rng = np.random.default_rng(0)
    ours = Surrogates({name: rng.random((8, len(COLUMNS))) for name in SURROGATES})
    listed = agreements(paper, ours)
    assert (
        len(listed)
        == len(SURROGATES) * (len(CLASSES) + 1)
        == len({(it.column, it.surrogate) for it in listed})
    )
