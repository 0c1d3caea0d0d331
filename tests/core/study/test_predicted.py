"""Curves of predicted detection: the shipped file is the fit of committed tables; known curves are recovered."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from riglens.core.errors import InputError
from riglens.core.scene.boxes import CLASSES
from riglens.core.study.curves import FoundObjects, MeansOfRigs
from riglens.core.study.detection.published import PROTOCOL, published_rigs
from riglens.core.study.detection.second import PROTOCOLS, second_rigs
from riglens.core.study.predicted import (
    GOAL_ERROR,
    GOAL_RANK,
    calibrate_recall,
    calibrate_rigs,
    read_precision,
)
from riglens.core.study.ranks import spearman
from riglens.core.targets.calibration import MOST, Curve, shipped, shipped_recall

DATA = Path(__file__).resolve().parents[3] / "docs" / "data"


def counts() -> NDArray[np.int64]:
    names = [rig.name for rig in published_rigs()]
    found = np.zeros((len(names), len(CLASSES), MOST + 1), np.int64)
    with (DATA / "predicted-detection-cells.csv").open(encoding="utf-8") as file:
        for line in csv.DictReader(file):
            place = names.index(line["rig"]), CLASSES.index(line["class"]), int(line["cells"])
            found[place] = int(line["objects"])
    return found


def test_the_shipped_calibration_is_the_fit_of_the_committed_tables() -> None:
    rigs, objects = published_rigs(), counts()
    with (DATA / "detection.csv").open(encoding="utf-8") as file:
        rays = {line["rig"]: int(line["rays"]) for line in csv.DictReader(file)}
    observed = read_precision(DATA / "detection.csv", rigs)
    found = calibrate_rigs(rays, objects, observed, "cells", PROTOCOL)
    assert found.calibration.domain == shipped().domain
    for number, name in enumerate(CLASSES):
        mine, asset = found.calibration.classes.of(name), shipped().classes.of(name)
        assert mine is not None and asset is not None
        assert mine.error == pytest.approx(asset.error, abs=1e-4)
        n = np.flatnonzero(objects[:, number].any(axis=0)).astype(np.float64)
        assert asset.at(n) == pytest.approx(mine.at(n), abs=1e-3)
    assert found.errors()[-1] == pytest.approx(shipped().mean_error, abs=1e-4)
    assert found.errors()[-1] <= GOAL_ERROR and found.rank() >= GOAL_RANK
    with (DATA / "predicted-detection.csv").open(encoding="utf-8") as file:
        printed = {(line["rig"], line["class"]): float(line["predicted"]) for line in csv.DictReader(file)}
    table = [[printed[rig, name] for name in CLASSES] for rig in found.rigs]
    assert 100.0 * found.left_out == pytest.approx(np.array(table), abs=0.02)


def test_the_shipped_recall_is_the_fit_of_the_committed_table_and_predicts_its_rigs() -> None:
    table = DATA / "detection2-recall-points.csv"
    found, asset = calibrate_recall(table, second_rigs(), PROTOCOLS["one-sweep"]), shipped_recall()
    assert (found.predicts, found.unit, found.domain) == (asset.predicts, asset.unit, asset.domain)
    with table.open(encoding="utf-8") as file:
        lines = list(csv.DictReader(file))
    for name in CLASSES:
        mine, theirs = found.classes.of(name), asset.classes.of(name)
        assert mine is not None and theirs is not None and mine.objects == theirs.objects
        assert mine.error == pytest.approx(theirs.error, abs=1e-4)
        assert theirs.at(np.arange(60.0)) == pytest.approx(mine.at(np.arange(60.0)), abs=1e-3)
        of = [line for line in lines if line["cls"] == name and line["group"] == "rig"]
        n, objects, hits = (
            np.array([float(line[key]) for line in of]) for key in ("points", "objects", "found")
        )
        places = {
            rig: np.array([line["name"] == rig for line in of]) for rig in {line["name"] for line in of}
        }
        assert len(places) == 23
        shares = np.array(
            [(objects[at] @ theirs.at(n[at]), hits[at].sum()) / objects[at].sum() for at in places.values()]
        )
        assert float(spearman(*shares.T)) > 0.97
        assert np.sqrt(np.mean((shares[:, 0] - shares[:, 1]) ** 2)) < theirs.error < 0.06


@pytest.mark.parametrize(
    "text", ["", "group,name,cls\nrig,a,car\n", "group,name,cls,points,objects,found\nrig,a,car,x,1,1\n"]
)
def test_a_table_without_recall_is_refused(tmp_path: Path, text: str) -> None:
    path = tmp_path / "points.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=r"must be the detection-recall-points\.csv"):
        calibrate_recall(path, second_rigs(), PROTOCOLS["one-sweep"])


def test_a_curve_is_recovered_from_means_of_rigs() -> None:
    truth = Curve(a=0.85, b=8.0, c=1.4, error=0.0, objects=1)
    rng, n = np.random.default_rng(1), np.arange(60.0)
    objects = np.array([rng.poisson(400.0 * np.exp(-n / scale)) for scale in np.linspace(2.0, 40.0, 12)])
    means = MeansOfRigs(n, objects.astype(np.float64), np.zeros(12))
    observed = means.predicted(truth)
    curve, left_out = MeansOfRigs(n, means.objects, observed).fitted()
    assert curve.at(n) == pytest.approx(truth.at(n), abs=1e-4) and curve.error < 1e-4
    assert left_out == pytest.approx(observed, abs=1e-4)


def test_recall_is_recovered_from_objects_within_its_error() -> None:
    truth = Curve(a=0.9, b=12.0, c=0.8, error=0.0, objects=1)
    rng, n = np.random.default_rng(2), np.arange(80.0)
    objects = rng.poisson(20.0 * np.exp(-n / 20.0), (8, 80))
    found = rng.binomial(objects, truth.at(n))
    curve = FoundObjects(n, objects.astype(np.float64), found.astype(np.float64)).fitted()
    every = objects.sum(axis=0)
    miss = abs(float(every @ (curve.at(n) - truth.at(n))) / every.sum())
    assert 0.0 < miss < curve.error < 0.05
    one = FoundObjects(n, objects[:1].astype(np.float64), found[:1].astype(np.float64)).fitted()
    assert one.error == 1.0, "a single sequence says nothing of others"


@pytest.mark.parametrize("text", ["", "rig,class\nCenter,car\n", "rig,class,ap\nCenter,car,many\n"])
def test_a_table_without_average_precision_is_refused(tmp_path: Path, text: str) -> None:
    path = tmp_path / "detection.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=r"must be the detection\.csv"):
        read_precision(path, published_rigs())
