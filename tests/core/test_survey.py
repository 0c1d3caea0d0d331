"""A survey counts boxes by direction and distance, and finds the ground below them."""

import csv
import gzip
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from riglens.core.scene.boxes import CLASSES
from riglens.core.scene.readers import open_boxes
from riglens.core.scene.statistics import RINGS_M, SECTORS, BoxStatistics, BoxTally
from riglens.core.scene.survey import doubts, survey
from tests.core.builders import Boxes, boxes_of

CAR = (4.5, 1.9, 1.6)


def at(angle_deg: float, distance_m: float, cls: int = 0, frame: int = 0):  # type: ignore[no-untyped-def]
    x, y = (distance_m * f(math.radians(angle_deg)) for f in (math.cos, math.sin))
    return frame, cls, (x, y, 0.8), CAR, 0.0


@pytest.mark.parametrize(
    ("angle_deg", "sector"),
    [(0, "front"), (44, "front"), (-44, "front"), (46, "left"), (134, "left"), (136, "rear"), (180, "rear"),
     (-136, "rear"), (-134, "right"), (-46, "right")],
)  # fmt: skip
def test_quarters_are_those_around_the_car(angle_deg: float, sector: str) -> None:
    found = survey(boxes_of(at(angle_deg, 12.0), frames=1))
    assert found.counts[0, SECTORS.index(sector)].sum() == found.counts.sum() == 1


@pytest.mark.parametrize(
    ("distance_m", "ring"), [(0.5, 0), (9.99, 0), (10.01, 1), (29, 2), (31, 3), (500, 4)]
)
def test_rings_are_those_of_the_distance_on_the_ground(distance_m: float, ring: int) -> None:
    assert survey(boxes_of(at(20, distance_m), frames=1)).counts[0, 0, ring] == 1
    assert len(RINGS_M) == 6


def test_boxes_per_frame_count_frames_without_boxes_too() -> None:
    found = survey(boxes_of(at(0, 5), at(0, 9), at(9, 5, 2), at(0, 5, frame=3), frames=8))
    assert (found.boxes_per_frame, found.most_in_a_frame, found.frames_with_boxes) == (0.5, 3, 2)
    assert found.counts.sum(axis=(1, 2)).tolist() == [3, 0, 1]


def test_sizes_are_medians_and_unknown_without_boxes() -> None:
    rows = [(0, 0, (5.0, n, 1.0), (4.0 + n, 2.0, 1.5), 0.0) for n in range(3)]
    sizes = survey(boxes_of(*rows, frames=1)).sizes_m
    np.testing.assert_allclose(sizes[0], [5.0, 2.0, 1.5], atol=0.011)
    assert np.isnan(sizes[1:]).all()


def test_a_quarter_with_next_to_nothing_is_told() -> None:
    ahead = [at(angle, 15, frame=angle + 40) for angle in range(-40, 40)] * 2
    rows = sorted([*ahead, at(90, 10)], key=lambda row: row[0])
    assert survey(boxes_of(*rows, frames=90)).bare_sectors() == {"left": 1, "rear": 0, "right": 0}
    assert survey(boxes_of(frames=3)).bare_sectors() == {}
    around = [at(angle, 10) for angle in range(0, 360, 10)]
    assert survey(boxes_of(*around, frames=1)).bare_sectors() == {}


