"""Runs the command line as a user would, in this process or in one of its own; small box data to score."""

import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from rich.progress import Progress, TaskID

from riglens.app.commands import main
from riglens.core.rig.library import LIBRARY_VARIABLE

REPOSITORY = Path(__file__).resolve().parents[2]
SMALL_GRID = ("--voxel", "0.5", "--roi", "20", "20", "4")
BOXES = """seq,frame,cls,x,y,z,length,width,height,yaw
s,0,car,6,0,0.8,4.5,1.9,1.6,0.3
s,0,bicycle,3,-4,0.9,1.8,0.6,1.7,0
s,1,car,-6,3,0.8,4.5,1.9,1.6,0
s,2,pedestrian,2,5,0.9,0.6,0.6,1.8,0
s,2,shopping_cart,2,6,0.9,0.6,0.6,1.8,0
"""


@dataclass(frozen=True)
class Outcome:
    """What a command left: exit code, standard output, standard error."""

    code: int
    out: str
    err: str

    def refused(self) -> str:
        """The one line that says what is wrong; fails unless the command ended as it must on bad input."""
        assert self.code == 2, self
        assert self.out == ""
        assert "Traceback" not in self.err
        lines = self.err.splitlines()
        assert len(lines) == 1, self.err
        return lines[0]

    def part(self, name: str) -> Any:
        """One part of the JSON on standard output, as of a review, or the objects of an evaluation."""
        assert self.code == 0, self.err
        return json.loads(self.out)[name]


Run = Callable[..., Outcome]


@pytest.fixture
def riglens(capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> Run:
    """`riglens ARGUMENTS...` in this process, which forgets the libraries that `--library` names afterwards.

    Every progress bar moves from 0 to 1 and never back.
    """
    monkeypatch.setenv(LIBRARY_VARIABLE, "")
    told, update = list[tuple[Progress, float]](), Progress.update

    def note(bar: Progress, task: TaskID, *, completed: float, **fields: Any) -> None:
        told.append((bar, completed))
        update(bar, task, completed=completed, **fields)

    monkeypatch.setattr(Progress, "update", note)

    def run(*arguments: object) -> Outcome:
        capfd.readouterr()
        told.clear()
        code = main([str(argument) for argument in arguments])
        out, err = capfd.readouterr()
        for bar in {bar for bar, _ in told}:
            shares = [share for one, share in told if one is bar]
            assert shares == sorted(shares) and shares[0] >= 0.0 and shares[-1] <= 1.0, (arguments, shares)
        return Outcome(code, out, err)

    return run


def program(*arguments: object) -> list[str]:
    """The command that runs `riglens ARGUMENTS...` in a process of its own."""
    return [sys.executable, "-m", "app", *(str(argument) for argument in arguments)]


def _heed_ctrl_c() -> None:
    """Undo what a shell does to jobs in the background: they, and what they start, ignore Ctrl-C."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


@pytest.fixture
def riglens_process() -> Iterator[Callable[..., "subprocess.Popen[str]"]]:
    """Start `riglens ARGUMENTS...` in a process of its own; keywords go to Popen."""
    started: list[subprocess.Popen[str]] = []

    def start(*arguments: object, **keywords: object) -> "subprocess.Popen[str]":
        environment = {**os.environ, "PYTHONPATH": str(REPOSITORY)}
        environment.update(keywords.pop("env", {}))  # type: ignore[call-overload]
        process: subprocess.Popen[str] = subprocess.Popen(
            program(*arguments),
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            encoding="utf-8",
            env=environment,
            preexec_fn=_heed_ctrl_c,
            **keywords,  # type: ignore[call-overload]
        )
        started.append(process)
        return process

    yield start
    for process in started:
        if process.poll() is None:
            process.kill()
        process.communicate()


@pytest.fixture
def boxes(tmp_path: Path) -> Path:
    """A small box table with all classes and one name that belongs to none."""
    path = tmp_path / "boxes.csv"
    path.write_text(BOXES, encoding="utf-8")
    return path


SMALL_RIG = """riglens: 1
name: small
sensors:
  - {name: roof, kind: lidar, position: [0.1, 0.2, 1.9], elevations_deg: {from: -20, to: 10, count: 8},
     azimuths_deg: {from: -180, to: 180, count: 180}}
  - {name: front, kind: camera, position: [1, 0, 1.4], image: [160, 90], hfov_deg: 90}
"""


@pytest.fixture
def small_rig(tmp_path: Path) -> Path:
    """A rig of a LiDAR and a camera with few rays, for what does not depend on the rig."""
    path = tmp_path / "small.yaml"
    path.write_text(SMALL_RIG, encoding="utf-8")
    return path
