"""A data set on the disk: whatever interrupts it, the files are the same; what does not fit is told in one line."""

import os
import signal
import subprocess
import sys
import zipfile
from collections.abc import Callable
from dataclasses import replace
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from pyarrow import parquet

from riglens.core.errors import InputError
from riglens.core.geometry import Pose
from riglens.core.pieces.folder import PieceFolder
from riglens.core.pieces.processes import worker_processes
from riglens.core.rig.library import sensor_from_model
from riglens.core.rig.model import Rig, Vehicle
from riglens.core.simulate import dataset as module
from riglens.core.simulate.channels import channels_of
from riglens.core.simulate.dataset import (
    DatasetFolder,
    bytes_needed,
    require_room,
    scenes_of,
)
from riglens.core.simulate.pictures import LABELS
from riglens.core.simulate.sweeps import GROUND, STATIC, Simulator
from riglens.core.simulate.units import Extras, simulate_unit, unpacked
from riglens.core.simulate.world import Worlds
from tests.core.simulate.small import CAMERA, SETTINGS, dataset, lidar, make, rig, road_users
from tests.waiting import poll

REPOSITORY = Path(__file__).resolve().parents[3]


@pytest.fixture(autouse=True)
def small_pieces(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "UNIT_FRAMES", 2)


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    path = tmp_path_factory.mktemp("whole") / "set"
    make(path, dataset())
    return content(path)