def boxes_on(ground_m: float, seed: int, count: int = 60, cls: int = 0) -> Boxes:
    """Boxes that stand on a ground, some of them anywhere else: wrong labels, bridges, far hills."""
    random = np.random.default_rng(seed)
    size = random.uniform([3, 1.5, 1.2], [5, 2, 3], (count, 3))
    bottom = ground_m + random.normal(0, 0.05, count)
    bottom[: count // 5] += random.uniform(-3, 3, count // 5)
    centre = np.column_stack([random.uniform(-12, 12, (count, 2)), bottom + size[:, 2] / 2])
    centre[-10:, 0] += 60  # far away and far below
    centre[-10:, 2] -= 8
    rotation = np.tile(np.eye(3), (count, 1, 1))
    return Boxes(np.arange(count), np.full(count, cls, np.uint8), centre, size, rotation, count)


@given(st.floats(-3, 3), st.integers(0, 1000))
def test_the_ground_is_found_among_outliers(ground_m: float, seed: int) -> None:
    ground = survey(boxes_on(ground_m, seed)).ground
    assert ground is not None and ground.is_certain
    assert ground.height_m == pytest.approx(ground_m, abs=0.06)
    assert ground.lift_m == pytest.approx(-ground_m, abs=0.07)
    assert ground.boxes == 50


def test_a_ground_off_zero_is_doubted_with_the_origin_that_mends_it() -> None:
    off, level = boxes_on(-1.7, 1), boxes_on(0.05, 1)
    (doubt,) = doubts(off.report())
    origin_m = doubt.remedies["origin_m"]
    assert isinstance(origin_m, tuple) and origin_m[2] == pytest.approx(1.7, abs=0.06)
    assert doubts(level.report()) == []
    tally = replace(off.report().statistics or BoxStatistics(), is_origin_known=True)
    assert doubts(replace(off.report(), statistics=tally)) == []  # the format says where the ground is
    assert doubts(replace(off.report(), statistics=None)) == []


@given(st.integers(0, 1000), st.integers(1, 59))
def test_statistics_of_parts_add_up_to_those_of_the_whole(seed: int, border: int) -> None:
    whole = boxes_on(-1.0, seed)
    tallies = []
    for rows in (whole.frame < border, whole.frame >= border):
        tallies.append(BoxTally())
        columns = (whole.frame, whole.cls, whole.centre_m, whole.size_m, whole.rotation)
        tallies[-1].add(*(column[rows] for column in columns))
    parts = [tally.statistics((0.0, 0.0, 0.0)) for tally in tallies]
    assert BoxStatistics.joined(parts) == whole.report().statistics
    assert BoxStatistics.joined([parts[0], None]) is None
    moved = replace(parts[0], origin_m=(1.0, 0.0, 0.0))
    joined = BoxStatistics.joined([moved, parts[1]])
    assert joined is not None and joined.origin_m is None


def test_pedestrians_stand_in_where_there_are_no_cars() -> None:
    ground = survey(boxes_on(0.5, 1, cls=2)).ground
    assert ground is not None
    assert ground.cls == "pedestrian" == CLASSES[2]


def test_a_ground_nobody_agrees_on_is_not_certain() -> None:
    random = np.random.default_rng(3)
    rows = [(n, 0, (5.0, 1.0, float(random.uniform(-3, 3))), CAR, 0.0) for n in range(50)]
    ground = survey(boxes_of(*rows, frames=50)).ground
    assert ground is not None and not ground.is_certain
    few = survey(boxes_of(at(0, 5), frames=1)).ground
    assert few is not None and not few.is_certain
    assert survey(boxes_of(at(0, 50), frames=1)).ground is None


@pytest.mark.parametrize("share", [0.3, 0.5, 0.6])
@pytest.mark.parametrize("apart_m", [0.3, 0.36, 0.45])
def test_two_heights_are_no_ground(share: float, apart_m: float) -> None:
    """As in a log of Argoverse 2: half of all bottoms between -0.34 and 0.01 m, and hardly any in the middle."""
    random = np.random.default_rng(4)
    low = random.random(400) < share
    bottom = np.where(low, -apart_m, 0.0) + random.normal(0, 0.03, 400)
    rows = [(n, 0, (5.0, 1.0, float(z) + CAR[2] / 2), CAR, 0.0) for n, z in enumerate(bottom)]
    ground = survey(boxes_of(*rows, frames=400)).ground
    assert ground is not None and not ground.is_certain
    assert ground.peaks_m == pytest.approx((-apart_m, 0.0), abs=0.08)
    assert "crowded around -0." in ground.text()


def test_bottoms_with_one_height_crowd_around_it() -> None:
    random = np.random.default_rng(5)
    for spread_m in (0.02, 0.1, 0.2):
        bottom = random.normal(-1.7, spread_m, 2000)
        rows = [(n, 0, (5.0, 1.0, float(z) + CAR[2] / 2), CAR, 0.0) for n, z in enumerate(bottom)]
        ground = survey(boxes_of(*rows, frames=2000)).ground
        assert ground is not None and ground.is_certain and len(ground.peaks_m) == 1


# ---------------------------------------------------------------- plausibility


def road(seed: int = 1, frames: int = 60) -> Boxes:
    """Traffic of the right-hand side on a road along x: lanes ahead and behind, oncoming cars, parked ones, people."""
    random = np.random.default_rng(seed)
    rows = []
    for frame in range(frames):
        cars = [
            (random.uniform(6, 40) * random.choice([-1, 1]), random.normal(0, 0.3), 0.0) for _ in range(3)
        ]
        cars += [(random.uniform(-40, 40), 3.5 + random.normal(0, 0.3), math.pi) for _ in range(3)]
        cars += [(random.normal(0, 1.0), random.uniform(8, 40) * random.choice([-1, 1]), 0.0)]
        for x, y, yaw in cars:
            height = random.choice([1.4, 1.5, 1.7, 3.2])
            size = (random.uniform(3.8, 5.0), random.uniform(1.7, 2.0), height)
            rows.append(
                (frame, 0, (x, y, height / 2 + random.normal(0, 0.03)), size, yaw + random.normal(0, 0.05))
            )
        begin, slant = random.uniform(10, 20), random.uniform(0.3, 0.6)  # a queue in a side street
        for place in (begin, begin + 6.0):
            middle = (place * math.cos(slant) + 5.0, place * math.sin(slant) + 8.0, 0.8)
            rows.append((frame, 0, middle, (4.5, 1.8, 1.6), slant))
        for _ in range(3):
            height = random.uniform(1.0, 2.0)
            place = (random.uniform(-15, 15), random.choice([-6, 6]) + random.normal(0, 0.3), height / 2)
            rows.append((frame, 2, place, (0.7, 0.6, height), random.uniform(-3, 3)))
    return boxes_of(*rows, frames=frames)


def turn(boxes: Boxes, matrix: list[list[float]]) -> Boxes:
    """Boxes in other axes: places and rotations are multiplied by a matrix."""
    axes = np.array(matrix)
    return replace(boxes, centre_m=boxes.centre_m @ axes.T, rotation=axes @ boxes.rotation)


def about_z(yaw: NDArray[np.float64]) -> NDArray[np.float64]:
    """Rotations (n, 3, 3) about z."""
    c, s, o = np.cos(yaw), np.sin(yaw), np.zeros_like(yaw)
    return np.moveaxis(np.array([[c, -s, o], [s, c, o], [o, o, o + 1.0]]), 2, 0)


def yaw_of(boxes: Boxes) -> NDArray[np.float64]:
    return np.arctan2(boxes.rotation[:, 1, 0], boxes.rotation[:, 0, 0])


SPOILED = {
    "shifted": ("the ground is not at z = 0", lambda b: replace(b, centre_m=b.centre_m - [0.0, 0.0, 2.3])),
    "swapped": ("length and width are swapped", lambda b: replace(b, size_m=b.size_m[:, [1, 0, 2]])),
    "half edges": ("half edges", lambda b: replace(b, size_m=b.size_m / 2, centre_m=b.centre_m * [1, 1, 0.5])),
    "turned": ("across the road", lambda b: turn(b, [[0, -1, 0], [1, 0, 0], [0, 0, 1]])),
    "turned to the right": ("across the road", lambda b: turn(b, [[0, 1, 0], [-1, 0, 0], [0, 0, 1]])),
    "turned round": ("x points backwards", lambda b: turn(b, [[-1, 0, 0], [0, -1, 0], [0, 0, 1]])),
    "yaw turned": (
        "across the road",
        lambda b: replace(b, rotation=b.rotation @ np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])),
    ),
    "aslant": ("cars stand aslant", lambda b: turn(b, about_z(np.array([math.pi / 6]))[0].tolist())),
    "yaw aslant": ("cars stand aslant", lambda b: replace(b, rotation=about_z(yaw_of(b) - math.pi / 6))),
    "yaw reversed": ("cars head against their rows", lambda b: replace(b, rotation=about_z(-yaw_of(b)))),
    "mirrored": ("a y axis that points right", lambda b: turn(b, [[1, 0, 0], [0, -1, 0], [0, 0, 1]])),
    "ahead": (
        "may not cover every side",
        lambda b: replace(b, centre_m=b.centre_m * [0.0, 0.1, 1.0] + [25.0, 0.0, 0.0]),
    ),
    "one frame again and again": (
        "equal the one before",
        lambda b: replace(
            b, **{name: np.tile(getattr(b, name)[:10], (6,) + (1,) * (getattr(b, name).ndim - 1)) for name in COLUMNS},
            frame=np.repeat(np.arange(6), 10), frames=6,
        ),
    ),
}  # fmt: skip
COLUMNS = ("cls", "centre_m", "size_m", "rotation")


