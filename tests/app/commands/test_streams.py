"""Standard streams that are closed, and results that go to pipes: `>&-`, `--out /dev/stdout`, `--out >(...)`."""

import io
import json
import os
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from riglens.core.rig.yaml.file import loads
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


@pytest.mark.parametrize("redirection", [">&-", "<&- >&- 2>&-"])
def test_closed_streams_take_no_result_away_from_files(tmp_path: Path, boxes: Path, redirection: str) -> None:
    words = ("evaluate", "W+T", "--boxes", boxes, *SMALL_GRID, "--json", tmp_path / "scores.json")
    done = through_a_shell(redirection, *words)
    assert (done.returncode, done.stdout) == (0, b"")
    assert b"Traceback" not in done.stderr
    assert json.loads((tmp_path / "scores.json").read_text())["rigs"][0]["name"] == "W+T"


@pytest.mark.parametrize("words", [("--help",), ("presets", "W+T")])
def test_closed_standard_output_is_no_failure(words: tuple[str, ...]) -> None:
    done = through_a_shell(">&-", *words)
    assert (done.returncode, done.stdout, done.stderr) == (0, b"", b"")


def test_no_complaint_goes_to_standard_output() -> None:
    done = through_a_shell("2>&-", "evaluate", "nosuch")
    assert (done.returncode, done.stdout) == (2, b"")


def test_a_pog_on_standard_output_is_alone_there(tmp_path: Path, boxes: Path) -> None:
    done = through_a_shell("", "pog", boxes, *SMALL_GRID, "--out", "/dev/stdout")
    assert done.returncode == 0 and b"3 frames" in done.stderr
    assert read_pog(io.BytesIO(done.stdout)).data.frames == 3
    done = through_a_shell(f"> {tmp_path}/pog.npz", "pog", boxes, *SMALL_GRID, "--out", "/dev/stdout")
    assert done.returncode == 0 and load_pog(tmp_path / "pog.npz").data.frames == 3


def test_other_results_on_standard_output_are_alone_there(boxes: Path) -> None:
    done = through_a_shell("", "convert", "W+T", "/dev/stdout", "--to", "riglens")
    assert done.returncode == 0 and loads(done.stdout.decode()).rig.name == "W+T"
    assert b"/dev/stdout: " in done.stderr
    done = through_a_shell("", "data", boxes, "--json", "/dev/stdout")
    assert done.returncode == 0 and json.loads(done.stdout)["riglens"] == 1
    done = through_a_shell("", "study", "table1", *SMALL_GRID, "--csv", "/dev/stdout")
    assert done.returncode == 0 and done.stdout.startswith(b"rig,class,") and b"Table" not in done.stdout


def test_a_build_of_several_parts_into_a_pipe(riglens, boxes: Path, tmp_path: Path) -> None:
    other = tmp_path / "other.csv"
    other.write_text(boxes.read_text().replace("\ns,", "\nt,"))
    reading, writing = os.pipe()
    received: list[bytes] = []
    with os.fdopen(reading, "rb") as end:
        listener = threading.Thread(target=lambda: received.append(end.read()))
        listener.start()
        outcome = riglens("pog", boxes, other, *SMALL_GRID, "--out", f"/dev/fd/{writing}", "--workers", "1")
        os.close(writing)
        listener.join()
    assert outcome.code == 0 and "occupied voxels" in outcome.out
    assert read_pog(io.BytesIO(received[0])).data.frames == 6


def test_a_build_of_several_parts_leaves_nothing_beside_a_pipe(riglens, boxes: Path, tmp_path: Path) -> None:
    folder = tmp_path / "pipes"
    folder.mkdir()
    os.mkfifo(folder / "pipe")
    other = tmp_path / "other.csv"
    other.write_text(boxes.read_text())
    end = os.open(folder / "pipe", os.O_RDWR)
    assert riglens("pog", boxes, other, *SMALL_GRID, "--out", folder / "pipe", "--workers", "1").code == 0
    assert read_pog(io.BytesIO(os.read(end, 1 << 20))).data.frames == 6
    os.close(end)
    assert os.listdir(folder) == ["pipe"]


def test_a_name_as_long_as_a_file_may_have_is_fine(riglens, boxes: Path, tmp_path: Path) -> None:
    other = tmp_path / "other.csv"
    other.write_text(boxes.read_text())
    out = tmp_path / ("n" * 251 + ".npz")
    assert riglens("pog", boxes, other, *SMALL_GRID, "--out", out, "--workers", "1").code == 0
    assert load_pog(out).data.frames == 6
    assert sorted(path.suffix for path in tmp_path.iterdir()) == [".csv", ".csv", ".npz"]


def test_a_picture_can_go_through_a_pipe(boxes: Path) -> None:
    words = ("render", "W+T", "--boxes", boxes, *SMALL_GRID, "--size", "64x64", "--out", "/dev/stdout")
    done = through_a_shell("", *words)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith(b"\x89PNG") and done.stdout.endswith(b"IEND\xaeB`\x82")
