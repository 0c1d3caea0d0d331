"""A command that is killed leaves what it writes as it was or whole; the same command then brings the whole of it."""

import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.app.conftest import REPOSITORY, SMALL_GRID, program

KILLS = 10
pytestmark = pytest.mark.slow


def started(command: list[str], folder: Path) -> subprocess.Popen[bytes]:
    """The command in a process group of its own, so that its workers die with it."""
    return subprocess.Popen(
        program(*command),
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(REPOSITORY)},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        start_new_session=True,
    )


def contents(path: Path) -> dict[str, bytes]:
    """What a file, or every file of a folder, holds; nothing where there is none."""
    found = [path] if path.is_file() else sorted(one for one in path.rglob("*") if one.is_file())
    return {str(one.relative_to(path.parent)): one.read_bytes() for one in found}


@pytest.mark.parametrize(
    ("command", "written", "resumes"),
    [
        (["report", "small.yaml", "--out", "OUT", "--draws", "4", *SMALL_GRID], "page.html", False),
        (["report", "small.yaml", "--out", "OUT", "--draws", "4", *SMALL_GRID], "page.pdf", False),
        (["render", "small.yaml", "--out", "OUT", "--size", "320x200", *SMALL_GRID], "car.png", False),
        (["convert", "small.yaml", "OUT"], "saved.yaml", False),
        (["simulate", "small.yaml", "--out", "OUT", "--workers", "2", "--pictures", "off"], "sets", True),
    ],
    ids=["report", "pdf", "picture", "save", "simulate"],
)
def test_a_killed_command_leaves_the_old_or_the_whole(
    command: list[str], written: str, resumes: bool, boxes: Path, small_rig: Path, tmp_path: Path, xvfb: str
) -> None:
    """The moments are drawn by a seed over the time that the whole command takes; `resumes`: a folder fills up."""
    folder = tmp_path / "work"
    folder.mkdir()
    target = folder / written
    command = [str(target) if one == "OUT" else one for one in command]
    command[command.index("small.yaml")] = str(small_rig)
    if command[0] != "convert":
        command += ["--boxes", str(boxes)]
    begun = time.monotonic()
    whole = started(command, folder)
    _, said = whole.communicate()
    took_s = time.monotonic() - begun
    assert whole.returncode == 0, said.decode()
    reference, moments = contents(target), random.Random(0)
    old = {written: b"old"}
    for _ in range(KILLS):
        if resumes:
            if moments.random() < 0.25:
                subprocess.run(
                    [sys.executable, "-c", "import shutil, sys; shutil.rmtree(sys.argv[1])", target]
                )
        else:
            target.write_bytes(b"old")
        process = started(command, folder)
        try:
            process.wait(moments.uniform(0.0, took_s))
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
        process.communicate()
        left = contents(target)
        if resumes:  # every file is whole, whether or not all are there
            assert all(reference[name] == data for name, data in left.items() if name in reference)
        else:
            assert left in (old, reference)
    again = started(command, folder)
    _, said = again.communicate()
    assert again.returncode == 0, said.decode()
    assert contents(target) == reference
    if not resumes:
        assert [one.name for one in folder.iterdir()] == [written]
