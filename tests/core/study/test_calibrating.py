"""Recall from a detector's own results: a known curve is recovered, and wrong files are refused in one line."""

from __future__ import annotations

import csv
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import riglens as rl
from riglens.app.commands import main
from riglens.core.errors import InputError
from riglens.core.scene.boxes import CLASSES
from riglens.core.study.calibrating import FEWEST
from riglens.core.targets.calibration import CameraCurve, Curve, read_calibration
from riglens.core.targets.engine import TargetEngine
from riglens.core.targets.object_table import object_table
from riglens.core.targets.settings import USUAL
from riglens.evaluation.options import SceneOptions
from riglens.evaluation.traffic import load_traffic
from tests.core.nuscenes_folder import random_boxes, write_tables

TRUTH = {
    "car": Curve(a=0.95, b=15.0, c=0.8, error=0.0, objects=1),
    "pedestrian": Curve(a=0.8, b=6.0, c=1.5, error=0.0, objects=1),
}
SEQUENCES, FRAMES, EACH = 6, 12, 9


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Boxes with points, and detections of a detector that follows TRUTH; 5 m apart, so that no two are confused."""
    folder, rng = tmp_path_factory.mktemp("calibrate"), np.random.default_rng(3)
    rows, results = [], dict[str, list[dict[str, Any]]]()
    for sequence in range(SEQUENCES):
        for frame in range(FRAMES):
            found = results.setdefault(f"s{sequence}/{frame}", [])
            for number in range(EACH):
                for side, (name, curve) in enumerate(TRUTH.items()):
                    x, y = 5.0 * number - 20.0 + 0.1 * frame, 7.5 - 15.0 * side
                    points = int(rng.exponential(15.0))
                    size = (4.2, 1.8, 1.8) if name == "car" else (1.0, 1.0, 1.8)
                    rows.append((f"s{sequence}", frame, name, x, y, 0.9, *size, 0.0, points))
                    if rng.random() < curve.at(np.array([float(points)]))[0]:
                        found.append(detection(name, x + rng.normal(0.0, 0.3), y, 0.9))
                    found.append(detection(name, x, y, 0.1))
            found.append(detection("barrier", 0.0, 0.0, 0.9))
    with (folder / "boxes.csv").open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        file.write("seq,frame,cls,x,y,z,length,width,height,yaw,num_lidar_pts\n")
        writer.writerows(rows)
    (folder / "results.json").write_text(json.dumps({"meta": {}, "results": results}), encoding="utf-8")
    return folder


def detection(name: str, x: float, y: float, score: float) -> dict[str, Any]:
    return {"translation": [x, y, 0.9], "detection_name": name, "detection_score": score}


def test_a_known_curve_is_recovered_within_its_error(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    results, boxes, out = folder / "results.json", folder / "boxes.csv", folder / "mine.yaml"
    assert main(["calibrate", str(results), "--boxes", str(boxes), "--out", str(out)]) == 0
    assert "pedestrian" in capsys.readouterr().out
    found = read_calibration(out)
    assert found == rl.calibrate(results, boxes) and (found.predicts, found.unit) == ("recall", "points")
    assert found.classes.bicycle is None
    n = np.random.default_rng(4).exponential(15.0, 5000).astype(int).astype(float)
    for name, truth in TRUTH.items():
        curve = found.classes.of(name)
        assert curve is not None and curve.objects == SEQUENCES * FRAMES * EACH
        assert 0.0 < abs(float((curve.at(n) - truth.at(n)).mean())) < curve.error < 0.08
    every = rl.calibrate(results, boxes, min_score=0.05).classes.car
    assert every is not None and every.at(n[n > 0.0]).min() > 0.9, "with the poorest detections all are found"


def test_the_calibration_predicts_for_a_rig(folder: Path) -> None:
    calibration = rl.calibrate(folder / "results.json", folder / "boxes.csv")
    with pytest.warns(rl.RigLensWarning, match="num_lidar_pts|no boxes of class bicycle"):
        traffic = rl.load_traffic(folder / "boxes.csv")
    found = rl.targets(rl.open_rig("Center"), traffic, calibration=calibration)
    row = found["car"].total.predicted
    assert row is not None and 0.0 < row.value < 1.0 and row.objects == found["car"].total.objects
    document = found.to_dict()
    assert document["calibration"]["predicts"] == "recall"
    assert document["rigs"][0]["classes"]["bicycle"]["predicted"] is None
    classes = [found[name].total.predicted.value for name in ("car", "pedestrian")]
    assert document["rigs"][0]["predicted_mean"]["value"] == pytest.approx(sum(classes) / 2.0)


def test_points_may_be_those_predicted_for_a_rig(folder: Path) -> None:
    results, boxes = folder / "results.json", folder / "boxes.csv"
    found = rl.calibrate(results, boxes, rig=rl.open_rig("nuScenes car"))
    assert found.classes.car is not None and found != rl.calibrate(results, boxes)


def test_what_cameras_add_is_recovered_from_results_of_pictures_alone(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    boxes, pictures, rig = folder / "boxes.csv", folder / "pictures.json", rl.open_rig("nuScenes car")
    traffic = load_traffic(SceneOptions(boxes=boxes), 50.0)
    counted = TargetEngine(traffic).evaluate(rig, replace(USUAL, body=None))
    table = object_table(counted).to_pylist()
    order = np.argsort(traffic.row[counted.objects.box], kind="stable")
    shown = counted.objects.visible[order].tolist()
    truth, rng = CameraCurve(s=1.2, d0_m=18.0), np.random.default_rng(5)
    calibration = rl.calibrate(folder / "results.json", boxes, rig=rig)
    results = dict[str, list[dict[str, Any]]]()
    for row, visible in zip(table, shown, strict=True):
        most = calibration.classes.of(row["cls"])
        chance = truth.at(np.array([visible]), np.hypot(row["x"], row["y"])[None])[0]
        if most is not None and rng.random() < most.a * chance:
            found = results.setdefault(f"{row['seq']}/{row['frame']}", [])
            found.append(detection(row["cls"], row["x"], row["y"], 0.9))
    pictures.write_text(json.dumps({"results": results}), encoding="utf-8")
    out, given = folder / "both.yaml", ("--boxes", str(boxes), "--rig", "nuScenes car")
    given += ("--camera-results", str(pictures), "--out", str(out))
    assert main(["calibrate", str(folder / "results.json"), *given]) == 0
    both = read_calibration(out)
    assert both.classes == calibration.classes and both.camera is not None
    assert "d0" in capsys.readouterr().out
    for visible, distance_m in ((1.0, 10.0), (0.5, 20.0), (1.0, 30.0)):
        one = both.camera.at(np.array([visible]), np.array([distance_m]))
        assert one == pytest.approx(truth.at(np.array([visible]), np.array([distance_m])), abs=0.05)
    with pytest.raises(InputError, match="rig"):
        rl.calibrate(folder / "results.json", boxes, camera_results=pictures)


@pytest.mark.parametrize(
    ("results", "named"),
    [
        ('{"results": {"s0/0": [{"translation": [0, 0, 0], "detection_name": "car"}]}}', "detection_score"),
        ('{"results": {"s9/0": []}}', "s9/0"),
        (
            '{"results": {"s0/0": [{"translation": [0, 0, 0], "detection_name": "tank", "detection_score": 1}]}}',
            "tank",
        ),
        (
            '{"results": {"s0/0": [{"translation": [0, 0], "detection_name": "car", "detection_score": 1}]}}',
            "transl",
        ),
        (
            '{"results": {"s0/0": [{"translation": [0, 0, NaN], "detection_name": "car", "detection_score": 1}]}}',
            "fin",
        ),
        ('{"results": {"s0/0": [7]}}', "must be a detection"),
        (
            '{"results": {"s0/0": [{"translation": [0, 0, 1%s], "detection_name": "car", "detection_score": 1}]}}'
            % ("0" * 400),
            "below 1e9",
        ),
        ('{"results": {"s0/0": 7}}', "must be a list"),
        ('{"results": {"s0/0": []}}', "at least one detection"),
        (
            '{"results": {"s0/0": [{"translation": [90, 90, 0], "detection_name": "car", "detection_score": 1}]}}',
            "finds no object",
        ),
        ("[]", "'results'"),
        ("{", "must be JSON"),
    ],
)
def test_wrong_results_are_one_line(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], results: str, named: str
) -> None:
    path, out = tmp_path / "results.json", tmp_path / "out.yaml"
    path.write_text(results, encoding="utf-8")
    boxes = str(folder / "boxes.csv")
    assert main(["calibrate", str(path), "--boxes", boxes, "--out", str(out)]) == 2
    error = capsys.readouterr().err.strip().splitlines()[-1]
    assert named in error and "results.json" in error and not out.exists()


def test_boxes_without_points_are_refused(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    lines = (folder / "boxes.csv").read_text(encoding="utf-8").splitlines()
    boxes = tmp_path / "boxes.csv"
    boxes.write_text("\n".join(line.rsplit(",", 1)[0] for line in lines), encoding="utf-8")
    out = str(tmp_path / "out.yaml")
    assert main(["calibrate", str(folder / "results.json"), "--boxes", str(boxes), "--out", out]) == 2
    assert "num_lidar_pts" in capsys.readouterr().err
    assert main(["calibrate", str(folder / "results.json"), "--out", out]) == 2
    assert "--boxes" in capsys.readouterr().err


def test_results_of_a_nuscenes_folder_are_global(tmp_path: Path) -> None:
    write_tables(tmp_path / "v1.0-mini", random_boxes(3, 10, 12), 3, 10)
    table = tmp_path / "v1.0-mini" / "sample_annotation.json"
    records, results = json.loads(table.read_text(encoding="utf-8")), dict[str, list[dict[str, Any]]]()
    for number, record in enumerate(records):
        record["num_lidar_pts"] = points = 7 * number % 40
        found = results.setdefault(record["sample_token"], [])
        name = record["instance_token"].split("-")[-1].removeprefix("human.")
        if points >= 10 and name.split(".")[0] in ("vehicle", "pedestrian"):
            x, y, _ = record["translation"]
            found.append(detection(name.split(".")[1 if name[0] == "v" else 0], x, y, 0.5))
    table.write_text(json.dumps(records), encoding="utf-8")
    (tmp_path / "results.json").write_text(json.dumps({"results": results}), encoding="utf-8")
    with pytest.warns(rl.RigLensWarning, match="middle car"):  # boxes of any size
        found = rl.calibrate(tmp_path / "results.json", tmp_path / "v1.0-mini")
    for name in CLASSES:
        curve = found.classes.of(name)
        assert curve is not None and curve.at(np.array([5.0]))[0] < 0.2 < 0.8 < curve.at(np.array([15.0]))[0]


@pytest.mark.parametrize("count", [FEWEST - 1, FEWEST])
def test_a_class_with_fewer_objects_has_no_curve(tmp_path: Path, count: int) -> None:
    """All with 20 points are found, and none of those with 1."""
    places = [(6.0 * (n % 8) - 21.0, 6.0 * (n // 8) - 12.0, 20 if n % 2 else 1) for n in range(count)]
    rows = [f"s,0,car,{x},{y},0.9,4.2,1.8,1.8,0,{points}" for x, y, points in places]
    boxes, results = tmp_path / "boxes.csv", tmp_path / "results.json"
    boxes.write_text(
        "\n".join(["seq,frame,cls,x,y,z,length,width,height,yaw,num_lidar_pts", *rows, ""]), encoding="utf-8"
    )
    found = [detection("car", x, y, 0.9) for x, y, points in places if points > 1]
    results.write_text(json.dumps({"meta": {}, "results": {"s/0": found}}), encoding="utf-8")
    if count < FEWEST:
        with pytest.raises(InputError, match="no object of a class"):
            rl.calibrate(results, boxes)
    else:
        curve = rl.calibrate(results, boxes).classes.car
        assert curve is not None and curve.objects == count