def content(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_the_folder_holds_what_was_planned(whole: dict[str, bytes]) -> None:
    names = [name.split("/")[0] for name in whole]
    assert names.count("samples") == 8 * 4 and names.count("labels") == names.count("depth") == 8
    assert names.count("points") == 8 and names.count("v1.0-trainval") == 15
    assert not any(name.startswith(".") for name in whole)


@pytest.mark.slow
def test_processes_give_the_same_files(tmp_path: Path, whole: dict[str, bytes]) -> None:
    with worker_processes(2) as workers:
        make(tmp_path / "set", dataset(), workers=workers)
    assert content(tmp_path / "set") == whole


@pytest.mark.parametrize("after", [0.1, 0.6])
def test_what_was_interrupted_goes_on_to_the_same_files(
    tmp_path: Path, whole: dict[str, bytes], after: float
) -> None:
    def stop(fraction: float) -> None:
        if fraction > after:
            raise KeyboardInterrupt

    what = dataset()
    with pytest.raises(KeyboardInterrupt):
        make(tmp_path / "set", what, stop)
    (tmp_path / "set" / "samples" / "LIDAR_TOP" / "half").write_bytes(b"?")  # no harm
    folder = DatasetFolder(tmp_path / "set", what)
    assert not folder.is_complete and 0 < len(folder.missing()) < len(what.spans)
    make(tmp_path / "set", what)
    (tmp_path / "set" / "samples" / "LIDAR_TOP" / "half").unlink()
    assert content(tmp_path / "set") == whole
    assert DatasetFolder(tmp_path / "set", what).is_complete


_CHILD = """
from pathlib import Path
from riglens.core.simulate import dataset as module
from tests.core.simulate.small import dataset, make
module.UNIT_FRAMES = 2
make(Path({path!r}), dataset())
"""


def test_a_killed_run_goes_on_to_the_same_files(tmp_path: Path, whole: dict[str, bytes]) -> None:
    """Killed as soon as the first piece is there, in the middle of whatever comes next."""
    path = tmp_path / "set"
    child = subprocess.Popen([sys.executable, "-c", _CHILD.format(path=str(path))], cwd=REPOSITORY)
    try:
        poll(lambda: child.poll() is not None or any((path / ".riglens").glob("unit-*")))
        os.kill(child.pid, signal.SIGKILL)
    finally:
        child.wait()
    make(path, dataset())
    assert content(path) == whole


def interrupted(path: Path, what: module.Dataset) -> None:
    """Leave a data set without its last part and the tables."""

    def stop(fraction: float) -> None:
        if fraction >= 0.75:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        make(path, what, stop)


HARM: dict[str, Callable[[Path], object]] = {
    "deleted": Path.unlink,
    "emptied": lambda path: path.write_bytes(b""),
    "altered": lambda path: path.write_bytes(path.read_bytes()[:-1] + b"?"),
}


@pytest.mark.parametrize(
    ("folder", "harm"),
    [
        *(("samples/LIDAR_TOP", harm) for harm in HARM),
        ("depth/CAM_FRONT", "deleted"),
        ("points", "altered"),
        *((".riglens", harm) for harm in HARM),
    ],
)
def test_a_part_whose_files_were_touched_is_made_again(
    tmp_path: Path, whole: dict[str, bytes], folder: str, harm: str
) -> None:
    path = tmp_path / "set"
    interrupted(path, dataset())
    HARM[harm](sorted((path / folder).iterdir())[0])
    assert len(make(path, dataset())) == 2  # the one that was touched, and the last one
    assert content(path) == whole


def test_notes_of_another_shape_count_for_nothing(tmp_path: Path) -> None:
    folder = DatasetFolder(tmp_path / "set", dataset())
    key, *_ = keys = list(dataset().spans)
    for notes in (b"", b"{", b"[]", b"[7, {}]", b'[[{"points": 1}], {}]', b"7"):
        kept = PieceFolder(folder.work, lambda _, content: content)
        kept.keep(key, notes)
        assert folder.missing() == keys


def test_a_complete_data_set_that_lost_a_file_is_not_complete(
    tmp_path: Path, whole: dict[str, bytes]
) -> None:
    path = tmp_path / "set"
    make(path, dataset())
    sorted((path / "labels" / "CAM_FRONT").iterdir())[2].unlink()
    assert not DatasetFolder(path, dataset()).is_complete
    make(path, dataset())
    assert content(path) == whole and DatasetFolder(path, dataset()).is_complete


def test_a_run_killed_before_anything_was_done_goes_on(tmp_path: Path, whole: dict[str, bytes]) -> None:
    """Whichever of its first steps it had come to."""
    (tmp_path / "set" / ".riglens").mkdir(parents=True)
    (tmp_path / "set" / ".riglens.json.0123abcd-999999999-0123abcd-0123456789ab.tmp").write_text(
        "{", encoding="utf-8"
    )
    assert not DatasetFolder(tmp_path / "set", dataset()).is_complete
    (tmp_path / "set" / ".riglens.json.0123abcd-999999999-0123abcd-0123456789ab.tmp").unlink()
    make(tmp_path / "set", dataset())
    assert content(tmp_path / "set") == whole


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (
            lambda path: (path / "letter.txt").write_text("x", encoding="utf-8"),
            r"must be a new or an empty folder \(holds 'letter.txt'\)",
        ),
        (lambda path: make(path, replace(dataset(), settings=replace(SETTINGS, seed=4))), "simulated seed"),
        (lambda path: make(path, dataset(of=rig(lidar("left", 0.1)))), "rig sha256"),
        (lambda path: (path / "riglens.json").write_bytes(b"\xff{"), "riglens.json cannot be read"),
        (
            lambda path: (path / "riglens.json").write_text("[]", encoding="utf-8"),
            "riglens.json cannot be read",
        ),
    ],
)
def test_a_folder_with_something_else_is_left_alone(
    tmp_path: Path, spoil: Callable[[Path], object], message: str
) -> None:
    spoil(tmp_path)
    before = content(tmp_path)
    with pytest.raises(InputError, match=message):
        DatasetFolder(tmp_path, dataset())
    assert content(tmp_path) == before


def test_a_file_is_no_folder(tmp_path: Path) -> None:
    (tmp_path / "set").write_text("x", encoding="utf-8")
    with pytest.raises(InputError, match="must be a folder, not a file"):
        DatasetFolder(tmp_path / "set", dataset())


def test_the_estimate_of_room_is_near_the_truth_and_too_little_is_refused(
    tmp_path: Path, whole: dict[str, bytes], monkeypatch: pytest.MonkeyPatch
) -> None:
    what = dataset()
    needed = bytes_needed(what, list(what.spans))
    assert needed == pytest.approx(sum(map(len, whole.values())), rel=0.15)
    monkeypatch.setattr(module.shutil, "disk_usage", lambda _: _Usage(needed * 2))
    require_room(needed, tmp_path / "new" / "set")
    monkeypatch.setattr(module.shutil, "disk_usage", lambda _: _Usage(needed))
    with pytest.raises(InputError, match=r"set: needs about [\d.]+ MB, but only [\d.]+ MB are free"):
        require_room(needed, tmp_path / "new" / "set")


