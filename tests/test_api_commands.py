"""Every command by the command line and by `import riglens as rl`: the same JSON, to the last bit."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import pytest

import riglens as rl
from riglens.app.commands import main, parsing
from riglens.app.commands.parsing import COMMANDS, GROUPS
from riglens.studies import running
from riglens.studies.running import Job
from tests.core.simulate import carla_stand_in
from tests.test_api import BOXES, ROI_M

GRID = ["--voxel", "0.5", "--roi", *map(str, ROI_M)]
REQUIREMENTS = f"""riglens_requirements: 1
settings: {{voxel_m: 0.5, roi_m: {list(ROI_M)}}}
seen:
  - {{class: car, at_least: 0.1}}
on_target:
  - {{class: car, at_least: 0.99}}
mounts:
  gap_m: 0.1
"""


FUNCTIONS = {
    "evaluate": "score",
    "review": "review",
    "optimise": "optimise",  # compared in tests/app/commands/test_optimise.py
    "sweep": "sweep",
    "check": "check",
    "calibrate": "calibrate",  # compared in tests/core/study/test_calibrating.py
    "report": "report",
    "render": "render",
    "convert": "convert",
    "simulate": "simulate",
    "data build": "build_pog",
    "data show": "survey",
    "list rigs": "presets",
    "list sensors": "sensors",
    **{f"study {name}": "study" for name in GROUPS["study"][1]},
}


def test_every_command_is_a_function() -> None:
    members = [f"{group} {name}" for group, (_, commands) in GROUPS.items() for name in commands]
    assert sorted(FUNCTIONS) == sorted([*COMMANDS, *members])
    assert set(FUNCTIONS.values()) <= set(rl.__all__)


OWN_LIBRARY = """own-2:
  kind: lidar
  title: Two beams of our own
  source: "Drawn for this test"
  elevations_deg: [-10, 0]
  azimuths_deg: {from: 0, to: 360, count: 360}
  range_m: [1, 50]
