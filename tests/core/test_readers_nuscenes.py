"""nuScenes tables: annotations of the global frame come out in the ego frame of their sample's LiDAR sweep."""

import gzip
import json
import math
import re
import tempfile
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from riglens.core.errors import InputError
from riglens.core.scene.boxes import CLASSES, BoxBatch
from riglens.core.scene.readers import open_boxes
from riglens.core.scene.readers.common import join
from tests.core.nuscenes_folder import compress, random_boxes, write_tables

MAPPED = {"vehicle.car": 0, "vehicle.bicycle": 1, "human.pedestrian.adult": 2}
HERE = (0.0, 0.0, 0.0)


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory):  # type: ignore[no-untyped-def]
    """A data set of three scenes with four samples each, the last one without boxes."""
    boxes = random_boxes(scenes=3, samples=3, per_sample=20)
    folder = tmp_path_factory.mktemp("nuscenes")
    write_tables(folder / "v1.0-mini", boxes, scenes=3, samples=4)
    return folder, boxes


def read(path: Path, **options: object) -> tuple[BoxBatch, object]:
    source = open_boxes(path, **options)  # type: ignore[arg-type]
    return join(list(source.batches())), source.report()


def order(centre: np.ndarray) -> np.ndarray:
    return np.lexsort(centre.round(6).T)


def test_boxes_come_out_as_scipy_placed_them(written) -> None:  # type: ignore[no-untyped-def]
    folder, boxes = written
    expected = [box for box in boxes if box.category in MAPPED]
    found, _ = read(folder, origin_m=HERE)
    assert found.frame.size == len(expected)
    centre = np.array([box.centre_m for box in expected])
    here, there = order(found.centre_m), order(centre)
    np.testing.assert_allclose(found.centre_m[here], centre[there], atol=1e-9)
    size = np.array([box.size_m for box in expected])
    np.testing.assert_allclose(found.size_m[here], size[there])
    rotation = np.array([box.rotation.as_matrix() for box in expected])
    np.testing.assert_allclose(found.rotation[here], rotation[there], atol=1e-12)
    assert found.cls[here].tolist() == [MAPPED[expected[i].category] for i in there]


