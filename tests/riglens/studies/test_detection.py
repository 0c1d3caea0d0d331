"""`riglens study detection`: tables, charts and words of a made-up result, and what cannot be done."""

from __future__ import annotations

import csv
import io
import json
import sys
from dataclasses import replace
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

from riglens.app.terminal.console import show
from riglens.core.errors import InputError
from riglens.core.rig.model import Rig, Vehicle
from riglens.core.rig.presets import preset
from riglens.core.rig.yaml.file import dumps
from riglens.core.study.detection.pieces import Study
from riglens.core.study.detection.protocol import WORDING, entrants
from riglens.core.study.detection.published import CAMERA_PROTOCOL
from riglens.core.study.detection.published import PROTOCOL as PUBLISHED
from riglens.core.study.detection.result import Result
from riglens.core.study.detection.statistics import COLUMNS, Precisions
from riglens.core.study.detection.surrogates import SURROGATES, Surrogates
from riglens.core.study.ranks import RankCorrelation
from riglens.studies import detection
from riglens.studies.detection_chart import chart, chart_figure, correlation, pair_chart
from riglens.studies.detection_files import as_json, pair_lines, rank_lines, rig_lines, seed_lines
from riglens.studies.files import csv_text
from tests.core.study.detection.small import NOWHERE, PROTOCOL, rig, traffic
from tests.core.vehicle.test_mesh_file import stl

SCALE = {"s_ms": -1000.0, "residual": 1000.0, "hits": -1e6}


def made_up(rigs: int = 7, seeds: int = 3, missing: str = "") -> Result:
    """Rigs that are the better the later; `missing`: a class without objects."""
    rng = np.random.default_rng(0)
    named: list[Rig] = [rig(f"rig {number}", beams=number + 2) for number in range(rigs)]
    if rigs > 5:
        named[:5] = [preset(name) for name in ("Center", "Pyramid", "Line", "Trapezoid", "Square")]
    better = np.cumsum([40.0, 1.0, *[9.0] * rigs])[:rigs][:, None] + np.array([5.0, -10.0, 0.0, -1.5])
    by_seed = better[:, None] + rng.normal(0, 0.5, (rigs, seeds, 4))
    replicas = better + rng.normal(0, 1.5, (300, 1, 4)) + rng.normal(0, 0.8, (300, rigs, 4))
    if missing:
        by_seed[..., COLUMNS.index(missing)] = replicas[..., COLUMNS.index(missing)] = np.nan
    names = tuple(one.name for one in named)
    every = Precisions(names, seeds, 12, by_seed.mean(axis=1), by_seed, replicas)
    share = better / 100 + rng.normal(0, 0.02, better.shape)
    values = {name: share * SCALE.get(name, 1.0) for name in SURROGATES}
    return Result(Study(entrants(named), PROTOCOL, traffic(), NOWHERE), every, every, Surrogates(values))


def rows(lines: object) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(csv_text(list(lines)))))  # type: ignore[call-overload]


def test_tables_hold_every_rig_class_pair_and_surrogate() -> None:
    result = made_up()
    per_rig, pairs, ranks = rows(rig_lines(result)), rows(pair_lines(result)), rows(rank_lines(result))
    assert [(row["rig"], row["class"]) for row in per_rig] == [
        (name, column) for name in result.every.rigs for column in COLUMNS
    ]
    assert set(SURROGATES) < set(per_rig[0])
    for row in per_rig:
        assert float(row["ap_low"]) < float(row["ap"]) < float(row["ap_high"])
    assert len(pairs) == 21 * 4 and {row["verdict"] for row in pairs} == {"worse", "not resolved"}
    assert len(ranks) == 3 * 4 * len(SURROGATES) * 2
    among = {row["among"]: int(row["rigs"]) for row in ranks}
    assert among == {"all rigs": 7, "equal ray count": 5, "LiDAR groups": 5}
    assert len(rows(seed_lines(result))) == 7 * 3


def test_the_json_is_plain_and_says_what_it_is() -> None:
    found = json.loads(json.dumps(as_json(made_up()), allow_nan=False))
    assert found["wording"] == WORDING and found["seeds"] == 3 and len(found["rigs"]) == 7
    assert found["machine"]["device"] == "cpu" and found["protocol"]["epochs"] == PROTOCOL.epochs
    assert len(found["rigs"][0]["ap_by_seed"]["car"]) == 3


def test_few_rigs_have_no_rank_correlation() -> None:
    result = made_up(rigs=4)
    assert {row["value"] for row in rows(rank_lines(result))} == {""}
    assert [one.found for one in result.ranks] == [None] * len(result.ranks)


