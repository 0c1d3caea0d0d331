"""Arrays, vectors and ranges of `import riglens as rl`."""

from __future__ import annotations

import numpy as np
import pyarrow as pa
import pytest

import riglens as rl
from tests.test_api import BOXES, ROI_M

CLASSES = ("car", "bicycle", "pedestrian")


@pytest.fixture(scope="module")
def boxes(tmp_path_factory: pytest.TempPathFactory) -> str:
    """A small box table with all classes."""
    path = tmp_path_factory.mktemp("arrays") / "boxes.csv"
    path.write_text(BOXES, encoding="utf-8")
    return str(path)


@pytest.fixture(scope="module")
def scene(boxes: str) -> rl.Scene:
    """That table on a coarse grid."""
    return rl.load_scene(boxes, 0.5, roi_m=np.array(ROI_M))


def test_vectors_are_lists_tuples_or_arrays(boxes: str) -> None:
    place, turn = [1.0, 0.5, 2.0], np.array([0.0, 10.0, -90.0])
    pose = rl.Pose(place, turn)
    assert pose == rl.Pose((1.0, 0.5, 2.0), (0.0, 10.0, -90.0)) and hash(pose) is not None
    beams = np.linspace(-15.0, 15.0, 4, dtype=np.float32)
    lidar = rl.Lidar(name="l", position=place, rpy_deg=turn, elevations_deg=beams, azimuths_deg=[0.0, 1.0])
    assert lidar.pose == pose and lidar.elevations_deg == (-15.0, -5.0, 5.0, 15.0)
    assert rl.Rig(sensors=[lidar]).replace(keep_out=[[0.0, 0.0, 1.0, 0.1]]).keep_out == (
        (0.0, 0.0, 1.0, 0.1),
    )
    moved = rl.load_traffic(boxes, origin_m=[1.0, 0.0, 0.0]).centre_m - rl.load_traffic(boxes).centre_m
    assert moved.tolist() == [[1.0, 0.0, 0.0]] * 4
    with pytest.raises(ValueError, match="position"):
        rl.Lidar(name="l", position=[1.0, 2.0], elevations_deg=beams, azimuths_deg=[0.0])


def test_grids_of_a_scene_have_its_shape_and_its_sums(scene: rl.Scene) -> None:
    result = rl.score(rl.open_rig("W+T"), scene)
    for name in CLASSES:
        probability, entropy = scene.probability(name), scene.entropy(name)
        assert probability.shape == entropy.shape == scene.grid.shape
        assert probability.max() == pytest.approx(1 / 3)
        assert entropy.sum() == pytest.approx(result[name].h_total)
        inside = (probability > 0.0) & (probability < 1.0)
        p = probability[inside]
        assert entropy[inside] == pytest.approx(-p * np.log(p) - (1 - p) * np.log(1 - p), abs=1e-9)
    x, y, z = (scene.grid.centres_m(axis) for axis in range(3))
    held = scene.probability("pedestrian") > 0.0
    assert (
        {abs(float(one)) for one in y[np.nonzero(held)[1]]} == {4.75, 5.25} and x.size == 40 and z.size == 8
    )


def test_what_is_seen_adds_up_to_the_score(scene: rl.Scene) -> None:
    rig = rl.open_rig("W+T")
    result, seen = rl.score(rig, scene), scene.seen(rig)
    assert int(seen.sum()) == result.covered_voxels["any"]
    for kind in ("camera", "lidar"):
        assert int(scene.seen(rig, kind=kind).sum()) == result.covered_voxels[kind]
    for name in CLASSES:
        share = scene.entropy(name)[seen].sum() / result[name].h_total
        assert share == pytest.approx(result[name].seen)
    by_sensor = [scene.seen(rig, sensor=sensor.name) for sensor in rig.sensors]
    assert np.array_equal(np.logical_or.reduce(by_sensor), seen)
    assert not scene.seen(rig, sensor="nobody").any()
    for ask in (lambda: scene.seen(rig, kind="lidars"), lambda: rl.sensors("lidars")):
        with pytest.raises(rl.InputError, match=r"kind must be lidar or .* \(got lidars\)"):
            ask()


def test_rays_start_at_the_sensor_and_triangles_make_the_car() -> None:
    rig = rl.open_rig("W+T")
    lidar = rig.sensor("LIDAR_1")
    rays = rl.rays(lidar)
    assert rays.origin_m == lidar.position and rays.directions.shape == (lidar.ray_count, 3)
    assert np.linalg.norm(rays.directions, axis=1) == pytest.approx(1.0)
    corners = rl.body_triangles(rig).reshape(-1, 3)
    assert np.ptp(corners[:, 0]) == pytest.approx(rig.vehicle.length)
    assert corners[:, 2].max() == pytest.approx(rig.vehicle.height)


def test_a_range_of_frames_holds_out_the_others(boxes: str) -> None:
    rig = rl.open_rig("W+T")
    traffic = rl.load_traffic(boxes)
    with traffic.engine(threads=1) as engine:
        first, rest, whole = (engine.evaluate(rig, sample=frames) for frames in (range(1), range(1, 3), None))
        again = engine.evaluate(rig, sample=1)
        with pytest.raises(rl.InputError, match=r"^frames must be a range of step 1 within 0 to 3"):
            engine.evaluate(rig, sample=range(1, 4))
    assert (first.frames_used, rest.frames_used, whole.frames_used) == (1, 2, 3)
    assert first.objects().equals(again.objects())
    parts = pa.concat_tables([first.objects(), rest.objects()]).sort_by(
        [("frame", "ascending"), ("cls", "descending")]
    )
    assert parts.equals(whole.objects().sort_by([("frame", "ascending"), ("cls", "descending")]))
    assert (
        sum(row["objects"] for row in rest.rows() if row["to_m"] == 60.0 and row["from_m"] == 0.0)
        == rest.objects().num_rows
    )
    assert sum(row["objects"] for row in rest.by_sector()) == rest.objects().num_rows
    assert sum(rest.to_dict()["data"]["objects"].values()) == rest.objects().num_rows
    with pytest.raises(RuntimeError, match="closed"):
        engine.evaluate(rig)
    alone = traffic.part(range(1, 3))
    assert alone.frames == 2 and rl.targets(rig, alone).objects().equals(rest.objects())


def test_what_one_kind_sees_is_what_the_rig_of_that_kind_sees(scene: rl.Scene) -> None:
    whole, parts = rl.open_rig("W+T"), dict[str, np.ndarray]()
    rig = whole.replace(sensors=(whole.enabled_lidars()[0], whole.enabled_cameras()[0]))
    for kind in ("lidar", "camera"):
        kept = (one for one in rig.sensors if one.kind == kind)
        alone = rig.replace(sensors=tuple(kept))
        parts[kind] = scene.seen(rig, kind=kind)
        np.testing.assert_array_equal(parts[kind], scene.seen(alone))
    assert (parts["lidar"] != parts["camera"]).any()
    np.testing.assert_array_equal(parts["lidar"] | parts["camera"], scene.seen(rig))