def test_frames_are_samples_in_order_of_time_and_stay_together(written) -> None:  # type: ignore[no-untyped-def]
    folder, boxes = written
    found, report = read(folder, origin_m=HERE)
    assert report.frames == 12
    assert report.sequences == 3
    assert (np.diff(found.frame) >= 0).all()
    for box in boxes:
        if box.category in MAPPED:
            row = np.argmin(np.linalg.norm(found.centre_m - box.centre_m, axis=1))
            first = found.frame[np.argmin(np.linalg.norm(found.centre_m - boxes[0].centre_m, axis=1))]
            assert found.frame[row] % 4 == box.sample
            assert (found.frame[row] // 4 == first // 4) == (box.scene == 0)


def test_what_is_not_mapped_is_counted_by_category(written) -> None:  # type: ignore[no-untyped-def]
    folder, boxes = written
    _, report = read(folder)
    counts = Counter(box.category for box in boxes)
    assert report.unmapped == Counter({name: n for name, n in counts.items() if name not in MAPPED})
    assert report.boxes == {cls: counts[name] for cls, name in zip(CLASSES, MAPPED, strict=True)}
    _, other = read(folder, class_map={"static_object.bicycle_rack": "bicycle", "vehicle.car": "ignore"})
    assert other.boxes["bicycle"] == counts["vehicle.bicycle"] + counts["static_object.bicycle_rack"]
    assert other.unmapped["vehicle.car"] == counts["vehicle.car"]


def test_the_ego_frame_starts_at_the_rear_axle_unless_told_otherwise(written) -> None:  # type: ignore[no-untyped-def]
    folder, _ = written
    (moved, report), (raw, _) = read(folder), read(folder, origin_m=HERE)
    np.testing.assert_allclose(moved.centre_m - raw.centre_m, np.tile([-1.35, 0, 0], (raw.frame.size, 1)))
    assert any("rear axle" in note and "-1.35" in note for note in report.notes)


def test_compressed_tables_and_the_version_folder_itself_read_the_same(written, tmp_path) -> None:  # type: ignore[no-untyped-def]
    folder, boxes = written
    write_tables(tmp_path / "v1.0-mini", boxes, scenes=3, samples=4)
    compress(tmp_path / "v1.0-mini")
    (plain, _), (packed, _) = read(folder), read(tmp_path / "v1.0-mini")
    assert np.array_equal(plain.centre_m, packed.centre_m)
    assert np.array_equal(plain.frame, packed.frame)


def test_two_versions_in_one_folder_have_to_be_named(written, tmp_path) -> None:  # type: ignore[no-untyped-def]
    _, boxes = written
    for name in ("v1.0-mini", "v1.0-trainval"):
        write_tables(tmp_path / name, boxes, scenes=3, samples=4)
    with pytest.raises(InputError, match=r"v1\.0-mini, v1\.0-trainval"):
        open_boxes(tmp_path)


@pytest.mark.parametrize("channel", ["LIDAR_CONCAT", "LIDAR_LEFT", "lidar_front"])
def test_the_sweeps_of_another_lidar_serve_where_there_is_no_top(tmp_path: Path, channel: str) -> None:
    boxes = random_boxes(scenes=2, samples=2, per_sample=9)
    write_tables(tmp_path, boxes, scenes=2, samples=2)
    expected, _ = read(tmp_path, origin_m=HERE)
    sensors = json.loads((tmp_path / "sensor.json").read_text(encoding="utf-8"))
    for sensor in sensors:
        sensor["channel"] = channel if sensor["channel"] == "LIDAR_TOP" else sensor["channel"]
    (tmp_path / "sensor.json").write_text(json.dumps(sensors), encoding="utf-8")
    found, report = read(tmp_path, origin_m=HERE)
    assert np.array_equal(found.centre_m, expected.centre_m)
    assert any(channel in note for note in report.notes)  # type: ignore[attr-defined]


@pytest.mark.parametrize("inner", ["v1.01-train", "data/v1.0-trainval", "some/tables"])
def test_tables_in_outer_folders_are_found(written, tmp_path: Path, inner: str) -> None:  # type: ignore[no-untyped-def]
    _, boxes = written
    write_tables(tmp_path / inner, boxes, scenes=3, samples=4)
    found, _ = read(tmp_path, origin_m=HERE)
    expected, _ = read(written[0], origin_m=HERE)
    assert np.array_equal(found.centre_m, expected.centre_m)


def test_all_missing_tables_are_named(tmp_path: Path) -> None:
    folder = write_tables(tmp_path, random_boxes(1, 1, 1), scenes=1, samples=1)
    for name in ("ego_pose", "category"):
        (folder / f"{name}.json").unlink()
    with pytest.raises(InputError, match=r"ego_pose\.json: missing \(and category\)"):
        open_boxes(tmp_path)
    (folder / "sample_annotation.json").unlink()
    with pytest.raises(InputError, match=r"sample_annotation\.json: missing: a nuScenes folder needs sample"):
        open_boxes(tmp_path)


def test_progress_rises_to_the_end(written) -> None:  # type: ignore[no-untyped-def]
    heard: list[float] = []
    list(open_boxes(written[0]).batches(heard.append))
    assert heard == sorted(heard)
    assert heard[-1] == 1.0


@pytest.fixture
def broken(tmp_path: Path):  # type: ignore[no-untyped-def]
    """A folder of which one table is changed by hand; returns the message of the refusal."""
    folder = write_tables(tmp_path / "v1.0-mini", random_boxes(1, 2, 5), scenes=1, samples=2)

    def change(table: str, edit) -> str:  # type: ignore[no-untyped-def]
        file = folder / f"{table}.json"
        records = json.loads(file.read_text(encoding="utf-8"))
        changed = edit(records)
        file.write_text(changed if isinstance(changed, str) else json.dumps(records), encoding="utf-8")
        with pytest.raises(InputError) as caught:
            list(open_boxes(tmp_path).batches())
        message = str(caught.value)
        assert "\n" not in message and len(message) < 500
        return message

    return change


def every(**fields: object):  # type: ignore[no-untyped-def]
    """An edit that sets fields of all records of a table."""

    def edit(records: list[dict[str, object]]) -> None:
        for record in records:
            record.update(fields)

    return edit


@pytest.mark.parametrize(
    ("table", "edit", "found"),
    [
        ("ego_pose", every(rotation=[1, 2, 3, 4]), "quaternion"),
        ("ego_pose", every(translation=[1, 2]), r"'translation': .*got '?\[1, 2\]"),
        ("ego_pose", every(translation=[0, 10**400, 0]), "finite"),
        ("ego_pose", lambda r: r.clear(), "no pose"),
        ("sensor", lambda r: r.pop(0) and None, r"LiDARs.*got 0"),
        (
            "sample_data",
            every(is_key_frame=False),
            "no key frame of LIDAR_TOP",
        ),
        (
            "sample_data",
            every(sample_token="?"),
            r"'sample_token': .*got '?\?",
        ),
        ("instance", every(category_token="?"), r"'category_token': .*got '?\?"),
        ("sample_annotation", every(instance_token="?"), r"'instance_token': .*got '?\?"),
        ("sample", lambda r: r[0].pop("timestamp") and None, "'timestamp': .*got '?nothing"),
        ("sample", every(timestamp=math.nan), "'timestamp': .*got '?nan"),
        ("sample", every(timestamp=-1), "'timestamp': .*got '?-1"),
        ("sample", every(timestamp=10**400), "'timestamp': .*got '?1000"),
        ("sample", every(timestamp=5), "a time that no other sample of the scene has"),
        ("category", every(name=7), "'name': .*got '?7"),
        ("sample_annotation", lambda r: "[1]", "record 1: .*'{'"),
        ("sample_annotation", lambda r: "{}", "starting with '"),
        ("sample_annotation", lambda r: "", "starting with '"),
        ("sample_annotation", lambda r: json.dumps(r)[:-40], "broken or too long"),
        ("sample_annotation", lambda r: json.dumps(r) + "x", "after the closing"),
        ("sample_annotation", lambda r: "[" + json.dumps(r[0]) + " 5]", "after record 1: .*got '5'"),
        ("sample_annotation", lambda r: '[{"a":' + "[" * 100_000, "RecursionError"),
        ("sample_annotation", lambda r: '[{"a": ' + "9" * 2_000_000, "broken or too long"),
        ("sample_annotation", lambda r: '[{"a": "' + "x" * 3_000_000, "broken or too long"),
    ],
)
def test_what_is_wrong_is_named_with_table_and_record(broken, table, edit, found) -> None:  # type: ignore[no-untyped-def]
    message = broken(table, edit)
    assert f"{table}.json" in message
    assert re.search(found, message)


@pytest.mark.parametrize("value", ["NaN", "1e999", "true", "null"])
def test_numbers_that_are_none_are_refused(broken, value) -> None:  # type: ignore[no-untyped-def]
    def edit(records: list[dict[str, object]]) -> str:
        for record in records:
            record["size"] = ["@", 1, 1]
        return json.dumps(records).replace('"@"', value)

    assert "size" in broken("sample_annotation", edit)


def test_a_missing_table_is_named(tmp_path: Path) -> None:
    folder = write_tables(tmp_path, random_boxes(1, 1, 1), scenes=1, samples=1)
    (folder / "ego_pose.json").unlink()
    with pytest.raises(InputError, match=r"ego_pose\.json: missing"):
        open_boxes(tmp_path)


def test_a_cut_off_compressed_table_is_refused(tmp_path: Path) -> None:
    folder = write_tables(tmp_path, random_boxes(1, 2, 3), scenes=1, samples=2)
    data = gzip.compress((folder / "ego_pose.json").read_bytes())
    (folder / "ego_pose.json").unlink()
    (folder / "ego_pose.json.gz").write_bytes(data[:-20])
    with pytest.raises(InputError, match=r"ego_pose\.json\.gz: damaged or truncated"):
        list(open_boxes(tmp_path).batches())


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no device that is always full")
def test_a_full_disk_is_told_with_the_folder_and_what_to_do(written, monkeypatch) -> None:  # type: ignore[no-untyped-def]
    monkeypatch.setattr(tempfile, "TemporaryFile", lambda **_: open("/dev/full", "wb", buffering=0))  # noqa: SIM115
    folder, *_ = written
    with pytest.raises(InputError) as caught:
        list(open_boxes(folder).batches())
    assert str(caught.value).endswith(
        "temporary files cannot be written (No space left on device); make room there, or name another folder in TMPDIR"
    )
