"""`import riglens as rl`: light, typed, and with the very figures of the command line."""

from __future__ import annotations

import inspect
import subprocess
import sys
import warnings
from collections.abc import Callable
from pathlib import Path

import pytest

import riglens as rl
import riglens.api as api
from riglens.app.commands import main
from riglens.evaluation.options import READING
from riglens.results import Result
from tests.waiting import TIMEOUT_S

REPOSITORY = Path(__file__).resolve().parents[1]
ROI_M = (20.0, 20.0, 4.0)
BOXES = """seq,frame,cls,x,y,z,length,width,height,yaw
s,0,car,6,0,0.8,4.5,1.9,1.6,0.3
s,0,bicycle,3,-4,0.9,1.8,0.6,1.7,0
s,1,car,-6,3,0.8,4.5,1.9,1.6,0
s,2,pedestrian,2,5,0.9,0.6,0.6,1.8,0
"""


@pytest.fixture
def boxes(tmp_path: Path) -> Path:
    """A small box table with all classes."""
    path = tmp_path / "boxes.csv"
    path.write_text(BOXES, encoding="utf-8")
    return path


@pytest.fixture
def scene(boxes: Path) -> rl.Scene:
    """That table on a coarse grid."""
    return rl.load_scene(boxes, 0.5, roi_m=ROI_M)


def moved(rig: rl.Rig, z_m: float) -> rl.Rig:
    """The rig with its first LiDAR at another height."""
    lidar = rig.enabled_lidars()[0]
    x_m, y_m, _ = lidar.position
    return rig.with_sensor(lidar.name, lidar.with_pose(rl.Pose((x_m, y_m, z_m), lidar.rpy_deg)))


@pytest.mark.parametrize("place", ["--out/b.csv", "a --boxes/b.csv", "--voxel", "a (--roi)"])
def test_messages_name_arguments_and_leave_paths_as_they_are(tmp_path: Path, place: str) -> None:
    path = tmp_path / place
    for source in (path, str(path)):
        with pytest.raises(rl.InputError) as caught:
            rl.load_scene(source)
        assert str(path) in str(caught.value)


def test_messages_name_arguments(boxes: Path, tmp_path: Path) -> None:
    with pytest.raises(rl.InputError, match=r"^threads must be an integer from 1 to"):
        rl.score(rl.open_rig("W+T"), rl.load_scene(boxes, 0.5, roi_m=ROI_M), threads=0)


def test_importing_loads_nothing_heavy_and_every_name_is_there_when_asked_for() -> None:
    code = (
        "import sys; import riglens as rl;"
        "heavy = {'numpy', 'numba', 'pydantic', 'PySide6', 'vtkmodules'};"
        "assert not heavy & set(sys.modules), heavy & set(sys.modules);"
        "assert set(rl.__all__) <= set(dir(rl));"
        "missing = [name for name in rl.__all__ if not hasattr(rl, name)]; assert not missing, missing;"
        "assert not {'PySide6', 'vtkmodules', 'cyclopts'} & set(sys.modules);"
    )
    subprocess.run([sys.executable, "-c", code], cwd=REPOSITORY, check=True, timeout=TIMEOUT_S)


def test_the_names_of_the_package_are_those_of_its_api() -> None:
    assert sorted(api.__all__) == api.__all__ and set(api.__all__) < set(dir(rl))
    assert all(getattr(rl, name) is getattr(api, name) for name in api.__all__)
    assert rl.__version__[0].isdigit()
    with pytest.raises(AttributeError, match="module 'riglens' has no attribute 'scores'"):
        rl.scores  # noqa: B018


@pytest.mark.parametrize(
    "name", ["load_scene", "load_traffic", "survey", "build_pog", "sweep", "report", "simulate"]
)
def test_whatever_reads_boxes_takes_every_option_of_reading(name: str) -> None:
    assert {"boxes", *READING} <= inspect.signature(getattr(rl, name)).parameters.keys()


def test_a_misspelt_option_of_reading_is_named() -> None:
    with pytest.raises(TypeError, match="'orign_m'"):
        rl.load_scene(orign_m=(0.0, 0.0, 0.0))  # type: ignore[call-arg]


def test_scores_are_a_mapping_of_the_figures_of_the_json(scene: rl.Scene) -> None:
    result = rl.score(rl.open_rig("N+P"), scene, reading="hits", camera_weight=0.25)
    document = result.to_dict()
    assert (document["reading"], document["lambda"]) == ("hits", 0.25)
    classes = document["rigs"][0]["classes"]
    assert set(result) == set(classes) and len(result) == 3
    for name, scores in classes.items():
        of_class = result[name]
        assert (of_class.seen, of_class.s_ms) == (scores["any"]["seen"], scores["s_ms"])
        assert of_class.h_total == scores["h_total"]
        assert (of_class.s_mig_camera, of_class.seen_camera) == tuple(scores["camera"].values())
        assert (of_class.s_mig_lidar, of_class.seen_lidar) == tuple(scores["lidar"].values())
    assert result.covered_voxels.items() >= document["rigs"][0]["covered_voxels"].items()


