"""Predicted detection: the curve of each object, means with their errors, domains, and the file of a calibration."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from riglens.core.errors import InputError
from riglens.core.figures.documents import objects_document
from riglens.core.figures.figure import ALL
from riglens.core.figures.predicted import FOUND, PREDICTED, found_text
from riglens.core.rig.model import Camera, Rig
from riglens.core.scene.boxes import CLASSES
from riglens.core.targets.calibration import (
    MIN_RECALL,
    MOST,
    Calibration,
    CameraCurve,
    Curve,
    Curves,
    Domain,
    read_calibration,
    shipped,
    shipped_recall,
)
from riglens.core.targets.counts import Counted
from riglens.core.targets.engine import TargetEngine
from riglens.core.targets.settings import USUAL
from tests.core.builders import rig_of, spinning
from tests.core.targets.cases import by_sector, parts, traffic
from tests.core.test_sectors import radar

CAR = Curve(a=0.9, b=12.0, c=0.8, error=0.02, objects=100)
PEDESTRIAN = Curve(a=0.8, b=3.0, c=2.0, error=0.03, objects=50)
NEAR = Calibration(
    name="near",
    predicts="recall",
    unit="points",
    detector="a detector",
    source="made up",
    domain=Domain(within_m=30.0, length_m=40.0, width_m=20.0, data="none"),
    classes=Curves(car=CAR, pedestrian=PEDESTRIAN),
    mean_error=0.015,
)
PLACES = [(8.0, 0.0), (-15.0, 4.0), (19.0, -9.0), (25.0, 0.0), (0.0, 12.0), (40.0, 3.0)]
"""The first three in the region."""
BOXES = [
    (frame, cls, (x, y + 1.5 * cls, 0.9), (1.0, 0.8, 1.8), 0.0)
    for frame in range(6)
    for cls in range(3)
    for x, y in PLACES
]
TRAFFIC = traffic(BOXES, 6)
RIG = rig_of(spinning((0.0, 0.0, 1.8), beams=16, count=720))
CALIBRATED = replace(USUAL, calibration=NEAR)


def scores(
    frames: int | None = None,
) -> Counted:
    return TargetEngine(TRAFFIC, threads=1).evaluate(RIG, CALIBRATED, frames)


def test_the_prediction_is_the_mean_of_the_curve_over_the_objects_that_all_figures_count() -> None:
    found = scores()
    objects, box = found.objects, found.objects.box
    for name, curve in (("car", CAR), ("pedestrian", PEDESTRIAN)):
        chosen = TRAFFIC.cls[box] == CLASSES.index(name)
        n = objects.all_points[chosen]
        wanted = [curve.a * (1.0 - math.exp(-((one / curve.b) ** curve.c))) for one in n.tolist()]
        row = parts(found)[name].total.predicted
        assert row.objects == chosen.sum() == parts(found)[name].total.share_5.objects
        assert row.value == pytest.approx(np.mean(wanted)) and row.value > 0.0
        assert (row.se, row.sample_se) == (curve.error, 0.0), "all frames were used"
        rings = [ring.predicted for ring in parts(found)[name].rings]
        total = sum(ring.objects * ring.value for ring in rings)
        assert total / row.objects == pytest.approx(row.value)
    assert not parts(found)["bicycle"].total.predicted.exists, "the class has no curve"
    classes = [parts(found)[name].total.predicted for name in ("car", "pedestrian")]
    mean = PREDICTED.estimates(found, "all")[ALL][0]
    assert mean.value == pytest.approx(sum(one.value for one in classes) / 2.0) and mean.se == NEAR.mean_error


def test_cameras_and_lidars_fail_independently_and_precision_leaves_out_the_first_recall() -> None:
    curve, camera = CAR.model_copy(update={"a": 0.7}), CameraCurve(s=1.5, d0_m=15.0)
    fused = shipped().model_copy(update={"classes": Curves(car=curve), "camera": camera})
    rig = Rig(sensors=(*RIG.sensors, Camera(name="camera", position=(0.0, 0.0, 1.6), hfov_deg=90.0)))
    settings = replace(USUAL, calibration=fused)
    found = TargetEngine(TRAFFIC, threads=1).evaluate(rig, settings)
    chosen = TRAFFIC.cls[found.objects.box] == 0
    n, visible = found.objects.cells[chosen].tolist(), found.objects.visible[chosen].tolist()
    far = TRAFFIC.distance_m[found.objects.box][chosen].tolist()
    chances = []
    for cells, share, distance_m in zip(n, visible, far, strict=True):
        q_lidar = 1.0 - math.exp(-((cells / curve.b) ** curve.c))
        q_camera = min(1.0, 1.5 * share / (1.0 + (distance_m / 15.0) ** 2))
        chances.append([0.7 * one for one in (1.0 - (1.0 - q_lidar) * (1.0 - q_camera), q_lidar, q_camera)])
    wanted = (np.mean(chances, axis=0) - MIN_RECALL) / (1.0 - MIN_RECALL)
    assert max(visible) > 0.5 > wanted[2] > 0.0, "cameras see some of the objects"
    car = PREDICTED.estimates(found, "all")["car"][0]
    assert [car.value, car.parts["lidar"], car.parts["camera"]] == pytest.approx(wanted.tolist())
    cells = PREDICTED.cells(found, TargetEngine(TRAFFIC, threads=1).evaluate(RIG, settings))
    assert cells.change[1, 0] == pytest.approx(wanted[0] - wanted[1])
    assert cells.parts["camera"].change[1, 0] == pytest.approx(wanted[2])


def test_no_precision_is_below_zero_and_a_rig_of_cameras_alone_has_one() -> None:
    camera = Camera(name="camera", position=(0.0, 0.0, 1.6), hfov_deg=90.0)
    blind = camera.model_copy(update={"position": (0.0, 0.0, 90.0)})
    some, none, radars = (
        TargetEngine(TRAFFIC, threads=1).evaluate(Rig(sensors=sensors), USUAL)
        for sensors in ((camera,), (blind,), (radar(),))
    )
    assert parts(some)["car"].total.predicted.value > 0.0
    assert parts(none)["car"].total.predicted.value == 0.0
    assert PREDICTED.cells(some, none).change[1, 0] == parts(some)["car"].total.predicted.value
    assert "no enabled LiDAR or camera" in parts(radars)["car"].total.predicted.reason
    lidars_alone = replace(USUAL, calibration=NEAR)
    lack = TargetEngine(TRAFFIC, threads=1).evaluate(Rig(sensors=(camera,)), lidars_alone)
    assert "no enabled LiDAR" in parts(lack)["car"].total.predicted.reason


def test_a_sample_of_frames_adds_its_own_error() -> None:
    row = parts(scores(frames=3))["car"].total.predicted
    assert row.state == "sampled"
    assert row.se == pytest.approx(math.hypot(row.sample_se, CAR.error)) and row.sample_se > 0.0


def test_tables_hold_the_same_figures() -> None:
    found = scores()
    cells = PREDICTED.cells(found, found)
    for number, name in enumerate(CLASSES, 1):
        row = parts(found)[name].total.predicted
        assert cells.objects[number, 0] == row.objects
        if row.exists:
            assert (cells.value[number, 0], cells.se[number, 0]) == pytest.approx((row.value, row.se))


def test_the_calibration_changes_no_other_figure_and_casts_nothing() -> None:
    engine = TargetEngine(TRAFFIC, threads=1)
    one, other = engine.evaluate(RIG, USUAL), engine.evaluate(RIG, CALIBRATED)
    assert one.objects.points is other.objects.points
    for name in CLASSES:
        mine, theirs = (dict(parts(each)[name].total.figures) for each in (one, other))
        for key in (PREDICTED.key, FOUND.key):
            assert mine.pop(key) != theirs.pop(key)
        assert mine == theirs


def test_objects_found_follow_recall_of_the_study_or_of_ones_own_detector() -> None:
    usual, own = (TargetEngine(TRAFFIC, threads=1).evaluate(RIG, how) for how in (USUAL, CALIBRATED))
    bundled = shipped_recall()
    for scores_, recall, classes in ((usual, bundled, CLASSES), (own, NEAR, ("car", "pedestrian"))):
        objects, box = scores_.objects, scores_.objects.box
        inside = recall.domain.holds(TRAFFIC.centre_m[box])
        said = found_text(scores_, 2.0)
        assert recall.domain.region in said
        for name in classes:
            chosen, curve = inside & (TRAFFIC.cls[box] == CLASSES.index(name)), recall.classes.of(name)
            row = parts(scores_)[name].total.found
            assert curve is not None and row.objects == chosen.sum() < len(PLACES) * 6
            assert row.value == pytest.approx(curve.at(objects.all_points[chosen].astype(float)).mean())
            assert f"{name} {100 * row.value:.0f} ±{200 * curve.error:.0f}" in said
            (ring,) = (one.found for one in parts(scores_)[name].rings[1:2])
            assert ring.objects < row.objects
            sectors = [one.found for one in by_sector(scores_)[name].values()]
            assert sum(one.objects for one in sectors) == row.objects
        cells = FOUND.cells(scores_, scores_)
        (car,) = (parts(scores_)["car"].total.found,)
        assert (cells.value[1, 0], cells.se[1, 0]) == pytest.approx((car.value, car.se))
    document = objects_document([usual])
    assert document["recall_calibration"]["predicts"] == "recall"
    car = parts(usual)["car"].total.found
    assert document["rigs"][0]["classes"]["car"]["found"]["value"] == car.value


def test_a_calibration_of_ap_says_nothing_of_objects_found() -> None:
    found = TargetEngine(TRAFFIC, threads=1).evaluate(RIG, replace(USUAL, calibration=shipped()))
    total = parts(found)["car"].total
    assert total.predicted.exists and not total.found.exists
    assert found_text(found, 1.0) == ""
    assert objects_document([found])["recall_calibration"] is None


def test_what_lies_outside_the_domain_is_said() -> None:
    calibration = shipped()
    assert calibration.outside(RIG, "class", True) == ""
    assert "plain" not in NEAR.outside(RIG, "class", True)
    assert "class shapes" in calibration.outside(RIG, "box", True)
    assert "rays" in calibration.outside(rig_of(spinning((0.0, 0.0, 1.8), count=2)), "class", True)
    none = TargetEngine(TRAFFIC, threads=1).evaluate(rig_of(), USUAL)
    row = parts(none)["car"].total.predicted
    assert not row.exists and "no enabled" in row.reason


def test_numbers_beyond_the_table_are_those_of_its_end() -> None:
    found = NEAR.by_lidars(np.zeros(2, np.uint8), np.array([MOST, 10 * MOST]))
    assert found[0] == found[1] == pytest.approx(CAR.a)


@pytest.mark.parametrize("calibration", [NEAR, shipped(), shipped_recall()])
def test_a_calibration_reads_back_to_the_same_bits(tmp_path: Path, calibration: Calibration) -> None:
    path = tmp_path / "calibration.yaml"
    path.write_text(calibration.text(), encoding="utf-8")
    assert read_calibration(path) == calibration


@pytest.mark.parametrize(
    ("old", "new", "line", "names"),
    [
        ("riglens_calibration: 2", "riglens_calibration: 3", 1, "riglens_calibration"),
        ("riglens_calibration: 2", "riglens_calibration: 1", 1, "riglens calibrate"),
        ("unit: points", "unit: pixels", 4, "unit"),
        ("a: 0.9,", "a: 1.5,", 10, "classes.car.a"),
        ("b: 12.0,", "b: .nan,", 10, "classes.car.b"),
        ("c: 0.8,", "", 10, "classes.car.c"),
        ("objects: 100", "objects: many", 10, "classes.car.objects"),
        ("mean_error: 0.015", "mean_error: -1", 8, "mean_error"),
        ("within_m: 30.0, length_m: 40.0", "within_m: 30.0", 7, "domain"),
        ("  car:", "  tram:", 10, "classes"),
        ("name: near", "name: near\nname: far", 3, "given twice"),
    ],
)
def test_a_broken_file_is_one_line_with_its_place(
    tmp_path: Path, old: str, new: str, line: int, names: str
) -> None:
    path, text = tmp_path / "calibration.yaml", NEAR.text()
    assert old in text
    path.write_text(text.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(InputError) as caught:
        read_calibration(path)
    assert names in str(caught.value) and "\n" not in str(caught.value)
    assert f"{path}:{line}:" in str(caught.value)


def test_errors_of_sample_and_calibration_add_as_squares() -> None:
    curves = NEAR.classes.model_copy(update={"bicycle": CAR})
    settings = replace(USUAL, calibration=NEAR.model_copy(update={"classes": curves}))
    found = TargetEngine(TRAFFIC, threads=1).evaluate(RIG, settings, 4)
    rows = [parts(found)[name].total.predicted for name in CLASSES]
    for row, curve in zip(rows, (CAR, CAR, PEDESTRIAN), strict=True):
        assert row.sample_se > 0.0 and row.se == pytest.approx(math.hypot(row.sample_se, curve.error))
    cells = PREDICTED.cells(found, found)
    np.testing.assert_allclose(cells.se[1:, 0], [row.se for row in rows])
    np.testing.assert_allclose(
        replace(cells, change_se=cells.se).anchored(cells).se, math.sqrt(2.0) * cells.se
    )
