"""The paper's Table I beside ours: layout, orders, agreement."""

import csv
from dataclasses import dataclass

import pytest

from riglens.assets import asset_path
from riglens.core.metric.scores import DEFAULT_LAMBDA, ClassScores, KindScore, MetricSettings, Scores
from riglens.core.rig.model import Rig
from riglens.core.rig.presets import PAPER_RIGS
from riglens.core.scene.boxes import CLASSES
from riglens.core.study.table1 import Figures, Order, Table1, compare, published_table1, table1

LIDAR = {"C": -187.9, "P": -183.0, "L": -134.7, "T": -134.2}
CAMERA = {"W": -670.7, "N": -686.5}


@dataclass(frozen=True)
class Answer:
    scores: Scores


def scores_of(camera: float, lidar: float) -> Scores:
    one = ClassScores(
        900.0, {"camera": KindScore(camera, 0.5), "lidar": KindScore(lidar, 0.2)}, 0.6, 0.1 * camera + lidar
    )
    return Scores(dict.fromkeys(CLASSES, one), {"camera": 1, "lidar": 1, "any": 1})


class FakeEngine:
    """Scores a rig by the groups in its name."""

    def __init__(self, lidar: dict[str, float], camera: dict[str, float]) -> None:
        self._lidar, self._camera = lidar, camera
        self.asked: list[tuple[str, MetricSettings]] = []

    def evaluate(self, rig: Rig, settings: MetricSettings) -> Answer | None:
        self.asked.append((rig.name, settings))
        cameras, lidars = rig.name.split("+")
        return Answer(scores_of(self._camera[cameras], self._lidar[lidars]))


def order_of(table: Table1, cls: str, what: str) -> Order:
    return next(order for order in table.orders if (order.cls, order.what) == (cls, what))


def test_the_published_figures_are_those_of_the_paper() -> None:
    published = published_table1()
    assert list(published) == list(PAPER_RIGS)
    assert published["W+C"]["car"] == Figures(-73080.0, -6450.0, -13750.0)
    assert published["N+T"]["pedestrian"] == Figures(-14090.0, -830.0, -2240.0)
    assert published["W+L"]["bicycle"] == Figures(-14150.0, -910.0, -2320.0)
    for figures in (f for row in published.values() for f in row.values()):
        assert figures.s_ms == pytest.approx(
            DEFAULT_LAMBDA * figures.camera_s_mig + figures.lidar_s_mig, abs=11.0
        )


def test_a_group_has_the_same_published_figure_in_every_rig() -> None:
    published = published_table1()
    for cls in CLASSES:
        lidars = {(rig[-1], row[cls].lidar_s_mig) for rig, row in published.items()}
        cameras = {(rig[0], row[cls].camera_s_mig) for rig, row in published.items()}
        assert (len(lidars), len(cameras)) == (4, 2)


def test_the_published_detection_accuracies_are_complete() -> None:
    with asset_path("paper", "detection_map.csv").open(encoding="utf-8", newline="") as stream:
        lines = list(csv.DictReader(stream))
    keys = {(line["class"], line["model"], line["backbone"], line["rig"]) for line in lines}
    assert len(lines) == len(keys) == 3 * 4 * 8
    assert {line["rig"] for line in lines} == set(PAPER_RIGS)
    by_key = {tuple(line.values())[:4]: float(line["map_percent"]) for line in lines}
    assert by_key["car", "Transfusion", "PointPillars", "W+T"] == 89.27
    assert by_key["pedestrian", "PointAugmenting", "VoxelNet", "N+L"] == 26.81
    assert all(0.0 < value < 100.0 for value in by_key.values())


def test_the_eight_rigs_are_scored_in_the_paper_order_with_the_settings_asked_for() -> None:
    engine, steps = FakeEngine(LIDAR, CAMERA), []
    settings = MetricSettings(reading="hits")
    table = table1(engine, settings, steps.append)
    assert engine.asked == [(name, settings) for name in PAPER_RIGS]
    assert [row.rig for row in table.rows] == list(PAPER_RIGS) and table.settings == settings
    assert steps == [n / 8 for n in range(1, 9)]
    assert table.rows[3].ours["car"] == Figures(-670.7, -134.2, 0.1 * -670.7 - 134.2)
    assert table.rows[3].published["car"].lidar_s_mig == -5250.0


def test_orders_that_are_those_of_the_paper_agree() -> None:
    table = table1(FakeEngine(LIDAR, CAMERA), MetricSettings())
    assert len(table.orders) == 9
    lidars, cameras = order_of(table, "car", "LiDAR groups"), order_of(table, "car", "camera groups")
    assert lidars.ours == lidars.published == ("Center", "Pyramid", "Line", "Trapezoid")
    assert cameras.ours == cameras.published == ("Narrow", "Wide")
    assert lidars.agrees and cameras.agrees
    assert (lidars.kendall_tau, lidars.spearman_rho) == (pytest.approx(1.0), pytest.approx(1.0))
    rigs = order_of(table, "car", "rigs")
    assert rigs.published == ("N+C", "W+C", "N+P", "N+L", "W+P", "N+T", "W+L", "W+T")
    assert rigs.ours == ("N+C", "W+C", "N+P", "W+P", "N+L", "N+T", "W+L", "W+T")
    assert not rigs.agrees and not table.agrees
    assert rigs.kendall_tau == pytest.approx(1 - 2 / 28) and rigs.spearman_rho == pytest.approx(
        1 - 6 * 2 / (8 * 63)
    )


def test_the_published_figures_agree_with_themselves() -> None:
    published = published_table1()
    scores = {
        name: Scores(
            {
                cls: ClassScores(
                    1.0,
                    {"camera": KindScore(f.camera_s_mig, 0.1), "lidar": KindScore(f.lidar_s_mig, 0.1)},
                    0.2,
                    f.s_ms,
                )
                for cls, f in row.items()
            },
            {},
        )
        for name, row in published.items()
    }
    table = compare(scores, MetricSettings())
    assert table.agrees and all(order.kendall_tau == pytest.approx(1.0) for order in table.orders)


def test_reversed_groups_disagree() -> None:
    table = table1(
        FakeEngine({name: -100.0 - value for name, value in LIDAR.items()}, CAMERA), MetricSettings()
    )
    lidars = order_of(table, "pedestrian", "LiDAR groups")
    assert lidars.ours == ("Trapezoid", "Line", "Pyramid", "Center") and not lidars.agrees
    assert lidars.kendall_tau == pytest.approx(-1.0)
    assert order_of(table, "pedestrian", "camera groups").agrees


def test_equal_figures_are_no_agreement_and_have_no_rank() -> None:
    table = table1(FakeEngine(dict.fromkeys("CPLT", 0.0), dict.fromkeys("WN", 0.0)), MetricSettings())
    for order in table.orders:
        assert not order.agrees and order.kendall_tau is None and order.spearman_rho is None