def test_sound_boxes_are_not_doubted() -> None:
    for seed in range(20):
        assert doubts(road(seed).report()) == []


@pytest.mark.parametrize("case", SPOILED)
def test_spoiled_boxes_are_doubted(case: str) -> None:
    said, spoil = SPOILED[case]
    facts = [doubt.fact for doubt in doubts(spoil(road()).report())]
    assert any(said in fact for fact in facts) and all("\n" not in fact for fact in facts)


@pytest.mark.parametrize("origin_m", [(-1.35, 0.0, 0.0), (0.0, 0.0, 0.0)])
@pytest.mark.parametrize("quarters", [1, 2, 3])
def test_tables_turned_before_their_origin_is_added_are_doubted(
    shared_data: Path, tmp_path: Path, quarters: int, origin_m: tuple[float, float, float]
) -> None:
    path = shared_data / "boxes" / "nuscenes_mini_val_ego.csv.gz"
    if not path.is_file():
        pytest.skip("the real boxes are not on this machine")
    with gzip.open(path, "rt", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    for row in rows:
        for _ in range(quarters):
            row["x"], row["y"] = str(-float(row["y"])), row["x"]
        row["yaw"] = str(float(row["yaw"]) + quarters * math.pi / 2)
    with (tmp_path / "turned.csv").open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)
    source = open_boxes(tmp_path / "turned.csv", origin_m)
    list(source.batches())
    said = "x points backwards" if quarters == 2 else "across the road"
    assert any(said in doubt.fact for doubt in doubts(source.report()))