class _Usage:
    def __init__(self, free: int) -> None:
        self.free = free


@pytest.mark.parametrize("damage", [lambda it: it[:-40], lambda it: b"", lambda it: b"PK" + it[2:90]])
def test_a_damaged_part_is_not_taken(damage: Callable[[bytes], bytes]) -> None:
    what = dataset()
    content = simulate_unit(what.unit(span(what, 0)))
    with pytest.raises(ChildProcessError, match="damaged part"):
        taken(damage(content), what, 0)


def span(what: module.Dataset, number: int) -> module.Span:
    return list(what.spans.values())[number]


def taken(content: bytes, what: module.Dataset, number: int) -> object:
    """The content as that of the span of that number."""
    return unpacked(content, span(what, number).frames, what.file_names(span(what, number)))


def test_the_part_of_other_frames_is_not_taken() -> None:
    what = dataset()
    with pytest.raises(ChildProcessError, match="another part"):
        taken(simulate_unit(what.unit(span(what, 0))), what, 1)


@pytest.mark.parametrize("name", ["../evil", "/tmp/evil", "samples/LIDAR_TOP/more.pcd.bin"])
def test_a_file_that_nobody_asked_for_is_not_taken(name: str) -> None:
    what = dataset()
    stream = BytesIO(simulate_unit(what.unit(span(what, 0))))
    with zipfile.ZipFile(stream, "a") as archive:
        archive.writestr(name, b"x")
    with pytest.raises(ChildProcessError, match="another part"):
        taken(stream.getvalue(), what, 0)


def test_a_rig_without_sensors_and_one_of_cameras_alone(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="rig none: needs an enabled LiDAR"):
        _ = dataset(of=Rig(name="none")).channels
    cameras = dataset(of=rig(CAMERA))
    with pytest.raises(InputError, match="no LiDAR while no pictures are drawn"):
        _ = replace(cameras, extras=Extras(pictures=False)).channels
    make(tmp_path / "set", cameras)
    assert not any("LIDAR" in name for name in content(tmp_path / "set"))


def test_one_lidar_has_one_channel_and_names_are_told_apart() -> None:
    assert [one.name for one in channels_of(rig(lidar("roof", 0.0)))] == ["LIDAR_TOP"]
    twins = rig(lidar("LIDAR_TOP", 0.0), lidar("lidar top", 0.1), lidar("löwe", 0.2), CAMERA)
    names = ["LIDAR_TOP", "LIDAR_TOP_2", "LIDAR_TOP_3", "LIDAR_L_WE", "CAM_FRONT"]
    assert [one.name for one in channels_of(twins)] == names


def test_a_channel_stands_where_its_sensor_does_as_seen_from_the_rear_axle() -> None:
    small = rig().replace(vehicle=Vehicle(rear_axle_x=-1.3))
    left, right, camera = (np.add(sensor.position, (1.3, 0.0, 0.0)) for sensor in small.sensors)
    places = [one.place_m for one in channels_of(small)]
    np.testing.assert_allclose(places, [(left + right) / 2, left, right, camera], atol=1e-12)


def test_a_sequence_is_thinned_frame_by_frame() -> None:
    scenes = scenes_of(road_users(), every=3)
    assert [(scene.frames, scene.places) for scene in scenes] == [((0, 3), (0, 3)), ((4, 7), (0, 3))]
    assert [len(scene.frames) for scene in scenes_of(road_users(), most=1)] == [4]
    nameless = road_users()
    nameless = replace(nameless, data=replace(nameless.data, labels=None))
    assert [scene.frames for scene in scenes_of(nameless)] == [tuple(range(8))]


