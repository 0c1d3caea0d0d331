"""`riglens pog` stores a POG that scores like its boxes, whole or in parts; an interrupted build changes nothing."""

import contextlib
import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import psutil
import pytest

from riglens.core.pieces.folder import sole_run
from riglens.core.scene.pog_store import load_pog
from tests.app.conftest import REPOSITORY, SMALL_GRID
from tests.waiting import TIMEOUT_S, poll


def scores_of(outcome):
    rigs = json.loads(outcome.out)["rigs"]
    return [{key: value for key, value in rig.items() if key != "elapsed_ms"} for rig in rigs]


def test_a_stored_pog_scores_exactly_as_its_boxes(riglens, boxes, tmp_path):
    stored = riglens("data", "build", boxes, "--out", tmp_path / "small.npz", *SMALL_GRID)
    assert stored.code == 0
    assert "3 frames" in stored.out
    direct = riglens("evaluate", "W+T", "N+C", "--boxes", boxes, *SMALL_GRID, "--no-targets", "--json", "-")
    through = riglens("evaluate", "W+T", "N+C", "--pog", tmp_path / "small.npz", "--json", "-")
    assert scores_of(direct) == scores_of(through)
    assert json.loads(direct.out)["grid"] == json.loads(through.out)["grid"]
    assert json.loads(direct.out)["data"] == json.loads(through.out)["data"]


@pytest.fixture
def stored(riglens, boxes, tmp_path):
    riglens("data", "build", boxes, "--out", tmp_path / "small.npz", *SMALL_GRID)
    return tmp_path / "small.npz"


@pytest.mark.parametrize(
    "option",
    ["--boxes a.csv", "--voxel 0.2", "--roi 60 40 4", "--origin 0 0 0", "--frames 5", "--classes a=car"],
)
def test_options_that_contradict_the_pog_are_refused(riglens, stored, option):
    name, *values = option.split()
    line = riglens("evaluate", "W+T", "--pog", stored, name, *values).refused()
    assert name in line
    assert "small.npz" in line or "--pog" in line


def test_options_that_repeat_the_pog_are_fine(riglens, stored):
    assert riglens("evaluate", "W+T", "--pog", stored, *SMALL_GRID).code == 0


def test_what_is_not_a_pog_is_refused(riglens, boxes, stored):
    assert "boxes.csv" in riglens("evaluate", "W+T", "--pog", boxes).refused()
    stored.write_bytes(stored.read_bytes()[:-200])
    assert "small.npz" in riglens("evaluate", "W+T", "--pog", stored).refused()


def test_ctrl_c_in_the_middle_of_a_build_changes_nothing(riglens_process, tmp_path):
    table = tmp_path / "long.csv"
    with table.open("w", encoding="utf-8") as file:
        file.write("seq,frame,cls,x,y,z,length,width,height,yaw\n")
        for frame in range(1_000_000):
            file.write(f"s,{frame},bus,{frame % 17},2,1.8,12,2.5,3.5,0.5\n")
    out, cache = tmp_path / "out", tmp_path / "cache"
    out.mkdir()
    (out / "old.npz").write_text("kept", encoding="utf-8")
    environment = {"RIGLENS_CACHE_DIR": str(cache)}
    process = riglens_process(
        "data",
        "build",
        table,
        "--out",
        out / "old.npz",
        "--voxel",
        "0.1",
        env=environment,
        start_new_session=True,
    )
    poll(lambda: str(table) in [file.path for file in psutil.Process(process.pid).open_files()])
    os.kill(process.pid, signal.SIGINT)
    output, errors = process.communicate(timeout=TIMEOUT_S)
    assert process.returncode in (130, -signal.SIGINT)  # a shell says 130 to both
    assert output == ""
    assert errors == "riglens: interrupted; no file was changed\n"
    assert (out / "old.npz").read_text(encoding="utf-8") == "kept"
    assert [path.name for path in out.iterdir()] == ["old.npz"]


# ---------------------------------------------------------------- in parts, and on a Dask cluster


