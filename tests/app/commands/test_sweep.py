"""`riglens sweep`: the figures of `riglens evaluate` for each rig, the same bytes however they were computed."""

# ruff: noqa: F811

import json
import os
import signal
from pathlib import Path

import pytest
from pyarrow import parquet

from riglens.core.blind.zones import BlindEngine, BlindSettings
from riglens.core.rig.yaml.file import load_rig
from riglens.core.sweep.fields import field_called, with_values
from riglens.evaluation import sweeping
from tests.app.commands.test_pog import address_in, dask, wait_for_part  # noqa: F401
from tests.app.conftest import SMALL_GRID
from tests.waiting import TIMEOUT_S

VARY = ("--vary", "roof.z=1.7:2.1:3", "--vary", "front.yaw=-20:20:2")
COMMON = (*SMALL_GRID, "--sample", "2")


@pytest.fixture
def sweep(riglens, boxes, small_rig, tmp_path):
    """Run a sweep and return its table."""

    def run(*words, out="out.parquet"):
        found = riglens("sweep", small_rig, "--boxes", boxes, "--out", tmp_path / out, *COMMON, *words)
        assert found.code == 0, found.err
        return parquet.read_table(tmp_path / out)

    return run


def figures(document, prefix=""):
    """Nested figures under dotted names, without lists and nothing."""
    for name, value in document.items():
        if isinstance(value, dict):
            yield from figures(value, prefix if name == "classes" else f"{prefix}{name}.")
        elif value is not None and not isinstance(value, list):
            yield f"{prefix}{name}", value


def test_each_row_is_what_evaluate_says_of_that_rig(sweep, riglens, boxes, small_rig, tmp_path):
    found = sweep(*VARY, "--blind", "0.3").to_pylist()
    file = load_rig(small_rig)
    assert len(found) == 6
    for row in found:
        values = {name: row[name] for name in ("roof.z", "front.yaw")}
        rig = with_values(file.rig, {field_called(file.rig, name): value for name, value in values.items()})
        file.save(tmp_path / "one.yaml", rig)
        words = ("evaluate", tmp_path / "one.yaml", "--boxes", boxes, *COMMON, "--targets", "--json", "-")
        document = json.loads(riglens(*words).out)
        expected = {**document["rigs"][0], **document["targets"]["rigs"][0]}
        expected["classes"] = {
            name: {
                **(one := document["rigs"][0]["classes"][name]),
                **(other := document["targets"]["rigs"][0]["classes"][name]),
                **{kind: one[kind] | other[kind] for kind in ("camera", "lidar")},
            }
            for name in ("car", "bicycle", "pedestrian")
        }
        assert row["rig"] == expected.pop("name") and row["rig_sha256"] == expected.pop("sha256")
        del expected["elapsed_ms"]
        for name, value in figures(expected):
            assert ".figures." in f".{name}" or row[name] == value, name
        blind = BlindEngine(rig.vehicle, BlindSettings()).evaluate(rig)
        assert row["blind_m2"] == pytest.approx(blind.area_m2(0.3).sum(), rel=1e-12) and row["blind_m2"] > 0.0
    assert len({row["rig_sha256"] for row in found}) == 6
    assert len({row["car.any.seen"] for row in found}) > 1


def test_any_split_and_any_workers_give_the_same_bytes(sweep, tmp_path, monkeypatch):
    whole = sweep(*VARY)
    for number, (size, workers) in enumerate(((1, 2), (4, 1))):
        monkeypatch.setattr(sweeping, "PIECE_RIGS", size)
        again = sweep(*VARY, "--workers", workers, out=f"{number}.parquet")
        assert again.equals(whole, check_metadata=True)
        assert (tmp_path / f"{number}.parquet").read_bytes() == (tmp_path / "out.parquet").read_bytes()


def test_changes_are_measured_against_the_given_rig(sweep):
    row = sweep("--vary", "roof.z=1.9:1.9:1").to_pylist()[0]
    assert row["car.lidar.share_5_change"] == 0.0 and row["car.lidar.share_5_change_se"] == 0.0
    low, high = sweep("--vary", "roof.z=1.7:2.3:2").to_pylist()
    change = high["car.lidar.share_5_change"] - low["car.lidar.share_5_change"]
    assert change == pytest.approx(high["car.lidar.share_5"] - low["car.lidar.share_5"], abs=1e-12)


def test_several_rigs_and_one_kind_of_figure(riglens, boxes, small_rig, tmp_path):
    words = (
        "--boxes",
        boxes,
        *SMALL_GRID,
        "--compute",
        "score",
        "--out",
        tmp_path / "o.parquet",
        "--json",
        "-",
    )
    found = riglens("sweep", small_rig, "W+T", *words)
    assert found.code == 0, found.err
    document = json.loads(found.out)
    assert [row["rig"] for row in document["rows"]] == ["small", "W+T"]
    assert not any("on_target" in name for name in document["rows"][0])
    assert document["grid"]["voxel_m"] == 0.5 and len(document["rigs"]) == 2