def test_parquet_holds_the_points_of_the_sweep(tmp_path: Path) -> None:
    what = dataset()
    make(tmp_path / "set", what)
    name = what.scenes[1].stem(2).format("POINTS")
    table = parquet.read_table(tmp_path / "set" / "points" / f"{name}.parquet")
    sweep = Simulator(what.rig, Worlds(what.traffic, SETTINGS)).sweep(what.scenes[1].frames[2])
    np.testing.assert_array_equal(
        np.stack([table[axis].to_numpy() for axis in "xyz"], axis=1), sweep.points_m
    )
    np.testing.assert_array_equal(table["object"].to_numpy(), sweep.object)
    on, lidars = table["on"].to_pylist(), table["lidar"].to_pylist()
    truth = Worlds(what.traffic, SETTINGS).truth(what.scenes[1].frames[2])
    names = {GROUND: "ground", STATIC: "static"}
    classes = ("car", "bicycle", "pedestrian")
    assert on == [names[k] if k < 0 else classes[truth.cls[k]] for k in sweep.object.tolist()]
    assert lidars == [("left", "right")[k] for k in sweep.sensor.tolist()]
    assert "time_s" not in table.column_names


def test_parquet_holds_the_times_of_a_scan_pattern(tmp_path: Path) -> None:
    what = dataset(
        of=rig(sensor_from_model("livox-mid-40-pattern", "L", Pose((0.0, 0.0, 1.9), (0.0, 5.0, 0.0))))
    )
    frame = what.scenes[0].frames[0]
    make(tmp_path / "set", replace(what, scenes=[replace(what.scenes[0], frames=(frame,), places=(0,))]))
    (path,) = (tmp_path / "set" / "points").iterdir()
    sweep = Simulator(what.rig, Worlds(what.traffic, SETTINGS)).sweep(frame)
    assert sweep.time_s.any()
    np.testing.assert_array_equal(parquet.read_table(path)["time_s"].to_numpy(), sweep.time_s)


def test_depth_and_labels_agree_with_the_lidar(tmp_path: Path) -> None:
    """A point of a LiDAR that stands where the camera does has the depth and the class of its pixel, but at edges."""
    eye = lidar("eye", 0.0).model_copy(update={"position": CAMERA.position, "rpy_deg": (0.0, 0.0, 0.0)})
    quiet = replace(dataset(of=rig(eye, CAMERA)), settings=replace(SETTINGS, noise_m=0.0, dropout=0.0))
    make(tmp_path / "set", quiet)
    frame = quiet.scenes[1].frames[1]
    stem = quiet.scenes[1].stem(quiet.scenes[1].places[1]).format("CAM_FRONT")
    depth_m = np.asarray(Image.open(tmp_path / "set" / "depth" / "CAM_FRONT" / f"{stem}.png")) / 100.0
    labels = np.asarray(Image.open(tmp_path / "set" / "labels" / "CAM_FRONT" / f"{stem}.png"))
    sweep, truth = (
        of(frame)
        for of in (Simulator(quiet.rig, Worlds(quiet.traffic, quiet.settings)).sweep, road_truth(quiet))
    )
    offset = sweep.points_m.astype(np.float64) - CAMERA.position
    fx_px, fy_px, cx_px, cy_px = CAMERA.intrinsics_px()
    ahead = offset[:, 0] > 1.0
    u = np.floor(cx_px - fx_px * offset[:, 1] / np.where(ahead, offset[:, 0], 1.0)).astype(int)
    v = np.floor(cy_px - fy_px * offset[:, 2] / np.where(ahead, offset[:, 0], 1.0)).astype(int)
    there = ahead & (u >= 0) & (u < 160) & (v >= 0) & (v < 90)
    assert there.sum() > 300
    u, v, far, what = u[there], v[there], offset[there, 0], sweep.object[there]
    near = np.abs(depth_m[v, u] - far) < 0.03 * far + 0.05
    expected = [
        LABELS.index({GROUND: "ground", STATIC: "static"}.get(k, "none")) if k < 0 else int(truth.cls[k]) + 1
        for k in what.tolist()
    ]
    same = labels[v, u] == expected
    assert near.mean() > 0.9 and same.mean() > 0.93


def road_truth(what: module.Dataset):  # type: ignore[no-untyped-def]
    return Worlds(what.traffic, what.settings).truth