"""


class Place(NamedTuple):
    """A rig, boxes on disk, and both as `rl` has them."""

    folder: Path
    boxes: Path
    rig: rl.Rig
    scene: rl.Scene
    traffic: rl.Traffic


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Place:
    """A small box table with all classes on a coarse grid, and a rig of three sensors."""
    folder = tmp_path_factory.mktemp("api")
    (folder / "boxes.csv").write_text(BOXES, encoding="utf-8")
    (folder / "requirements.yaml").write_text(REQUIREMENTS, encoding="utf-8")
    whole = rl.open_rig("W+T")
    rig = whole.replace(name="few", sensors=(*whole.enabled_lidars()[:2], whole.enabled_cameras()[0]))
    rl.save_rig(rig, folder / "rig.yaml")
    boxes = folder / "boxes.csv"
    return Place(folder, boxes, rig, rl.load_scene(boxes, 0.5, roi_m=ROI_M), rl.load_traffic(boxes))


def by_words(place: Place, *words: object) -> dict[str, Any]:
    """The JSON of a command; its exit code may say that a requirement is not met."""
    out = place.folder / "out.json"
    assert main([*map(str, words), "--json", str(out)]) in (0, 1)
    found: dict[str, Any] = json.loads(out.read_text(encoding="utf-8"))
    return found


CASES: dict[str, tuple[list[str], Callable[[Place], Any]]] = {
    "evaluate": (["BOXES", "GRID"], lambda p: rl.score(p.rig, p.scene, p.traffic)),
    "evaluate targets": (["BOXES", "GRID", "--targets"], lambda p: rl.targets(p.rig, p.traffic)),
    "review audit": (["BOXES", "GRID"], lambda p: rl.audit(p.rig, p.scene)),
    "review blind": (
        ["--blind-width", "0", "--blind-within", "5", "--blind-voxel", "0.2"],
        lambda p: rl.blind(p.rig, width_m=0, within_m=5, voxel_m=0.2),
    ),
    "review range": (
        ["--directions", "2", "--range-to", "30", "--min-points", "3"],
        lambda p: rl.detection_range(p.rig, directions=2, to_m=30, min_points=3),
    ),
    "review redundancy": (["BOXES", "GRID"], lambda p: rl.redundancy(p.rig, p.scene, p.traffic)),
    "review tolerance": (
        ["BOXES", "GRID", "--draws", "4", "--sample", "2", "--errors", "ride"],
        lambda p: rl.tolerance(p.rig, p.scene, p.traffic, draws=4, sample=2, errors="ride"),
    ),
    "review": (
        [
            "BOXES",
            "GRID",
            "--draws",
            "2",
            "--sample",
            "0",
            "--only",
            "redundancy,mounts,tolerance,audit,footprint",
            "--halves",
            "--damaged",
            "LIDAR_1=left",
        ],
        lambda p: rl.review(
            p.rig,
            p.scene,
            p.traffic,
            draws=2,
            sample=0,
            only=["redundancy", "mounts", "tolerance", "audit", "footprint"],
            halves=True,
            damaged=["LIDAR_1=left"],
        ),
    ),
    "check": (
        ["BOXES", "GRID", "--requirements", "REQUIREMENTS"],
        lambda p: rl.check(p.rig, p.folder / "requirements.yaml", p.scene, p.traffic),
    ),
}


def test_a_sweep_is_that_of_the_command_line(place: Place) -> None:
    out, mine = place.folder / "sweep.parquet", place.folder / "mine.parquet"
    lidar = place.rig.enabled_lidars()[0].name
    words = [
        "--boxes",
        str(place.boxes),
        *GRID,
        "--vary",
        f"{lidar}.z=1.7:1.9:2",
        "--vary",
        f"{lidar}.yaw=0:9:2",
    ]
    document = by_words(place, "sweep", place.folder / "rig.yaml", *words, "--sample", "2", "--out", out)
    vary = {f"{lidar}.z": (1.7, 1.9, 2), f"{lidar}.yaw": (0, 9, 2)}
    found = rl.sweep(place.rig, vary, place.boxes, voxel_m=0.5, roi_m=ROI_M, sample=2, workers=1)
    found.save(mine)
    assert mine.read_bytes() == out.read_bytes()
    assert json.loads(json.dumps(found.to_dict())) == document
    assert found.table().num_rows == len(found.rows()) == 4 and "<table>" in found._repr_html_()
    assert f"4 rigs, {found.table().num_columns} columns" in repr(found)


def test_data_show_what_they_hold(place: Place) -> None:
    assert "boxes.csv: 3 frames, 4 objects" in repr(place.traffic)
    one = place.traffic.part(range(1))
    assert f": 1 frames, {int(one.counts.sum())} objects" in repr(one)
    nx, ny, nz = place.scene.grid.shape
    assert f"boxes.csv: 3 frames, {nx} × {ny} × {nz} voxels of 0.5 m" in repr(place.scene)


def test_a_sweep_reads_its_data_again(place: Place, tmp_path: Path) -> None:
    boxes, found = tmp_path / "boxes.csv", []
    for shift in ("", "s,2,car,-9,0,0.8,4.5,1.9,1.6,0.3\n"):
        boxes.write_text(BOXES + shift, encoding="utf-8")
        found.append(rl.sweep(place.rig, None, boxes, compute="targets", workers=1).to_dict())
    assert [one["rows"][0]["car.objects"] for one in found] == [2, 3]
    assert found[0]["targets"]["data"]["sha256"] != found[1]["targets"]["data"]["sha256"]


@pytest.mark.parametrize("command", CASES)
def test_a_command_says_the_same_by_both(place: Place, command: str) -> None:
    words, ask = CASES[command]
    said = {
        "BOXES": ["--boxes", str(place.boxes)],
        "GRID": GRID,
        "REQUIREMENTS": [str(place.folder / "requirements.yaml")],
    }
    spelled = [part for word in words for part in said.get(word, [word])]
    name, _, part = command.partition(" ")
    only = ["--only", part] if part and name == "review" else []
    expected = by_words(place, name, place.folder / "rig.yaml", *spelled, *only)
    expected = expected[part] if part else expected
    result = ask(place)
    found = json.loads(json.dumps(result.to_dict()))
    for document in (expected, found):
        for rig in (*document.get("rigs", ()), *document.get("targets", {}).get("rigs", ())):
            rig.pop("elapsed_ms", None)
    assert found == expected
    assert result.table().num_rows == len(result.rows()) > 0
    assert "<table>" in result._repr_html_()
    shown = repr(result)
    assert shown[0] == "<" and shown[-1] == ">" and type(result).__name__ in shown and place.rig.name in shown


def test_data_and_models_are_those_of_the_command_line(place: Place) -> None:
    expected = by_words(place, "data", "show", place.boxes, "--origin", "1", "0", "0")
    survey = rl.survey(place.boxes, origin_m=[1, 0, 0])
    assert json.loads(json.dumps(survey.to_dict())) == expected
    assert survey.table()["boxes"].to_pylist() == [2, 1, 1]
    expected = by_words(place, "list", "sensors", "--kind", "camera")
    assert json.loads(json.dumps(rl.sensors("camera").to_dict())) == expected
    vlp = rl.sensor("velodyne-vlp-16", "roof", [0, 0, 1.9])
    assert vlp.kind == "lidar" and vlp.position == (0.0, 0.0, 1.9) and vlp.model == "velodyne-vlp-16"


def test_a_pog_that_was_built_is_a_scene(place: Place) -> None:
    built = rl.build_pog(place.boxes, out=place.folder / "town.npz", voxel_m=0.5, roi_m=list(ROI_M))
    assert built.grid == place.scene.grid
    assert dict(rl.score(place.rig, built)) == dict(rl.score(place.rig, place.scene))
    by_word = place.folder / "by-word.npz"
    assert main(["data", "build", str(place.boxes), *GRID, "--out", str(by_word)]) == 0
    assert by_word.read_bytes() == (place.folder / "town.npz").read_bytes()


def test_files_of_rigs_are_those_of_the_command_line(place: Place, tmp_path: Path) -> None:
    mine, words = tmp_path / "mine.yaml", tmp_path / "words.yaml"
    assert main(["list", "rigs", "N+T", "--out", str(words)]) == 0
    rl.save_rig(rl.open_rig("N+T"), mine)
    assert mine.read_bytes() == words.read_bytes()
    rl.save_rig(place.rig.replace(sensors=place.rig.enabled_lidars()), mine)
    source, urdf = tmp_path / "rig.urdf", [tmp_path / "mine.urdf", tmp_path / "words.urdf"]
    with pytest.warns(rl.RigLensWarning):
        rl.convert(mine, source)
        rl.convert(source, urdf[0], origin_m=[1, 0, 0.5], rear_axle_x=-1.2, vehicle=rl.open_rig("KITTI car"))
    origin = ["--origin", "1", "0", "0.5", "--rear-axle-x", "-1.2", "--vehicle", "KITTI car"]
    assert main(["convert", str(source), str(urdf[1]), *origin]) == 0
    assert urdf[0].read_bytes() == urdf[1].read_bytes() != source.read_bytes()


def test_pictures_are_those_of_the_command_line(place: Place, tmp_path: Path, xvfb: str) -> None:
    mine, words = tmp_path / "mine.png", tmp_path / "words.png"
    look = ["--slice", "0", "2", "--threshold", "0.1", "--log", "--opacity", "0.7", "--ray-opacity", "0.5"]
    look += ["--ray-density", "2", "--fill", "ground", "--no-ground", "--no-legend", "--size", "320x200"]
    look += ["--px-per-m", "200", "50", "--plain-traffic"]
    rig, boxes = place.folder / "rig.yaml", ["--boxes", str(place.boxes)]
    assert main(["render", str(rig), *boxes, *GRID, *look, "--out", str(words)]) == 0
    rl.render(
        rl.open_rig(rig), place.scene, mine, slice_m=(0, 2), threshold=0.1, log=True, opacity=0.7,
        ray_opacity=0.5, ray_density=2, fill="ground", ground=False, legend=False, size_px=(320, 200),
        px_per_m=(200, 50), plain_traffic=True, traffic=rl.load_traffic(place.boxes),
    )  # fmt: skip
    assert mine.read_bytes() == words.read_bytes()


def test_models_of_your_own_are_added(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("RIGLENS_LIBRARY", "")
    own = tmp_path / "own.yaml"
    own.write_text(OWN_LIBRARY, encoding="utf-8")
    rl.use_libraries(own)
    assert rl.sensor("own-2", "roof", [0, 0, 1.9]).ray_count == 2 * 360


@pytest.fixture
def one(place: Place) -> Path:
    """The file of a rig with one small LiDAR."""
    lidar = place.rig.enabled_lidars()[0].replace(
        elevations_deg=(-10.0, 0.0), azimuths_deg=tuple(range(0, 360, 3))
    )
    path = place.folder / "one.yaml"
    rl.save_rig(place.rig.replace(name="one", sensors=[lidar]), path)
    return path


def test_data_sets_are_those_of_the_command_line(
    place: Place, one: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    words = ["--boxes", str(place.boxes), "--pictures", "off", "--workers", "1", "--clutter", "3"]
    assert main(["simulate", str(one), *words, "--out", str(place.folder / "data words")]) == 0
    capfd.readouterr()
    with pytest.warns(rl.RigLensWarning, match="1 sequence only"):
        (folder,) = rl.simulate(
            rl.open_rig(one), place.folder / "data mine", place.boxes, pictures=False, workers=1, clutter=3
        )
    assert capfd.readouterr() == ("", "")
    mine, theirs = (
        {path.relative_to(top): path.read_bytes() for path in top.rglob("*") if path.is_file()}
        for top in (folder, place.folder / "data words")
    )
    assert mine == theirs and len(mine) > 10


def test_reports_are_those_of_the_command_line(place: Place, one: Path) -> None:
    page, again = place.folder / "page.html", place.folder / "again.html"
    assert (
        main(
            [
                "report",
                str(one),
                "--boxes",
                str(place.boxes),
                *GRID,
                "--draws",
                "0",
                "--lambda",
                "0.3",
                "--out",
                str(page),
            ]
        )
        == 0
    )
    rig = rl.open_rig(one)
    assert rl.report(rig, again, place.boxes, voxel_m=0.5, roi_m=ROI_M, draws=0, camera_weight=0.3) == again
    assert again.read_bytes() == page.read_bytes()
    assert rl.verify_report(page, place.boxes)
    page.write_text(page.read_text(encoding="utf-8").replace("<h1", "<h2", 1), encoding="utf-8")
    assert not rl.verify_report(page, place.boxes)


def test_data_sets_of_carla_are_those_of_the_command_line(
    place: Place, one: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folders = [place.folder / "carla-words", place.folder / "carla-mine"]
    monkeypatch.setitem(sys.modules, "carla", carla_stand_in.module(carla_stand_in.town()))
    words = ["--carla", "localhost:2000", "--frames", "2", "--pictures", "off", "--out", str(folders[0])]
    assert main(["simulate", str(one), *words]) == 0
    monkeypatch.setitem(sys.modules, "carla", carla_stand_in.module(carla_stand_in.town()))
    with pytest.warns(rl.RigLensWarning, match="^CARLA: "):
        rl.simulate(rl.open_rig(one), folders[1], carla="localhost:2000", frames=2, pictures=False)
    theirs, mine = (
        {path.relative_to(top): path.read_bytes() for path in top.rglob("*") if path.is_file()}
        for top in folders
    )
    assert mine == theirs and len(mine) > 10
    with pytest.raises(rl.InputError, match=r"^workers does not apply"):
        rl.simulate(rl.open_rig(one), place.folder / "no", carla="localhost:2000", workers=2)


TRUE_POINTS = """seq,frame,cls,x,y,z,length,width,height,yaw,num_lidar_pts
a,0,car,10,0,0.8,4.5,1.9,1.6,0,50
a,0,car,25,6,0.8,4.5,1.9,1.6,0,9
a,1,pedestrian,6,4,0.9,0.6,0.6,1.8,0,20
"""


def test_studies_are_those_of_the_command_line(
    place: Place, one: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    boxes, words, mine = place.folder / "true.csv", place.folder / "words", place.folder / "mine"
    boxes.write_text(TRUE_POINTS, encoding="utf-8")
    assert main(["study", "targets", str(boxes), "--rig", str(one), "--out", str(words)]) == 0
    capfd.readouterr()
    with pytest.warns(rl.RigLensWarning, match="num_lidar_pts|no boxes of class") as remarks:
        found = rl.study("targets", boxes, rig=rl.open_rig(one), out=mine)
    assert {remark.filename for remark in remarks} == {__file__}
    assert capfd.readouterr().out == ""
    for file in ("targets.csv", "targets-objects.csv", "targets.png"):
        assert (mine / file).read_bytes() == (words / file).read_bytes()
    objects = found.to_dict()["tables"]["targets-objects.csv"]
    assert sorted(row["true"] for row in objects) == [9, 20, 50]
    assert found.rows()[0]["sequence"] == "a" and found.table().num_rows == len(found.rows())


def test_a_study_gives_the_json_that_it_writes(place: Place, one: Path) -> None:
    options = {"sensor": ["velodyne-vlp-16"], "voxel_m": 0.5, "roi_m": ROI_M, "boxes": place.boxes}
    out = place.folder / "sensors"
    found = rl.study("accuracy", rl.open_rig(one), out=out, quick=True, **options)
    assert found.to_dict() == json.loads((out / "accuracy-sensors.json").read_text(encoding="utf-8"))
    assert {row["model"] for row in found.rows()} == {"velodyne-vlp-16"}


def test_an_unknown_study_or_option_is_refused(place: Place) -> None:
    with pytest.raises(rl.InputError, match="must be one of table1, accuracy"):
        rl.study("nonsense", out=place.folder)  # type: ignore[arg-type]
    with pytest.raises(rl.InputError, match="fast is not an option of the study table1"):
        rl.study("table1", out=place.folder, fast=True)
    with pytest.raises(rl.InputError, match="device must be 'cpu' or 'cuda'"):
        rl.study("detection", "W+T", out=place.folder, device="gpu")
    with pytest.raises(rl.InputError, match="study external: too many positional arguments"):
        rl.study("external", "W+T", out=place.folder)


STUDIES: dict[str, tuple[list[str], list[str], dict[str, Any]]] = {
    "table1": ([], ["--voxel", "0.5"], {"voxel_m": 0.5}),
    "accuracy": (["Center"], ["--quick", "--lambda", "0.3"], {"quick": True, "camera_weight": 0.3}),
    "stability": ([], ["--edits", "5"], {"edits": 5}),
    "targets": (["boxes.csv"], ["--azimuths", "900", "--threads", "1"], {"azimuths": 900, "threads": 1}),
    "external": ([], ["--frames", "7", "--kitti", "k"], {"frames": 7, "kitti": "k"}),
    "detection": (["W+T"], ["--seeds", "2", "--cameras", "good"], {"seeds": 2, "cameras": "good"}),
    "predicted": (["detection.csv"], [], {}),
}


@pytest.mark.parametrize("name", STUDIES)
def test_a_study_is_called_as_the_command_line_calls_it(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    inputs, words, options = STUDIES[name]
    files = ["--csv", "table1.csv", "--detection-csv", "table1-detection.csv", "--sheet", "table1-groups.png"]
    out = [str(tmp_path / word) if "." in word else word for word in files]
    calls = list[tuple[object, ...]]()

    class Called(Exception):
        pass

    def run(options: object, job: Job, /, *inputs: object) -> None:
        calls.append(
            (options, job.scene, job.score, job.out if name != "table1" else None, *map(str, inputs))
        )
        raise Called

    monkeypatch.setitem(running.STUDIES, name, replace(running.STUDIES[name], run=run))
    with pytest.raises(Called):
        rl.study(name, *inputs, out=tmp_path, **options)  # type: ignore[arg-type]
    with pytest.raises(Called):
        parsing.run(
            ["study", name, *inputs, *words, *(out if name == "table1" else ["--out", str(tmp_path)])]
        )
    by_python, by_words = calls
    assert by_python == by_words


def test_every_study_is_compared() -> None:
    assert list(STUDIES) == list(GROUPS["study"][1])