def test_a_scene_says_what_it_is_made_of(scene: rl.Scene) -> None:
    assert repr(scene) == "<Scene of boxes.csv: 3 frames, 40 × 40 × 8 voxels of 0.5 m>"


def test_a_tolerance_has_a_noise_floor_for_every_figure(scene: rl.Scene) -> None:
    found = rl.tolerance(rl.open_rig("Center"), scene, draws=1)
    assert found.floor.keys() == found.spreads.keys() and found.floor == found.tolerances.floor


def test_an_engine_gives_the_scores_of_single_evaluations(scene: rl.Scene) -> None:
    rig = rl.open_rig("N+P")
    one_lidar = rig.replace(sensors=rig.enabled_lidars()[:1])
    rigs = [moved(one_lidar, z_m) for z_m in (0.3, 1.0, 3.8)]
    with scene.engine(threads=2) as engine:
        found = [dict(engine.evaluate(rig)) for rig in [*rigs, rigs[0]]]
    alone = [dict(rl.score(rig, scene)) for rig in rigs]
    assert found == [*alone, alone[0]]
    assert len({result["car"].seen for result in alone}) == 2
    with pytest.raises(RuntimeError, match="closed"):
        engine.evaluate(rigs[0])


def test_points_and_audits_are_mappings_with_their_objects(boxes: Path, scene: rl.Scene) -> None:
    rig, traffic = rl.open_rig("N+P"), rl.load_traffic(boxes, within_m=50.0)
    found = rl.targets(rig, traffic, min_points=3)
    assert found.objects()["cls"].to_pylist() == ["car", "bicycle", "car", "pedestrian"]
    assert list(found) == ["car", "bicycle", "pedestrian"] and found.frames_used == 3
    assert found["car"].total.objects == 2 and "car at least 5 points" in repr(found)
    audit = rl.audit(rig, scene)
    assert list(audit) == [sensor.name for sensor in audit.rig.sensors]
    assert all(sum(sensor.shares.values()) == pytest.approx(1.0) for sensor in audit.values())
    assert "rays that hit the car" in repr(audit)
    with pytest.raises(rl.InputError, match=r"^sample must be an integer ≥ 1"):
        rl.targets(rig, traffic, sample=0)
    with pytest.raises(rl.InputError, match="threads"):
        rl.audit(rig, scene, threads=0)


def test_a_scene_says_what_it_holds(scene: rl.Scene) -> None:
    assert (scene.grid.shape, scene.grid.voxel_m, scene.grid.roi_m) == ((40, 40, 8), 0.5, ROI_M)
    assert scene.data.frames == 3
    assert scene.data.boxes == {"car": 2, "bicycle": 1, "pedestrian": 1}


def test_a_stored_pog_is_a_scene(boxes: Path, scene: rl.Scene, tmp_path: Path) -> None:
    stored = tmp_path / "town.npz"
    grid = ["--voxel", "0.5", "--roi", *map(str, ROI_M)]
    assert main(["data", "build", str(boxes), "--out", str(stored), *grid]) == 0
    rig = rl.open_rig("W+T")
    assert dict(rl.score(rig, rl.load_scene(pog=stored))) == dict(rl.score(rig, scene))


def test_wrong_arguments_are_named_as_python_names_them(boxes: Path, scene: rl.Scene, tmp_path: Path) -> None:
    rig = rl.open_rig("W+T")
    with pytest.raises(rl.InputError, match=r"^frames describes a box data set; specify it with boxes"):
        rl.load_scene(frames=3)
    with pytest.raises(rl.InputError, match=r"^boxes cannot be combined with pog"):
        rl.load_scene(boxes, pog=tmp_path / "town.npz")
    with pytest.raises(rl.InputError, match="camera_weight must be"):
        rl.score(rig, scene, camera_weight=-1.0)
    with pytest.raises(rl.InputError, match=r"^threads must be an integer"):
        scene.engine(threads=0)
    with pytest.raises(rl.InputError, match=r"^out must end in \.png"):
        rl.render(rig, scene, "picture.jpg")
    with pytest.raises(rl.InputError, match=r"did you mean W\+T"):
        rl.open_rig("W+TT")
    with pytest.raises(ValueError, match="at most 360"):
        rl.Lidar(name="l", position=(0, 0, 2), elevations_deg=(0.0,), azimuths_deg=(-200.0, 200.0))


