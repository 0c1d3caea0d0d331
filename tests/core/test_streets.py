"""Streets of a map: the town's traffic drives on their asphalt, and their marks end before crossings."""

from __future__ import annotations

import csv
import gzip
import math
from collections import Counter
from itertools import islice

import numpy as np
import pytest
from matplotlib.path import Path as Outline
from numpy.typing import NDArray

from riglens.core.scene.boxes import DataReport, FrameLabels
from riglens.core.scene.occluders import MapPose
from riglens.core.scene.readers import bundled
from riglens.core.scene.streets import Street, Streets, surfaces

LANES = (("sidewalk", 3.0), ("bike", 1.8), ("motor", 3.2), ("motor", 3.2))


def on_any(quads: NDArray[np.float64], places: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return which places (n, 2) lie in a quadrangle (q, 4, 2)."""
    return np.any([Outline(quad).contains_points(places, radius=1e-9) for quad in quads], axis=0)


def town(frames: int) -> DataReport:
    labels = FrameLabels(("0",), np.zeros(frames, np.int64), np.arange(frames))
    return DataReport(bundled._NAME, frames, {}, labels=labels)


def test_the_towns_cars_are_on_asphalt_and_its_pedestrians_mostly_beside_it() -> None:
    on: Counter[tuple[str, bool]] = Counter()
    with gzip.open(bundled._folder() / "boxes.csv.gz", "rt", encoding="utf-8") as stream:
        rows = [row for row in islice(csv.DictReader(stream), 3000) if row["seq"] == "0"]
    for number in sorted({int(row["frame"]) for row in rows})[::10]:
        view = bundled.streets_around(town(50), number)
        assert view is not None
        there = [row for row in rows if int(row["frame"]) == number]
        places = np.array([(float(row["x"]), float(row["y"])) for row in there])
        for row, is_on in zip(there, on_any(view.asphalt, places).tolist(), strict=True):
            on[row["cls"], is_on] += 1
        assert on_any(view.asphalt, np.zeros((1, 2))).all(), "the car itself"
    assert on["car", True] > 100 and on["car", False] == 0
    assert on["pedestrian", False] > 4 * on["pedestrian", True]


def test_other_data_have_no_streets() -> None:
    data = town(1)
    assert bundled.streets_around(DataReport("own.csv", 1, {}, labels=data.labels), 0) is None
    assert bundled.streets_around(DataReport(data.source, 1, {}), 0) is None


def test_marks_follow_the_lanes_and_end_before_a_crossing() -> None:
    east = Street(np.array([(0.0, 0.0), (100.0, 0.0)]), LANES)
    beyond = Street(np.array([(100.0, 0.0), (200.0, 0.0)]), LANES)
    north = Street(np.array([(100.0, 0.0), (100.0, 80.0)]), (("motor", 4.0),))
    assert east.half_m == pytest.approx(8.2)
    alone, crossed = surfaces([east]), surfaces([east, beyond, north])
    across = {round(abs(y), 2) for y in alone.marks.mean(axis=1)[:, 1].tolist()}
    assert across == {0.13, 3.2, 6.4, 8.06}, "double line, dashes, line of the bike lane, kerb"
    assert alone.marks[..., 0].max() == pytest.approx(100.0)
    of_east = crossed.marks[(crossed.marks[..., 0] < 95.0).all(axis=1)]
    at_north = (np.abs(crossed.marks[..., 0] - 100.0) < 4.2).all(axis=1)
    assert of_east[..., 0].max() == pytest.approx(100.0 - 8.2 - 2.0), "its own width goes on beyond"
    assert crossed.marks[at_north][..., 1].min() == pytest.approx(8.2 + 2.0)
    assert on_any(crossed.asphalt, crossed.marks.mean(axis=1)).all()


def test_a_view_is_turned_into_the_frame_of_the_car() -> None:
    whole = surfaces([Street(np.array([(0.0, 0.0), (60.0, 0.0)]), (("motor", 3.0),))])
    poses = {
        ("a", 0): MapPose("m", (10.0, 0.0, 0.0), math.pi / 2),
        ("a", 1): MapPose("other", (0.0, 0.0, 0.0), 0.0),
    }
    streets = Streets({"m": whole}, poses)
    view = streets.around(("a", 0), reach_m=30.0)
    assert view is not None
    assert np.abs(view.asphalt[..., 0]).max() == pytest.approx(3.0)
    assert view.asphalt[..., 1].max() == pytest.approx(13.0) and view.asphalt[..., 1].min() < -25.0
    assert len(view.asphalt) < len(whole.asphalt)
    assert streets.around(("a", 1)) is None and streets.around(("b", 0)) is None
