"""The official development kit of nuScenes loads what is simulated, counts the same points, and evaluates it.

It asks for numpy 1, so it is not among our packages: `make test-devkit` installs it beside them.
"""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from riglens.core.simulate.units import Notes
from tests.core.simulate.small import points_m

pytestmark = pytest.mark.filterwarnings("default")
nuscenes = pytest.importorskip("nuscenes", reason="make test-devkit")


@pytest.fixture(scope="module")
def kit(folder: Path) -> Any:
    return nuscenes.NuScenes("v1.0-trainval", str(folder), verbose=False)


def test_it_loads_all_tables_and_every_file(folder: Path, kit: Any) -> None:
    assert len(kit.sample) == 8 and len(kit.scene) == 2
    assert {record["channel"] for record in kit.sensor} == {
        "LIDAR_TOP",
        "LIDAR_LEFT",
        "LIDAR_RIGHT",
        "CAM_FRONT",
    }
    for record in kit.sample_data:
        assert (folder / record["filename"]).exists()
    for scene in kit.scene:
        token, count = scene["first_sample_token"], 0
        while token:
            count, last, token = count + 1, token, kit.get("sample", token)["next"]
        assert (count, last) == (scene["nbr_samples"], scene["last_sample_token"])
    kit.list_scenes()


def test_points_in_each_box_are_those_that_the_kit_counts(kit: Any) -> None:
    from nuscenes.utils.data_classes import LidarPointCloud
    from nuscenes.utils.geometry_utils import points_in_box

    some = 0
    for sample in kit.sample:
        path, boxes, _ = kit.get_sample_data(sample["data"]["LIDAR_TOP"])
        cloud = LidarPointCloud.from_file(path).points[:3].astype(np.float64)
        for box in boxes:
            expected = int(points_in_box(box, cloud).sum())
            assert kit.get("sample_annotation", box.token)["num_lidar_pts"] == expected
            some += expected > 0
    assert some > 40


def test_points_of_one_lidar_lie_where_those_of_all_do(kit: Any) -> None:
    """In the world: the merged sweep is that of the LiDARs one after the other."""
    sample = kit.sample[3]
    parts = [_in_world(kit, sample["data"][name]) for name in ("LIDAR_LEFT", "LIDAR_RIGHT")]
    np.testing.assert_allclose(_in_world(kit, sample["data"]["LIDAR_TOP"]), np.concatenate(parts), atol=1e-4)


def _in_world(kit: Any, token: str) -> Any:
    from pyquaternion import Quaternion

    data = kit.get("sample_data", token)
    points = points_m(Path(kit.dataroot) / data["filename"])
    for table, key in (("calibrated_sensor", "calibrated_sensor_token"), ("ego_pose", "ego_pose_token")):
        pose = kit.get(table, data[key])
        points = points @ Quaternion(pose["rotation"]).rotation_matrix.T + pose["translation"]
    return points


def test_boxes_projected_by_the_kit_hold_the_pixels_that_are_seen(folder: Path, kit: Any) -> None:
    from nuscenes.utils.geometry_utils import view_points

    records = json.loads((folder / "v1.0-trainval" / "image_annotations.json").read_text(encoding="utf-8"))
    assert len(records) > 8
    for record in records:
        _, boxes, intrinsic = kit.get_sample_data(
            record["sample_data_token"], selected_anntokens=[record["sample_annotation_token"]]
        )
        corners = boxes[0].corners()
        if (corners[2] < 0.5).any():
            continue
        outline = view_points(corners, intrinsic, normalize=True)[:2]
        low, high = outline.min(axis=1) - 1.0, outline.max(axis=1) + 1.0
        x0, y0, x1, y1 = record["bbox_corners"]
        assert low[0] <= x0 < x1 <= high[0] and low[1] <= y0 < y1 <= high[1]


def test_it_evaluates_the_truth_as_perfect_and_what_is_far_beside_it_as_zero(
    folder: Path, kit: Any, tmp_path: Path
) -> None:
    import tqdm
    from nuscenes.eval.common.config import config_factory
    from nuscenes.eval.detection.evaluate import DetectionEval

    tqdm.tqdm.monitor_interval = 0  # no thread of its own

    def ap(name: str, results: Notes) -> dict[str, float]:
        path = tmp_path / f"{name}.json"
        path.write_text(
            json.dumps({"meta": dict.fromkeys(_USES, True), "results": results}), encoding="utf-8"
        )
        config = config_factory("detection_cvpr_2019")
        metrics, _ = DetectionEval(
            kit, config, str(path), "riglens_val", str(tmp_path / name), False
        ).evaluate()
        return {name: float(value) for name, value in metrics.mean_dist_aps.items()}

    val = [sample for sample in kit.sample if kit.get("scene", sample["scene_token"])["name"].endswith("2-b")]
    seen = [
        record for record in kit.sample_annotation if record["num_lidar_pts"] > 0
    ]  # the others are dropped
    hit = {record["token"] for record in seen}
    truth = {
        sample["token"]: [_result(kit, token) for token in sample["anns"] if token in hit] for sample in val
    }
    perfect = ap("truth", truth)
    assert [perfect[name] for name in ("car", "bicycle", "pedestrian")] == pytest.approx([1.0] * 3)
    for results in truth.values():
        for result in results:
            result["translation"] = [x + 90.0 for x in result["translation"]]
    beside = ap("beside", truth)
    assert beside["car"] == beside["bicycle"] == beside["pedestrian"] == 0.0


_USES = ("use_camera", "use_lidar", "use_radar", "use_map", "use_external")


def _result(kit: Any, token: str) -> dict[str, Any]:
    record = kit.get("sample_annotation", token)
    name = {"vehicle.car": "car", "vehicle.bicycle": "bicycle", "human.pedestrian.adult": "pedestrian"}
    return {
        "sample_token": record["sample_token"],
        "translation": record["translation"],
        "size": record["size"],
        "rotation": record["rotation"],
        "velocity": [0.0, 0.0],
        "detection_name": name[record["category_name"]],
        "detection_score": 0.9,
        "attribute_name": "",
    }