def test_a_class_without_objects_is_empty_in_the_tables(
    capsys: pytest.CaptureFixture[str],
) -> None:
    result = made_up(missing="bicycle")
    assert {row["ap"] for row in rows(rig_lines(result)) if row["class"] == "bicycle"} == {""}
    json.dumps(as_json(result), allow_nan=False)
    show(detection.shown(result))
    said = capsys.readouterr().out
    assert (
        "bicycle: no objects in the region of the test frames" in " ".join(said.split()) and WORDING in said
    )


def test_one_rig_is_shown_without_comparison(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    result = made_up(rigs=1)
    detection.write(result, [], [], tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(detection.NAMES)
    show(detection.shown(result))
    said = capsys.readouterr().out
    assert "nothing to compare" in said and "Rank correlations need 5 rigs or more; there are 1." in said


def test_it_is_said_that_cameras_take_part(capsys: pytest.CaptureFixture[str]) -> None:
    plain = made_up(rigs=2)
    seeing = replace(plain, study=replace(plain.study, protocol=replace(PROTOCOL, cameras="poor")))
    for result in (plain, seeing):
        show(detection.shown(result))
    first, second = capsys.readouterr().out.split(WORDING)[:2]
    assert "cameras" not in first
    assert "Points have the classes that cameras show, segmentation poor; S-MS and seen are of all" in second
    assert pair_chart(plain) != pair_chart(seeing)


def test_charts_are_the_same_each_time_also_without_objects_of_a_class() -> None:
    result = made_up(missing="bicycle")
    assert chart(result) == chart(result) and pair_chart(result) == pair_chart(result)


def test_names_of_rigs_stand_clear_of_one_another_however_close_the_rigs_are() -> None:
    result, apart = made_up(10), 0.02
    every = replace(
        result.every, value=result.every.value.mean(axis=0) * (1.0 - apart) + result.every.value * apart
    )
    values = {
        name: x.mean(axis=0) * (1.0 - apart) + x * apart for name, x in result.surrogates.values.items()
    }
    figure = chart_figure(replace(result, every=every, surrogates=Surrogates(values)))
    figure.draw_without_rendering()
    for axes in figure.axes:
        names = [text.get_window_extent() for text in axes.texts]
        assert len(names) == 10
        assert not any(one.overlaps(other) for one, other in combinations(names, 2))
        assert all(figure.bbox.x0 < box.x0 and box.x1 < figure.bbox.x1 for box in names)


def test_a_correlation_is_written_with_its_interval() -> None:
    assert correlation(RankCorrelation(-0.5, -0.812, 0.104, 0.1, True)) == "−0.50 [−0.81, 0.10]"


# ---------------------------------------------------------------- what cannot be done


def refused(riglens: object, *words: object) -> str:
    result = riglens("study", "detection", *words)  # type: ignore[operator]
    assert result.code == 2
    lines = [line for line in result.err.strip().splitlines() if not line.startswith("note: ")]
    assert len(lines) == 1, lines
    return str(lines[0])


def test_without_pytorch_one_line_says_what_to_install(
    riglens: object, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "torch", None)
    assert "pip install 'riglens[detect]'" in refused(riglens, "Trapezoid")


@pytest.fixture
def some_machine(monkeypatch: pytest.MonkeyPatch) -> None:
    """As if PyTorch were there: what is refused here is so before it is needed."""
    monkeypatch.setattr(detection, "machine", lambda device: NOWHERE)


@pytest.mark.usefixtures("some_machine")
@pytest.mark.parametrize(
    ("words", "said"),
    [
        ((), "--published"),
        (("Trapezoid", "--published"), "--published"),
        (("Wide",), "rig 'Wide' must have an enabled LiDAR"),
        (("Trapezoid", "--workers", "0"), "--workers must be between 1"),
        (("Trapezoid", "--seeds", "0"), "--seeds must be an integer from 1"),
        (("Trapezoid", "--workers", "2", "--dask", "tcp://h:1"), "--workers cannot be combined with"),
        (("no-such-rig",), "no-such-rig"),
    ],
)
def test_bad_words_are_one_line(riglens: object, tmp_path: Path, words: tuple[str, ...], said: str) -> None:
    assert said in refused(riglens, *words, "--out", tmp_path)


def test_the_published_rigs_and_protocol_go_with_or_without_cameras() -> None:
    plain, seeing = detection.Plan(published=True), detection.Plan(published=True, cameras="usual")
    assert (len(plain.rigs(())), len(seeing.rigs(()))) == (30, 12)
    assert plain.protocol() == PUBLISHED and seeing.protocol() == CAMERA_PROTOCOL
    assert detection.Plan(cameras="poor").protocol().cameras == "poor"


def table_of(path: Path, sequences: int, frames: int) -> Path:
    """Box data with a road user of each class in every frame."""
    lines = ["seq,frame,cls,x,y,z,length,width,height,yaw"]
    lines += [f"s{s},{f},{cls},5,5,0.8,4,2,1.6,0" for s in range(sequences) for f in range(frames)
              for cls in ("car", "bicycle", "pedestrian")]  # fmt: skip
    path.write_text("\n".join(lines), encoding="utf-8")
    return path


@pytest.mark.usefixtures("some_machine")
@pytest.mark.parametrize(("sequences", "frames"), [(1, 3), (1, 40)])
def test_three_frames_or_one_sequence_are_one_line(
    riglens: object, tmp_path: Path, sequences: int, frames: int
) -> None:
    table = table_of(tmp_path / "boxes.csv", sequences, frames)
    said = refused(riglens, "Trapezoid", "--boxes", table, "--out", tmp_path / "out")
    assert f"(got {frames} in {sequences})" in said


@pytest.mark.usefixtures("some_machine")
@pytest.mark.parametrize(
    ("address", "said"),
    [("nowhere", "--dask must be tcp://HOST:PORT"), ("tcp://127.0.0.1:1", "--dask finds no scheduler")],
)
def test_a_cluster_that_is_not_there_is_one_line(
    riglens: object, tmp_path: Path, address: str, said: str
) -> None:
    table = table_of(tmp_path / "boxes.csv", 5, 8)
    words = ("Trapezoid", "--boxes", table, "--dask", address, "--out", tmp_path / "out")
    assert said in refused(riglens, *words)


@pytest.mark.usefixtures("some_machine")
def test_a_body_of_a_file_takes_part(
    riglens: object, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    mine = tmp_path / "mine.yaml"
    with_file = preset("Trapezoid").replace(name="mine", vehicle=Vehicle(body="car.stl"))
    mine.write_text(dumps(with_file), encoding="utf-8")
    table = table_of(tmp_path / "boxes.csv", 5, 8)
    words = (mine, "--boxes", table, "--body", "blocks", "--out", tmp_path / "out")
    assert "car.stl: no such file" in refused(riglens, *words)
    (tmp_path / "car.stl").write_bytes(stl())

    def ends(asked: Study, *_: object) -> Surrogates:
        mesh = asked.compared[0].rig.vehicle.body_mesh
        raise InputError(f"{mesh is not None and len(mesh.triangles)} triangles")

    monkeypatch.setattr(detection, "_surrogates", ends)
    assert "4 triangles" in refused(riglens, *words)
    assert "False triangles" in refused(riglens, *words[:3], "--body", "ignored", *words[-2:])


@pytest.mark.slow
def test_a_quick_study_from_words_to_files(riglens: object, tmp_path: Path) -> None:
    pytest.importorskip("torch", reason="make test-detect")
    rng = np.random.default_rng(0)
    lines = ["seq,frame,cls,x,y,z,length,width,height,yaw"]
    for sequence in range(6):
        for frame in range(4):
            for cls, size, z in (("car", "4.4,1.9,1.5", 0.75), ("pedestrian", "0.6,0.6,1.8", 0.9)):
                x, y = rng.uniform(4, 12, 2) * rng.choice([-1, 1], 2)
                lines.append(f"s{sequence},{frame},{cls},{x:.2f},{y:.2f},{z},{size},{rng.uniform(-3, 3):.2f}")
    table, out = tmp_path / "boxes.csv", tmp_path / "out"
    table.write_text("\n".join(lines), encoding="utf-8")
    words = ("study", "detection", "Trapezoid", "Line", "--quick", "--boxes", table, "--out", out)
    first = riglens(*words)  # type: ignore[operator]
    assert first.code == 0, first.err
    assert {path.name for path in out.iterdir()} == {*detection.NAMES, "pieces"}
    assert WORDING in first.out and "Rank correlations need 5 rigs" in first.out
    assert "bicycle: no objects in the region of the test frames" in " ".join(first.out.split())
    assert (
        (out / "detection-recall.csv")
        .read_text(encoding="utf-8")
        .startswith("class,unit,from,to,ring,objects,found,recall\ncar,")
    )
    points = rows(csv.DictReader((out / "detection-recall-points.csv").open(encoding="utf-8")))
    by_rig = dict.fromkeys(("Trapezoid", "Line"), 0)
    for line in points:
        if line["group"] == "rig":
            by_rig[line["name"]] += int(line["objects"])
    drives = sum(int(line["objects"]) for line in points if line["group"] == "sequence")
    assert by_rig["Trapezoid"] == by_rig["Line"] > 0 and drives == sum(by_rig.values())
    assert "done: net of seed 1" in first.err
    texts = {path: path.read_bytes() for path in out.iterdir() if path.is_file()}
    again = riglens(*words)  # type: ignore[operator]
    assert again.code == 0 and "done:" not in again.err
    assert {path: path.read_bytes() for path in texts} == texts
