"""Frames keep the names of their data set, so that a row of an object table can be found in it again."""

import json
from pathlib import Path

import numpy as np

from riglens.core.scene.readers import open_boxes
from tests.core.argoverse_log import random_columns, write_log
from tests.core.nuscenes_folder import random_boxes, write_tables
from tests.core.sound_boxes import CALIB, LABEL, kitti_tracking


def names(path: Path) -> list[tuple[str, int]]:
    source = open_boxes(path)
    for _ in source.batches():
        pass
    report = source.report()
    assert report.labels is not None
    return [report.labels.of(frame) for frame in range(report.frames)]


def test_of_kitti_they_are_sequence_and_frame(tmp_path: Path) -> None:
    assert names(kitti_tracking(tmp_path).path) == [("0000", 0), ("0000", 1), ("0000", 2)]


def test_of_single_kitti_frames_they_are_the_folder_and_the_number_of_the_file(tmp_path: Path) -> None:
    folder = tmp_path / "training"
    for number in (3, 12):
        for name, content in (("label_2", LABEL.splitlines()[0].partition(b" ")[2][2:]), ("calib", CALIB)):
            (folder / name).mkdir(parents=True, exist_ok=True)
            (folder / name / f"{number:06}.txt").write_bytes(content + b"\n")
    assert names(folder) == [("training", 3), ("training", 12)]


def test_of_argoverse_they_are_the_log_and_the_time_of_the_sweep(tmp_path: Path) -> None:
    columns = random_columns(3, 4)
    for log in ("one", "two"):
        write_log(tmp_path / log, columns)
    times = [int(time) for time in np.unique(columns["timestamp_ns"])]
    assert names(tmp_path) == [(log, time) for log in ("one", "two") for time in times]


def test_of_nuscenes_they_are_the_scene_and_the_number_of_the_sample(tmp_path: Path) -> None:
    folder = write_tables(tmp_path, random_boxes(2, 3, 2), 2, 3)
    counted = [(f"scene-{scene}", sample) for scene in range(2) for sample in range(3)]
    assert names(tmp_path) == counted
    tables = next(folder.rglob("sample.json")).parent
    (tables / "scene.json").write_text(
        json.dumps([{"token": "scene-0", "name": "scene-0061"}]), encoding="utf-8"
    )
    assert names(tmp_path) == [(name.replace("scene-0", "scene-0061"), sample) for name, sample in counted]