def test_boxes_given_by_their_foot_are_doubted() -> None:
    boxes = road()
    foot = replace(boxes, centre_m=boxes.centre_m - np.outer(boxes.size_m[:, 2] / 2, [0.0, 0.0, 1.0]))
    assert any("the foot of the boxes" in doubt.fact for doubt in doubts(foot.report()))


@pytest.mark.parametrize(
    "case", ["shifted", "swapped", "turned", "turned to the right", "turned round", "yaw turned", "mirrored", "aslant",
     "yaw aslant", "yaw reversed"],
)  # fmt: skip
@pytest.mark.parametrize("name", ["kitti_tracking_velo", "nuscenes_mini_val_ego"])
def test_real_boxes_are_doubted_only_where_they_are_spoiled(shared_data: Path, name: str, case: str) -> None:
    path = shared_data / "boxes" / f"{name}.csv.gz"
    if not path.is_file():
        pytest.skip("the real boxes are not on this machine")
    source = open_boxes(path, (0.4, 0.0, 1.73) if name.startswith("kitti") else (-1.35, 0.0, 0.0))
    batches = list(source.batches())
    columns = {
        column: np.concatenate([getattr(one, column) for one in batches]) for column in ("frame", *COLUMNS)
    }
    boxes = Boxes(**columns, frames=source.report().frames)
    sides = "may not cover every side"  # KITTI has boxes ahead only
    assert [doubt for doubt in doubts(boxes.report()) if sides not in doubt.fact] == []
    said, spoil = SPOILED[case]
    facts = [doubt.fact for doubt in doubts(spoil(boxes).report())]
    assert any(said in fact for fact in facts)
    assert "aslant" not in said or not any("against their rows" in fact for fact in facts)