def test_boxes_that_do_not_count_are_warned_of(boxes: Path) -> None:
    boxes.write_text(BOXES + "s,2,shopping_cart,2,6,0.9,0.6,0.6,1.8,0\n", encoding="utf-8")
    with pytest.warns(rl.RigLensWarning, match="1 box belongs to no class and does not count: shopping_cart"):
        rl.load_scene(boxes, 0.5, roi_m=ROI_M)
    scene = rl.load_scene(boxes, 0.5, roi_m=ROI_M, classes={"shopping_cart": "pedestrian"})
    assert scene.data.boxes["pedestrian"] == 2


def test_a_ground_off_zero_is_warned_of_with_the_argument_that_mends_it(tmp_path: Path) -> None:
    cars = "".join(f"s,{n},car,{4 + n % 4},{n % 7 - 3},-0.9,4.5,1.9,1.6,0.1\n" for n in range(40))
    low = tmp_path / "low.csv"
    low.write_text(BOXES.splitlines(keepends=True)[0] + cars, encoding="utf-8")

    def warned(load: Callable[[], object]) -> list[str]:
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always")
            load()
        assert {one.category for one in told} == {rl.RigLensWarning}
        return [str(one.message) for one in told if "z = 0" in str(one.message)]

    for load in (lambda: rl.load_scene(low, 0.5, roi_m=ROI_M), lambda: rl.load_traffic(low)):
        (line,) = warned(load)
        assert "low.csv" in line and "-1.7" in line and "origin_m=(0, 0, 1.7)" in line
    assert warned(lambda: rl.load_scene(low, 0.5, roi_m=ROI_M, origin_m=(0, 0, 1.7))) == []


def test_a_body_of_another_unit_is_warned_of_where_the_user_asks(scene: rl.Scene, tmp_path: Path) -> None:
    corners = [f"v {x} {y} {z}" for x in (0, 4600) for y in (0, 1900) for z in (0, 1450)]
    faces = ("1 3 4 2", "5 6 8 7", "1 2 6 5", "3 7 8 4", "1 5 7 3", "2 4 8 6")
    (tmp_path / "car.obj").write_text(
        "\n".join([*corners, *(f"f {face}" for face in faces)]) + "\n", encoding="utf-8"
    )
    rig = rl.open_rig("Center").replace(vehicle=rl.Vehicle(body="car.obj"), self_occlusion=True)
    calls = (
        lambda: rl.score(rig, scene, mesh_folder=tmp_path),
        lambda: rl.audit(rig, scene, mesh_folder=tmp_path),
    )
    for call in calls:
        with pytest.warns(rl.RigLensWarning, match=r"set vehicle\.mesh\.scale: 0\.001") as told:
            call()
        assert told[0].filename == __file__


def test_a_saved_rig_comes_back_and_comments_stay(tmp_path: Path) -> None:
    path, rig = tmp_path / "rig.yaml", rl.open_rig("W+T")
    rl.save_rig(rig, path)
    path.write_text("# measured on Tuesday\n" + path.read_text(encoding="utf-8"), encoding="utf-8")
    rl.save_rig(moved(rig, 1.75), path)
    assert rl.open_rig(path) == moved(rig, 1.75)
    assert path.read_text(encoding="utf-8").startswith("# measured on Tuesday\n")
    assert set(rl.presets()) >= {"W+T", "N+P", "Center"}


def test_a_converted_rig_tells_what_the_format_cannot_hold(tmp_path: Path) -> None:
    rig, target = rl.open_rig("W+T"), tmp_path / "rig.urdf"
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        assert rl.convert("W+T", target) == rig
        back = rl.convert(target, tmp_path / "back.yaml")
    assert {warning.category for warning in told} == {rl.RigLensWarning}
    assert {warning.filename for warning in told} == {__file__}
    assert "ROS URDF: ignored: vehicle: the format cannot express it" in map(str, (w.message for w in told))
    assert [sensor.name for sensor in back.sensors] == [sensor.name for sensor in rig.sensors]
    with pytest.raises(rl.InputError, match=r"^target_format must name the format"):
        rl.convert(rig, tmp_path / "rig.unknown")
    assert rl.convert(rig, tmp_path / "rig.unknown", target_format="riglens") == rig
    assert (tmp_path / "rig.unknown").read_text(encoding="utf-8").startswith("riglens: 1")


def test_a_table_has_the_columns_of_all_rows():
    class Uneven(Result):
        def to_dict(self):
            return {}

        def rows(self):
            return [{"rig": "a"}, {"rig": "b", "radar": 0.5}]

    assert Uneven().table().to_pydict() == {"rig": ["a", "b"], "radar": [None, 0.5]}