@pytest.mark.parametrize(
    ("words", "part"),
    [
        (("--vary", "rof.z=1:2:3"), "no sensor 'rof' (did you mean 'roof'?)"),
        (("--vary", "roof.pich=1:2:3"), "no field 'pich' (did you mean 'pitch'?)"),
        (("--vary", "roof.z=1:2:0"), "--vary 'roof.z': number of values must be ≥ 1 (got 0)"),
        (("--vary", "roof.z=1:2"), "--vary 'roof.z' lacks the number of values"),
        (("--vary", "roof.z=1:2", "--sobol", "0"), "--sobol must be an integer ≥ 1 (got 0)"),
        (("--vary", "roof.z=0:1:2000", "--vary", "roof.x=0:1:2000"), "1 to 1,000,000 rigs (got 4,000,000)"),
        (("--vary", "front.hfov_deg=10:400:2"), "'front.hfov_deg' cannot be 400"),
        (("--vary", "roof.z=1:2:2", "--table", "no.csv"), "--table cannot be combined with --vary"),
        (("--table", "no.csv"), "no.csv: no such file"),
        (("--blind", "9"), "--blind must be between 0.05 and 2 m (got 9)"),
        (("--pog", "p.npz"), "--pog holds no objects to count: leave it out, or choose score for --compute"),
        (("--chart", "c.pdf"), "--chart must end in .png or .svg"),
        (("--vary", "roof.z=1:2:2", "--chart", "c.png", "--figure", "x"), "--figure must be a column"),
        (("--chart", "c.png"), "--chart needs one or two varied fields (got 0)"),
    ],
)
def test_what_makes_no_sense_is_one_line_and_leaves_nothing(riglens, boxes, small_rig, tmp_path, words, part):
    out = tmp_path / "o.parquet"
    line = riglens("sweep", small_rig, "--boxes", boxes, "--out", out, *COMMON, *words).refused()
    assert part in line
    assert not out.exists() and not (tmp_path / "o.parquet.parts").exists()


def test_an_interrupted_sweep_computes_only_what_is_missing(
    sweep, riglens, boxes, small_rig, tmp_path, monkeypatch
):
    monkeypatch.setattr(sweeping, "PIECE_RIGS", 1)
    compute, keys = sweeping.computed, []

    def interrupted(key, *arguments):
        keys.append(key)
        if len(keys) == 4:
            raise KeyboardInterrupt
        return compute(key, *arguments)

    monkeypatch.setattr(sweeping, "computed", interrupted)
    words = ("--boxes", boxes, "--out", tmp_path / "out.parquet", *COMMON, "--workers", "1")
    found = riglens("sweep", small_rig, *words, *VARY)
    assert found.code == 130 and "3 finished parts are kept" in found.err
    again = sweep(*VARY, "--workers", "1")
    assert len(keys) == 4 + 3 and len(set(keys)) == 6
    assert again.equals(sweep(*VARY, "--workers", "1", out="at-once.parquet"))
    assert sorted(path.name for path in tmp_path.iterdir() if "parts" in path.name) == []


MANY = ("--vary", "roof.z=1.7:2.1:20", "--vary", "roof.yaw=0:90:20")


@pytest.mark.slow
def test_a_killed_sweep_goes_on_and_gives_the_same_bytes(riglens_process, sweep, boxes, small_rig, tmp_path):
    out, parts = tmp_path / "killed.parquet", tmp_path / "killed.parquet.parts"
    words = ("sweep", small_rig, "--boxes", boxes, "--out", out, *COMMON, *MANY, "--workers", "2")
    process = riglens_process(*words)
    wait_for_part(process, parts)
    os.kill(process.pid, signal.SIGKILL)
    process.communicate()
    assert not out.exists()
    kept = {path.name: path.stat().st_mtime_ns for path in parts.glob("*.piece")}
    again = riglens_process(*words)
    wait_for_part(again, parts, min(len(kept) + 1, 4))
    assert kept.items() <= {path.name: path.stat().st_mtime_ns for path in parts.glob("*.piece")}.items()
    _, errors = again.communicate(timeout=TIMEOUT_S)
    assert again.returncode == 0, errors
    sweep(*MANY, "--workers", "1")
    assert out.read_bytes() == (tmp_path / "out.parquet").read_bytes() and not parts.exists()


@pytest.mark.slow
def test_a_cluster_that_loses_a_worker_gives_the_same_bytes(
    riglens_process,
    dask,
    sweep,
    boxes,
    small_rig,
    tmp_path,
):
    file, out = tmp_path / "scheduler.json", tmp_path / "cluster.parquet"
    dask("dask_scheduler", "--host", "127.0.0.1", "--port", "0", "--scheduler-file", file)
    workers = [
        dask("dask_worker", "--scheduler-file", file, "--no-nanny", "--nthreads", "1", "--local-directory", tmp_path)
        for _ in range(2)
    ]  # fmt: skip
    words = ("sweep", small_rig, "--boxes", boxes, "--out", out, *COMMON, *MANY, "--dask", address_in(file))
    process = riglens_process(*words)
    wait_for_part(process, Path(f"{out}.parts"))
    workers[0].kill()
    _, errors = process.communicate(timeout=TIMEOUT_S)
    assert process.returncode == 0, errors
    sweep(*MANY, "--workers", "1")
    assert out.read_bytes() == (tmp_path / "out.parquet").read_bytes()