GRID = ("--voxel", "0.2", "--roi", "40", "20", "4")
HEADER = "seq,frame,cls,x,y,z,length,width,height,yaw\n"
TABLES = 6


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of tables that each take a moment."""
    path = tmp_path_factory.mktemp("tables")
    random = np.random.default_rng(11)
    for table in range(TABLES):
        numbers = random.uniform([-18, -9, 0.5, 3, 1, 1, -3], [18, 9, 2, 12, 3, 3, 3], (2400, 7)).round(3)
        rows = (f"s,{n // 4},car,{','.join(map(str, row))}" for n, row in enumerate(numbers.tolist()))
        (path / f"{table}.csv").write_text(HEADER + "\n".join(rows) + "\n", encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def expected(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[bytes, ...]:
    """The POG built here, one table after the other."""
    from riglens.app.commands import main

    out = tmp_path_factory.mktemp("expected") / "all.npz"
    assert main(["data", "build", str(folder), "--out", str(out), *GRID, "--workers", "1"]) == 0
    return content(out)


def content(path: Path) -> tuple[bytes, ...]:
    pog = load_pog(path)
    assert pog.data.frames == TABLES * 600
    return pog.index.words.tobytes(), pog.counts.tobytes(), str(pog.counts.dtype).encode()


def test_tables_named_one_by_one_in_any_order_give_the_pog_of_the_folder(riglens, folder, expected, tmp_path):
    paths = sorted(folder.iterdir(), reverse=True)
    outcome = riglens("data", "build", *paths, "--out", tmp_path / "o.npz", *GRID, "--workers", "1")
    assert outcome.code == 0
    assert "5.csv + 5 more: 3,600 frames" in outcome.out
    assert content(tmp_path / "o.npz") == expected
    assert [path.name for path in tmp_path.iterdir()] == ["o.npz"]


def wait_for_part(process: "subprocess.Popen[str]", parts: Path, count: int = 1) -> None:
    """Return when some parts are finished; fails when the build ends before that."""

    def is_there() -> bool:
        assert process.poll() is None, process.communicate()
        return parts.is_dir() and len(list(parts.glob("*.piece"))) >= count

    poll(is_there)


@pytest.mark.slow
def test_a_killed_build_leaves_no_process_and_goes_on(riglens_process, folder, expected, tmp_path):
    out, parts = tmp_path / "o.npz", tmp_path / "o.npz.parts"
    words = ("data", "build", folder, "--out", out, *GRID, "--workers", "2")
    process = riglens_process(*words)
    wait_for_part(process, parts)
    children = psutil.Process(process.pid).children(recursive=True)
    os.kill(process.pid, signal.SIGKILL)
    process.communicate()
    assert not out.exists()
    kept = {path.name: path.stat().st_mtime_ns for path in parts.glob("*.piece")}
    _, alive = psutil.wait_procs(children, timeout=TIMEOUT_S)
    assert not alive
    process = riglens_process(*words)
    wait_for_part(process, parts, min(len(kept) + 1, TABLES))
    again = {path.name: path.stat().st_mtime_ns for path in parts.glob("*.piece")}
    assert kept.items() <= again.items()
    assert process.wait(TIMEOUT_S) == 0
    assert content(out) == expected
    assert not parts.exists()


def test_ctrl_c_says_how_many_parts_are_kept(riglens_process, folder, tmp_path):
    parts = tmp_path / "o.npz.parts"
    process = riglens_process(
        "data", "build", folder, "--out", tmp_path / "o.npz", *GRID, "--workers", "2", start_new_session=True
    )
    wait_for_part(process, parts)
    os.killpg(process.pid, signal.SIGINT)  # as a terminal does: to the workers too
    output, errors = process.communicate(timeout=TIMEOUT_S)
    assert process.returncode == 130
    assert output == ""
    (line,) = errors.splitlines()
    assert line.startswith("riglens: interrupted; ") and f"finished parts are kept in {parts}" in line
    assert len(list(parts.glob("*.piece"))) == int(line.split()[2])


def test_two_builds_of_one_file_at_the_same_time_are_refused(riglens, folder, tmp_path):
    out = tmp_path / "o.npz"
    with sole_run(tmp_path / "o.npz.parts"):
        line = riglens("data", "build", folder, "--out", out, *GRID).refused()
    assert "another run uses this folder" in line and not out.exists()


def test_a_cluster_on_another_host_without_tls_is_remarked_on_once(riglens, boxes, tmp_path):
    address = "tcp://no-such.invalid:8786"
    outcome = riglens("data", "build", boxes, "--out", tmp_path / "o.npz", "--dask", address)
    remark, refusal = outcome.err.splitlines()
    assert remark.startswith(f"note: {address} is not encrypted") and "docs/security.md" in remark
    assert "--dask finds no scheduler" in refusal


def test_options_of_the_build_are_checked(riglens, boxes, tmp_path, monkeypatch):
    out = ("--out", tmp_path / "o.npz")
    assert "--workers must be between 1" in riglens("data", "build", boxes, *out, "--workers", "0").refused()
    assert "tcp://HOST:PORT" in riglens("data", "build", boxes, *out, "--dask", "localhost").refused()
    both = ("--workers", "2", "--dask", "tcp://127.0.0.1:9")
    assert "--workers cannot be combined with" in riglens("data", "build", boxes, *out, *both).refused()
    assert "BOXES" in riglens("data", "build", *out).refused()
    monkeypatch.setitem(sys.modules, "distributed", None)
    line = riglens("data", "build", boxes, *out, "--dask", "tcp://127.0.0.1:9").refused()
    assert "pip install 'riglens[cluster]'" in line


def test_a_bad_table_among_many_is_named_in_one_line(riglens, folder, tmp_path):
    bad = tmp_path / "bad.csv"
    bad.write_text(HEADER + "s,0,car,abc,0,0,1,1,1,0\n", encoding="utf-8")
    outcome = riglens(
        "data", "build", folder / "0.csv", bad, "--out", tmp_path / "o.npz", *GRID, "--workers", "2"
    )
    assert outcome.refused() == (
        f"riglens: {bad}:2: column 'x': must be a finite number in metres within ±1e+06 (got 'abc')"
    )


@pytest.fixture
def dask(tmp_path: Path) -> Iterator[Callable[..., "subprocess.Popen[bytes]"]]:
    """Start a Dask scheduler or worker as a process of its own."""
    started: list[subprocess.Popen[bytes]] = []
    environment = {**os.environ, "PYTHONPATH": str(REPOSITORY)}

    def start(module: str, *arguments: object) -> "subprocess.Popen[bytes]":
        command = [sys.executable, "-m", f"distributed.cli.{module}", *map(str, arguments), "--no-dashboard"]
        with (tmp_path / f"{module}-{len(started)}.log").open("wb") as log:
            started.append(subprocess.Popen(command, env=environment, stdout=log, stderr=log))
        return started[-1]

    yield start
    for process in started:
        process.kill()
    for process in started:
        process.wait(TIMEOUT_S)


def address_in(file: Path) -> str:
    """Where the scheduler says that it listens, once it has written that."""
    found: list[str] = []

    def is_written() -> bool:
        with contextlib.suppress(FileNotFoundError, json.JSONDecodeError):
            found.append(str(json.loads(file.read_text(encoding="utf-8"))["address"]))
        return bool(found)

    poll(is_written)
    return found[0]


@pytest.mark.slow
def test_a_cluster_that_loses_a_worker_gives_the_same_pog(riglens_process, dask, folder, expected, tmp_path):
    file, out = tmp_path / "scheduler.json", tmp_path / "o.npz"
    dask("dask_scheduler", "--host", "127.0.0.1", "--port", "0", "--scheduler-file", file)
    workers = [
        dask("dask_worker", "--scheduler-file", file, "--no-nanny", "--nthreads", "1", "--local-directory", tmp_path)
        for _ in range(2)
    ]  # fmt: skip
    address = address_in(file)
    process = riglens_process("data", "build", folder, "--out", out, *GRID, "--dask", address)
    wait_for_part(process, tmp_path / "o.npz.parts")
    workers[0].kill()
    output, errors = process.communicate(timeout=TIMEOUT_S)
    assert process.returncode == 0, errors
    assert "3,600 frames" in output
    assert content(out) == expected
