"""The tables of a data set, read as any program reads them: with json and scipy's rotations, and by our own reader."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from riglens.core.scene.readers import open_boxes
from riglens.core.simulate.sweeps import Simulator
from riglens.core.simulate.tables import VISIBLE, Scene, visibility_bin
from riglens.core.simulate.world import Worlds
from riglens.core.targets.traffic import read_traffic
from tests.core.simulate.small import dataset, points_m

Doubles = NDArray[np.float64]


@pytest.fixture(scope="module")
def tables(folder: Path) -> dict[str, dict[str, dict[str, Any]]]:
    """Records by token, by table."""
    names = (
        "sample",
        "sample_data",
        "sample_annotation",
        "calibrated_sensor",
        "ego_pose",
        "sensor",
        "instance",
        "scene",
    )
    read = {
        name: json.loads((folder / "v1.0-trainval" / f"{name}.json").read_text(encoding="utf-8"))
        for name in names
    }
    return {name: {record["token"]: record for record in records} for name, records in read.items()}


def turned(points: Doubles, pose: dict[str, Any]) -> Doubles:
    """Points of a frame in that of its pose."""
    w, x, y, z = pose["rotation"]
    return np.asarray(Rotation.from_quat([x, y, z, w]).apply(points) + pose["translation"])


def of_channel(tables: dict[str, Any], name: str) -> list[dict[str, Any]]:
    """Records of sample_data of a channel."""
    sensors = {token for token, record in tables["sensor"].items() if record["channel"] == name}
    mounted = {
        token for token, record in tables["calibrated_sensor"].items() if record["sensor_token"] in sensors
    }
    return [
        record for record in tables["sample_data"].values() if record["calibrated_sensor_token"] in mounted
    ]


def in_world(folder: Path, tables: dict[str, Any], data: dict[str, Any]) -> Doubles:
    on_car = turned(
        points_m(folder / data["filename"]), tables["calibrated_sensor"][data["calibrated_sensor_token"]]
    )
    return turned(on_car, tables["ego_pose"][data["ego_pose_token"]])


@pytest.mark.parametrize("name", ["sample", "sample_data"])
def test_records_are_linked_forwards_and_backwards(tables: dict[str, Any], name: str) -> None:
    records = tables[name]
    links = {(token, one["next"]) for token, one in records.items() if one["next"]}
    assert links == {(one["prev"], token) for token, one in records.items() if one["prev"]} != set()
    assert all(records[one]["timestamp"] < records[other]["timestamp"] for one, other in links)


def test_points_in_boxes_are_those_of_the_files(folder: Path, tables: dict[str, Any]) -> None:
    points = {
        data["sample_token"]: in_world(folder, tables, data) for data in of_channel(tables, "LIDAR_TOP")
    }
    some = 0
    for one in tables["sample_annotation"].values():
        w, x, y, z = one["rotation"]
        width, length, height = one["size"]
        offset = points[one["sample_token"]] - one["translation"]
        local = np.abs(Rotation.from_quat([x, y, z, w]).inv().apply(offset))
        inside = int((local <= np.array([length, width, height]) / 2.0).all(axis=1).sum())
        assert one["num_lidar_pts"] == inside
        some += inside > 0
    assert some > 40


def test_all_lidars_together_are_the_lidars_one_after_the_other(folder: Path, tables: dict[str, Any]) -> None:
    for sample in tables["sample"]:
        parts = {}
        for name in ("LIDAR_TOP", "LIDAR_LEFT", "LIDAR_RIGHT"):
            (data,) = (one for one in of_channel(tables, name) if one["sample_token"] == sample)
            rings = np.fromfile(folder / data["filename"], np.float32).reshape(-1, 5)[:, 4]
            parts[name] = np.column_stack([in_world(folder, tables, data), rings])
        parts["LIDAR_RIGHT"][:, 3] += 16
        together = np.concatenate([parts["LIDAR_LEFT"], parts["LIDAR_RIGHT"]])
        np.testing.assert_allclose(parts["LIDAR_TOP"], together, atol=1e-4)


def test_the_merged_lidar_looks_ahead_along_y(folder: Path, tables: dict[str, Any]) -> None:
    """As the LIDAR_TOP of nuScenes: x to the right of the car, y ahead; in the middle of the rig's LiDARs."""
    data = of_channel(tables, "LIDAR_TOP")[0]
    pose = tables["calibrated_sensor"][data["calibrated_sensor_token"]]
    ahead, right = turned(np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0]]), {**pose, "translation": [0.0] * 3})
    assert ahead == pytest.approx([1.0, 0.0, 0.0]) and right == pytest.approx([0.0, -1.0, 0.0])
    assert pose["translation"] == pytest.approx([1.35, 0.3, 1.9])  # from under the rear axle


def test_hits_and_visible_shares_are_those_of_the_sweep(tables: dict[str, Any]) -> None:
    what = dataset()
    simulator = Simulator(what.rig, Worlds(what.traffic, what.settings))
    by_sample: dict[str, list[dict[str, Any]]] = {}
    for one in tables["sample_annotation"].values():
        by_sample.setdefault(one["sample_token"], []).append(one)
    for frame, sample in enumerate(tables["sample"]):
        hits = simulator.sweep(frame).hits(len(simulator.worlds.truth(frame).cls)).tolist()
        assert [one["riglens_hits"] for one in by_sample.get(sample, [])] == hits
    shares = [one["riglens_visible"] for one in tables["sample_annotation"].values()]
    known = [share for share in shares if share is not None]  # None: no sensor could see it
    assert all(0.0 <= share <= 1.0 for share in known) and len(set(known)) > 5


def test_visibility_bins_are_those_of_nuscenes() -> None:
    shares = [None, 0.0, 0.399, 0.4, 0.599, 0.6, 0.799, 0.8, 1.0]
    assert [int(visibility_bin(share)) for share in shares] == [1, 1, 1, 2, 2, 3, 3, 4, 4]
    assert VISIBLE == ("v0-40", "v40-60", "v60-80", "v80-100")


def test_one_sequence_in_five_is_for_validation() -> None:
    assert [n for n in range(12) if Scene(n, f"scene {n}", (), ()).is_val] == [4, 9]


def test_our_own_reader_gives_the_boxes_back(folder: Path) -> None:
    what = dataset()
    again = read_traffic(open_boxes(folder / "v1.0-trainval"))
    assert again.frames == what.traffic.frames
    for frame in range(again.frames):
        mine = np.flatnonzero(what.traffic.frame_of_box == np.flatnonzero(what.traffic.frame == frame)[0])
        theirs = np.flatnonzero(again.frame_of_box == np.flatnonzero(again.frame == frame)[0])
        np.testing.assert_array_equal(what.traffic.cls[mine], again.cls[theirs])
        np.testing.assert_allclose(what.traffic.centre_m[mine], again.centre_m[theirs], atol=1e-9)
        np.testing.assert_allclose(what.traffic.rotation[mine], again.rotation[theirs], atol=1e-9)
