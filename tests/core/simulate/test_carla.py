"""Collecting from CARLA, against a stand-in of its client: everything left-handed comes out right-handed."""

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from riglens.core.errors import InputError
from riglens.core.formats.report import Notes
from riglens.core.rig.model import Rig
from riglens.core.scene.readers import open_boxes
from riglens.core.simulate import carla_session
from riglens.core.simulate.carla_collection import Collection, Wanted, collect, depth_of, labels_of
from riglens.core.simulate.carla_session import Address, castable, session
from riglens.core.simulate.channels import channels_of, ego_origin_m
from riglens.core.simulate.pictures import LABELS
from riglens.core.simulate.settings import SimulationSettings
from riglens.core.simulate.units import Extras
from riglens.core.targets.traffic import read_traffic
from tests.core.simulate import carla_stand_in
from tests.core.simulate.small import CAMERA, lidar, rig

HERE = Address("localhost", 2000)
MOUNTED = rig(
    lidar("left", -0.5, 25.0),
    lidar("right", 0.5, -110.0),
    CAMERA.model_copy(update={"rpy_deg": (2.0, -4.0, 12.0), "image": (640, 480)}),
)


@pytest.fixture
def world(monkeypatch: pytest.MonkeyPatch) -> carla_stand_in.World:
    made = carla_stand_in.town()
    monkeypatch.setitem(sys.modules, "carla", carla_stand_in.module(made))
    return made


def run(path: Path, of: Rig = MOUNTED, frames: int = 3, stop_after: int | None = None) -> Collection:
    def progress(fraction: float) -> None:
        if stop_after is not None and fraction * frames >= stop_after:
            raise KeyboardInterrupt

    made = castable(of, Notes())
    with session(HERE) as opened:
        opened.mount(made, 0.02, 0.05, True)
        to = Collection(made, SimulationSettings(), Extras(), path, "Town10HD", 4)
        collect(opened, to, Wanted(frames, 4), progress)
    to.finish()
    return to


def table(folder: Path, name: str) -> list[dict[str, Any]]:
    found = json.loads((folder / "v1.0-trainval" / f"{name}.json").read_text(encoding="utf-8"))
    assert isinstance(found, list)
    return found


def test_points_lie_in_the_boxes_of_those_they_are_on(world: carla_stand_in.World, tmp_path: Path) -> None:
    """On a leaning road, from two LiDARs: the middle of each road user and eight points near its corners."""
    to = run(tmp_path / "set")
    annotations = table(tmp_path / "set", "sample_annotation")
    assert [one["num_lidar_pts"] for one in annotations] == [18] * 9
    points = (
        sum(path.stat().st_size for path in (tmp_path / "set" / "samples" / "LIDAR_LEFT").iterdir()) // 20
    )
    assert points == 3 * (3 + 2) * 9 == 135  # also those far away, and of what has no size
    assert [to.ticks[0].actors[k].cls for k in range(3)] == [0, 1, 2]


def test_the_cameras_show_road_users_where_the_tables_say(
    world: carla_stand_in.World, tmp_path: Path
) -> None:
    to, path = run(tmp_path / "set"), tmp_path / "set"
    channel = next(one for one in channels_of(to.rig) if one.name == "CAM_FRONT")
    stem, seen = to.scene.stem(2).format("CAM_FRONT"), 0
    labels = np.asarray(Image.open(path / "labels" / "CAM_FRONT" / f"{stem}.png"))
    depth_cm = np.asarray(Image.open(path / "depth" / "CAM_FRONT" / f"{stem}.png"))
    traffic = to.traffic()
    boxes = traffic.frame_of_box == np.flatnonzero(traffic.frame == 2)[0]
    assert channel.intrinsic is not None
    for cls, centre in zip(traffic.cls[boxes], traffic.centre_m[boxes], strict=True):
        x, y, z = channel.to_sensor((centre - ego_origin_m(to.rig))[None])[0]
        u, v = (channel.intrinsic @ [x, y, z])[:2] / z
        if z > 0.0 and 0 <= u < 640 and 0 <= v < 480:
            assert LABELS[labels[int(v), int(u)]] == ("car", "bicycle", "pedestrian")[cls]
            assert depth_cm[int(v), int(u)] == pytest.approx(100.0 * z, abs=0.6)
            seen += 1
    assert seen >= 2 and LABELS[labels[-1, 0]] == "ground"
    rgb = np.asarray(Image.open(path / "samples" / "CAM_FRONT" / f"{stem}.jpg"))
    assert rgb.shape == (480, 640, 3) and np.abs(rgb[-1, 0].astype(int) - [100, 150, 200]).max() < 6


def test_rings_are_numbered_as_the_rig_lists_its_beams(world: carla_stand_in.World, tmp_path: Path) -> None:
    """CARLA sends the highest beam first; the rig lists its beams from below."""
    run(tmp_path / "set")
    file = sorted((tmp_path / "set" / "samples" / "LIDAR_LEFT").iterdir())[0]
    rings = np.fromfile(file, np.float32).reshape(-1, 5)[:, 4]
    assert rings.tolist() == [15.0] * 5 + [0.0] * 40


