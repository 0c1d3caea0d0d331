"""Argoverse 2 logs: cuboids of the ego frame, one frame per sweep with annotations, logs of a folder together."""

import re
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.feather
import pytest
from scipy.spatial.transform import Rotation

from riglens.core.errors import InputError
from riglens.core.scene.boxes import BoxBatch
from riglens.core.scene.readers import open_boxes
from riglens.core.scene.readers.common import join
from tests.core.argoverse_log import random_columns, write_log

HERE = (0.0, 0.0, 0.0)
MAPPED = {"REGULAR_VEHICLE": 0, "BICYCLIST": 1, "PEDESTRIAN": 2}


def read(path: Path, **options: object) -> tuple[BoxBatch, object]:
    source = open_boxes(path, **options)  # type: ignore[arg-type]
    return join(list(source.batches())), source.report()


@pytest.mark.parametrize("compression", ["lz4", "zstd", "uncompressed"])
def test_cuboids_keep_place_size_and_full_rotation(tmp_path: Path, compression: str) -> None:
    columns = random_columns(6, 30)
    turns = Rotation.random(180, random_state=3)
    columns.update(zip(("qx", "qy", "qz", "qw"), turns.as_quat().T, strict=True))
    found, report = read(write_log(tmp_path, columns, compression), origin_m=HERE)
    rows = np.flatnonzero(np.isin(columns["category"], list(MAPPED)))
    assert report.frames == 6
    assert found.frame.tolist() == (rows // 30).tolist()
    assert found.cls.tolist() == [MAPPED[name] for name in columns["category"][rows]]
    for axis, name in enumerate(("tx_m", "ty_m", "tz_m")):
        assert np.array_equal(found.centre_m[:, axis], columns[name][rows])
    for axis, name in enumerate(("length_m", "width_m", "height_m")):
        assert np.array_equal(found.size_m[:, axis], columns[name][rows])
    np.testing.assert_allclose(found.rotation, turns[rows].as_matrix(), atol=1e-12)


def test_rows_may_come_in_any_order(tmp_path: Path) -> None:
    columns = random_columns(5, 20)
    mixed = np.random.default_rng(1).permutation(100)
    sorted_, _ = read(write_log(tmp_path / "a", columns))
    found, _ = read(write_log(tmp_path / "b", {name: column[mixed] for name, column in columns.items()}))
    assert np.array_equal(found.frame, sorted_.frame)
    for frame in range(5):
        here, there = (np.sort(batch.centre_m[batch.frame == frame], axis=0) for batch in (found, sorted_))
        assert np.array_equal(here, there)


def test_the_car_itself_and_street_furniture_are_counted_but_no_traffic(tmp_path: Path) -> None:
    columns = random_columns(5, 40)
    _, report = read(write_log(tmp_path, columns))
    for name in ("EGO_VEHICLE", "BOLLARD"):
        assert report.unmapped[name] == (columns["category"] == name).sum() > 0
    assert sum(report.boxes.values()) == np.isin(columns["category"], list(MAPPED)).sum()


def test_the_ground_is_at_zero_after_the_rear_axle_was_put_at_its_height(tmp_path: Path) -> None:
    found, report = read(write_log(tmp_path, random_columns(3, 50)))
    np.testing.assert_allclose(found.centre_m[:, 2] - found.size_m[:, 2] / 2, 0, atol=1e-9)
    assert any("rear axle is at -1.34 0 0.33 m" in note for note in report.notes)


@pytest.mark.parametrize("depth", ["", "train"])
def test_logs_of_a_folder_add_up(tmp_path: Path, depth: str) -> None:
    for number, sweeps in enumerate((3, 4, 2)):
        write_log(tmp_path / depth / f"log-{number}", random_columns(sweeps, 10, seed=number))
    found, report = read(tmp_path)
    assert report.frames == 9
    assert report.sequences == 3
    assert (np.diff(found.frame) >= 0).all()
    assert found.frame.max() == 8
    one, alone = read(tmp_path / depth / "log-1")
    assert alone.frames == 4
    assert np.array_equal(found.centre_m[(found.frame >= 3) & (found.frame < 7)], one.centre_m)
    assert read(tmp_path, frames=20)[1].frames == 20
    with pytest.raises(InputError, match="must be at least 9"):
        read(tmp_path, frames=5)


def test_the_hash_of_a_folder_follows_what_is_in_it_and_not_how_logs_are_called(tmp_path: Path) -> None:
    for name, seeds in (("a", (1, 2)), ("b", (2, 1)), ("c", (1, 3))):
        for place, seed in enumerate(seeds):
            write_log(tmp_path / name / f"log{place}", random_columns(2, 5, seed=seed))
    a, b, c = (open_boxes(tmp_path / name).content_hash for name in "abc")
    assert a == b != c
    assert open_boxes(tmp_path / "a", frames=9).content_hash != a


def refused(path: Path) -> str:
    with pytest.raises(InputError) as caught:
        list(open_boxes(path).batches())
    message = str(caught.value)
    assert "\n" not in message and "annotations.feather" in message
    return message


def test_columns_and_numbers_that_do_not_fit_are_named(tmp_path: Path) -> None:
    def change(**columns: object) -> str:
        kept = {**random_columns(2, 3), "category": ["BUS"] * 6, **columns}
        kept = {name: column for name, column in kept.items() if column is not None}
        return refused(write_log(tmp_path, kept))  # type: ignore[arg-type]

    assert "column 'qw' is missing" in change(qw=None)
    assert "column 'category': must be text (got type int64)" in change(category=[1] * 6)
    assert "column 'timestamp_ns': must be integers (got type double)" in change(timestamp_ns=[0.5] * 6)
    assert "column 'tx_m' must have a value in every row" in change(tx_m=[1.0, None, 2.0, 3.0, 4.0, 5.0])
    assert re.search("row 4: column 'length_m': .*got -1", change(length_m=[1.0, 1.0, 1.0, -1.0, 1.0, 1.0]))
    assert re.search("row 2: column 'tz_m': .*got nan", change(tz_m=[1.0, float("nan"), 1.0, 1.0, 1.0, 1.0]))
    assert "row 1: qw qx qy qz: " in change(qw=[7.0] * 6)
    assert "got length inf" in change(qw=[1e308] * 6, qz=[1e308] * 6)


def test_what_is_no_feather_file_is_refused(tmp_path: Path) -> None:
    path = write_log(tmp_path, random_columns(2, 3))
    data = path.read_bytes()
    for broken in (b"", b"ARROW1", data[:-30], b"FEA1" + data, data[: len(data) // 2]):
        path.write_bytes(broken)
        assert "damaged Feather file" in refused(path)


def test_a_log_without_any_sweep_is_refused_alone_but_not_among_others(tmp_path: Path) -> None:
    none = {name: column[:0] for name, column in random_columns(1, 1).items()}
    none["category"] = pa.array([], pa.string())
    write_log(tmp_path / "x" / "empty", none)
    with pytest.raises(InputError, match="at least one frame"):
        read_all = open_boxes(tmp_path / "x" / "empty")
        list(read_all.batches())
    write_log(tmp_path / "x" / "full", random_columns(2, 4))
    assert read(tmp_path / "x")[1].frames == 2
