"""Standard streams that are closed, and results that go to pipes: `>&-`, `--out /dev/stdout`, `--out >(...)`."""

import io
import json
import os
import subprocess
import sys
import threading
from collections.abc import Callable
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path

import pytest

from riglens.app.commands import main
from riglens.core.rig.yaml.file import load_rig, loads
from riglens.core.scene.pog_store import load_pog, read_pog
from tests.app.conftest import REPOSITORY, SMALL_GRID, program
from tests.waiting import TIMEOUT_S

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="this system has no /dev")


def through_a_shell(redirection: str, *arguments: object) -> "subprocess.CompletedProcess[bytes]":
    """Run `riglens ARGUMENTS... REDIRECTION` as a shell does."""
    return subprocess.run(
        ["sh", "-c", f'exec "$@" {redirection}', "sh", *program(*arguments)],
        env={**os.environ, "PYTHONPATH": str(REPOSITORY)},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        timeout=TIMEOUT_S,
        check=False,
    )


Pipe = Callable[..., tuple[bytes, bytes]]


@pytest.fixture
def through_a_pipe(capfd: pytest.CaptureFixture[str]) -> Pipe:
    """Run `riglens ARGUMENTS... | cat` in this process; what came through the pipe, and standard error."""

    def run(*arguments: object) -> tuple[bytes, bytes]:
        received: list[bytes] = []
        reading, writing = os.pipe()
        with capfd.disabled(), os.fdopen(reading, "rb") as end:
            listener = threading.Thread(target=lambda: received.append(end.read()))
            listener.start()
            kept, err = os.dup(1), io.StringIO()
            os.dup2(writing, 1)
            os.close(writing)
            with (
                open(1, "w", encoding="utf-8", closefd=False) as out,
                redirect_stdout(out),
                redirect_stderr(err),
            ):
                code = main([str(argument) for argument in arguments])
            os.dup2(kept, 1)
            os.close(kept)
            listener.join()
        assert code == 0, err.getvalue()
        return received[0], err.getvalue().encode()

    return run


@pytest.mark.parametrize("redirection", [">&-", "<&- >&- 2>&-"])
def test_closed_streams_take_no_result_away_from_files(tmp_path: Path, redirection: str) -> None:
    done = through_a_shell(redirection, "list", "rigs", "W+T", "--out", tmp_path / "rig.yaml")
    assert (done.returncode, done.stdout) == (0, b"")
    assert b"Traceback" not in done.stderr
    assert load_rig(tmp_path / "rig.yaml").rig.name == "W+T"


@pytest.mark.parametrize("words", [("--help",), ("list", "rigs", "W+T")])
def test_closed_standard_output_is_no_failure(words: tuple[str, ...]) -> None:
    done = through_a_shell(">&-", *words)
    assert (done.returncode, done.stdout, done.stderr) == (0, b"", b"")


def test_no_complaint_goes_to_standard_output() -> None:
    done = through_a_shell("2>&-", "evaluate", "nosuch")
    assert (done.returncode, done.stdout) == (2, b"")


def test_a_pog_on_standard_output_is_alone_there(tmp_path: Path, boxes: Path, through_a_pipe: Pipe) -> None:
    words = ("data", "build", boxes, *SMALL_GRID, "--out", "/dev/stdout")
    out, err = through_a_pipe(*words)
    assert b"3 frames" in err and read_pog(io.BytesIO(out)).data.frames == 3
    done = through_a_shell(f"> {tmp_path}/pog.npz", *words)
    assert done.returncode == 0 and load_pog(tmp_path / "pog.npz").data.frames == 3


def test_other_results_on_standard_output_are_alone_there(boxes: Path, through_a_pipe: Pipe) -> None:
    out, err = through_a_pipe("convert", "W+T", "/dev/stdout", "--to", "riglens")
    assert loads(out.decode()).rig.name == "W+T" and b"/dev/stdout: " in err
    out, _ = through_a_pipe("data", "show", boxes, "--json", "/dev/stdout")
    assert json.loads(out)["riglens"] == 1
    out, _ = through_a_pipe("study", "table1", "--boxes", boxes, *SMALL_GRID, "--csv", "/dev/stdout")
    assert out.startswith(b"rig,class,") and b"Table" not in out
    words = ("render", "W+T", "--boxes", boxes, *SMALL_GRID, "--size", "64x64", "--out", "/dev/stdout")
    out, _ = through_a_pipe(*words)
    assert out.startswith(b"\x89PNG") and out.endswith(b"IEND\xaeB`\x82")


def test_a_build_of_several_parts_into_a_pipe(riglens, boxes: Path, tmp_path: Path) -> None:
    other = tmp_path / "other.csv"
    other.write_text(boxes.read_text(encoding="utf-8").replace("\ns,", "\nt,"), encoding="utf-8")
    reading, writing = os.pipe()
    received: list[bytes] = []
    with os.fdopen(reading, "rb") as end:
        listener = threading.Thread(target=lambda: received.append(end.read()))
        listener.start()
        outcome = riglens(
            "data", "build", boxes, other, *SMALL_GRID, "--out", f"/dev/fd/{writing}", "--workers", "1"
        )
        os.close(writing)
        listener.join()
    assert outcome.code == 0 and "occupied voxels" in outcome.out
    assert read_pog(io.BytesIO(received[0])).data.frames == 6


def test_a_build_of_several_parts_leaves_nothing_beside_a_pipe(riglens, boxes: Path, tmp_path: Path) -> None:
    folder = tmp_path / "pipes"
    folder.mkdir()
    os.mkfifo(folder / "pipe")
    other = tmp_path / "other.csv"
    other.write_text(boxes.read_text(encoding="utf-8"), encoding="utf-8")
    end = os.open(folder / "pipe", os.O_RDWR)
    assert (
        riglens("data", "build", boxes, other, *SMALL_GRID, "--out", folder / "pipe", "--workers", "1").code
        == 0
    )
    assert read_pog(io.BytesIO(os.read(end, 1 << 20))).data.frames == 6
    os.close(end)
    assert os.listdir(folder) == ["pipe"]


def test_a_name_as_long_as_a_file_may_have_is_fine(riglens, boxes: Path, tmp_path: Path) -> None:
    other = tmp_path / "other.csv"
    other.write_text(boxes.read_text(encoding="utf-8"), encoding="utf-8")
    out = tmp_path / ("n" * 251 + ".npz")
    assert riglens("data", "build", boxes, other, *SMALL_GRID, "--out", out, "--workers", "1").code == 0
    assert load_pog(out).data.frames == 6
    assert sorted(path.suffix for path in tmp_path.iterdir()) == [".csv", ".csv", ".npz"]