def test_who_is_who_is_kept_from_frame_to_frame(world: carla_stand_in.World, tmp_path: Path) -> None:
    run(tmp_path / "set")
    instances = table(tmp_path / "set", "instance")
    assert [one["nbr_annotations"] for one in instances] == [3, 3, 3]
    by_token = {one["token"]: one for one in table(tmp_path / "set", "sample_annotation")}
    token, places = instances[0]["first_annotation_token"], []
    while token:
        places.append(by_token[token]["translation"])
        token = by_token[token]["next"]
    steps = np.linalg.norm(np.diff(places, axis=0), axis=1)
    assert steps == pytest.approx([5.0 * 0.05 * 4] * 2, abs=0.02)  # metres between frames at 5 m/s
    times = [one["timestamp"] for one in table(tmp_path / "set", "sample")]
    assert np.diff(times).tolist() == [200_000] * 2


def test_the_boxes_are_read_back_by_other_commands(world: carla_stand_in.World, tmp_path: Path) -> None:
    to = run(tmp_path / "set")
    again = read_traffic(open_boxes(tmp_path / "set" / "boxes.csv"))
    mine = to.traffic()
    assert again.frames == 3
    np.testing.assert_array_equal(again.cls, mine.cls)
    np.testing.assert_allclose(again.centre_m, mine.centre_m, atol=1e-4)
    np.testing.assert_allclose(again.size_m, mine.size_m, atol=1e-4)


def test_the_world_goes_on_as_before(world: carla_stand_in.World, tmp_path: Path) -> None:
    run(tmp_path / "set")
    assert not world.settings.synchronous_mode and world.settings.fixed_delta_seconds is None
    assert len(world.actors) == 5  # neither sensors nor the car that was made


def test_a_car_that_is_there_is_used_and_stays(world: carla_stand_in.World, tmp_path: Path) -> None:
    shape = carla_stand_in.box(2.4, 1.0, 0.7, 0.7)
    hero = world.add("vehicle.lincoln.mkz", world.start, shape, number_of_wheels="4", role_name="hero")
    run(tmp_path / "set")
    assert hero.is_there and len(world.actors) == 6
    assert len(table(tmp_path / "set", "sample_annotation")) == 9


def test_what_was_interrupted_is_a_data_set_of_the_frames_so_far(
    world: carla_stand_in.World, tmp_path: Path
) -> None:
    made = castable(MOUNTED, Notes())
    to = Collection(made, SimulationSettings(), Extras(), tmp_path / "set", "Town10HD", 4)
    with pytest.raises(KeyboardInterrupt), session(HERE) as opened:
        opened.mount(made, 0.0, 0.0, True)
        collect(opened, to, Wanted(9, 1), _stop_at(2 / 9))
    to.finish()
    assert len(table(tmp_path / "set", "sample")) == 2 and not world.settings.synchronous_mode


def _stop_at(share: float) -> Any:
    def progress(fraction: float) -> None:
        if fraction >= share:
            raise KeyboardInterrupt

    return progress


def test_a_sensor_that_stays_silent_ends_it(
    world: carla_stand_in.World, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(carla_session, "ANSWER_S", 0.01)
    world.silent = "depth"
    with pytest.raises(ChildProcessError, match="sensor CAM_FRONT depth sent nothing"):
        run(tmp_path / "set")
    assert not world.settings.synchronous_mode and len(world.actors) == 5


@pytest.mark.parametrize(
    "text", ["", "localhost", "localhost:", ":2000", "a:b", "h:0", "h:70000", "a b:1", "h:1:2"]
)
def test_what_is_no_address_is_refused(text: str) -> None:
    with pytest.raises(InputError, match=r"^carla must be HOST:PORT"):
        Address.of(text)


def test_nobody_answers_and_no_package(world: carla_stand_in.World, monkeypatch: pytest.MonkeyPatch) -> None:
    with (
        pytest.raises(InputError, match="CARLA at localhost:1: no simulator answers \\(time-out"),
        session(Address("localhost", 1)),
    ):
        pass
    monkeypatch.setitem(sys.modules, "carla", None)
    with pytest.raises(InputError, match=r"pip install 'riglens\[carla\]'"), session(HERE):
        pass


def test_what_carla_cannot_cast_is_told() -> None:
    uneven = lidar("uneven", 0.0).replace(
        elevations_deg=(-20.0, -3.0, 1.0), azimuth_offsets_deg=(0.0, 1.0, 2.0)
    )
    notes = Notes()
    made = castable(rig(uneven, CAMERA), notes)
    assert made.enabled_lidars()[0].elevations().tolist() == pytest.approx([-20.0, -9.5, 1.0])
    assert any("uneven angles" in line for line in notes.report("CARLA").lines())


def test_depth_and_labels_are_decoded() -> None:
    """As CARLA's reference says: (R + 256 G + 65536 B) / (256^3 - 1) of 1000 m, BGRA; tags in the red channel."""
    bgra = np.array(
        [[[0, 78, 32, 255], [255, 255, 255, 255]]], np.uint8
    )  # 20000 / 16777215 of 1000 m: 1.192 m
    assert depth_of(bgra).tolist() == [[119, 0]]
    tags = np.zeros((1, 8, 4), np.uint8)
    tags[0, :, 2] = [14, 19, 13, 12, 1, 11, 3, 0]
    names = [LABELS[k] for k in labels_of(tags)[0]]
    assert names == ["car", "bicycle", "bicycle", "pedestrian", "ground", "sky", "static", "none"]
